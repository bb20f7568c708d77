// Adaptive sampling: what its passes read and write. A lattice of rays is traced, then what lies between is predicted or
// listed to be traced, at half the stride each time.
//
// Twins: crates/gpu-backend/src/fog/sampling.rs (layout), crates/hybrid-march/src/adaptive.rs (method).

#import view
#import ray_list

// Bins of the histogram of estimates: by quarters of a power of two, from this power of the target error on.
const BINS: u32 = 56u;
const BINS_AND_REST: u32 = 57u;
const BINS_PER_OCTAVE: f32 = 4.0;
const FIRST_OCTAVE: f32 = -10.0;

struct Level {
    stride: u32,   // distance of the pixels that are known; units: pixels
    spacing: u32,  // of the lattice; units: pixels
    survey: u32,   // of how many groups in a row one is in the histogram
    target_error: f32, // as a share of what shadows take away
    budget: f32,   // mean square that estimates may have; units: squares of the target error
    share: f32,    // of what is left of it, for this level
    most: f32,     // estimate that is accepted; units: target errors
    most_traced: f32, // share of the level's pixels: where there would be more, all are
}

struct Sampling {
    found: atomic<u32>, // rays that were listed since the list was last closed
    traced: u32,        // rays in all lists
    error: f32,         // estimated error that is accepted; units: W/(m^2 sr)
    unit: f32,          // target error; units: W/(m^2 sr)
    groups: vec3u,      // of threads over the list
    left: f32,          // of the budget, for all pixels together; units: squares of the target error
    // estimates of the level by their size; the last ones are too large for any bin
    counts: array<atomic<u32>, BINS_AND_REST>,
    _pad: array<u32, 3>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var ray_ends: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> rays: RayList;
@group(0) @binding(3) var<storage, read_write> values: array<vec4f>;
@group(0) @binding(4) var<uniform> level: Level;
@group(0) @binding(5) var<storage, read_write> sampling: Sampling;
// radiance of the lattice as if nothing cast a shadow
@group(0) @binding(6) var<storage, read_write> unshadowed: array<vec4f>;
// inverse distance of what every pixel sees; units: 1/m
@group(0) @binding(7) var<storage, read_write> inverse_depths: array<f32>;

// Columns and rows of the lattice.
fn lattice_size() -> vec2u {
    return (view.size + level.spacing - 1u) / level.spacing;
}
