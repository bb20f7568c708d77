// Airlight of one light by a march that looks its map up at every step, in a homogeneous medium without bounds.
//
// A ray is marched where occluders may shadow it at all, and adjoining steps of equal visibility are one evaluation of
// the interval form, so that all of the error is in where the shadows' boundaries are believed to be. In and out: see
// bindings.wgsl. Twin: `BruteForce` in crates/hybrid-march/src/brute_force.rs.

#import bindings
#import piece
#import shadow_map
#import steps

// runs that wait to be integrated: threads of a group that march together then do it together
const WAITING: u32 = 8u;
var<private> runs: array<vec3f, WAITING>;
var<private> run_count: u32;
var<private> lamp: Lamp;
var<private> radiance: vec3f;

// A run from x0 to x1 (xy) of one visibility (z).
fn take_run(run: vec3f) {
    if !(run.z > 0.0 && run.y > run.x) {
        return;
    }
    if run_count == WAITING {
        integrate();
    }
    runs[run_count] = run;
    run_count += 1u;
}

fn integrate() {
    for (var i = 0u; i < run_count; i++) {
        radiance += runs[i].z * piece_airlight(lamp, runs[i].x, runs[i].y);
    }
    run_count = 0u;
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
    if piece.y > piece.x {
        var marched = piece;
        if LIGHT != SPOT {
            marched = shadowed_piece(LIGHT, lamp.foot, ray, piece);
        }
        let path = map_path(ray);
        let steps = steps_of(lamp.foot.foot, marched, false, LIGHT == DIRECTIONAL);
        let stop = select(0u, light.end_sample, marched.y > marched.x);
        // what lies before and after is lit without a step
        var run = vec3f(piece.x, marched.x, 1.0);
        if light.first_sample > 0u {
            run = vec3f(step_at(steps, f32(light.first_sample)), 0.0, 0.0);
        }
        for (var i = light.first_sample; i < stop; i++) {
            let visibility = map_visibility(path, step_at(steps, f32(i) + 0.5));
            if visibility != run.z {
                let start = step_at(steps, f32(i));
                take_run(vec3f(run.x, start, run.z));
                run = vec3f(start, start, visibility);
            }
        }
        if light.end_sample == light.samples {
            let after = max(marched.x, marched.y);
            if run.z != 1.0 {
                take_run(vec3f(run.x, after, run.z));
                run = vec3f(after, after, 1.0);
            }
            take_run(vec3f(run.x, piece.y, 1.0));
        } else {
            take_run(vec3f(run.x, step_at(steps, f32(stop)), run.z));
        }
        integrate();
    }
    var sum = vec4f(radiance, 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, id.xy, 0);
    }
    textureStore(scattered, id.xy, sum);
}
