// Airlight of one light in a medium that varies, by a march that casts a shadow ray at every step (march_varying.wgsl). In
// and out: see bindings.wgsl and bindings_bvh.wgsl.

#import bindings
#import march_varying
#import sight_rays

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    set_so_far(pixel, march_varying(pixel));
}
