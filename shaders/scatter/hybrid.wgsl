// Airlight of one light by a march between the faces of its shadow volume that looks its map up (hybrid.wgsl). In and out:
// see bindings.wgsl.

#import bindings
#import sight_map
#import hybrid

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var radiance = vec3f();
    // a loop, since some drivers execute both sides of every branch
    loop {
        if !is_wanted(pixel) {
            break;
        }
        radiance = hybrid(pixel);
        break;
    }
    add_radiance(pixel, radiance);
}
