// Evaluates airlight over arrays of problems, each a light, a medium and its lit intervals: for tests and `eval`.
//
// In: problems (Problem, 32 bytes each), intervals (x0, x1 in m). Out: one radiance a problem.
// Twin: crates/gpu-backend/src/probe.rs.

#import airlight

struct Problem {
    sigma_s: f32,   // units: 1/m
    sigma_t: f32,   // units: 1/m
    intensity: f32, // units: W/sr
    x_foot: f32,    // units: m
    h: f32,         // units: m
    g: f32,         // asymmetry; 0 is isotropic
    first: u32,     // index of the first interval
    count: u32,     // number of intervals
}

@group(0) @binding(0) var<storage, read> problems: array<Problem>;
@group(0) @binding(1) var<storage, read> intervals: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> results: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&problems) {
        return;
    }
    let p = problems[id.x];
    let foot = Foot(p.x_foot, p.h);
    var sum = 0.0;
    for (var i = 0u; i < p.count; i++) {
        let interval = intervals[p.first + i];
        sum += airlight(p.sigma_s, p.sigma_t, p.intensity, p.g, foot, interval.x, interval.y);
    }
    results[id.x] = sum;
}
