// The leaves of a tessellation and the triangles between their nodes: a thread takes the split quads of a word, and writes
// those of their children that are not split further. Every leaf has sixteen places: its corners and edge middles in turn
// from the upper left, and from 8 on the apex for a wall at its top, right, bottom and left edge. The first place of each
// triangle is its own, so that the triangle's plane can hang on it. Twin: crates/lightvolume/src/{builder,stitch}.rs.

#import tessellation
#import leaf_head

@group(0) @binding(0) var<uniform> tree: Tree;
@group(0) @binding(1) var<storage, read> splits: array<u32>;
@group(0) @binding(2) var<storage, read_write> head: Head;
// column and row of the quad (16 bits each); level (8 bits), edges with a finer neighbour (8 bits), face
@group(0) @binding(3) var<storage, read_write> leaves: array<vec2u>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

fn is_split(face: u32, level: u32, quad: vec2u) -> bool {
    if level == 0u || !exists(level, quad) {
        return false;
    }
    return ((splits[word_of(face, level, quad)] >> (quad.x & 31u)) & 1u) == 1u;
}

// Bits 1 top, 2 right, 4 bottom, 8 left: edges across which the neighbour is split.
fn finer_edges(face: u32, level: u32, quad: vec2u) -> u32 {
    if level == 0u {
        return 0u;
    }
    return select(0u, 1u, quad.y > 0u && is_split(face, level, quad - vec2u(0u, 1u)))
        | select(0u, 2u, is_split(face, level, quad + vec2u(1u, 0u)))
        | select(0u, 4u, is_split(face, level, quad + vec2u(0u, 1u)))
        | select(0u, 8u, quad.x > 0u && is_split(face, level, quad - vec2u(1u, 0u)));
}

// The same bits: edges on the border of a map that is closed by walls.
fn border_edges(level: u32, quad: vec2u) -> u32 {
    if tree.seams == 1u {
        return 0u;
    }
    let far = (quad + 1u) << vec2u(level);
    return select(0u, 1u, quad.y == 0u) | select(0u, 2u, far.x >= tree.last.x)
        | select(0u, 4u, far.y >= tree.last.y) | select(0u, 8u, quad.x == 0u);
}

fn put(at: u32, leaf: u32, places: vec3u) -> u32 {
    indices[at] = 16u * leaf + places.x;
    indices[at + 1u] = 16u * leaf + places.y;
    indices[at + 2u] = 16u * leaf + places.z;
    return at + 3u;
}

fn put_leaf(first: u32, leaf: u32, face: u32, level: u32, quad: vec2u) -> u32 {
    let finer = finer_edges(face, level, quad);
    leaves[leaf] = vec2u(quad.x | (quad.y << 16u), level | (finer << 8u) | (face << 16u));
    var at = first;
    // upper left and lower right of the diagonal, which is always there
    for (var half = 0u; half < 8u; half += 4u) {
        let ahead = (finer & select(4u, 1u, half == 0u)) != 0u;
        let behind = (finer & select(2u, 8u, half == 0u)) != 0u;
        let last = (select(6u, 7u, behind) + half) & 7u;
        at = put(at, leaf, vec3u(half, (select(2u, 1u, ahead) + half) & 7u, last));
        if ahead {
            at = put(at, leaf, vec3u(half + 1u, (half + 2u) & 7u, last));
        }
        if behind {
            at = put(at, leaf, vec3u((half + 7u) & 7u, (half + 2u) & 7u, (half + 6u) & 7u));
        }
    }
    let border = border_edges(level, quad);
    for (var side = 0u; side < 4u; side++) {
        if ((border >> side) & 1u) == 1u {
            at = put(at, leaf, vec3u(8u + side, (2u * side + 2u) & 7u, 2u * side));
        }
    }
    return at;
}

fn index_count(face: u32, level: u32, quad: vec2u) -> u32 {
    return 6u + 3u * (countOneBits(finer_edges(face, level, quad)) + countOneBits(border_edges(level, quad)));
}

// Level and first word of the row of a word of a face; level 0 where there is none.
fn level_of(word: u32) -> u32 {
    for (var level = tree.top; level >= 1u; level--) {
        if word >= tree.starts[level >> 2u][level & 3u] {
            return level;
        }
    }
    return 0u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let thread = id.y * groups.x * 64u + id.x;
    let face = id.z;
    if thread >= tree.face_words {
        return;
    }
    if thread == 0u && !is_split(face, tree.top, vec2u()) {
        let leaf = atomicAdd(&head.leaves, 1u);
        let at = atomicAdd(&head.indices, index_count(face, tree.top, vec2u()));
        put_leaf(at, leaf, face, tree.top, vec2u());
    }
    let level = level_of(thread);
    if level == 0u {
        return;
    }
    let bits = splits[face * tree.face_words + thread];
    if bits == 0u {
        return;
    }
    let word = thread - tree.starts[level >> 2u][level & 3u];
    let quad = vec2u(32u * (word % row_words(level)), word / row_words(level));
    let below = level - 1u;
    var count = 0u;
    var room = 0u;
    for (var rest = bits; rest != 0u; rest &= rest - 1u) {
        let parent = quad + vec2u(firstTrailingBit(rest), 0u);
        for (var k = 0u; k < 4u; k++) {
            let child = 2u * parent + vec2u(k & 1u, k >> 1u);
            if exists(below, child) && !is_split(face, below, child) {
                count += 1u;
                room += index_count(face, below, child);
            }
        }
    }
    if count == 0u {
        return;
    }
    var leaf = atomicAdd(&head.leaves, count);
    var at = atomicAdd(&head.indices, room);
    for (var rest = bits; rest != 0u; rest &= rest - 1u) {
        let parent = quad + vec2u(firstTrailingBit(rest), 0u);
        for (var k = 0u; k < 4u; k++) {
            let child = 2u * parent + vec2u(k & 1u, k >> 1u);
            if exists(below, child) && !is_split(face, below, child) {
                at = put_leaf(at, leaf, face, below, child);
                leaf += 1u;
            }
        }
    }
}
