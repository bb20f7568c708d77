// Which quads are split: those that are too coarse, and those without which neighbours would differ by more than one
// level. One workgroup a face, from the finest level up, 32 quads a word. Out: a bit a quad in `splits`; the number of
// leaves. Where those are more than there is room for, the finest levels are left out until they fit.
// Twin: crates/lightvolume/src/hierarchy.rs.

#import judge
#import leaf_head

@group(0) @binding(0) var<uniform> tree: Tree;
// the map, a layer a face; r32float
@group(0) @binding(1) var heights: texture_2d_array<f32>;
@group(0) @binding(2) var<storage, read_write> marks: array<atomic<u32>>;
// what is known of the cells under the quads of level 6 and above, face by face and level by level
@group(0) @binding(3) var<storage, read_write> coarse: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> splits: array<u32>;
@group(0) @binding(5) var<storage, read_write> head: Head;

var<workgroup> leaf_count: atomic<u32>;
var<workgroup> is_done: bool;

fn coarse_start(face: u32, level: u32) -> u32 {
    let side = 1u << (tree.top - 6u);
    let quads = (4u * side * side - 1u) / 3u;
    let own = 1u << (tree.top - level);
    return face * quads + 4u * (side * side - own * own) / 3u;
}

fn judge_coarse(face: u32, level: u32, quad: vec2u) {
    let side = 1u << (tree.top - level);
    var judged = vec2f(0.0, 3e38);
    if exists(level, quad) {
        var below = judged;
        let first = coarse_start(face, level - 1u) + 4u * quad.y * side + 2u * quad.x;
        for (var k = 0u; k < 4u; k++) {
            let child = coarse[first + (k >> 1u) * 2u * side + (k & 1u)];
            below = vec2f(max(below.x, child.x), min(below.y, child.y));
        }
        let verdict = judge(face, level, quad, below);
        judged = verdict.judged;
        if verdict.value > tree.threshold || at_seam(level, quad) {
            atomicOr(&marks[word_of(face, level, quad)], 1u << (quad.x & 31u));
        }
    }
    coarse[coarse_start(face, level) + quad.y * side + quad.x] = judged;
}

// A word of `splits`; nothing is split outside of the tree.
fn splits_at(face: u32, level: u32, row: i32, word: i32) -> u32 {
    if row < 0 || word < 0 || row >= i32(rows_of(level)) || word >= i32(row_words(level)) {
        return 0u;
    }
    return splits[word_of(face, level, vec2u(32u * u32(word), u32(row)))];
}

// Joins pairs of bits: bit i of the result is bit 2 i or bit 2 i + 1.
fn joined(bits: u32) -> u32 {
    var b = (bits | (bits >> 1u)) & 0x55555555u;
    b = (b | (b >> 1u)) & 0x33333333u;
    b = (b | (b >> 2u)) & 0x0f0f0f0fu;
    b = (b | (b >> 4u)) & 0x00ff00ffu;
    return (b | (b >> 8u)) & 0x0000ffffu;
}

// Quads of which a child is split, or one of the eight children next to their edges.
fn needed(face: u32, level: u32, row: u32, word: u32) -> u32 {
    let below = level - 1u;
    let r = 2 * i32(row);
    let w = 2 * i32(word);
    // own children's rows, and the words to either side for what lies across the word's ends
    let before = splits_at(face, below, r, w - 1) | splits_at(face, below, r + 1, w - 1);
    let low = splits_at(face, below, r, w) | splits_at(face, below, r + 1, w);
    let high = splits_at(face, below, r, w + 1) | splits_at(face, below, r + 1, w + 1);
    let after = splits_at(face, below, r, w + 2) | splits_at(face, below, r + 1, w + 2);
    // rows of the neighbours above and below
    let across_low = splits_at(face, below, r - 1, w) | splits_at(face, below, r + 2, w);
    let across_high = splits_at(face, below, r - 1, w + 1) | splits_at(face, below, r + 2, w + 1);
    let first = low | (low << 1u) | (before >> 31u) | (low >> 1u) | (high << 31u) | across_low;
    let second = high | (high << 1u) | (low >> 31u) | (high >> 1u) | (after << 31u) | across_high;
    return joined(first) | (joined(second) << 16u);
}

// Bits of the quads of a word that exist.
fn existing(level: u32, row: u32, word: u32) -> u32 {
    let columns = ((tree.last.x - 1u) >> level) + 1u;
    if row > (tree.last.y - 1u) >> level || columns <= 32u * word {
        return 0u;
    }
    let count = columns - 32u * word;
    return select((1u << count) - 1u, 0xffffffffu, count >= 32u);
}

// Bits of the quads of a word that are cells' parents at a cube's seams.
fn at_seams(level: u32, row: u32, word: u32) -> u32 {
    if tree.seams == 0u {
        return 0u;
    }
    var bits = 0u;
    for (var i = 0u; i < 32u; i++) {
        bits |= select(0u, 1u << i, at_seam(level, vec2u(32u * word + i, row)));
    }
    return bits;
}

// By how many leaves there are more if the quads of a word are split.
fn more_leaves(level: u32, row: u32, word: u32, bits: u32) -> u32 {
    let half = level - 1u;
    let rows = select(1u, 2u, ((2u * row + 1u) << half) < tree.last.y);
    var children = 2u * countOneBits(bits);
    let last = (tree.last.x - 1u) >> level;
    if ((2u * last + 1u) << half) >= tree.last.x && last >> 5u == word {
        children -= (bits >> (last & 31u)) & 1u;
    }
    return rows * children - countOneBits(bits);
}

// Splits quads level by level; the `left_out` finest levels only where seams ask for it.
fn balance(face: u32, left_out: u32, index: u32) {
    for (var level = 1u; level <= tree.top; level++) {
        let words = row_words(level);
        for (var i = index; i < rows_of(level) * words; i += 256u) {
            let row = i / words;
            let word = i % words;
            let at = word_of(face, level, vec2u(32u * word, row));
            var bits = at_seams(level, row, word);
            if level > left_out {
                bits |= atomicLoad(&marks[at]);
            }
            if level > 1u {
                bits |= needed(face, level, row, word);
            }
            bits &= existing(level, row, word);
            splits[at] = bits;
            atomicAdd(&leaf_count, more_leaves(level, row, word, bits));
        }
        storageBarrier();
    }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let face = group.z;
    for (var level = 7u; level <= tree.top; level++) {
        let side = 1u << (tree.top - level);
        for (var i = index; i < side * side; i += 256u) {
            judge_coarse(face, level, vec2u(i % side, i / side));
        }
        storageBarrier();
    }
    for (var left_out = 0u; left_out <= tree.top; left_out++) {
        if index == 0u {
            atomicStore(&leaf_count, 1u);
        }
        workgroupBarrier();
        balance(face, left_out, index);
        workgroupBarrier();
        if index == 0u {
            let count = atomicLoad(&leaf_count);
            is_done = count <= tree.most_leaves || left_out == tree.top;
            if is_done {
                atomicAdd(&head.counted, count);
                atomicMax(&head.left_out, left_out);
            }
        }
        if workgroupUniformLoad(&is_done) {
            break;
        }
    }
}
