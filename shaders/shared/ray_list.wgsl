// A list of pixels whose view rays are to be traced, and their places in arrays: row by row from the top, rows padded so
// that an array can be copied into a texture. Layout in Rust: crates/gpu-backend/src/fog/sampling.rs.

struct RayList {
    count: u32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
    pixels: array<u32>, // places
}

// Pixels from the beginning of a row to that of the next.
fn row_stride() -> u32 {
    return (view.size.x + 15u) & ~15u;
}

// A pixel's place.
fn place_of(pixel: vec2u) -> u32 {
    return pixel.y * row_stride() + pixel.x;
}

// Groups of 64 threads along a row of a dispatch over a list.
const GROUPS_A_ROW: u32 = 1024u;
