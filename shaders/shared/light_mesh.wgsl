// The surface around what a light reaches, extruded from its map: nodes of the map as homogeneous points, and the planes
// of the triangles between them (Billeter, Sintorn and Assarsson 2010, section 4).
//
// A node of height h = 1/depth towards d lies at light h + d with the weight h, so that one where nothing stops light is
// the point at infinity towards d. In an orthographic map nothing is farther than `far`, and what is enclosed is the shadow.
// Vectors are in the camera's basis with the eye at the origin. The importing pass declares the uniforms `view`, `light`
// and `mesh`, the texture `heights` and the override constant `LIGHT`.
// Twins: crates/gpu-backend/src/layout/mesh.rs (layout), crates/lightvolume/src (functions).

#import map_nodes

struct Mesh {
    origin: vec3f,  // of a local light, or the middle of the plane of depth 0; units: m
    far: f32,       // depth of nodes where nothing stops light, of an orthographic map; units: m
    right: vec3f,   // to the map's right edge: a tangent, or units: m
    mirrored: u32,  // 1 where right x down points back to the light, as in cube maps
    down: vec3f,    // to its lower edge
    pool: u32,      // crossings for which there is room, of all pixels
    forward: vec3f, // unit
    row_bits: u32,  // of the number of a node within its row, of an indexed grid
}

// A homogeneous point.
struct Placed {
    at: vec3f,
    weight: f32,
}

// A vertex of the surface, on its way to the rasteriser.
struct Crossing {
    @builtin(position) position: vec4f,
    @location(0) weight: f32,
    // value and slope of a function that is positive behind the surface: plane.xyz . p + plane.w
    @location(1) @interpolate(flat, first) plane: vec4f,
}

// The rows that give homogeneous texel coordinates of a point.
struct Grid {
    u: vec4f,
    v: vec4f,
    w: vec4f,
}

// Column, row (centres at +0.5) and height of a node.
fn node_at(face: i32, node: vec2i) -> vec3f {
    var height = textureLoad(heights, node, face, 0).r;
    if LIGHT == DIRECTIONAL {
        height = max(height, -mesh.far);
    }
    return vec3f(vec2f(node) + 0.5, height);
}

// The axes of a cube's face as combinations of those of the world: right, down, forward. Inverse of seen_by.
fn face_axes(face: i32) -> mat3x3f {
    return transpose(mat3x3f(
        seen_by(face, vec3f(1.0, 0.0, 0.0)), seen_by(face, vec3f(0.0, 1.0, 0.0)), seen_by(face, vec3f(0.0, 0.0, 1.0)),
    ));
}

// A world vector as a row over points: `light.rows` of a cube map are the world's axes.
fn world_row(d: vec3f) -> vec4f {
    return d.x * light.rows[0] + d.y * light.rows[1] + d.z * light.rows[2];
}

fn grid_of(face: i32) -> Grid {
    var x = light.rows[0];
    var y = light.rows[1];
    var w = light.rows[2];
    if LIGHT == POINT {
        let axes = face_axes(face);
        x = world_row(axes[0]);
        y = world_row(axes[1]);
        w = world_row(axes[2]);
    }
    return Grid(0.5 * light.map_width * (w + x), 0.5 * light.map_height * (w + y), w);
}

// Where a node lies.
fn place(face: i32, node: vec3f) -> Placed {
    let a = 2.0 * node.x / light.map_width - 1.0;
    let b = 2.0 * node.y / light.map_height - 1.0;
    if LIGHT == DIRECTIONAL {
        return Placed(mesh.origin + a * mesh.right + b * mesh.down - node.z * mesh.forward, 1.0);
    }
    var direction = mesh.forward + a * mesh.right + b * mesh.down;
    if LIGHT == POINT {
        let axes = face_axes(face);
        direction = world_row(axes[2] + a * axes[0] + b * axes[1]).xyz;
    }
    return Placed(mesh.origin * node.z + direction, node.z);
}

// What the surface's border is joined to: the light, or under an orthographic map a point below all of its middle.
fn apex_node() -> vec3f {
    return vec3f(0.5 * light.map_width, 0.5 * light.map_height, -mesh.far);
}

fn apex() -> Placed {
    if LIGHT == DIRECTIONAL {
        return place(0, apex_node());
    }
    return Placed(mesh.origin, 1.0);
}

// The apex of a wall that stands on a node. From the light itself walls are seen from their edge, and the apex is nowhere
// on the screen: there a wall ends where it begins.
fn wall_apex(node: vec3f) -> Placed {
    if LIGHT != DIRECTIONAL && all(mesh.origin == vec3f()) {
        return place(0, node);
    }
    return apex();
}

// The plane of three nodes, as a function that is positive behind it.
fn plane_of(grid: Grid, a: vec3f, b: vec3f, c: vec3f) -> vec4f {
    let p = b - a;
    let q = c - a;
    let area = p.x * q.y - p.y * q.x;
    let du = (p.z * q.y - p.y * q.z) / area;
    let dv = (p.x * q.z - p.z * q.x) / area;
    let surface = (a.z - du * a.x - dv * a.y) * grid.w + du * grid.u + dv * grid.v;
    if LIGHT == DIRECTIONAL {
        return surface + light.rows[3];
    }
    return surface - vec4f(0.0, 0.0, 0.0, 1.0);
}

// The plane between a border edge from one node to another and the apex.
fn wall_plane(a: vec3f, b: vec3f) -> vec4f {
    let grid = grid_of(0);
    if LIGHT == DIRECTIONAL {
        return plane_of(grid, apex_node(), a, b);
    }
    if a.x == b.x {
        return grid.u - a.x * grid.w;
    }
    return grid.v - a.y * grid.w;
}

// A vertex as the rasteriser takes it. Depth is half of w: nothing is cut off but what lies behind the eye.
fn seen(point: Placed, plane: vec4f) -> Crossing {
    let p = point.at;
    let x = 2.0 * (p.x - view.offset.x * p.z) / (view.scale_x * f32(view.size.x)) - p.z;
    let y = p.z - 2.0 * (p.y - view.offset.y * p.z) / (view.scale_y * f32(view.size.y));
    return Crossing(vec4f(x, y, 0.5 * p.z, p.z), point.weight, plane);
}

// A vertex of a triangle that is not there.
fn nothing_seen() -> Crossing {
    return Crossing(vec4f(0.0, 0.0, 0.0, 1.0), 1.0, vec4f());
}
