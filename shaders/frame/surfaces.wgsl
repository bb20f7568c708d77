// Radiance of the surfaces in view, lit by one light and attenuated on both ways, as it arrives at the eye.
//
// Two-sided Lambert: base colour/pi x E cos(theta) x visibility x e^(-sigma_t d_light) x e^(-sigma_t d_eye), both lengths
// counted inside the medium only. Visibility is one shadow ray.
//
// In: see bindings.wgsl and bindings_bvh.wgsl; which triangle each view ray hits, and all triangles. Out: rgba32float
// radiance, added to that of the lights before; units: W/(m^2 sr). Twins: crates/ground-truth/src/surface.rs (function),
// crates/gpu-backend/src/surfaces (layout).

#import bindings
#import bindings_bvh
#import piece
#import light_path

struct SurfaceTriangle {
    normal: vec3f,      // unit, of either side; world axes
    _pad0: f32,
    base_color: vec3f, // diffuse reflectance, linear
    _pad1: f32,
}

@group(3) @binding(0) var<storage, read> surface_triangles: array<SurfaceTriangle>;
// the triangle that each pixel's ray hits, row by row from the top; no index of one where it hits none
@group(3) @binding(1) var<storage, read> hits: array<u32>;

override BOUNDED: bool = false;
override DENSITY: u32 = 0u;

const INV_PI: f32 = 0.318309886;

// How far shadow rays start above a surface, as a share of the largest length in their sums: the eye's coordinates, the
// view ray, and the way from the eye to the far side of all casters. The point on the surface and the triangle tests are
// off by a few roundings of 6e-8 of that. These are 16, and still far below what a pixel sees; more would only move the
// edges of shadows.
const SHADOW_OFFSET: f32 = 1e-6;

fn shadow_offset(distance: f32) -> f32 {
    return SHADOW_OFFSET * max(length(light.eye) + distance, length(light.center) + light.radius);
}

// Whether the light reaches a point of a surface (world axes, from the eye), on the side that the normal points to.
//
// The ray starts above the surface rather than later along itself, as it does in f64: a ray that grazes the surface stays
// within the rounding of f32 for a long way. From above it every way to a light on that side leads further up. It ends as
// much before the light, which may lie in a surface as well.
fn lit(point: vec3f, normal: vec3f, distance: f32) -> bool {
    let offset = shadow_offset(distance);
    let start = point + offset * normal;
    let origin = start + light.eye;
    if LIGHT == DIRECTIONAL {
        return !occluded(origin, light.world, ENDLESS);
    }
    let to = light.world - start;
    return !occluded(origin, to, 1.0 - offset / max(length(to), offset));
}

// Irradiance on the side that the normal points to, of a point at `distance` along a view ray; units: W/m^2.
fn irradiance(ray: ViewRay, direction: vec3f, normal: vec3f, distance: f32) -> vec3f {
    let point = distance * direction;
    var to = light.world;
    var unoccluded = light.power;
    if LIGHT != DIRECTIONAL {
        to = light.world - point;
        let squared = dot(to, to);
        // in the light there is no direction to it
        if squared < 1e-30 {
            return vec3f();
        }
        unoccluded /= squared;
        to *= inverseSqrt(squared);
        if LIGHT == SPOT {
            let w = distance * ray.direction - light.to_light;
            unoccluded *= spot_falloff(w) * picture_colour(w);
        }
    }
    let cosine = dot(normal, to);
    if !(cosine > 0.0) || all(unoccluded == vec3f()) {
        return vec3f();
    }
    if SHADOWED {
        if !lit(point, normal, distance) {
            return vec3f();
        }
    }
    return unoccluded * cosine * exp(-view.sigma_t * light_path(point));
}

fn surface_radiance(pixel: vec2u, triangle: SurfaceTriangle) -> vec3f {
    let ray = view_ray(pixel);
    let direction = to_world(ray.direction);
    let distance = textureLoad(ray_ends, pixel, 0).r;
    let eye_side = select(-triangle.normal, triangle.normal, dot(triangle.normal, direction) <= 0.0);
    let arriving = irradiance(ray, direction, eye_side, distance);
    let eye_path = optical_path(vec3f(), direction, vec2f(0.0, distance));
    return triangle.base_color * INV_PI * arriving * exp(-view.sigma_t * eye_path);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var sum = select(vec4f(), so_far(pixel), light.adds == ADDS);
    let hit = hits[pixel.y * view.size.x + pixel.x];
    if hit < arrayLength(&surface_triangles) {
        sum += vec4f(surface_radiance(pixel, surface_triangles[hit]), 0.0);
    }
    set_so_far(pixel, sum);
}
