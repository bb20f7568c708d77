// A list of pixels whose view rays are to be traced. Layout in Rust: crates/gpu-backend/src/fog/sampling.rs.

struct RayList {
    count: u32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
    pixels: array<u32>, // row x width + column
}

// Groups of 64 threads along a row of a dispatch over a list.
const GROUPS_A_ROW: u32 = 1024u;
