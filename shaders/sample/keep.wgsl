// Keeps the lattice's radiance as if nothing cast a shadow. In and out: see sampling.wgsl.

#import sampling

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = lattice_size();
    if any(id.xy >= size) {
        return;
    }
    unshadowed[id.y * size.x + id.x] = values[place_of(id.xy * level.spacing)];
}
