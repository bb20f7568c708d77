// Blocks of pixels that share one view ray, through their middle.
//
// The importing pass declares the uniforms `view` and `blocks`. Twins: crates/hybrid-march/src/upsample.rs (functions),
// crates/gpu-backend/src/fog/low.rs (layout).

#import view

struct Blocks {
    scale: u32, // side of a block; units: pixels
    refines: u32, // 1 where pixels at depth edges are computed anew
    _pad1: u32,
    _pad2: u32,
}

// A block's centre, if it were whole; units: pixels.
fn block_center(block: vec2u) -> vec2f {
    return (vec2f(block) + 0.5) * f32(blocks.scale);
}

// Distance along the ray through an image position for each metre of planar depth.
fn stretch(pixel: vec2f) -> f32 {
    let tangent = pixel * vec2f(view.scale_x, view.scale_y) + view.offset;
    return sqrt(1.0 + dot(tangent, tangent));
}
