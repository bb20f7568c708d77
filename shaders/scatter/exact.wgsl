// Airlight of one light with the exact shadows of its map, or without a map in closed form: no step, no sample.
//
// In and out: see bindings.wgsl. Twins: crates/shadowmap/src/exact.rs with crates/ground-truth/src/airlight.rs.

#import bindings
#import piece
#import traversal

// lit pieces that wait to be integrated: threads of a group that march together then do it together
const WAITING: u32 = 8u;
var<private> pieces: array<vec2f, WAITING>;
var<private> piece_count: u32;
var<private> lamp: Lamp;
var<private> radiance: vec3f;

fn take_piece(x0: f32, x1: f32) {
    if piece_count == WAITING {
        integrate();
    }
    pieces[piece_count] = vec2f(x0, x1);
    piece_count += 1u;
}

fn integrate() {
    for (var i = 0u; i < piece_count; i++) {
        radiance += piece_airlight(lamp, pieces[i].x, pieces[i].y);
    }
    piece_count = 0u;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let ray = view_ray(id.xy);
    let end = textureLoad(ray_ends, id.xy, 0).r;
    lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    if SHADOWED {
        walk(map_path(ray), piece);
        integrate();
    } else {
        radiance = piece_airlight(lamp, piece.x, piece.y);
    }
    var sum = vec4f(radiance, 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, id.xy, 0);
    }
    textureStore(scattered, id.xy, sum);
}
