// Halves the stride at which a picture's airlight is known: pixels halfway between are predicted, or listed where that would
// err by too much.
//
// A thread has the three pixels behind one that is known: to its right, below, and across. In and out: see sampling.wgsl.
// Twin: `Known::take` in crates/hybrid-march/src/adaptive/prediction.rs.

#import prediction

var<workgroup> group_count: atomic<u32>;
var<workgroup> group_first: u32;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    let half = i32(level.stride / 2u);
    let known = vec2i(id.xy * level.stride);
    let there = are_there(known, half);
    var is_listed = vec3<bool>(false);
    let places = vec3u(
        place_of(vec2u(known + vec2i(half, 0))),
        place_of(vec2u(known + vec2i(0, half))),
        place_of(vec2u(known + half)),
    );
    if any(there) {
        let found = predictions(known, i32(level.stride));
        let is_good = vec3f(found[0].estimate, found[1].estimate, found[2].estimate) <= vec3f(sampling.error);
        is_listed = there & !is_good;
        if there.x && is_good.x {
            values[places.x] = vec4f(found[0].value, 0.0);
        }
        if there.y && is_good.y {
            values[places.y] = vec4f(found[1].value, 0.0);
        }
        if there.z && is_good.z {
            values[places.z] = vec4f(found[2].value, 0.0);
        }
    }
    // one place in the list for all of a group, so that rays that are traced together are close together
    let own = select(vec3u(0u), vec3u(1u), is_listed);
    var at = atomicAdd(&group_count, own.x + own.y + own.z);
    workgroupBarrier();
    if index == 0u {
        group_first = atomicAdd(&sampling.found, atomicLoad(&group_count));
    }
    workgroupBarrier();
    at += group_first;
    if is_listed.x {
        rays.pixels[at] = places.x;
    }
    if is_listed.y {
        rays.pixels[at + own.x] = places.y;
    }
    if is_listed.z {
        rays.pixels[at + own.x + own.y] = places.z;
    }
}
