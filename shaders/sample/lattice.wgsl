// Lists the rays of the lattice, and finds the inverse distance that every pixel sees. In and out: see sampling.wgsl.

#import sampling

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let end = textureLoad(ray_ends, id.xy, 0).r;
    inverse_depths[place_of(id.xy)] = select(1.0 / end, 0.0, end >= 1e29);
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
