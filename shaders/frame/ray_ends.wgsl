// Where each view ray ends, from the depth buffer that a host's renderer drew for a view.
//
// In: a depth texture. Out: r32float distance along the ray; units: m. Inverse planar depth is `scale` d + `offset` of
// the device depth d. Twin: `SceneDepth` in crates/gpu-backend/src/fog/frame.rs.

#import view

struct Convention {
    scale: f32,
    offset: f32,
    far: f32, // device depth where nothing was drawn
    _pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depths: texture_depth_2d;
@group(0) @binding(2) var ray_ends: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var<uniform> convention: Convention;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let device = textureLoad(depths, id.xy, 0);
    var end = view.max_distance;
    if device != convention.far {
        let ray = view_ray(id.xy);
        end = min(ray.length / (convention.scale * device + convention.offset), end);
    }
    textureStore(ray_ends, id.xy, vec4f(end, 0.0, 0.0, 0.0));
}
