// The quadtree over a map's cells that a light volume is tessellated by (Billeter, Sintorn and Assarsson 2010,
// section 4.1): how its quads are numbered, and whether one is too coarse.
//
// Level l has quads of 2^l x 2^l cells between nodes; those that stick out of the map end at its last node. A bit a quad
// says that it is split, rows of 32-bit words, level by level and face by face. The importing pass declares the uniform
// `tree` and, for `judge`, the texture `heights`. Twins: crates/gpu-backend/src/lightvolume/tessellation.rs (layout),
// crates/lightvolume/src/quads.rs (functions).

struct Tree {
    last: vec2u,         // column and row of the last node
    top: u32,            // level of the root
    face_words: u32,     // words of all levels of a face
    threshold: f32,      // units: m
    far: f32,            // depth that counts as infinite; units: m
    _pad2: u32,
    flat: u32,           // 1 for an orthographic map
    seams: u32,          // 1 where the borders are cells, as a cube's are
    most_leaves: u32,    // of a face
    _pad0: u32,
    _pad1: u32,
    starts: array<vec4u, 4>, // first word of each level
}

// Words of a row of quads of a level, at least one.
fn row_words(level: u32) -> u32 {
    return max((1u << (tree.top - level)) >> 5u, 1u);
}

fn rows_of(level: u32) -> u32 {
    return 1u << (tree.top - level);
}

// The word that holds the bit of a quad.
fn word_of(face: u32, level: u32, quad: vec2u) -> u32 {
    let start = tree.starts[level >> 2u][level & 3u];
    return face * tree.face_words + start + quad.y * row_words(level) + (quad.x >> 5u);
}

// Whether any of a quad lies on the map.
fn exists(level: u32, quad: vec2u) -> bool {
    return all((quad << vec2u(level)) < tree.last);
}

// Whether a quad of a cube touches the border of its face, and so is split down to cells.
fn at_seam(level: u32, quad: vec2u) -> bool {
    return tree.seams == 1u && (any(quad == vec2u(0u)) || any(((quad + 1u) << vec2u(level)) >= tree.last));
}

// The node at a corner of quads of a level.
fn corner_of(level: u32, quad: vec2u) -> vec2u {
    return min(quad << vec2u(level), tree.last);
}
