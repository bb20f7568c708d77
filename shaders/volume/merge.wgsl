// The depths of the frontmost and the backmost face, drawn apart, as one texture like that of resolve.wgsl.
// Twin: crates/gpu-backend/src/volume/faces.rs.

#import volume

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var front: texture_depth_2d;
@group(0) @binding(2) var back: texture_depth_2d;
@group(0) @binding(3) var faces: texture_storage_2d<rg32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(faces)) {
        return;
    }
    let depths = vec2f(textureLoad(front, id.xy, 0), textureLoad(back, id.xy, 0));
    let inverse = select(depths * volume.most_inverse, vec2f(), depths.x == 0.0);
    textureStore(faces, id.xy, vec4f(inverse, 0.0, 0.0));
}
