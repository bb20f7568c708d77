// Fills the table of frame_table.wgsl, an entry a thread. In: see bindings.wgsl. Out: rgba32float in the place of the view's
// airlight: airlight per intensity as printed, or the mean of exponentials over angles.
// Twins: `FrameTable::new` and `AngleTable::new` in crates/media-math/src/optics/airlight_table.rs.

#import bindings
#import frame_table

// Sine and cosine of an angle in [0, pi].
fn sine_cosine(angle: f32) -> vec2f {
    let t = accurate_tan(0.5 * angle);
    if t > 1e15 {
        return vec2f(0.0, -1.0);
    }
    return vec2f(2.0 * t, 1.0 - t * t) / (1.0 + t * t);
}

fn lamp_at(foot: Foot) -> Lamp {
    return Lamp(LightFoot(foot, vec3f()), vec3f(), 0.0, vec2f());
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let entry = pixel_of(tile.xy, index);
    let size = textureDimensions(scattered);
    if any(entry >= size) {
        return;
    }
    let last = vec2f(size) - 1.0;
    let at = vec2f(entry) / last;
    let distance = max(length(light.to_light), 1e-30);
    var value = vec3f();
    if TABLE == PRINTED {
        let inset = 1.0 - 1.0 / f32(size.x);
        let cosine = clamp(2.0 * at.x - 1.0, -inset, inset);
        let foot = Foot(distance * cosine, distance * sqrt((1.0 - cosine) * (1.0 + cosine)));
        if entry.y > 0u {
            value = constant_airlight(lamp_at(foot), vec3f(1.0), 0.0, at.y * light.table_end);
        }
    } else {
        // on the axis itself the angle is 0 or pi at once: a little beside it the mean is the same
        let gamma = clamp(at.x * PI, 1e-4, PI - 1e-4);
        let beside = sine_cosine(gamma);
        let foot = Foot(distance * beside.y, distance * beside.x);
        let psi = at.y * (PI - gamma);
        value = exp(-view.sigma_t * distance);
        if entry.y > 0u {
            // law of sines; at the last row the ray is parallel to the way from the light
            let rest = sine_cosine((1.0 - at.y) * (PI - gamma)).x;
            let x = select(distance * sine_cosine(psi).x / max(rest, 1e-30), ENDLESS, entry.y + 1u == size.y);
            let airlight = constant_airlight(lamp_at(foot), vec3f(1.0), 0.0, x);
            // a channel that scatters nothing has no airlight, whatever its mean
            let mean = airlight * foot.h / (INV_4PI * psi * max(view.sigma_s, vec3f(1e-30)));
            value = select(mean, vec3f(), view.sigma_s == vec3f());
        }
    }
    textureStore(scattered, entry, vec4f(value, 0.0));
}
