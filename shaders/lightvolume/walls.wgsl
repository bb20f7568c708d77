// What closes a light volume of a single image: a triangle between each border edge of its grid and the light, or under
// an orthographic map a point far below. In and out: see light_crossing.wgsl.

#import light_crossing

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32) -> Crossing {
    let last = vec2i(i32(light.map_width), i32(light.map_height)) - 1;
    let edge = i32(vertex / 3u);
    // once around: top, right, bottom, left
    var a = vec2i(edge, 0);
    var step = vec2i(1, 0);
    if edge >= 2 * last.x + last.y {
        a = vec2i(0, last.y - (edge - 2 * last.x - last.y));
        step = vec2i(0, -1);
    } else if edge >= last.x + last.y {
        a = vec2i(last.x - (edge - last.x - last.y), last.y);
        step = vec2i(-1, 0);
    } else if edge >= last.x {
        a = vec2i(last.x, edge - last.x);
        step = vec2i(0, 1);
    }
    let from_node = node_at(0, a);
    let to_node = node_at(0, a + step);
    let plane = wall_plane(from_node, to_node);
    switch vertex % 3u {
        case 0u: { return seen(wall_apex(from_node), plane); }
        case 1u: { return seen(place(0, to_node), plane); }
        default: { return seen(place(0, from_node), plane); }
    }
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
