// The surface of a light volume from the leaves of a tessellation, see leaves.wgsl. In and out: see light_crossing.wgsl.

#import light_crossing

struct Leaf {
    quad: vec2u,
    level: u32,
    finer: u32,
    face: i32,
}

// Node at one of the eight places around a leaf.
fn node_of(leaf: Leaf, place: u32) -> vec3f {
    // columns 0 1 2 2 2 1 0 0 and rows 0 0 0 1 2 2 2 1, two bits each
    let half = vec2u((0x06a4u >> (2u * place)) & 3u, (0x6a40u >> (2u * place)) & 3u);
    let last = vec2u(u32(light.map_width), u32(light.map_height)) - 1u;
    let node = min((leaf.quad << vec2u(leaf.level)) + ((half << vec2u(leaf.level)) >> vec2u(1u)), last);
    return node_at(leaf.face, vec2i(node));
}

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32) -> Crossing {
    let packed = leaves[vertex >> 4u];
    let leaf = Leaf(
        vec2u(packed.x & 0xffffu, packed.x >> 16u), packed.y & 0xffu, (packed.y >> 8u) & 0xffu, i32(packed.y >> 16u),
    );
    let place_index = vertex & 15u;
    if place_index >= 8u {
        let side = place_index - 8u;
        let from_node = node_of(leaf, 2u * side);
        let to_node = node_of(leaf, (2u * side + 2u) & 7u);
        return seen(wall_apex(from_node), wall_plane(from_node, to_node));
    }
    // the triangle that begins here: of the upper left half (0, 1, 7) or of the lower right one (4, 5, 3)
    let half = select(0u, 4u, place_index >= 3u && place_index <= 5u);
    let own = (place_index + 8u - half) & 7u;
    let ahead = (leaf.finer & select(4u, 1u, half == 0u)) != 0u;
    let behind = (leaf.finer & select(2u, 8u, half == 0u)) != 0u;
    let second = select(2u, 1u, own == 0u && ahead);
    let third = select(6u, 7u, own != 7u && behind);
    let node = node_of(leaf, place_index);
    let plane = plane_of(
        grid_of(leaf.face), node, node_of(leaf, (second + half) & 7u), node_of(leaf, (third + half) & 7u),
    );
    return seen(place(leaf.face, node), plane);
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
