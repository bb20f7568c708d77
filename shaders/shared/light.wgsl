// A light as a view sees it: where it is, how it shines, and which part of a view ray it reaches at all.
//
// The importing pass declares the uniforms `view` and `light`. Twins: crates/gpu-backend/src/layout/light.rs (layout),
// crates/scene/src/{light,cone}.rs and crates/hybrid-march/src/extent.rs (functions).

#import view
#import airlight

const POINT: u32 = 0u;
const SPOT: u32 = 1u;
const DIRECTIONAL: u32 = 2u;

// It is added to; or it is kept but where its alpha says that a pixel is to be computed anew, by the first light and by
// those that add to it.
const ADDS: u32 = 1u;
const REFINES: u32 = 2u;
const REFINES_FURTHER: u32 = 3u;

// Vectors in the camera's basis, from the eye, unless marked otherwise.
struct Light {
    to_light: vec3f,     // units: m
    cos_outer: f32,
    axis: vec3f,         // unit; the way the light travels along its axis
    cos_inner: f32,
    right: vec3f,        // unit; to the right of a spot's picture
    tan_outer: f32,
    top: vec3f,          // unit; to the top of a spot's picture
    nearest_texel: u32,  // 1 where a picture is read without interpolation
    power: vec3f,        // units: W/sr, or W/m^2 of a directional light
    map_height: f32,     // rows of the map; units: texels
    center: vec3f,       // of the sphere around all occluders; units: m
    radius: f32,         // of that sphere; units: m; negative where nothing casts shadows
    pixel: vec4f,        // where the light's line meets the image plane, in pixels: rounded (xy) and the rest (zw)
    image: vec3f,        // that point's tangents and 1; 0 where the light is beside the eye and has no such point
    map_width: f32,      // columns of the map; units: texels
    world: vec3f,        // to the light (m), or of a directional light the unit way to it; world axes
    map_top: u32,        // coarsest level of the map's pyramid
    first_sample: u32,   // of those that this dispatch marches
    end_sample: u32,
    samples: u32,        // of the whole march
    kernel: u32,         // width of a filtered lookup; units: texels
    variance: vec4f,     // of a variance map: depth of 1 (m), least variance, bleed reduction, unused
    outside: u32,        // 1 where what the map does not see is lit
    adds: u32,           // what becomes of what the texture before holds, see below
    face_scale: u32,     // pixels a side for which the faces of a shadow volume are kept
    refine: u32,         // bisections of a boundary that a march has found
    eye: vec3f,          // where the view is taken from; world axes and origin; units: m
    lit_samples: u32,    // steps of each segment outside of the outermost faces of a shadow volume
    table_end: f32,        // distance of the last row of a frame's table as printed; units: m
    _pad0: f32,
    _pad1: f32,
    _pad2: f32,
    rows: array<vec4f, 4>, // X, Y, W and depth over (a, b, 1) per unit of the ray's tangent vector, and at the eye
}

// Distance along a ray to the point nearest to the light, distance from there, and the vector between.
struct LightFoot {
    foot: Foot,
    from_light: vec3f, // from the light to the foot; units: m
}

// Where the light is relative to a ray.
//
// The light's distance from the ray comes from the pixel's distance from the light's image, of which no digit is
// lost next to the light.
fn light_foot(ray: ViewRay) -> LightFoot {
    let x_foot = dot(light.to_light, ray.direction);
    let apart = ((ray.pixel - light.pixel.xy) - light.pixel.zw) * vec2f(view.scale_x, view.scale_y);
    // image x tangent, times the depth of the light
    let p = light.image;
    let by_image = light.to_light.z * vec3f(-apart.y, apart.x, p.x * apart.y - p.y * apart.x);
    // no branch: a driver that compiles branches on uniforms anew for their values would do so in every dispatch
    let normal = select(cross(light.to_light, ray.tangent), by_image, light.image.z != 0.0);
    let squared = ray.length * ray.length;
    // the part of the way to the light at right angles to the ray is tangent x normal/|tangent|^2 with this sign
    let to_light = cross(ray.tangent, normal) / squared;
    let h = max(length(normal) / ray.length, 1e-12 * max(length(light.to_light), 1.0));
    return LightFoot(Foot(x_foot, h), -to_light);
}

// Both ends of a piece of a ray.
fn no_piece(at: f32) -> vec2f {
    return vec2f(at, at);
}

// The x with offset + slope x >= 0, within a piece.
fn nonnegative(offset: f32, slope: f32, piece: vec2f) -> vec2f {
    if slope > 0.0 {
        return vec2f(max(piece.x, -offset / slope), piece.y);
    }
    if slope < 0.0 {
        return vec2f(piece.x, min(piece.y, -offset / slope));
    }
    return select(vec2f(piece.x, piece.x), piece, offset >= 0.0);
}

