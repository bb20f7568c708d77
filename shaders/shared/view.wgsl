// A view, its medium, and the view ray of a pixel.
//
// Vectors are in the camera's own basis (right, up, forward) with the eye at the origin, so that nothing is lost to
// the scene's place in the world; those marked "world axes" are not rotated, but start at the eye as well.
// The importing pass declares the uniform `view`. Twin: crates/gpu-backend/src/layout/view.rs.

#import elementary

struct View {
    forward: vec3f,          // world axes
    max_distance: f32,       // how far a ray that hits nothing goes; units: m; ENDLESS for infinity
    right: vec3f,            // world axes
    scale_x: f32,            // tangent per pixel, to the right
    up: vec3f,               // world axes
    scale_y: f32,            // tangent per pixel, upwards: negative, row 0 is at the top
    offset: vec2f,           // tangent at the image's upper left corner
    size: vec2u,             // units: pixels
    sigma_s: vec3f,          // units: 1/m
    least_extinction: f32,   // of the channels that are attenuated at all; units: 1/m
    sigma_t: vec3f,          // units: 1/m
    first_lobe: u32,         // 0, see lobe_count
    emission: vec3f,         // units: W/(m^3 sr)
    height_y0: f32,          // height up to which the density is 1, above the eye; units: m
    bounds_min: vec3f,       // world axes, from the eye; units: m
    height_scale: f32,       // units: m
    bounds_max: vec3f,       // world axes, from the eye; units: m
    grid_step: f32,          // step of a sum along a way through the density grid; units: m
    grid_min: vec3f,         // world axes, from the eye; units: m
    _pad0: f32,
    grid_max: vec3f,         // world axes, from the eye; units: m
    _pad1: f32,
    lobes: array<vec4f, 4>,  // weight, kind (see phase.wgsl), g, how many lobes there are
}

struct ViewRay {
    pixel: vec2f,     // column and row; pixel centres at +0.5
    tangent: vec3f,   // (a, b, 1): the direction before it is scaled
    length: f32,      // of tangent
    direction: vec3f, // unit
}

// The view ray through a pixel's centre.
fn view_ray(pixel: vec2u) -> ViewRay {
    let at = vec2f(pixel) + 0.5;
    let tangent = vec3f(at.x * view.scale_x + view.offset.x, at.y * view.scale_y + view.offset.y, 1.0);
    let length = sqrt(dot(tangent, tangent));
    return ViewRay(at, tangent, length, tangent / length);
}

// Lobes of the phase function. At a place that a driver does not know: lavapipe would compile the count of a loop into the
// shader, in every dispatch.
fn lobe_count() -> u32 {
    return u32(view.lobes[view.first_lobe].w);
}

// A direction of the camera's basis along the world's axes.
fn to_world(v: vec3f) -> vec3f {
    return v.x * view.right + v.y * view.up + v.z * view.forward;
}
