// What becomes of a crossing of a view ray with the surface of a light volume.
//
// The airlight of a ray is the sum of s L(0, x) over its crossings, with s = +1 where it leaves the light and -1 where it
// enters it (BSA10 Eq. 3). A crossing behind the end of the ray adds only its sign: what those signs sum to is 1 where the
// ray ends lit, and the airlight of the whole ray is added once for that. So nothing cancels behind the surfaces.
//
// The first crossings of each pixel are kept by their distances, to be sorted and integrated piece by piece, where nothing
// cancels at all; and where every thread has work to do, as the fragments of small triangles have not. What does not fit is
// summed as it comes: blended, or where float32 does not blend as a share of the unshadowed airlight in fixed point.
// In: group 0. Twin: crates/lightvolume/src/signed.rs.

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
// of each pixel: number of crossings before the end of the ray (16 bits), sum of the signs behind it (16 bits); then the
// distances of the first `mesh.kept`, negative where the ray enters the light; units: m
@group(0) @binding(9) var<storage, read_write> kept: array<atomic<u32>>;

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

// s L(0, x) of a crossing.
fn term(ray: ViewRay, end: f32, x: f32, leaves_light: f32) -> vec3f {
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    return leaves_light * piece_airlight(lamp, piece.x, min(x, piece.y));
}

fn add_fixed(pixel: vec2u, radiance: vec3f) {
    let whole = textureLoad(unshadowed, pixel, 0).rgb;
    let at = 3u * (pixel.y * view.size.x + pixel.x);
    for (var c = 0u; c < 3u; c++) {
        let share = select(0.0, radiance[c] / whole[c], whole[c] > 0.0);
        atomicAdd(&sums[at + c], i32(round(share * FIXED_ONE)));
    }
}

// Keeps a crossing, or returns what it adds.
fn crossed(crossing: Crossing, is_front: bool) -> vec4f {
    let pixel = vec2u(crossing.position.xy);
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let x = distance_of(crossing, ray);
    let leaves_light = is_front == (mesh.mirrored == 1u);
    let at = (mesh.kept + 1u) * (pixel.y * view.size.x + pixel.x);
    let is_behind = x >= end || x > 1e25;
    let sign_behind = select(0xffff0000u, 0x00010000u, leaves_light);
    let slot = atomicAdd(&kept[at], select(1u, sign_behind, is_behind)) & 0xffffu;
    var radiance = vec3f();
    // a loop, since some drivers execute both sides of every branch
    loop {
        if is_behind {
            break;
        }
        if slot < mesh.kept {
            atomicStore(&kept[at + 1u + slot], bitcast<u32>(max(x, 1e-30)) | select(0x80000000u, 0u, leaves_light));
            break;
        }
        radiance = term(ray, end, x, select(-1.0, 1.0, leaves_light));
        if FIXED {
            add_fixed(pixel, radiance);
        }
        break;
    }
    if is_behind || slot < mesh.kept {
        discard;
    }
    return vec4f(radiance, 0.0);
}
