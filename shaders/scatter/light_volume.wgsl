// The airlight of a light from the crossings of each ray with the surface of its volume: sorted, and integrated between
// them where the ray is lit.
//
// In: what did not fit among the crossings that are kept in place of `faces`; else see light_crossing.wgsl and
// bindings.wgsl. Out: see bindings.wgsl. A sum of rounded terms may come out a little negative where all is dark: that is
// taken away, and left in alpha. (BSA10 Eq. 3; twin: crates/lightvolume/src/signed.rs)

#import bindings
#import piece

// as in light_crossing.wgsl, behind the number that is kept of each pixel
@group(2) @binding(0) var<storage, read> kept: array<u32>;
@group(2) @binding(1) var<uniform> most_kept: vec4u;

// whether the sums are shares of the unshadowed airlight
override FIXED: bool = false;

const MOST_KEPT: u32 = 16u;

// distances, negative where the ray enters the light
var<private> crossings: array<f32, MOST_KEPT>;

// Sorts the first crossings of a pixel by distance; returns the sum of their signs.
fn sorted(first: u32, count: u32) -> i32 {
    var signs = 0;
    for (var i = 0u; i < count; i++) {
        let crossing = bitcast<f32>(kept[first + i]);
        signs += select(-1, 1, crossing > 0.0);
        var at = i;
        for (; at > 0u && abs(crossings[at - 1u]) > abs(crossing); at--) {
            crossings[at] = crossings[at - 1u];
        }
        crossings[at] = crossing;
    }
    return signs;
}

fn closed(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    let first = (most_kept.x + 1u) * (pixel.y * view.size.x + pixel.x);
    let head = kept[first];
    let found = head & 0xffffu;
    let count = min(found, most_kept.x);
    // an orthographic volume is that of the shadow
    let ends_lit = (bitcast<i32>(head) >> 16u) + select(0, 1, LIGHT == DIRECTIONAL);
    var radiance = vec3f();
    if found > count {
        // some are in the sum: the others join them
        for (var i = 0u; i < count; i++) {
            let crossing = bitcast<f32>(kept[first + 1u + i]);
            radiance += sign(crossing) * piece_airlight(lamp, piece.x, min(abs(crossing), piece.y));
        }
        let whole = piece_airlight(lamp, piece.x, piece.y);
        let sum = textureLoad(faces, pixel, 0).rgb;
        return radiance + f32(ends_lit) * whole + select(sum, sum * whole, FIXED);
    }
    var is_lit = sorted(first + 1u, count) + ends_lit;
    var start = piece.x;
    for (var i = 0u; i <= count; i++) {
        var crossing = end;
        if i < count {
            crossing = crossings[i];
        }
        let x = clamp(abs(crossing), piece.x, piece.y);
        if is_lit > 0 && x > start {
            radiance += piece_airlight(lamp, start, x);
        }
        is_lit -= select(-1, 1, crossing > 0.0);
        start = x;
    }
    return radiance;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    add_clamped(pixel, closed(pixel));
}
