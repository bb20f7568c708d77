// The airlight of each pixel: what is accumulated up to its surface, interpolated between the froxels around it.

#import froxel
#import froxel_which

@group(2) @binding(1) var ray_ends: texture_2d<f32>;
@group(2) @binding(2) var accumulated: texture_3d<f32>;
@group(2) @binding(3) var airlight: texture_storage_2d<rgba32float, write>;

// What is accumulated in a column of froxels up to a place among its slices.
fn column_value(tile: vec2u, k: u32, share: f32) -> vec4f {
    var before = vec4f();
    if k > 0u {
        before = textureLoad(accumulated, vec3u(tile, k - 1u), 0);
    }
    return mix(before, textureLoad(accumulated, vec3u(tile, k), 0), share);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let froxel_view = froxel_views.views[which.view];
    if any(id.xy >= froxel_view.size) {
        return;
    }
    let place = slice_place(min(textureLoad(ray_ends, id.xy, 0).r, froxels.range));
    let k = min(u32(place), froxels.slices - 1u);
    let share = place - f32(k);
    let at = (vec2f(id.xy) + 0.5) / f32(froxels.tile) - 0.5;
    let low = floor(at);
    let f = at - low;
    let last = vec2f(froxel_view.tiles - 1u);
    let a = vec2u(clamp(low, vec2f(0.0), last));
    let b = vec2u(clamp(low + 1.0, vec2f(0.0), last));
    let upper = mix(column_value(a, k, share), column_value(vec2u(b.x, a.y), k, share), f.x);
    let lower = mix(column_value(vec2u(a.x, b.y), k, share), column_value(b, k, share), f.x);
    let sum = mix(upper, lower, f.y);
    textureStore(airlight, id.xy, vec4f(sum.rgb, 0.0));
}
