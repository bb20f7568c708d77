// Airlight of a textured spot by a march in three segments that looks its map up (hybrid_textured.wgsl). In and out: see
// bindings.wgsl.

#import bindings
#import sight_map
#import hybrid_textured

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var sum = vec4f(hybrid_textured(pixel), 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
