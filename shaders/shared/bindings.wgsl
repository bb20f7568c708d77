// What every scattering pass reads and writes: group 0 for the view, group 1 for the light. Where a light lacks
// something, a texture of one texel stands in and is not read. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

#import bindings_view
#import light
#import pixels

@group(1) @binding(0) var<uniform> light: Light;
// the light's map, a layer a face; r32float
@group(1) @binding(1) var heights: texture_2d_array<f32>;
// least and greatest height of blocks of cells; rg32float
@group(1) @binding(2) var pyramid: texture_2d_array<f32>;
// moments of depth; rg32float
@group(1) @binding(3) var moments: texture_2d_array<f32>;
// a spot's picture, linear RGB; rgba32float
@group(1) @binding(4) var picture: texture_2d<f32>;
// 1/z of the frontmost and the backmost face of the light's shadow volume, 0 where there is none; rg32float; units: 1/m
@group(1) @binding(5) var faces: texture_2d<f32>;
// a spot's picture at every size, linear RGB, filterable
@group(1) @binding(6) var mips: texture_2d<f32>;
@group(1) @binding(7) var smooth_sampler: sampler;
// airlight of this frame and light by angle, see frame_table.wgsl; rgba32float
@group(1) @binding(8) var frame_table: texture_2d<f32>;

// one of POINT, SPOT, DIRECTIONAL
override LIGHT: u32 = 0u;
// whether the spot has a picture
override TEXTURED: bool = false;
// whether the light has a map
override SHADOWED: bool = true;
// whether a map's texel centres are joined by triangles
override LINEAR: bool = false;
// how a map is looked up, see shadow_map.wgsl
override LOOKUP: u32 = 0u;
// whether the channels are attenuated alike
override ACHROMATIC: bool = true;
// whether the phase function is isotropic
override ISOTROPIC: bool = true;
