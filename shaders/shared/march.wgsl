// Airlight of one light along a view ray by a march that asks for visibility at every step, in a homogeneous medium
// without bounds.
//
// A ray is marched where occluders may shadow it at all, and adjoining steps of equal visibility are one evaluation of
// the interval form, so that all of the error is in where the shadows' boundaries are believed to be. The importing pass
// declares what piece.wgsl asks for and defines `visibility_at(sight, x)` and `sight_of(ray)`. Twin: `BruteForce` in
// crates/hybrid-march/src/brute_force.rs.

#import piece
#import steps

// A run of steps of one visibility.
struct Run {
    i: u32,           // the step that comes next
    first: u32,       // its first step
    from_start: bool, // whether it began before the march
    visibility: f32,
    ended: bool,      // whether it was lit and step i - 1 differs
    after: f32,       // visibility of that step
}

// The run with one more step: a dark one gives way to what follows, a lit one ends.
fn next_step(run: Run, visibility: f32) -> Run {
    let differs = visibility != run.visibility;
    let ended = differs && run.visibility > 0.0;
    let begins = differs && !ended;
    return Run(
        run.i + 1u, select(run.first, run.i, begins), run.from_start && !begins,
        select(run.visibility, visibility, begins), ended, visibility,
    );
}

// Radiance of the steps that this dispatch marches; units: W/(m^2 sr).
fn march(pixel: vec2u) -> vec3f {
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
        let sight = sight_of(ray);
        let steps = steps_of(lamp.foot.foot, marched, false, LIGHT == DIRECTIONAL);
        let equal = steps.kind == EQUAL_STEPS;
        let width = (marched.y - marched.x) / f32(light.samples);
        let whole = light.end_sample == light.samples;
        let stop = select(light.first_sample, light.end_sample, marched.y > marched.x);
        let marched_to = max(marched.x, marched.y);
        // the run so far: its first step and visibility; the first run of all is lit from where the piece begins
        var i = light.first_sample;
        var first = i;
        var from_start = i == 0u;
        var visibility = select(0.0, 1.0, from_start);
        // whether the march is over and only what lies after it is left
        var tail = false;
        loop {
            // goes on until a lit run ends, so that threads of a group integrate theirs together
            var run = Run(i, first, from_start, visibility, false, visibility);
            // two loops: some drivers execute both sides of every branch, and only a loop is left out
            loop {
                if !equal || run.i >= stop || run.ended {
                    break;
                }
                run = next_step(run, visibility_at(sight, marched.x + (f32(run.i) + 0.5) * width));
            }
            loop {
                if equal || run.i >= stop || run.ended {
                    break;
                }
                run = next_step(run, visibility_at(sight, step_at(steps, f32(run.i) + 0.5)));
            }
            let joined = !run.ended && whole && run.visibility == 1.0;
            var start = select(step_at(steps, f32(run.first)), piece.x, run.from_start);
            start = select(start, marched_to, tail);
            let end = step_at(steps, f32(select(stop, run.i - 1u, run.ended)));
            radiance += run.visibility * piece_airlight(lamp, start, select(end, piece.y, joined));
            if !run.ended {
                if tail || joined || !whole || piece.y <= marched_to {
                    break;
                }
                tail = true;
            }
            i = run.i;
            first = select(stop, run.i - 1u, run.ended);
            from_start = false;
            visibility = select(1.0, run.after, run.ended);
        }
    }
    return radiance;
}