// The part of a piece inside a cone around the light, of one nappe; `along` is the cosine between ray and axis.
//
// With t from the foot, the axial distance is at_foot + along t and the distance from the light sqrt(t^2 + h^2).
fn cone_piece(foot: LightFoot, axis: vec3f, direction: vec3f, cos2: f32, piece: vec2f) -> vec2f {
    let at_foot = dot(foot.from_light, axis);
    let along = dot(direction, axis);
    let h = foot.foot.h;
    let x_foot = foot.foot.x_foot;
    let qa = along * along - cos2;
    let qb = along * at_foot;
    let qc = at_foot * at_foot - cos2 * h * h;
    let discriminant = qb * qb - qa * qc;
    if discriminant < 0.0 && qa <= 0.0 {
        return no_piece(piece.x);
    }
    let q = -(qb + select(-1.0, 1.0, qb >= 0.0) * sqrt(max(discriminant, 0.0)));
    var low = -ENDLESS;
    var high = ENDLESS;
    if qa > 0.0 {
        // the ray runs into the cone, or out of its mirror image
        let roots = vec2f(q / qa, select(0.0, qc / q, q != 0.0));
        if along > 0.0 {
            low = max(roots.x, roots.y);
        } else {
            high = min(roots.x, roots.y);
        }
    } else if qa < 0.0 {
        let roots = vec2f(q / qa, select(0.0, qc / q, q != 0.0));
        low = min(roots.x, roots.y);
        high = max(roots.x, roots.y);
        if at_foot + along * (0.5 * (low + high)) <= 0.0 {
            return no_piece(piece.x);
        }
    } else {
        // parallel to a line of the cone
        if qb > 0.0 {
            low = -0.5 * qc / qb;
        } else if qb < 0.0 {
            high = -0.5 * qc / qb;
        } else if !(qc > 0.0 && at_foot > 0.0) {
            return no_piece(piece.x);
        }
    }
    let inside = vec2f(max(piece.x, x_foot + low), min(piece.y, x_foot + high));
    if inside.y <= inside.x {
        return no_piece(piece.x);
    }
    return inside;
}

// The part of a piece that anything inside the occluders' sphere may shadow.
fn shadowed_piece(kind: u32, foot: LightFoot, ray: ViewRay, piece: vec2f) -> vec2f {
    var behind = piece;
    if kind == DIRECTIONAL {
        // a half-infinite cylinder, capped at the sphere's near side
        let eye = -light.center;
        let w = eye - dot(eye, light.axis) * light.axis;
        let d = ray.direction - dot(ray.direction, light.axis) * light.axis;
        let a = dot(d, d);
        let b = dot(w, d);
        let c = dot(w, w) - light.radius * light.radius;
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return no_piece(piece.x);
        }
        if a > 1e-14 {
            let q = -(b + select(-1.0, 1.0, b >= 0.0) * sqrt(discriminant));
            let roots = vec2f(q / a, select(0.0, c / q, q != 0.0));
            behind = vec2f(max(piece.x, min(roots.x, roots.y)), min(piece.y, max(roots.x, roots.y)));
        } else {
            behind = select(behind, no_piece(piece.x), c > 0.0);
        }
        behind = nonnegative(dot(eye, light.axis) + light.radius, dot(ray.direction, light.axis), behind);
    } else {
        let to_center = light.center - light.to_light;
        let distance = length(to_center);
        let axis = to_center / max(distance, 1e-30);
        let sine = min(light.radius / max(distance, 1e-30), 1.0);
        let offset = -dot(light.to_light, axis) - (distance - light.radius);
        behind = nonnegative(offset, dot(ray.direction, axis), piece);
        behind = cone_piece(foot, axis, ray.direction, (1.0 - sine) * (1.0 + sine), behind);
        // from within, everything; a branch on uniforms alone would be compiled anew, as above
        behind = select(behind, piece, distance <= light.radius);
    }
    if behind.y <= behind.x || light.radius < 0.0 {
        return no_piece(piece.x);
    }
    return behind;
}

// glTF's falloff towards w, a vector away from the light.
fn spot_falloff(w: vec3f) -> f32 {
    let cosine = dot(w, light.axis) / max(length(w), 1e-30);
    let t = (min(cosine, 1.0) - light.cos_outer) / max(light.cos_inner - light.cos_outer, 0.001);
    let clamped = clamp(t, 0.0, 1.0);
    return clamped * clamped;
}

// Coordinates on a spot's picture towards w: 0 to 1 over the square around the outer cone, v downwards.
fn picture_coordinates(w: vec3f) -> vec2f {
    let k = max(light.tan_outer * dot(w, light.axis), 1e-30);
    return vec2f(0.5 + 0.5 * dot(w, light.right) / k, 0.5 - 0.5 * dot(w, light.top) / k);
}
