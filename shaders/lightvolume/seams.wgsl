// What joins the faces of a cube's light volume: twelve strips of cells between the outermost nodes of two faces, and a
// triangle at each of the eight corners. In and out: see light_crossing.wgsl.

#import light_crossing

// A node of a seam: where it lies, and as (u, v, height) of the seam's own grid.
struct SeamNode {
    placed: Placed,
    direction: vec3f,
}

// The node of the cube map towards d, whose largest component is 1.
fn towards(d: vec3f) -> SeamNode {
    let height = height_towards(d);
    let direction = world_row(d).xyz;
    return SeamNode(Placed(mesh.origin * height + direction, height), direction);
}

// The same of three nodes in the order in which the faces' triangles go round, seen from the light.
fn ordered(corner: u32, a: SeamNode, b: SeamNode, c: SeamNode, plane: vec4f) -> Crossing {
    // the camera's basis is left-handed, and so are a cube's images
    let turned = dot(a.direction, cross(b.direction, c.direction)) < 0.0;
    switch corner {
        case 0u: { return seen(a.placed, plane); }
        case 1u: { if turned { return seen(c.placed, plane); } return seen(b.placed, plane); }
        default: { if turned { return seen(b.placed, plane); } return seen(c.placed, plane); }
    }
}

// Node (i, side) of a strip, as in strip_heights.
fn strip_node(own: Strip, i: i32, side: i32) -> SeamNode {
    let h = 1.0 / light.map_width;
    let along = (2.0 * f32(i) + 1.0) * h - 1.0;
    let a = select(1.0, 1.0 - h, side == 1) * own.sign_a;
    let b = select(1.0 - h, 1.0, side == 1) * own.sign_b;
    return towards(on_axes(own.a, own.b, own.c, vec3f(a, b, along)));
}

fn strip_vertex(index: i32, cell: i32, k: u32) -> Crossing {
    let own = strip(index);
    let n = light.map_width;
    let h = 1.0 / n;
    let scale = 1.0 / (2.0 - h);
    let ra = own.sign_a * light.rows[own.a];
    let rb = own.sign_b * light.rows[own.b];
    let w = ra + rb;
    let grid = Grid(0.5 * n * (2.0 - h) * light.rows[own.c] + 0.5 * (n - 1.0) * w, (rb - (1.0 - h) * ra) * n, w);
    let lower = k >= 3u;
    let a = vec2i(cell + select(0, 1, lower), select(0, 1, lower));
    let b = vec2i(cell + select(1, 0, lower), select(0, 1, lower));
    let c = vec2i(cell + select(0, 1, lower), select(1, 0, lower));
    let na = strip_node(own, a.x, a.y);
    let nb = strip_node(own, b.x, b.y);
    let nc = strip_node(own, c.x, c.y);
    let plane = plane_of(
        grid, vec3f(vec2f(a), na.placed.weight * scale), vec3f(vec2f(b), nb.placed.weight * scale),
        vec3f(vec2f(c), nc.placed.weight * scale),
    );
    return ordered(k % 3u, na, nb, nc, plane);
}

fn corner_vertex(index: i32, k: u32) -> Crossing {
    let signs = corner_signs(index);
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    let scale = 1.0 / (3.0 - 2.0 * h);
    let x = towards(signs * vec3f(1.0, near, near));
    let y = towards(signs * vec3f(near, 1.0, near));
    let z = towards(signs * vec3f(near, near, 1.0));
    let ra = signs.x * light.rows[0];
    let rb = signs.y * light.rows[1];
    let rc = signs.z * light.rows[2];
    let w = ra + rb + rc;
    let grid = Grid((rb / scale - near * w) * n, (rc / scale - near * w) * n, w);
    let plane = plane_of(
        grid, vec3f(0.0, 0.0, x.placed.weight * scale), vec3f(1.0, 0.0, y.placed.weight * scale),
        vec3f(0.0, 1.0, z.placed.weight * scale),
    );
    return ordered(k, x, y, z, plane);
}

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32) -> Crossing {
    let cells = u32(light.map_width) - 1u;
    let strips = 72u * cells;
    if vertex >= strips {
        let rest = vertex - strips;
        return corner_vertex(i32(rest / 3u), rest % 3u);
    }
    let cell = vertex / 6u;
    return strip_vertex(i32(cell / cells), i32(cell % cells), vertex % 6u);
}

@fragment
fn fs_main(crossing: Crossing, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return crossed(crossing, is_front);
}
