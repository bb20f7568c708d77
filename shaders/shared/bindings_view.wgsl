// What every pass over a view's pixels reads: group 0. Where a view lacks something, a texture of one texel stands in
// and is not read. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

#import view

@group(0) @binding(0) var<uniform> view: View;
// distance at which each view ray ends; r32float; units: m; ENDLESS where it hits nothing
@group(0) @binding(1) var ray_ends: texture_2d<f32>;
// density of the medium; r32float
@group(0) @binding(4) var density_grid: texture_3d<f32>;
