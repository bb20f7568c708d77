// Puts the airlight of all pixels into a picture. In and out: see sampling.wgsl.

#import sampling

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    textureStore(picture, id.xy, vec4f(values[place_of(id.xy)].rgb, 0.0));
}
