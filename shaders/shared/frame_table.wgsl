// Airlight from the eye to a distance out of a table that is made for one frame, light and medium, so that a step costs a
// lookup (Wyman and Ramsey 2008, section 3.4): as printed over cos(gamma) and x, or over angles, which has no singularity.
//
// The importing pass declares `view`, `light` and the texture `frame_table`. Twins: `FrameTable` and `AngleTable` in
// crates/media-math/src/optics/airlight_table.rs.

#import piece

// one of the constants below
override TABLE: u32 = 0u;

const NO_TABLE: u32 = 0u;
const PRINTED: u32 = 1u;
const ANGLES: u32 = 2u;

// Bilinear between entries, those on the border included.
fn table_entry(at: vec2f) -> vec3f {
    let last = vec2f(textureDimensions(frame_table)) - 1.0;
    let p = clamp(at, vec2f(0.0), vec2f(1.0)) * last;
    let low = vec2i(min(floor(p), last - 1.0));
    let f = p - vec2f(low);
    let upper = mix(textureLoad(frame_table, low, 0).rgb, textureLoad(frame_table, low + vec2i(1, 0), 0).rgb, f.x);
    let lower = mix(textureLoad(frame_table, low + vec2i(0, 1), 0).rgb, textureLoad(frame_table, low + 1, 0).rgb, f.x);
    return mix(upper, lower, f.y);
}

// Angle at the light between the eye and the point at distance x, and the most that it can be.
fn angles_at(foot: Foot, x: f32) -> vec2f {
    let gamma = accurate_angle(foot.h, foot.x_foot);
    if x >= 1e29 {
        return vec2f(PI - gamma, PI - gamma);
    }
    let squared = foot.h * foot.h + foot.x_foot * foot.x_foot;
    return vec2f(accurate_angle(foot.h * x, squared - x * foot.x_foot), PI - gamma);
}

// Airlight between the eye and distance x in light of unit intensity, but for a constant of the ray.
fn airlight_to(lamp: Lamp, x: f32) -> vec3f {
    let foot = lamp.foot.foot;
    if TABLE == PRINTED {
        let cosine = foot.x_foot / max(length(light.to_light), 1e-30);
        return table_entry(vec2f(0.5 * (1.0 + cosine), x / light.table_end));
    }
    let angles = angles_at(foot, x);
    let mean = table_entry(vec2f(1.0 - angles.y / PI, angles.x / max(angles.y, 1e-30)));
    return view.sigma_s * INV_4PI * (angles.x / foot.h) * mean;
}

// Airlight of a lit piece, whichever way it is computed; units: W/(m^2 sr).
fn run_airlight(lamp: Lamp, x0: f32, x1: f32) -> vec3f {
    if TABLE == NO_TABLE {
        return piece_airlight(lamp, x0, x1);
    }
    if !(x1 > x0) {
        return vec3f();
    }
    return light.power * max(airlight_to(lamp, x1) - airlight_to(lamp, x0), vec3f());
}
