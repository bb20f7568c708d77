// The arguments of the draws of a second pass over a light volume: none where every pixel's crossings are kept.
// Twin: crates/gpu-backend/src/lightvolume/draw.rs.

// 1 where a pixel has more crossings than are kept
@group(0) @binding(0) var<storage, read> overflow: array<u32>;
// the head of the leaves, if the surface is made of them
@group(0) @binding(1) var<storage, read> head: array<u32>;
// five words for each of two draws
@group(0) @binding(2) var<storage, read_write> arguments: array<u32>;
// of each draw: vertices, instances, 1 where the vertices are the leaves' indices
@group(0) @binding(3) var<uniform> draws: array<vec4u, 2>;

@compute @workgroup_size(2)
fn main(@builtin(local_invocation_index) index: u32) {
    let wanted = draws[index];
    arguments[5u * index] = select(wanted.x, head[0], wanted.z == 1u);
    arguments[5u * index + 1u] = wanted.y * overflow[0];
    arguments[5u * index + 2u] = 0u;
    arguments[5u * index + 3u] = 0u;
    arguments[5u * index + 4u] = 0u;
}
