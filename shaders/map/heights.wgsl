// Heights of a map (shadow_map.wgsl) from the depth buffer that a host's renderer drew for a light.
//
// In: a depth texture, a layer a face. Out: r32float. Device depth d gives height `scale` d + `offset`, which is exact for
// every usual matrix: 1/depth and device depth are both linear over the image. Twin: crates/shadowmap/src/encoding.rs.

struct Convention {
    scale: f32,
    offset: f32,
    far: f32,      // device depth where nothing was drawn
    nothing: f32,  // height there
    bias: f32,     // units: m
    flat: u32,     // 1 for an orthographic map
    _pad: vec2u,
}

@group(0) @binding(0) var depths: texture_depth_2d_array;
@group(0) @binding(1) var heights: texture_storage_2d_array<r32float, write>;
@group(0) @binding(2) var<uniform> convention: Convention;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depths)) {
        return;
    }
    let device = textureLoad(depths, id.xy, id.z, 0);
    var height = convention.nothing;
    if device != convention.far {
        height = convention.scale * device + convention.offset;
        if convention.flat == 1u {
            height -= convention.bias;
        } else {
            height = height / (1.0 + convention.bias * height);
        }
    }
    textureStore(heights, id.xy, id.z, vec4f(height, 0.0, 0.0, 0.0));
}
