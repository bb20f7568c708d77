// The view of a pass over one view's froxels, and what is left of it from the frame before.

#import froxel
#import elementary

struct FroxelWhich {
    view: u32,
    _pad0: u32,
    newest: f32,        // weight of this frame beside it
    _pad1: u32,
    before: FroxelView, // where the view was
}

@group(2) @binding(0) var<uniform> which: FroxelWhich;

// A point in a froxel volume, in froxels: their middles at +0.5; z is negative where it is not in it.
fn froxel_place(view: FroxelView, point: vec3f) -> vec3f {
    let from_eye = point - view.eye;
    let depth = dot(from_eye, view.forward);
    let distance = length(from_eye);
    if !(depth > 0.0) || !(distance <= froxels.range) {
        return vec3f(0.0, 0.0, -1.0);
    }
    let tangent = vec2f(dot(from_eye, view.right), dot(from_eye, view.up)) / depth;
    let pixel = (tangent - view.offset) / view.scale;
    if any(pixel < vec2f(0.0)) || any(pixel >= vec2f(view.size)) {
        return vec3f(0.0, 0.0, -1.0);
    }
    return vec3f(pixel / f32(froxels.tile), slice_place(distance));
}

// The slice of a distance and the share of it, added.
fn slice_place(distance: f32) -> f32 {
    let part = distance / froxels.range;
    let curved = accurate_log1p(part * froxels.growth) / froxels.curve;
    let guess = select(part, curved, froxels.growth > 0.0);
    let last = froxels.slices - 1u;
    var k = min(u32(clamp(guess, 0.0, 1.0) * f32(froxels.slices)), last);
    // the logarithm may be off by a rounding
    if k > 0u && distance < slice_start(k) {
        k--;
    } else if k < last && distance >= froxels.starts[k].y {
        k++;
    }
    let slice = froxels.starts[k];
    return f32(k) + clamp((distance - slice.x) / (slice.y - slice.x), 0.0, 1.0);
}
