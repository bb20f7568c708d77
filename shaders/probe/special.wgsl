// Evaluates Sun et al.'s F over arrays: for tests and `eval`.
//
// In: problems (u, v0, v1). Out: the integral of e^(-u tan xi) from v0 to v1 for each. Twins:
// crates/media-math/src/optics/special.rs and crates/gpu-backend/src/probe/special.rs.

#import airlight

struct Problem {
    u: f32,
    v0: f32, // units: rad, in [0, pi/2]
    v1: f32,
    _pad: f32,
}

@group(0) @binding(0) var<storage, read> problems: array<Problem>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;

// The integral, as airlight of a light 1 m beside the ray: R is tan xi.
fn sun_f(p: Problem) -> f32 {
    if !(p.v1 > p.v0) {
        return 0.0;
    }
    let r0 = accurate_tan(p.v0);
    // tan v1 - tan v0 and tan(v1 - v0), without their difference
    let tangent = accurate_tan(p.v1 - p.v0);
    let rest = 1.0 - r0 * tangent;
    let dr = select(ENDLESS, tangent * (1.0 + r0 * r0) / rest, rest > 1e-7);
    let angle = 2.0 * (p.v1 - p.v0);
    let span = Span(1.0, r0, dr, tangent, r0, sin(angle), cos(angle), 1.0);
    return 2.0 * PI * exp(-p.u * r0) * isotropic_integral(span, p.u);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&problems) {
        results[id.x] = sun_f(problems[id.x]);
    }
}
