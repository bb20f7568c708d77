// What one crossing of a view ray with the surface of a light volume adds to the ray's airlight: s L(0, x), with s = +1
// where the ray leaves the light and -1 where it enters it                                     (BSA10 Eq. 3)
//
// A crossing behind the end of the ray adds only its sign; what the signs sum to is 1 where the ray ends lit, and the
// airlight of the whole ray is added once for that when all crossings are there. So nothing cancels behind the surfaces.
// In: group 0. Out: radiance and signs, blended; or, where float32 does not blend, the same as a share of the unshadowed
// airlight in fixed point. Twin: crates/lightvolume/src/signed.rs.

#import light_mesh
#import piece

@group(0) @binding(0) var<uniform> view: View;
// distance at which each view ray ends; r32float; units: m; ENDLESS where it hits nothing
@group(0) @binding(1) var ray_ends: texture_2d<f32>;
@group(0) @binding(2) var<uniform> light: Light;
// the light's map, a layer a face; r32float
@group(0) @binding(3) var heights: texture_2d_array<f32>;
@group(0) @binding(4) var<uniform> mesh: Mesh;
// leaves of the tessellation, see lightvolume/leaves.wgsl
@group(0) @binding(5) var<storage, read> leaves: array<vec2u>;
// sums in fixed point, three a pixel
@group(0) @binding(6) var<storage, read_write> sums: array<atomic<i32>>;
// the unshadowed airlight of each ray; rgba32float
@group(0) @binding(7) var unshadowed: texture_2d<f32>;
@group(0) @binding(8) var picture: texture_2d<f32>;

override LIGHT: u32 = 0u;
override TEXTURED: bool = false;
override ACHROMATIC: bool = true;
override ISOTROPIC: bool = true;
// whether sums are in fixed point
override FIXED: bool = false;

// 1 in fixed point
const FIXED_ONE: f32 = 16777216.0;

// Distance at which a ray meets the plane of the triangle; units: m.
//
// The rasteriser moves vertices to its grid. The distance that it interpolates lies within the triangle, but errs where
// the triangle is seen from its edge; that of the plane is exact, but runs away where the ray passes the triangle by.
fn distance_of(crossing: Crossing, ray: ViewRay) -> f32 {
    let interpolated = ray.length / max(crossing.weight * crossing.position.w, 1e-30);
    let met = -crossing.plane.w / dot(crossing.plane.xyz, ray.direction);
    return select(interpolated, met, abs(met - interpolated) <= 0.1 * interpolated);
}

// The part of a ray that the light shines on at all.
fn reached(lamp: Lamp, ray: ViewRay, end: f32) -> vec2f {
    let whole = vec2f(0.0, end);
    if LIGHT == SPOT {
        return cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, whole);
    }
    return whole;
}

fn cross_at(crossing: Crossing, is_front: bool) -> vec4f {
    let pixel = vec2u(crossing.position.xy);
    let ray = view_ray(pixel);
    let lamp = lamp_of(ray);
    let piece = reached(lamp, ray, textureLoad(ray_ends, pixel, 0).r);
    let x = distance_of(crossing, ray);
    let leaves_light = select(1.0, -1.0, is_front != (mesh.mirrored == 1u));
    if x >= piece.y || x > 1e25 {
        return vec4f(0.0, 0.0, 0.0, leaves_light);
    }
    var radiance = vec3f();
    // a loop, since some drivers execute both sides of every branch
    loop {
        if !(x > piece.x) {
            break;
        }
        radiance = leaves_light * piece_airlight(lamp, piece.x, x);
        break;
    }
    return vec4f(radiance, 0.0);
}

fn crossed(crossing: Crossing, is_front: bool) -> vec4f {
    let term = cross_at(crossing, is_front);
    if FIXED {
        let pixel = vec2u(crossing.position.xy);
        let whole = textureLoad(unshadowed, pixel, 0).rgb;
        let at = 3u * (pixel.y * view.size.x + pixel.x);
        for (var c = 0u; c < 3u; c++) {
            let share = term.a + select(0.0, term[c] / whole[c], whole[c] > 0.0);
            atomicAdd(&sums[at + c], i32(round(share * FIXED_ONE)));
        }
    }
    return term;
}
