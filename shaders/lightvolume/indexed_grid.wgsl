// The surface of a light volume with every cell of the map as two triangles, by indices that a tile of the map has in
// common with all others; instances are the map's faces. A node has two indices: as the first vertex of the upper left
// triangle of the cell to its lower right, and of the lower right one of the cell to its upper left. Nodes beyond the last
// are drawn onto it. In and out: see light_crossing.wgsl.

#import light_crossing

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32, @builtin(instance_index) face: u32) -> Crossing {
    let last = vec2i(i32(light.map_width), i32(light.map_height)) - 1;
    let index = i32(vertex >> 1u);
    let node = min(vec2i(index & ((1 << mesh.row_bits) - 1), index >> mesh.row_bits), last);
    let step = select(1, -1, (vertex & 1u) == 1u);
    let a = node_at(i32(face), node);
    let b = node_at(i32(face), clamp(node + vec2i(step, 0), vec2i(0), last));
    let c = node_at(i32(face), clamp(node + vec2i(0, step), vec2i(0), last));
    return seen(place(i32(face), a), plane_of(grid_of(i32(face)), a, b, c));
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
