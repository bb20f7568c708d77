// Airlight of one light by a march that looks its map up at every step (march.wgsl). In and out: see bindings.wgsl.

#import bindings
#import march
#import sight_map

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
        radiance = march(pixel);
        break;
    }
    add_radiance(pixel, radiance);
}
