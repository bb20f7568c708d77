// Closes a list of rays: how many there are, and how many groups of threads trace them. In and out: see sampling.wgsl.

#import sampling

@compute @workgroup_size(1)
fn main() {
    let count = atomicExchange(&sampling.found, 0u);
    rays.count = count;
    sampling.traced += count;
    let groups = (count + 63u) / 64u;
    sampling.groups = vec3u(min(groups, GROUPS_A_ROW), (groups + GROUPS_A_ROW - 1u) / GROUPS_A_ROW, 1u);
}
