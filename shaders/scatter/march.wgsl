// Airlight of one light by a march that looks its map up at every step, in a homogeneous medium without bounds.
//
// A ray is marched where occluders may shadow it at all, and adjoining steps of equal visibility are one evaluation of
// the interval form, so that all of the error is in where the shadows' boundaries are believed to be. In and out: see
// bindings.wgsl. Twin: `BruteForce` in crates/hybrid-march/src/brute_force.rs.

#import bindings
#import piece
#import shadow_map
#import steps

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    let ray = view_ray(pixel);
    var radiance = vec3f();
    let end = textureLoad(ray_ends, pixel, 0).r;
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, end);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    if piece.y > piece.x {
        var marched = piece;
        if LIGHT != SPOT {
            marched = shadowed_piece(LIGHT, lamp.foot, ray, piece);
        }
        let path = map_path(ray);
        let steps = steps_of(lamp.foot.foot, marched, false, LIGHT == DIRECTIONAL);
        let stop = select(0u, light.end_sample, marched.y > marched.x);
        let whole = light.end_sample == light.samples;
        let stop_at = select(step_at(steps, f32(stop)), max(marched.x, marched.y), whole);
        // the run so far: where it began and its visibility; what lies before and after is lit without a step
        var start = select(step_at(steps, f32(light.first_sample)), piece.x, light.first_sample == 0u);
        var visibility = select(0.0, 1.0, light.first_sample == 0u);
        var i = light.first_sample;
        let last = max(stop, light.first_sample) + 1u;
        loop {
            // goes on until a lit run ends, so that threads of a group integrate theirs together
            var run = vec3f();
            loop {
                if i > last || run.z > 0.0 {
                    break;
                }
                // after the steps what lies behind them, and then nothing
                var here = select(0.0, 1.0, whole && i + 1u == last);
                var border = select(piece.y, stop_at, i + 1u == last);
                if i + 1u < last {
                    here = map_visibility(path, step_at(steps, f32(i) + 0.5));
                    border = step_at(steps, f32(i));
                }
                if here != visibility {
                    run = vec3f(start, border, visibility);
                    start = border;
                    visibility = here;
                }
                i += 1u;
            }
            radiance += run.z * piece_airlight(lamp, run.x, run.y);
            if i > last {
                break;
            }
        }
    }
    var sum = vec4f(radiance, 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
