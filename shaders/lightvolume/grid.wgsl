// The surface of a light volume with every cell of the map as two triangles; instances are the map's faces. No vertex
// buffer: six vertices a cell. In and out: see light_crossing.wgsl.

#import light_crossing

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32, @builtin(instance_index) face: u32) -> Crossing {
    let columns = u32(light.map_width) - 1u;
    let index = vertex / 6u;
    let cell = vec2i(i32(index % columns), i32(index / columns));
    let k = vertex % 6u;
    // the diagonal joins the upper right and the lower left node
    let lower = k >= 3u;
    let a = node_at(i32(face), cell + select(vec2i(0, 0), vec2i(1, 1), lower));
    let b = node_at(i32(face), cell + select(vec2i(1, 0), vec2i(0, 1), lower));
    let c = node_at(i32(face), cell + select(vec2i(0, 1), vec2i(1, 0), lower));
    let corner = k % 3u;
    let own = select(select(c, b, corner == 1u), a, corner == 0u);
    return seen(place(i32(face), own), plane_of(grid_of(i32(face)), a, b, c));
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
