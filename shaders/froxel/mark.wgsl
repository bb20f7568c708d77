// Marks the voxels that froxels will read, and the lights that they will ask them for. All views in one dispatch.
//
// A mark is the very bit that the ray's answer then takes the place of, so that marks need no memory of their own.

#import froxel
#import froxel_voxels

fn mark_voxel(voxel: vec3u, fine: bool, lights: u32) {
    let read = alternate(voxel, fine);
    let bits = to_bits(lights, chosen_lights(voxel_center(read, fine)));
    if bits == 0u {
        return;
    }
    var word = 0u;
    if BRICKS {
        let place = make_brick(brick_key(read, fine));
        if place == NOWHERE {
            return;
        }
        word = brick_word(place, read);
    } else {
        word = dense_word(read);
        note_block(read);
    }
    let shifted = bits << voxel_shift(read);
    // most voxels are marked by several froxels: a read is cheaper than a write that changes nothing
    if (load_word(word) & shifted) != shifted {
        or_word(word, shifted);
    }
}

fn mark_point(point: vec3f, fine: bool, lights: u32) {
    if !TRILINEAR {
        mark_voxel(voxel_at(point, fine), fine, lights);
        return;
    }
    let around = voxels_around(point, fine);
    for (var i = 0u; i < 8u; i++) {
        if corner_weight(around, i) > 0.0 {
            mark_voxel(corner_voxel(around, i), fine, lights);
        }
    }
}

fn mark_froxel(point: vec3f, k: u32) {
    let asked = needs(point);
    let fine = k < froxels.fine_slices;
    if is_within(point, froxels.grid_min, froxels.grid_max) {
        if asked != 0u {
            mark_point(point, fine, asked);
        }
        return;
    }
    // nothing shadows it outside of the box: its shadow is that of where the way to the light enters
    var left = asked;
    while left != 0u {
        let i = firstTrailingBit(left);
        left &= left - 1u;
        mark_point(stand_in(light_at(i), point), fine, 1u << i);
    }
}

@compute @workgroup_size(4, 4, 4)
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let far_slices = froxels.slices - froxels.near_slices;
    let layers = (far_slices + 4u * SLICES_A_THREAD - 1u) / (4u * SLICES_A_THREAD);
    let view = froxel_views.views[group.z / layers];
    let tile = group.xy * 4u + local.xy;
    let first = froxels.near_slices + ((group.z % layers) * 4u + local.z) * SLICES_A_THREAD;
    if any(tile >= view.tiles) || first >= froxels.slices {
        return;
    }
    let reach = reach_of(view, tile);
    let direction = froxel_direction(view, tile, 1u);
    let end = min(first + SLICES_A_THREAD, froxels.slices);
    for (var k = first; k < end; k++) {
        if slice_start(k) >= reach {
            break;
        }
        mark_froxel(view.eye + slice_distance(k, froxels.jitter) * direction, k);
    }
}
