// Adaptive sampling: what its passes read and write. A lattice of rays is traced, then what lies between is interpolated or
// listed to be traced, at half the stride each time.
//
// Twins: crates/gpu-backend/src/fog/sampling.rs (layout), crates/hybrid-march/src/adaptive.rs (method).

#import view
#import ray_list

struct Level {
    stride: u32,     // distance of the pixels that are known; units: pixels
    spacing: u32,    // of the lattice; units: pixels
    tolerance: f32,  // estimated error that is accepted, as a share of what shadows take away
    _pad: f32,
}

struct Sampling {
    found: atomic<u32>, // rays that were listed since the list was last closed
    traced: u32,        // rays in all lists
    error: f32,         // estimated error that is accepted; units: W/(m^2 sr)
    _pad: u32,
    groups: vec3u,      // of threads over the list
    _pad1: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var ray_ends: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> rays: RayList;
@group(0) @binding(3) var<storage, read_write> values: array<vec4f>;
@group(0) @binding(4) var<uniform> level: Level;
@group(0) @binding(5) var<storage, read_write> sampling: Sampling;
// radiance of the lattice as if nothing cast a shadow
@group(0) @binding(6) var<storage, read_write> unshadowed: array<vec4f>;
// 1/z with the planar depth z of every pixel, 0 for infinity; units: 1/m
@group(0) @binding(7) var<storage, read_write> planes: array<f32>;

// Columns and rows of the lattice.
fn lattice_size() -> vec2u {
    return (view.size + level.spacing - 1u) / level.spacing;
}
