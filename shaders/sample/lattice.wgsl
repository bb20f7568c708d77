// Lists the rays of the lattice. In and out: see sampling.wgsl.

#import sampling

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = lattice_size();
    if any(id.xy >= size) {
        return;
    }
    rays.pixels[id.y * size.x + id.x] = place_of(id.xy * level.spacing);
    if all(id.xy == vec2u(0u)) {
        atomicStore(&sampling.found, size.x * size.y);
        sampling.traced = 0u;
    }
}
