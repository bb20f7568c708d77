// The farthest end of a view ray in each tile of a view.

#import froxel
#import froxel_which

@group(2) @binding(1) var ray_ends: texture_2d<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let view = froxel_views.views[which.view];
    if any(id.xy >= view.tiles) {
        return;
    }
    let first = id.xy * froxels.tile;
    let last = min(first + froxels.tile, view.size);
    var farthest = 0.0;
    for (var y = first.y; y < last.y; y++) {
        for (var x = first.x; x < last.x; x++) {
            farthest = max(farthest, textureLoad(ray_ends, vec2u(x, y), 0).r);
        }
    }
    reaches[view.first_tile + id.y * view.tiles.x + id.x] = min(farthest, froxels.range);
}
