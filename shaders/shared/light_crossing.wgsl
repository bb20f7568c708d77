// What becomes of a crossing of a view ray with the surface of a light volume.
//
// The airlight of a ray is the sum of s L(0, x) over its crossings, with s = +1 where it leaves the light and -1 where it
// enters it (BSA10 Eq. 3). A crossing behind the end of the ray adds only its sign: what those signs sum to is 1 where the
// ray ends lit, and the airlight of the whole ray is added once for that. So nothing cancels behind the surfaces.
//
// A first pass notes the crossings of each pixel in a list, to be sorted and integrated piece by piece, where nothing
// cancels at all; and where every thread has work to do, as the fragments of small triangles have not. The lists share one
// pool. Pixels for which it had no room are summed by a second pass: blended, or where float32 does not blend as a share
// of the unshadowed airlight in fixed point. Without a pool that is the only pass, as in the paper.
//
// Terms of the sum are measured from the end of the ray on the same side of the light: s L(0, x) before the ray's foot,
// -s L(x, end) behind it. Then the airlight next to the light, which may be all there is, is in no term, and is added with
// that of the whole ray where the foot is lit.
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
// crossings that are noted, of all pixels; then of each pixel two words: the sum of the signs of what lies behind its end
// (upper 16 bits) and IS_SUMMED, and the last of its list; then of each that is noted its distance (m), negative where the
// ray enters the light, and the one before it. Places in the list begin at 1.
@group(0) @binding(9) var<storage, read_write> notes: array<atomic<u32>>;
// 1 if the pool is too small
@group(0) @binding(10) var<storage, read_write> overflow: array<atomic<u32>>;

override LIGHT: u32 = 0u;
override TEXTURED: bool = false;
override ACHROMATIC: bool = true;
override ISOTROPIC: bool = true;
// whether sums are in fixed point
override FIXED: bool = false;
// whether this is the pass that sums
override SUMS: bool = false;

// 1 in fixed point
const FIXED_ONE: f32 = 16777216.0;
// a pixel of which not all crossings are noted
const IS_SUMMED: u32 = 1u;

// Distance at which a ray meets the plane of the triangle; units: m.
//
// The rasteriser moves vertices to its grid. The distance that it interpolates lies within the triangle, but errs where
// the triangle is seen from its edge; that of the plane is exact, but runs away where the ray passes the triangle by.
fn distance_of(crossing: Crossing, ray: ViewRay) -> f32 {
    let interpolated = ray.length / max(crossing.weight * crossing.position.w, 1e-30);
    let met = -crossing.plane.w / dot(crossing.plane.xyz, ray.direction);
    return select(interpolated, met, abs(met - interpolated) <= 0.1 * interpolated);
}

// What a crossing adds, measured from the end of the ray on its side of the light.
fn term(ray: ViewRay, end: f32, x: f32, is_behind_foot: bool) -> vec3f {
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    let at = clamp(x, piece.x, piece.y);
    let from_end = select(vec2f(piece.x, at), vec2f(at, piece.y), is_behind_foot);
    return piece_airlight(lamp, from_end.x, from_end.y) * select(1.0, -1.0, is_behind_foot);
}

fn add_fixed(pixel: vec2u, radiance: vec3f) {
    let whole = textureLoad(unshadowed, pixel, 0).rgb;
    let at = 3u * (pixel.y * view.size.x + pixel.x);
    for (var c = 0u; c < 3u; c++) {
        let share = select(0.0, radiance[c] / whole[c], whole[c] > 0.0);
        atomicAdd(&sums[at + c], i32(round(share * FIXED_ONE)));
    }
}

fn signed(leaves_light: bool) -> u32 {
    return select(0xffff0000u, 0x00010000u, leaves_light);
}

// Notes a crossing before the end of the ray.
fn note(at: u32, x: f32, leaves_light: bool) {
    let place = atomicAdd(&notes[0], 1u);
    if place >= mesh.pool {
        atomicOr(&notes[at], IS_SUMMED);
        atomicStore(&overflow[0], 1u);
        return;
    }
    let own = 1u + 2u * (view.size.x * view.size.y + place);
    let before = atomicExchange(&notes[at + 1u], place + 1u);
    atomicStore(&notes[own], bitcast<u32>(max(x, 1e-30)) | select(0x80000000u, 0u, leaves_light));
    atomicStore(&notes[own + 1u], before);
}

// Notes a crossing, or returns what it adds.
fn crossed(crossing: Crossing, is_front: bool) -> vec4f {
    let pixel = vec2u(crossing.position.xy);
    let ray = view_ray(pixel);
    let met = distance_of(crossing, ray);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let x = select(met, ENDLESS, met > 1e25);
    let leaves_light = is_front == (mesh.mirrored == 1u);
    let at = 1u + 2u * (pixel.y * view.size.x + pixel.x);
    let is_only = mesh.pool == 0u;
    if !SUMS || is_only {
        if x >= end {
            atomicAdd(&notes[at], signed(leaves_light));
        } else if !SUMS {
            note(at, x, leaves_light);
        }
    }
    if !SUMS {
        return vec4f();
    }
    let is_behind_foot = LIGHT != DIRECTIONAL && x > dot(light.to_light, ray.direction);
    var radiance = vec3f();
    // a loop, since some drivers execute both sides of every branch
    loop {
        if x >= end || !(is_only || (atomicLoad(&notes[at]) & IS_SUMMED) != 0u) {
            break;
        }
        if is_behind_foot {
            atomicAdd(&notes[at], signed(leaves_light));
        }
        radiance = select(-1.0, 1.0, leaves_light) * term(ray, end, x, is_behind_foot);
        if FIXED {
            add_fixed(pixel, radiance);
        }
        break;
    }
    return vec4f(radiance, 0.0);
}
