// Shadow rays of the volumes of single views, all views in one dispatch: the frustum next to each viewer (Stojanovic et
// al. 2023, section 3.1.2), or every froxel of the reference.
//
// A cell is traced to the lights that some froxel in it asks for. A thread has the slices of a word.

#import froxel
#import bindings_bvh

// How far some froxel of a cell is lit.
fn cell_reach(view: FroxelView, cell: vec2u) -> f32 {
    let first = cell * froxels.near_side;
    let last = min(first + froxels.near_side, view.tiles);
    var reach = 0.0;
    for (var y = first.y; y < last.y; y++) {
        for (var x = first.x; x < last.x; x++) {
            reach = max(reach, reach_of(view, vec2u(x, y)));
        }
    }
    return reach;
}

// Lights that froxels of a cell ask for.
fn cell_needs(view: FroxelView, cell: vec3u) -> u32 {
    var asked = 0u;
    let first = cell.xy * froxels.near_side;
    let last = min(first + froxels.near_side, view.tiles);
    let distance = slice_distance(cell.z, froxels.jitter);
    let start = slice_start(cell.z);
    for (var y = first.y; y < last.y; y++) {
        for (var x = first.x; x < last.x; x++) {
            let tile = vec2u(x, y);
            if start < reach_of(view, tile) {
                asked |= needs(view.eye + distance * froxel_direction(view, tile, 1u));
            }
        }
    }
    return asked;
}

// Mask of a cell: the lights that reach it.
fn cell_mask(view: FroxelView, cell: vec3u, traced: ptr<function, u32>) -> u32 {
    let asked = cell_needs(view, cell);
    if asked == 0u {
        return 0u;
    }
    let point = view.eye + slice_distance(cell.z, froxels.jitter) * froxel_direction(view, cell.xy, froxels.near_side);
    let chosen = chosen_lights(point);
    var left = asked & chosen;
    var lit = 0u;
    while left != 0u {
        let i = firstTrailingBit(left);
        left &= left - 1u;
        var is_lit = true;
        if may_be_shadowed(light_at(i), point) {
            *traced += 1u;
            is_lit = !occluded(point, way_to(light_at(i), point), way_end(light_at(i)));
        }
        lit |= u32(is_lit) << light_bit(chosen, i);
    }
    return lit;
}

@compute @workgroup_size(4, 4, 4)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let lanes = 32u / LIGHT_BITS;
    let words = (froxels.near_slices + lanes - 1u) / lanes;
    let layers = (words + 3u) / 4u;
    let view = froxel_views.views[group.z / layers];
    let cells = (view.tiles + froxels.near_side - 1u) / froxels.near_side;
    let first = vec3u(group.xy * 4u + local.xy, ((group.z % layers) * 4u + local.z) * lanes);
    if any(first.xy >= cells) || first.z >= froxels.near_slices {
        return;
    }
    let reach = cell_reach(view, first.xy);
    var word = 0u;
    var traced = 0u;
    for (var lane = 0u; lane < lanes; lane++) {
        let cell = first + vec3u(0u, 0u, lane);
        if cell.z >= froxels.near_slices || slice_start(cell.z) >= reach {
            break;
        }
        word |= cell_mask(view, cell, &traced) << (lane * LIGHT_BITS);
    }
    near_masks[near_place(view, first).x] = word;
    if traced > 0u {
        atomicAdd(&counts[NEAR_RAYS], traced);
    }
}
