// Counts the estimates of some groups of pixels by their size. In and out: see sampling.wgsl.

#import prediction

var<workgroup> counts: array<atomic<u32>, BINS_AND_REST>;

fn count(estimate: f32) {
    var bin = 0.0;
    if estimate > 0.0 {
        bin = clamp((log2(estimate / sampling.unit) - FIRST_OCTAVE) * BINS_PER_OCTAVE, 0.0, f32(BINS));
    }
    atomicAdd(&counts[u32(bin)], 1u);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) thread: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let column = group.x * level.survey + 3u * group.y % level.survey;
    let known = vec2i((vec2u(column, group.y) * 8u + thread.xy) * level.stride);
    let there = are_there(known, i32(level.stride / 2u));
    if any(there) {
        let found = predictions(known, i32(level.stride));
        for (var i = 0u; i < 3u; i++) {
            if there[i] {
                count(found[i].estimate);
            }
        }
    }
    workgroupBarrier();
    if index < BINS_AND_REST {
        let all = atomicLoad(&counts[index]);
        if all > 0u {
            atomicAdd(&sampling.counts[index], all);
        }
    }
}
