// Airlight of a spot whose intensity varies along a view ray, by a march in three segments of its cone: before, between and
// behind the outermost faces of its shadow volume (Wyman and Ramsey 2008, sections 3.2 and 3.3), in a homogeneous medium
// without bounds.
//
// Visibility is asked between the faces alone, unless a segment is dark at its outer ends; a boundary between two lookups is
// bisected `light.refine` times. A step's intensity is the
// picture's mean over it times that of the falloff, and its airlight is exact. The importing pass declares what piece.wgsl
// and light_mips.wgsl ask for and the texture `faces`, and defines `visibility_at(sight, x)` and `sight_of(ray)`.
// Twin: crates/hybrid-march/src/textured.rs.

#import piece
#import steps
#import frame_table
#import light_mips

// neither 1/d^2 nor extinction on the light's way
override HOFFMAN_PREETHAM: bool = false;
// steps of equal length instead of equal angle at the light
override EQUAL_DISTANCE: bool = false;
// the picture's mean over a step instead of its colour in the middle
override MIPS: bool = true;
// whether the faces are those of a part of the casters: visibility is asked everywhere
override PARTIAL: bool = false;

// How far inside a segment its ends are asked for light, as a share of it: off the surface that may bound it.
const INSIDE: f32 = 1e-3;

fn samples_of(segment: u32) -> u32 {
    return select(light.lit_samples, light.samples, segment == 1u);
}

// Whether visibility has to be asked in a segment; `found` says whether the ray meets a face.
fn is_shadowed(sight: Sight, segment: u32, steps: Steps, found: bool) -> bool {
    if !SHADOWED {
        return false;
    }
    var dark = segment == 1u || PARTIAL;
    for (var k = 0; k < 2; k++) {
        if dark || (k == 1 && segment == 0u && found) {
            break;
        }
        dark = visibility_at(sight, share_at(steps, select(INSIDE, 1.0 - INSIDE, k == 1))) < 1.0;
    }
    return dark;
}

// Falloff towards w, and in Hoffman and Preetham's model the phase value.
fn smooth_factor(lamp: Lamp, x: f32) -> f32 {
    let w = away_from(lamp, x);
    let falloff = spot_falloff(w);
    if !HOFFMAN_PREETHAM {
        return falloff;
    }
    return falloff * phase_between(-w / max(length(w), 1e-30), lamp.direction);
}

// The middle of a step: as much airlight on either side, but for what varies slowly.
fn middle_of(foot: Foot, start: f32, end: f32) -> f32 {
    let near = length(vec2f(start - foot.x_foot, foot.h));
    if end >= 1e29 {
        return start + near;
    }
    if HOFFMAN_PREETHAM {
        return 0.5 * (start + end);
    }
    let far = length(vec2f(end - foot.x_foot, foot.h));
    return start + (end - start) * near / (near + far);
}

// Airlight of a lit step; units: W/(m^2 sr).
fn step_airlight(lamp: Lamp, start: f32, end: f32) -> vec3f {
    let middle = middle_of(lamp.foot.foot, start, end);
    // a direction is all that an endless ray leaves
    let far = min(end, 1e15);
    let mean = (smooth_factor(lamp, start) + 4.0 * smooth_factor(lamp, middle) + smooth_factor(lamp, far)) / 6.0;
    var colour = vec3f(1.0);
    if TEXTURED && MIPS {
        colour = line_colour(picture_coordinates(away_from(lamp, start)), picture_coordinates(away_from(lamp, far)));
    } else if TEXTURED {
        colour = picture_colour(away_from(lamp, middle));
    }
    let intensity = mean * colour * light.power;
    if HOFFMAN_PREETHAM {
        return sunlit_airlight(1.0, intensity, start, end);
    }
    if TABLE != NO_TABLE {
        return intensity * max(airlight_to(lamp, end) - airlight_to(lamp, start), vec3f());
    }
    return constant_airlight(lamp, intensity, start, end);
}

// Radiance of all steps of the ray; units: W/(m^2 sr).
fn hybrid_textured(pixel: vec2u) -> vec3f {
    let ray = view_ray(pixel);
    let lamp = lamp_of(ray);
    let cos2 = light.cos_outer * light.cos_outer;
    let whole = vec2f(0.0, textureLoad(ray_ends, pixel, 0).r);
    let piece = cone_piece(lamp.foot, light.axis, ray.direction, cos2, whole);
    var radiance = vec3f();
    if !(piece.y > piece.x) {
        return radiance;
    }
    var front = piece.y;
    var back = piece.y;
    var found = false;
    if SHADOWED {
        let kept = textureLoad(faces, pixel / light.face_scale, 0).rg;
        found = kept.x > 0.0;
        let backmost = select(ray.length / max(abs(kept.y), 1e-30), ENDLESS, kept.y == 0.0);
        front = select(piece.y, clamp(ray.length / max(kept.x, 1e-30), piece.x, piece.y), found);
        back = select(piece.y, clamp(backmost, front, piece.y), found);
    }
    let sight = sight_of(ray);
    let foot = lamp.foot.foot;
    // where visibility was found last, and what it was
    var known = vec2f(piece.x, 1.0);
    for (var segment = 0u; segment < 3u; segment++) {
        var span = vec2f(piece.x, front);
        if segment == 1u {
            span = vec2f(front, back);
        } else if segment == 2u {
            span = vec2f(back, piece.y);
        }
        let count = select(0u, samples_of(segment), span.y > span.x);
        let steps = steps_of(foot, span, !EQUAL_DISTANCE, false);
        var shadowed = false;
        // loops, since some drivers execute both sides of every branch
        loop {
            if count == 0u {
                break;
            }
            shadowed = is_shadowed(sight, segment, steps, found);
            break;
        }
        var start = span.x;
        for (var i = 0u; i < count; i++) {
            let end = select(share_at(steps, f32(i + 1u) / f32(count)), span.y, i + 1u == count);
            let middle = middle_of(foot, start, end);
            var seen = vec2f(select(start, middle, shadowed), 1.0);
            loop {
                if !shadowed {
                    break;
                }
                seen.y = visibility_at(sight, middle);
                break;
            }
            // a boundary since the last lookup, and so a piece on the wrong side of the border between two steps
            var wrong = vec2f(start, start);
            var change = 0.0;
            loop {
                if known.y == seen.y || light.refine == 0u || seen.x >= 1e29 {
                    break;
                }
                var low = known.x;
                var high = seen.x;
                // of this ray's own: the same for all, lavapipe would unroll it anew in every dispatch
                let bisections = select(0u, light.refine, known.y != seen.y);
                for (var k = 0u; k < bisections; k++) {
                    let between = 0.5 * (low + high);
                    let same = visibility_at(sight, between) == known.y;
                    low = select(low, between, same);
                    high = select(between, high, same);
                }
                let boundary = 0.5 * (low + high);
                wrong = vec2f(min(boundary, start), max(boundary, start));
                change = select(known.y - seen.y, seen.y - known.y, boundary < start);
                break;
            }
            // the step, then what was on the wrong side
            var part = vec3f(start, end, seen.y);
            loop {
                loop {
                    if part.z == 0.0 || part.y <= part.x {
                        break;
                    }
                    radiance += part.z * step_airlight(lamp, part.x, part.y);
                    break;
                }
                if change == 0.0 {
                    break;
                }
                part = vec3f(wrong, change);
                change = 0.0;
            }
            known = select(vec2f(end, 1.0), seen, shadowed);
            start = end;
        }
    }
    return radiance;
}
