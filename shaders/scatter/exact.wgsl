// Airlight of one light with the exact shadows of its map, or without a map in closed form: no step, no sample.
//
// In and out: see bindings.wgsl. Twins: crates/shadowmap/src/exact.rs with crates/ground-truth/src/airlight.rs.

#import bindings
#import piece
#import traversal

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    var radiance = vec3f();
    if SHADOWED {
        let path = map_path(ray);
        loop {
            walk(path, piece);
            let kept = min(found - dealt_with, KEPT);
            for (var i = 0u; i < kept; i++) {
                radiance += piece_airlight(lamp, pieces[i].x, pieces[i].y);
            }
            dealt_with += kept;
            if dealt_with >= found {
                break;
            }
        }
    } else {
        radiance = piece_airlight(lamp, piece.x, piece.y);
    }
    var sum = vec4f(radiance, 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
