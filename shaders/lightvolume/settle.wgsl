// Sums in fixed point as numbers: shares of the unshadowed airlight, three a pixel. Out: rgba32float.
// See light_crossing.wgsl.

@group(0) @binding(0) var<storage, read> sums: array<i32>;
@group(0) @binding(1) var settled: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(settled);
    if any(id.xy >= size) {
        return;
    }
    let at = 3u * (id.y * size.x + id.x);
    let shares = vec3f(f32(sums[at]), f32(sums[at + 1u]), f32(sums[at + 2u])) / 16777216.0;
    textureStore(settled, id.xy, vec4f(shares, 0.0));
}
