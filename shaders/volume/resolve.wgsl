// What tiles.wgsl kept, as a texture: 1/z of the frontmost face (0 where there is none) and of the backmost; units: 1/m.
// Twin: crates/gpu-backend/src/volume/faces.rs.

@group(0) @binding(0) var<storage, read> tiles: array<u32>;
@group(0) @binding(1) var faces: texture_storage_2d<rg32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(faces);
    if any(id.xy >= size) {
        return;
    }
    let tile = 2u * (id.y * size.x + id.x);
    let front = bitcast<f32>(tiles[tile]);
    let back = bitcast<f32>(~tiles[tile + 1u]);
    textureStore(faces, id.xy, vec4f(front, select(back, 0.0, front == 0.0), 0.0, 0.0));
}
