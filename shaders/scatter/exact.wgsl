// Airlight of one light with the exact shadows of its map, or without a map in closed form: no step, no sample.
//
// In and out: see bindings.wgsl. Twins: crates/shadowmap/src/exact.rs with crates/ground-truth/src/airlight.rs.

#import bindings
#import piece
#import traversal

fn exact(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    if !SHADOWED {
        return piece_airlight(lamp, piece.x, piece.y);
    }
    var radiance = vec3f();
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
    return radiance;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var radiance = vec3f();
    // a loop, since some drivers execute both sides of every branch
    loop {
        if !is_wanted(pixel) {
            break;
        }
        radiance = exact(pixel);
        break;
    }
    add_radiance(pixel, radiance);
}
