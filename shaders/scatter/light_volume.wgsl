// The airlight of a light whose volume's crossings are summed: closed where the ray ends lit.
//
// In: the sums in place of `faces`, see light_crossing.wgsl; else and out: see bindings.wgsl. A sum of rounded terms comes
// out a little negative where all is dark: that is taken away, and left in alpha.   (BSA10 Eq. 3; twin:
// crates/lightvolume/src/signed.rs)

#import bindings
#import piece

// whether the sums are shares of the unshadowed airlight
override FIXED: bool = false;

fn closed(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    let sum = textureLoad(faces, pixel, 0);
    // an orthographic volume is that of the shadow
    let ends_lit = sum.a + select(0.0, 1.0, LIGHT == DIRECTIONAL);
    var radiance = sum.rgb;
    loop {
        if ends_lit == 0.0 && !FIXED {
            break;
        }
        let whole = piece_airlight(lamp, piece.x, piece.y);
        radiance = select(sum.rgb + ends_lit * whole, (sum.rgb + ends_lit) * whole, FIXED);
        break;
    }
    return radiance;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    let radiance = closed(pixel);
    add_clamped(pixel, radiance);
}
