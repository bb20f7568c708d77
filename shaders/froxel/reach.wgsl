// How far the froxels of a tile are lit: to the farthest end of a ray in it or the tiles around, since the picture is
// interpolated between tiles. All views at once.

#import froxel

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let view = froxel_views.views[id.z];
    if any(id.xy >= view.tiles) {
        return;
    }
    let low = max(id.xy, vec2u(1u)) - 1u;
    let high = min(id.xy + 1u, view.tiles - 1u);
    var farthest = 0.0;
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            farthest = max(farthest, reaches[view.first_tile + y * view.tiles.x + x]);
        }
    }
    reaches[arrayLength(&reaches) / 2u + view.first_tile + id.y * view.tiles.x + id.x] = farthest;
}
