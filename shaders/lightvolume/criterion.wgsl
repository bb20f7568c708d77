// Which quads of the levels 1 to 6 are too coarse: a workgroup takes 64 x 64 cells of a face. Out: a bit a quad in
// `marks`, and what the quads of level 6 know of the cells under them. In: see shared/judge.wgsl.
// Twin: crates/lightvolume/src/{edge_map,distance}.rs.

#import judge

@group(0) @binding(0) var<uniform> tree: Tree;
// the map, a layer a face; r32float
@group(0) @binding(1) var heights: texture_2d_array<f32>;
@group(0) @binding(2) var<storage, read_write> marks: array<atomic<u32>>;
// of level 6 and above, face by face
@group(0) @binding(3) var<storage, read_write> coarse: array<vec2f>;

// of the quads of levels 1 to 6 of the tile, one after the other
var<workgroup> known: array<vec2f, 1365>;

const NOTHING_BELOW: f32 = 3e38;

fn mark(face: u32, level: u32, quad: vec2u, value: f32) {
    if value > tree.threshold || at_seam(level, quad) {
        atomicOr(&marks[word_of(face, level, quad)], 1u << (quad.x & 31u));
    }
}

fn judge_quad(face: u32, level: u32, tile: vec2u, own: vec2u, first: u32, first_below: u32) {
    let side = 64u >> level;
    let quad = tile * side + own;
    var judged = vec2f(0.0, NOTHING_BELOW);
    loop {
        if !exists(level, quad) {
            break;
        }
        var below = vec2f(0.0, NOTHING_BELOW);
        if level > 1u {
            for (var k = 0u; k < 4u; k++) {
                let child = known[first_below + (2u * own.y + (k >> 1u)) * 2u * side + 2u * own.x + (k & 1u)];
                below = vec2f(max(below.x, child.x), min(below.y, child.y));
            }
        }
        let verdict = judge(face, level, quad, below);
        mark(face, level, quad, verdict.value);
        judged = verdict.judged;
        break;
    }
    known[first + own.y * side + own.x] = judged;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    var first = 0u;
    var first_below = 0u;
    for (var level = 1u; level <= 6u; level++) {
        let side = 64u >> level;
        let count = side * side;
        for (var i = index; i < count; i += 256u) {
            if level <= tree.top {
                judge_quad(group.z, level, group.xy, vec2u(i % side, i / side), first, first_below);
            }
        }
        workgroupBarrier();
        first_below = first;
        first += count;
    }
    if index == 0u && tree.top >= 6u {
        let side = 1u << (tree.top - 6u);
        let quads = (4u * side * side - 1u) / 3u;
        coarse[group.z * quads + group.y * side + group.x] = known[1364];
    }
}
