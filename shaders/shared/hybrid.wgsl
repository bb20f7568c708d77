// Airlight of one light along a view ray by a march between the frontmost and the backmost face of its shadow volume
// (Wyman and Ramsey 2008, section 3.1), in a homogeneous medium without bounds.
//
// Before the one and behind the other everything is lit. A ray that starts or ends in shadow meets no face there: visibility
// is asked at its ends, and at the backmost face, which may be that of a neighbouring ray where faces are kept by tile.
// Each boundary that is found between two steps is bisected `light.refine` times by further lookups. The importing pass
// declares what piece.wgsl asks for and the texture `faces`, and defines `visibility_at(sight, x)` and `sight_of(ray)`.
// Twin: crates/hybrid-march/src/hybrid.rs.

#import piece
#import steps
#import frame_table

// steps of equal length between the faces, instead of equal angle at a local light; endless rays have none
override EQUAL_DISTANCE: bool = false;

// How far behind its start visibility is asked whether a ray without faces starts in shadow, as a share of the ray.
const BEHIND_START: f32 = 1e-4;

// How near to its end visibility is asked whether a ray ends in shadow, as a share of the ray.
const BEFORE_END: f32 = 1e-6;

// Lookups of a ray, at most, of which bisections take what the steps leave: some drivers cut all loops of a group of threads
// together at 65,535 trips, and a shadow ray takes many.
override MOST_LOOKUPS: u32 = 30000u;

// Lookups before the first step.
const FIRST_LOOKUPS: u32 = 3u;

// Optical depth behind which no step is taken on an endless ray.
const MARCH_DEPTH: f32 = 16.0;

// Bisections, at least, of the boundary behind the backmost face where a ray ends in shadow.
const LEAST_TAIL: u32 = 8u;

// What lies between the faces of a ray, and what is known outside.
struct Between {
    marched: vec2f, // units: m
    covered: bool,  // whether anything may be shadowed
    first: f32,     // visibility just behind where the piece starts
    last: f32,      // visibility where the march ends
    tail: bool,     // whether the ray is lit behind the faces and dark at its end
}

fn between_faces(ray: ViewRay, foot: Foot, sight: Sight, piece: vec2f, pixel: vec2u) -> Between {
    let kept = textureLoad(faces, pixel / light.face_scale, 0).rg;
    let found = kept.x > 0.0;
    let endless = piece.y >= 1e29;
    // a drawn back face is stored with its sign turned
    let backmost = select(ray.length / max(abs(kept.y), 1e-30), ENDLESS, kept.y == 0.0);
    let front = clamp(ray.length / max(kept.x, 1e-30), piece.x, piece.y);
    // without faces nothing changes along the ray: it is asked in its middle
    let back = select(piece.x, clamp(backmost, piece.x, piece.y), found);
    // behind the backmost face nothing changes before the surface that ends the ray: so it is asked halfway, where no
    // rounding answers, nor the texel of a map beside it
    let behind = share_at(steps_of(foot, vec2f(back, piece.y), false, LIGHT == DIRECTIONAL), 0.5);
    // before the frontmost face nothing changes either. Not at the eye: there all rays would get one answer, and a wrong one
    // where it lies on a face or in line with an edge
    let ahead = vec2f(piece.x, select(piece.y, front, found));
    let inside = share_at(
        steps_of(foot, ahead, false, LIGHT == DIRECTIONAL), select(BEHIND_START, 0.5, found),
    );
    let asked = vec3f(inside, behind, piece.y - BEFORE_END * (piece.y - piece.x));
    var seen = vec3f(1.0);
    for (var k = 0; k < 3; k++) {
        // so far away no light is left; and to a ray from there the whole hierarchy is one line, which it goes through
        if endless && (k == 2 || (k == 1 && back >= MARCH_DEPTH / view.least_extinction)) {
            continue;
        }
        seen[k] = visibility_at(sight, asked[k]);
    }
    let starts_dark = seen.x < 1.0;
    // a shadow ray may slip through between two triangles: one answer does not decide a ray
    let covered = found || starts_dark || seen.y < 1.0;
    let on = covered && (!found || seen.y < 1.0);
    // a face of an endless ray may be thousands of scenes away: behind this depth no light is left
    let last_back = select(back, min(back, MARCH_DEPTH / view.least_extinction), endless);
    let last_step = select(last_back, piece.y, on);
    let marched = vec2f(min(select(front, piece.x, starts_dark), last_step), last_step);
    let last = select(1.0, seen.z, on && !endless);
    return Between(marched, covered, seen.x, last, !on && seen.z < 1.0);
}

