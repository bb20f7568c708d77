// Airlight of one light by a march that casts a shadow ray at every step (march.wgsl). In and out: see bindings.wgsl and
// bindings_bvh.wgsl.

#import bindings
#import march
#import sight_rays

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var sum = vec4f(march(pixel), 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
