// The airlight of every pixel from that of blocks of pixels: bilinear between the blocks around it, each with the layer
// whose depth is closer to the pixel's, and the less the more its depth differs.
//
// Beside a depth edge the airlight of either side may change within a block: alpha 1 says that the pixel is to be computed
// anew. A thread takes a block. In: where rays end, of pixels and of blocks in two layers (m), and the blocks' radiance in both.
// Out: rgba32float radiance. Twin: `LowResolution::upsample` in crates/hybrid-march/src/upsample.rs.

#import view
#import blocks

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> blocks: Blocks;
@group(0) @binding(2) var ray_ends: texture_2d<f32>;
@group(0) @binding(3) var near_ends: texture_2d<f32>;
@group(0) @binding(4) var far_ends: texture_2d<f32>;
@group(0) @binding(5) var near_layer: texture_2d<f32>;
@group(0) @binding(6) var far_layer: texture_2d<f32>;
@group(0) @binding(7) var scattered: texture_storage_2d<rgba32float, write>;

// Share of a depth at which the depth weight has fallen to a quarter.
const DEPTH_TOLERANCE: f32 = 0.05;

// Difference of depths, in units of that tolerance, and ratio of a block's two depths from which on there is an edge and
// no slope.
const EDGE: f32 = 2.0;
const LAYERS_APART: f32 = 1.25;

const AROUND: array<vec2i, 12> = array(
    vec2i(1, 0), vec2i(-1, 0), vec2i(0, 1), vec2i(0, -1), vec2i(2, 0), vec2i(-2, 0), vec2i(0, 2), vec2i(0, -2),
    vec2i(1, 1), vec2i(-1, 1), vec2i(1, -1), vec2i(-1, -1),
);

// The 3 x 3 blocks around the thread's own: radiance and planar depth of both layers.
var<private> near_blocks: array<vec4f, 9>;
var<private> far_blocks: array<vec4f, 9>;

// Depths from here on are infinite: rays without end differ in the depth that ENDLESS stands for.
const INFINITE: f32 = 1e29;

// The difference of two depths as a share of the larger.
fn difference(a: f32, b: f32) -> f32 {
    return 1.0 - min(min(a, b), INFINITE) / max(min(max(a, b), INFINITE), 1e-30);
}

// Whether the rays around a pixel, up to two pixels away, end at other distances.
fn beside_edge(pixel: vec2i) -> bool {
    let end = textureLoad(ray_ends, pixel, 0).r;
    var beside = false;
    for (var k = 0; k < 12; k++) {
        let at = pixel + AROUND[k];
        if all(at >= vec2i(0)) && all(at < vec2i(view.size)) {
            beside = beside || difference(end, textureLoad(ray_ends, at, 0).r) > EDGE * DEPTH_TOLERANCE;
        }
    }
    return beside;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(near_ends);
    if any(id.xy >= size) {
        return;
    }
    let scale = f32(blocks.scale);
    for (var k = 0; k < 9; k++) {
        let at = vec2i(id.xy) + vec2i(k % 3 - 1, k / 3 - 1);
        let block = vec2u(clamp(at, vec2i(0), vec2i(size) - 1));
        let along = stretch(block_center(block));
        near_blocks[k] = vec4f(textureLoad(near_layer, block, 0).rgb, textureLoad(near_ends, block, 0).r / along);
        far_blocks[k] = near_blocks[k];
        let end = textureLoad(far_ends, block, 0).r;
        // a loop, since some drivers execute both sides of every branch
        loop {
            if end == 0.0 {
                break;
            }
            far_blocks[k] = vec4f(textureLoad(far_layer, block, 0).rgb, end / along);
            break;
        }
    }
    let center = block_center(id.xy);
    let first = id.xy * blocks.scale;
    let end = min(first + blocks.scale, view.size);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let pixel = vec2f(vec2u(x, y)) + 0.5;
            let depth = textureLoad(ray_ends, vec2u(x, y), 0).r / stretch(pixel);
            let away = (pixel - center) / scale;
            let side = select(vec2i(-1), vec2i(1), away >= vec2f(0.0));
            let share = abs(away);
            var sum = vec3f();
            var weights = 0.0;
            var edge = false;
            for (var k = 0; k < 4; k++) {
                let aside = vec2i(k & 1, k >> 1u);
                let at = aside * side;
                let block = vec2i(id.xy) + at;
                let outside = any(block < vec2i(0)) || any(block >= vec2i(size));
                let index = at.x + 1 + 3 * (at.y + 1);
                let near = near_blocks[index];
                let far = far_blocks[index];
                let near_apart = difference(depth, near.w);
                let far_apart = difference(depth, far.w);
                let value = select(near.rgb, far.rgb, far_apart < near_apart);
                let apart = min(near_apart, far_apart) / DEPTH_TOLERANCE;
                let tent = select(vec2f(1.0) - share, share, aside == vec2i(1));
                let falloff = 1.0 + apart * apart;
                let weight = select(tent.x * tent.y / (falloff * falloff), 0.0, outside);
                edge = edge || (weight > 0.0 && (apart > EDGE || far.w > LAYERS_APART * near.w));
                sum += weight * value;
                weights += weight;
            }
            // a loop, since some drivers execute both sides of every branch
            var anew = 0.0;
            loop {
                if !edge || blocks.refines == 0u {
                    break;
                }
                anew = select(0.0, 1.0, beside_edge(vec2i(vec2u(x, y))));
                break;
            }
            textureStore(scattered, vec2u(x, y), vec4f(sum / weights, anew));
        }
    }
}