// Radiance of all pieces of the ray; units: W/(m^2 sr).
fn hybrid(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let lamp = lamp_of(ray);
    var piece = vec2f(0.0, textureLoad(ray_ends, pixel, 0).r);
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    var radiance = vec3f();
    if !(piece.y > piece.x) {
        return radiance;
    }
    let sight = sight_of(ray);
    let between = between_faces(ray, lamp.foot.foot, sight, piece, pixel);
    let marched = between.marched;
    let steps = steps_of(lamp.foot.foot, marched, !EQUAL_DISTANCE || piece.y >= 1e29, LIGHT == DIRECTIONAL);
    let endless = marched.y >= 1e29;
    // after the steps: where the march ends, and the end of the ray
    let stops = select(light.samples, light.samples + select(1u, 2u, between.tail), between.covered || between.tail);
    let equal = steps.kind == EQUAL_STEPS;
    let width = (marched.y - marched.x) / f32(light.samples);
    // nothing between the faces, but maybe behind them
    var i = select(light.samples, 0u, between.covered);
    var state = between.first;
    var start = piece.x;
    var lookups = FIRST_LOOKUPS + light.samples;
    // where the state was last seen
    var before = select(piece.x, marched.x, between.covered);
    loop {
        // goes on until a run of light ends, so that threads of a group integrate theirs together
        var run = vec2f(start, piece.y);
        var share = state;
        var ended = false;
        loop {
            if i >= stops || ended {
                break;
            }
            var x = before;
            var border = before;
            var seen = state;
            // two loops with nothing else in them: some drivers execute both sides of every branch, and only a loop is
            // left out
            loop {
                if !equal || i >= light.samples || seen != state {
                    break;
                }
                before = x;
                x = marched.x + (f32(i) + 0.5) * width;
                seen = visibility_at(sight, x);
                i++;
            }
            loop {
                if equal || i >= light.samples || seen != state {
                    break;
                }
                before = x;
                x = step_at(steps, f32(i) + 0.5);
                seen = visibility_at(sight, x);
                i++;
            }
            border = step_at(steps, f32(i - min(i, 1u)));
            var bisections = select(0u, light.refine, LOOKUP == 0u || LOOKUP == 3u);
            if seen == state && i >= light.samples && i < stops {
                // behind the steps
                before = x;
                let tail = i > light.samples;
                x = select(select(piece.x, marched.y, between.covered), piece.y, tail);
                border = x;
                seen = select(select(between.last, state, endless), 0.0, tail);
                bisections = select(bisections, max(bisections, LEAST_TAIL), tail);
                i++;
            }
            if seen != state {
                bisections = min(bisections, MOST_LOOKUPS - min(lookups, MOST_LOOKUPS));
                lookups += bisections;
                var low = before;
                var high = x;
                for (var k = 0u; k < bisections; k++) {
                    let middle = 0.5 * (low + high);
                    let same = visibility_at(sight, middle) == state;
                    low = select(low, middle, same);
                    high = select(middle, high, same);
                }
                // the border of a face is kept if no lookup finds the boundary elsewhere
                let kept = bisections == 0u || border == low || border == high;
                border = select(0.5 * (low + high), border, kept);
                run = vec2f(start, border);
                share = state;
                ended = state > 0.0;
                start = border;
                state = seen;
            }
            before = x;
        }
        if !ended {
            run = vec2f(start, piece.y);
            share = state;
        }
        radiance += share * run_airlight(lamp, run.x, run.y);
        if !ended {
            break;
        }
    }
    return radiance;
}
