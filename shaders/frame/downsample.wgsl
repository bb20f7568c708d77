// Where the rays of blocks of pixels end: at the nearest and at the farthest of what their pixels see.
//
// In: distances at which the pixels' rays end. Out: the same for rays through the blocks' centres, in two layers; the far
// one is 0 where both are as good as one. Units: m. Twin: `LowResolution::ends` in crates/hybrid-march/src/upsample.rs.

#import view
#import blocks

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> blocks: Blocks;
@group(0) @binding(2) var ray_ends: texture_2d<f32>;
@group(0) @binding(3) var near_ends: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var far_ends: texture_storage_2d<r32float, write>;

// Depths that differ by less than this share are one.
const SAME_DEPTH: f32 = 0.02;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(near_ends)) {
        return;
    }
    let first = id.xy * blocks.scale;
    let end = min(first + blocks.scale, view.size);
    var nearest = ENDLESS;
    var farthest = 0.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let depth = textureLoad(ray_ends, vec2u(x, y), 0).r / stretch(vec2f(vec2u(x, y)) + 0.5);
            nearest = min(nearest, depth);
            farthest = max(farthest, depth);
        }
    }
    let along = stretch(block_center(id.xy));
    let one = farthest <= nearest * (1.0 + SAME_DEPTH) || nearest >= 1e29;
    textureStore(near_ends, id.xy, vec4f(min(nearest * along, ENDLESS), 0.0, 0.0, 0.0));
    textureStore(far_ends, id.xy, vec4f(select(min(farthest * along, ENDLESS), 0.0, one), 0.0, 0.0, 0.0));
}
