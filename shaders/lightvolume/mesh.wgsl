// The surface of a light volume from a list of triangles that was made beforehand, of a map of one image. Each vertex is
// two words: twice its column and row (16 bits each), and what it is. In and out: see light_crossing.wgsl.
// Twin: crates/gpu-backend/src/lightvolume/mesh.rs.

#import light_crossing

// a node of the map; the light; under a node, at the far plane of an orthographic map
const SURFACE: u32 = 0u;
const APEX: u32 = 1u;

fn vertex_node(index: u32) -> vec3f {
    let packed = leaves[index];
    let at = 0.5 * vec2f(f32(packed.x & 0xffffu), f32(packed.x >> 16u));
    if packed.y == SURFACE {
        return node_at(0, vec2i(at));
    }
    return vec3f(at + 0.5, -mesh.far);
}

// Where a vertex lies; `next` is the node after it in its triangle.
fn vertex_place(index: u32, next: vec3f) -> Placed {
    if leaves[index].y == APEX {
        return wall_apex(next);
    }
    return place(0, vertex_node(index));
}

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32) -> Crossing {
    let first = vertex - vertex % 3u;
    let a = vertex_node(first);
    let b = vertex_node(first + 1u);
    let c = vertex_node(first + 2u);
    var plane: vec4f;
    if LIGHT == SPOT && leaves[first].y == APEX {
        plane = wall_plane(b, c);
    } else if LIGHT == SPOT && leaves[first + 1u].y == APEX {
        plane = wall_plane(c, a);
    } else if LIGHT == SPOT && leaves[first + 2u].y == APEX {
        plane = wall_plane(a, b);
    } else {
        // skirts stand upright and have none: their distance is interpolated
        plane = plane_of(grid_of(0), a, b, c);
    }
    let next = first + (vertex + 1u - first) % 3u;
    return seen(vertex_place(vertex, vertex_node(next)), plane);
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
