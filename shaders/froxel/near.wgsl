// Shadow rays of the volumes of single views, all views in one dispatch: the frustum next to each viewer (Stojanovic et
// al. 2023, section 3.1.2), or every froxel of the reference.
//
// A cell is traced to the lights that some froxel in it asks for. Threads are cells, 4 x 4 x 4 a group; four in a row
// share the words that they write.

#import froxel
#import bindings_bvh

var<workgroup> words: array<atomic<u32>, 64>;
var<workgroup> rays: atomic<u32>;

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

@compute @workgroup_size(4, 4, 4)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let layers = (froxels.near_slices + 3u) / 4u;
    let view = froxel_views.views[group.z / layers];
    let cell = vec3u(group.xy, group.z % layers) * 4u + local;
    let cells = (view.tiles + froxels.near_side - 1u) / froxels.near_side;
    atomicStore(&words[index], 0u);
    if index == 0u {
        atomicStore(&rays, 0u);
    }
    workgroupBarrier();
    if all(cell.xy < cells) && cell.z < froxels.near_slices {
        let asked = cell_needs(view, cell);
        if asked != 0u {
            let distance = slice_distance(cell.z, froxels.jitter);
            let point = view.eye + distance * froxel_direction(view, cell.xy, froxels.near_side);
            let chosen = chosen_lights(point);
            var left = asked & chosen;
            var lit = 0u;
            var traced = 0u;
            while left != 0u {
                let i = firstTrailingBit(left);
                left &= left - 1u;
                var is_lit = true;
                if may_be_shadowed(froxels.lights[i], point) {
                    traced++;
                    is_lit = !occluded(point, way_to(froxels.lights[i], point), way_end(froxels.lights[i]));
                }
                lit |= u32(is_lit) << light_bit(chosen, i);
            }
            // words of a row of four cells lie in a row
            let bit = local.x * LIGHT_BITS;
            atomicOr(&words[(local.z * 4u + local.y) * 4u + (bit >> 5u)], lit << (bit & 31u));
            atomicAdd(&rays, traced);
        }
    }
    workgroupBarrier();
    if local.x < LIGHT_BITS / 8u && cell.y < cells.y && cell.z < froxels.near_slices {
        let first = vec3u(group.x * 4u, cell.yz);
        let word = near_place(view, first).x + local.x;
        near_masks[word] = atomicLoad(&words[(local.z * 4u + local.y) * 4u + local.x]);
    }
    if index == 0u {
        let traced = atomicLoad(&rays);
        if traced > 0u {
            atomicAdd(&counts[NEAR_RAYS], traced);
        }
    }
}
