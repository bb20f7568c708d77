// Airlight of one light, or the medium's own glow, along a view ray by a march with the transmittance of the way so far.
//
// For everything that has no closed form between boundaries: a density over space, a bounded medium, a textured spot,
// Hoffman and Preetham's model, emission. What the march has passed so far is handed from one dispatch to the next in the
// fourth channel. The importing pass declares what piece.wgsl and light_path.wgsl ask for and defines
// `visibility_at(sight, x)` and `sight_of(ray)`. Twin: `BruteForce` in crates/hybrid-march/src/brute_force.rs.

#import piece
#import steps
#import light_path

// the medium's own glow
const GLOW: u32 = 3u;
// optical depth at which a march along an infinite ray stops
const MARCH_DEPTH: f32 = 16.0;

override BOUNDED: bool = false;
override DENSITY: u32 = 0u;
// neither 1/d^2 nor extinction on the light's way
override HOFFMAN_PREETHAM: bool = false;

// The end of an infinite piece at which no light is left, or all but a millionth of what the ray meets is passed.
fn opaque_end(direction: vec3f, piece: vec2f) -> f32 {
    let all = 0.999999 * optical_path(vec3f(), direction, vec2f(piece.x, ENDLESS));
    let enough = min(MARCH_DEPTH / view.least_extinction, all);
    if DENSITY == HEIGHT_DENSITY && !BOUNDED && direction.y > 0.0 && enough == all {
        // the millionth that is left lies above y0: a bisection would look for it in the last digits of the path
        let top = view.height_scale / direction.y;
        let left = (all / 0.999999) * 1e-6;
        return max(top * accurate_log(top / left) + view.height_y0 / direction.y, piece.x);
    }
    var low = piece.x;
    var high = piece.x + 1.0;
    for (var i = 0; i < 100; i++) {
        if optical_path(vec3f(), direction, vec2f(piece.x, high)) >= enough {
            break;
        }
        low = high;
        high = 2.0 * high;
    }
    for (var i = 0; i < 40; i++) {
        let middle = 0.5 * (low + high);
        if optical_path(vec3f(), direction, vec2f(piece.x, middle)) < enough {
            low = middle;
        } else {
            high = middle;
        }
    }
    return high;
}

// Integral of dx/d^2 over a step; units: 1/m.
fn inverse_square(foot: Foot, start: f32, end: f32) -> f32 {
    let a = start - foot.x_foot;
    let width = end - start;
    return accurate_angle(foot.h * width, foot.h * foot.h + a * (a + width)) / foot.h;
}

// Radiance so far with the steps that this dispatch marches (rgb), and the optical path that they end at (a).
fn march_varying(pixel: vec2u) -> vec4f {
    let ray = view_ray(pixel);
    let direction = to_world(ray.direction);
    var piece = vec2f(0.0, textureLoad(ray_ends, pixel, 0).r);
    if BOUNDED {
        piece = box_piece(view.bounds_min, view.bounds_max, vec3f(), direction, piece);
    }
    if DENSITY == GRID_DENSITY {
        piece = box_piece(view.grid_min, view.grid_max, vec3f(), direction, piece);
    }
    var lamp: Lamp;
    if LIGHT != GLOW {
        lamp = lamp_of(ray);
    }
    if LIGHT == SPOT {
        piece = cone_piece(lamp.foot, light.axis, ray.direction, light.cos_outer * light.cos_outer, piece);
    }
    // no branches on uniforms alone: see pixels.wgsl
    let sum = select(vec4f(), so_far(pixel), light.adds == ADDS);
    if !(piece.y > piece.x) {
        return sum;
    }
    let endless = piece.y >= 1e29;
    if endless {
        piece.y = opaque_end(direction, piece);
    }
    let sight = sight_of(ray);
    let foot = lamp.foot.foot;
    let steps = steps_of(foot, piece, endless && LIGHT != GLOW, LIGHT == DIRECTIONAL || LIGHT == GLOW);
    let before = optical_path(vec3f(), direction, vec2f(0.0, piece.x));
    var passed = select(sum.a, before, light.first_sample == 0u);
    var radiance = vec3f();
    for (var i = light.first_sample; i < light.end_sample; i++) {
        let start = step_at(steps, f32(i));
        let middle = step_at(steps, f32(i) + 0.5);
        let end = step_at(steps, f32(i) + 1.0);
        let width = end - start;
        let point = middle * direction;
        let density = density_at(point);
        let step_path = density * width;
        let near = exp(-view.sigma_t * passed);
        passed += step_path;
        if density == 0.0 {
            continue;
        }
        // mean transmittance over the step
        let y = view.sigma_t * step_path;
        let mean = near * vec3f(phi(y.x), phi(y.y), phi(y.z));
        if LIGHT == GLOW {
            radiance += view.emission * step_path * mean;
            continue;
        }
        var visibility = 1.0;
        if SHADOWED {
            visibility = visibility_at(sight, middle);
        }
        if visibility == 0.0 {
            continue;
        }
        var arriving = light.power;
        var phase = lamp.sun_phase;
        if LIGHT == SPOT {
            arriving = spot_intensity(lamp, middle);
        }
        if LIGHT != DIRECTIONAL {
            let a = middle - foot.x_foot;
            let d = sqrt(a * a + foot.h * foot.h);
            let r = select(d + a, foot.h * (foot.h / (d - a)), a < 0.0);
            phase = phase_at(r, foot.h);
        }
        if LIGHT == DIRECTIONAL || HOFFMAN_PREETHAM {
            arriving *= width;
        } else {
            // an angle over h: it stays right next to the light
            arriving *= inverse_square(foot, start, end);
        }
        var attenuation = vec3f(1.0);
        if !HOFFMAN_PREETHAM {
            attenuation = exp(-view.sigma_t * light_path(point));
        }
        radiance += visibility * density * phase * (view.sigma_s * arriving) * attenuation * mean;
    }
    return vec4f(sum.rgb + radiance, passed);
}
