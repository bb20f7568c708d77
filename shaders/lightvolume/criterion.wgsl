// Which quads of the levels 1 to 6 are too coarse: a workgroup takes 64 x 64 cells of a face, a thread 4 x 4 of them, whose
// 25 nodes are those of four quads of level 1 and one of level 2. Out: a bit a quad in `marks`, and what the quads of level 6
// know of the cells under them. In: see shared/judge.wgsl.
// Twin: crates/lightvolume/src/{edge_map,distance}.rs.

#import judge

@group(0) @binding(0) var<uniform> tree: Tree;
// the map, a layer a face; r32float
@group(0) @binding(1) var heights: texture_2d_array<f32>;
@group(0) @binding(2) var<storage, read_write> marks: array<atomic<u32>>;
// of level 6 and above, face by face
@group(0) @binding(3) var<storage, read_write> coarse: array<vec2f>;

// of the quads of levels 2 to 6 of the tile, one after the other
var<workgroup> known: array<vec2f, 341>;

const NOTHING_BELOW: f32 = 3e38;

fn mark(face: u32, level: u32, quad: vec2u, value: f32) {
    if value > tree.threshold || at_seam(level, quad) {
        atomicOr(&marks[word_of(face, level, quad)], 1u << (quad.x & 31u));
    }
}

fn both(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(max(a.x, b.x), min(a.y, b.y));
}

// A quad of level 1 by its nodes.
fn judge_smallest(face: u32, quad: vec2u, heights: Nine) -> vec2f {
    var judged = vec2f(0.0, NOTHING_BELOW);
    if exists(1u, quad) {
        let verdict = distance_of_quad(1u, quad, heights, judged);
        mark(face, 1u, quad, verdict.value);
        judged = verdict.judged;
    }
    return judged;
}

// The quads of the levels 1 and 2 of 4 x 4 cells.
fn judge_block(face: u32, quad: vec2u) -> vec2f {
    var judged = vec2f(0.0, NOTHING_BELOW);
    let is_there = exists(2u, quad);
    if !is_there | (tree.top == 0u) {
        return judged;
    }
    if is_there & (tree.top == 1u) {
        return judge_by_loads(face, 1u, quad, judged);
    }
    if CRITERION == LAPLACIAN {
        var below = judged;
        for (var k = 0u; k < 4u; k++) {
            let child = 2u * quad + vec2u(k & 1u, k >> 1u);
            if exists(1u, child) {
                below = both(below, judge_by_loads(face, 1u, child, judged));
            }
        }
        return judge_by_loads(face, 2u, quad, below);
    }
    var h: array<f32, 25>;
    for (var j = 0u; j < 5u; j++) {
        for (var i = 0u; i < 5u; i++) {
            h[5u * j + i] = tree_height(face, min(4u * quad + vec2u(i, j), tree.last));
        }
    }
    let child = 2u * quad;
    let a = judge_smallest(face, child, Nine(h[0], h[1], h[2], h[5], h[6], h[7], h[10], h[11], h[12]));
    let b = judge_smallest(face, child + vec2u(1u, 0u), Nine(h[2], h[3], h[4], h[7], h[8], h[9], h[12], h[13], h[14]));
    let c = judge_smallest(face, child + vec2u(0u, 1u), Nine(h[10], h[11], h[12], h[15], h[16], h[17], h[20], h[21], h[22]));
    let d = judge_smallest(face, child + 1u, Nine(h[12], h[13], h[14], h[17], h[18], h[19], h[22], h[23], h[24]));
    let own = Nine(h[0], h[2], h[4], h[10], h[12], h[14], h[20], h[22], h[24]);
    let verdict = distance_of_quad(2u, quad, own, both(both(a, b), both(c, d)));
    mark(face, 2u, quad, verdict.value);
    return verdict.judged;
}

fn judge_by_loads(face: u32, level: u32, quad: vec2u, below: vec2f) -> vec2f {
    let verdict = judge(face, level, quad, below);
    mark(face, level, quad, verdict.value);
    return verdict.judged;
}

// A quad of level 3 or more.
fn judge_quad(face: u32, level: u32, tile: vec2u, own: vec2u, first: u32, first_below: u32) {
    let side = 64u >> level;
    let quad = tile * side + own;
    var judged = vec2f(0.0, NOTHING_BELOW);
    loop {
        if !exists(level, quad) {
            break;
        }
        var below = vec2f(0.0, NOTHING_BELOW);
        for (var k = 0u; k < 4u; k++) {
            below = both(below, known[first_below + (2u * own.y + (k >> 1u)) * 2u * side + 2u * own.x + (k & 1u)]);
        }
        judged = judge_by_loads(face, level, quad, below);
        break;
    }
    known[first + own.y * side + own.x] = judged;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    known[index] = judge_block(group.z, 16u * group.xy + vec2u(index % 16u, index / 16u));
    workgroupBarrier();
    var first = 256u;
    var first_below = 0u;
    for (var level = 3u; level <= 6u; level++) {
        let side = 64u >> level;
        let count = side * side;
        if (level <= tree.top) & (index < count) {
            judge_quad(group.z, level, group.xy, vec2u(index % side, index / side), first, first_below);
        }
        workgroupBarrier();
        first_below = first;
        first += count;
    }
    if (index == 0u) & (tree.top >= 6u) {
        let side = 1u << (tree.top - 6u);
        let quads = (4u * side * side - 1u) / 3u;
        coarse[group.z * quads + group.y * side + group.x] = known[340];
    }
}
