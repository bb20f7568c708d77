// The airlight of a light from the crossings of each ray with the surface of its volume: sorted, and integrated between
// them where the ray is lit.
//
// In: the sums of pixels whose crossings are not all noted, in place of `faces`; else see light_crossing.wgsl and
// bindings.wgsl. Out: see bindings.wgsl. A sum of rounded terms may come out a little negative where all is dark: that is
// taken away, and left in alpha. (BSA10 Eq. 3; twin: crates/lightvolume/src/signed.rs)

#import bindings
#import piece

// see light_crossing.wgsl
@group(2) @binding(0) var<storage, read> notes: array<u32>;
// crossings for which there is room (x)
@group(2) @binding(1) var<uniform> pool: vec4u;

// whether the sums are shares of the unshadowed airlight
override FIXED: bool = false;

const IS_SUMMED: u32 = 1u;

// A crossing of a list: distance, negative where the ray enters the light; units: m.
fn noted(place: u32) -> f32 {
    return bitcast<f32>(notes[2u * (view.size.x * view.size.y + place) - 1u]);
}

fn previous(place: u32) -> u32 {
    return notes[2u * (view.size.x * view.size.y + place)];
}

// The next crossing of a list after that at distance x and place `last`, by distance and then by place; 0 for none.
fn next_of(list: u32, x: f32, last: u32) -> u32 {
    var next = 0u;
    var nearest = ENDLESS;
    for (var place = list; place != 0u; place = previous(place)) {
        let at = abs(noted(place));
        let is_after = at > x || (at == x && place > last);
        let is_nearer = at < nearest || (at == nearest && (place < next || next == 0u));
        if is_after && is_nearer {
            nearest = at;
            next = place;
        }
    }
    return next;
}

fn closed(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    let first = 1u + 2u * (pixel.y * view.size.x + pixel.x);
    let head = notes[first];
    let is_summed = (pool.x == 0u) | ((head & IS_SUMMED) != 0u);
    // where all is summed the whole ray is one piece
    let list = select(notes[first + 1u], 0u, is_summed);
    // an orthographic volume is that of the shadow
    var is_lit = (bitcast<i32>(head) >> 16u) + select(0, 1, LIGHT == DIRECTIONAL);
    let whole_lit = f32(is_lit);
    for (var place = list; place != 0u; place = previous(place)) {
        is_lit += select(-1, 1, noted(place) > 0.0);
    }
    var radiance = vec3f();
    var start = piece.x;
    var last = 0u;
    var x = -1.0;
    loop {
        last = next_of(list, x, last);
        var sign_here = 0;
        x = end;
        if last != 0u {
            let crossing = noted(last);
            x = abs(crossing);
            sign_here = select(-1, 1, crossing > 0.0);
        }
        let at = clamp(x, piece.x, piece.y);
        if ((is_lit > 0) | is_summed) && at > start {
            radiance += piece_airlight(lamp, start, at);
        }
        is_lit -= sign_here;
        start = at;
        if last == 0u {
            break;
        }
    }
    if !is_summed {
        return radiance;
    }
    // the surface may be crossed twice just behind the end, or once more in front of it: rounding moves a pair that a ray
    // meets at its edge to both sides of the end, and what one adds the other's sign takes back
    let sum = textureLoad(faces, pixel, 0).rgb;
    if FIXED {
        return (sum + whole_lit) * radiance;
    }
    return sum + whole_lit * radiance;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    add_clamped(pixel, closed(pixel));
}
