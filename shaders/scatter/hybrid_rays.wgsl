// Airlight of one light by a march between the faces of its shadow volume that casts shadow rays (hybrid.wgsl). In and out:
// see bindings.wgsl and bindings_bvh.wgsl.

#import bindings
#import sight_rays
#import hybrid

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var sum = vec4f(hybrid(pixel), 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
