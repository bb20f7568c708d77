// Airlight of one light with the exact shadows of its map, or without a map in closed form: no step, no sample.
//
// In and out: see bindings.wgsl. Twins: crates/shadowmap/src/exact.rs with crates/ground-truth/src/airlight.rs.

#import bindings
#import piece
#import traversal

var<private> lamp: Lamp;
var<private> radiance: vec3f;

fn take_piece(x0: f32, x1: f32) {
    radiance += piece_airlight(lamp, x0, x1);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    if SHADOWED {
        walk(map_path(ray), piece);
    } else {
        radiance = piece_airlight(lamp, piece.x, piece.y);
    }
    var sum = vec4f(radiance, 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
