// The nodes of a light's map, its texel centres, and the triangles that join them across the edges of a cube.
//
// A map holds heights: 1/depth in perspective and cube maps, -depth in orthographic ones, so that more is nearer to
// the light and a plane in the world is linear over the texels.
//
// The importing pass declares the texture `heights` (one layer a face) and the override constant `LIGHT` (light.wgsl).
// Twins: crates/shadowmap/src/{face,cube,seams}.rs.

#import light

// height of a texel that nothing stops light in, in an orthographic map; in others it is 0
const NOTHING: f32 = -3e38;

// A position on a map.
struct MapPoint {
    face: i32,
    u: f32,   // columns from the left; texel centres lie at +0.5
    v: f32,   // rows from the top
    w: f32,   // what heights are multiplied with
    own: f32, // what the product is compared with
}

// Face that sees direction d, and (right, down, forward) of d in its frame: order and axes of cube textures.
struct Seen {
    face: i32,
    v: vec3f,
}

fn seen_by(face: i32, d: vec3f) -> vec3f {
    switch face {
        case 0: { return vec3f(-d.z, -d.y, d.x); }
        case 1: { return vec3f(d.z, -d.y, -d.x); }
        case 2: { return vec3f(d.x, d.z, d.y); }
        case 3: { return vec3f(d.x, -d.z, -d.y); }
        case 4: { return vec3f(d.x, -d.y, d.z); }
        default: { return vec3f(-d.x, -d.y, -d.z); }
    }
}

fn face_towards(d: vec3f) -> i32 {
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(0, 1, d.x < 0.0);
    }
    if a.z > a.y {
        return select(4, 5, d.z < 0.0);
    }
    return select(2, 3, d.y < 0.0);
}

fn seen_towards(d: vec3f) -> Seen {
    let face = face_towards(d);
    return Seen(face, seen_by(face, d));
}

// Where the direction d from the light falls on a cube map.
fn on_cube(d: vec3f) -> MapPoint {
    let seen = seen_towards(d);
    let n = light.map_width;
    let scale = 0.5 * n / seen.v.z;
    let u = clamp(0.5 * n + seen.v.x * scale, 0.0, n);
    let v = clamp(0.5 * n + seen.v.y * scale, 0.0, n);
    return MapPoint(seen.face, u, v, seen.v.z, 1.0);
}

fn height_at(face: i32, column: i32, row: i32) -> f32 {
    let texel = clamp(vec2i(column, row), vec2i(0), vec2i(i32(light.map_width), i32(light.map_height)) - 1);
    return textureLoad(heights, texel, face, 0).r;
}

// Four node heights of a cell, at (0, 0), (1, 0), (0, 1), (1, 1); its diagonal joins the second and the third.
fn cell_heights(face: i32, column: i32, row: i32) -> vec4f {
    return vec4f(
        height_at(face, column, row), height_at(face, column + 1, row),
        height_at(face, column, row + 1), height_at(face, column + 1, row + 1),
    );
}

// Height of the cube map's texel whose centre lies towards d.
fn height_towards(d: vec3f) -> f32 {
    let p = on_cube(d);
    return height_at(p.face, i32(p.u), i32(p.v));
}

// A vector with the given components along three axes of the world.
fn on_axes(a: i32, b: i32, c: i32, values: vec3f) -> vec3f {
    var d = vec3f();
    d[a] = values.x;
    d[b] = values.y;
    d[c] = values.z;
    return d;
}

// The strip between the outermost centres of two faces of a cube map, one along axis a and one along b.
struct Strip {
    a: i32,
    b: i32,
    c: i32,      // the axis along the edge
    sign_a: f32,
    sign_b: f32,
}

fn strip(index: i32) -> Strip {
    // pairs of axes (0, 1), (0, 2), (1, 2), each with four signs
    let pair = index / 4;
    let a = select(0, 1, pair == 2);
    let b = select(2, 1, pair == 0);
    return Strip(a, b, 3 - a - b, select(1.0, -1.0, (index & 1) == 1), select(1.0, -1.0, (index & 2) == 2));
}

// Node heights of cell i of a strip, counted along the positive axis c; scaled for W = a + b.
fn strip_heights(strip: Strip, i: i32) -> vec4f {
    let h = 1.0 / light.map_width;
    let along = vec2f((2.0 * f32(i) + 1.0) * h - 1.0, (2.0 * f32(i) + 3.0) * h - 1.0);
    let a = vec2f(strip.sign_a, (1.0 - h) * strip.sign_a);
    let b = vec2f(strip.sign_b, (1.0 - h) * strip.sign_b);
    let cell = vec4f(
        height_towards(on_axes(strip.a, strip.b, strip.c, vec3f(a.x, b.y, along.x))),
        height_towards(on_axes(strip.a, strip.b, strip.c, vec3f(a.x, b.y, along.y))),
        height_towards(on_axes(strip.a, strip.b, strip.c, vec3f(a.y, b.x, along.x))),
        height_towards(on_axes(strip.a, strip.b, strip.c, vec3f(a.y, b.x, along.y))),
    );
    return cell / (2.0 - h);
}

// Signs of the axes at one of the eight corners of a cube map.
fn corner_signs(index: i32) -> vec3f {
    return select(vec3f(1.0), vec3f(-1.0), (vec3i(index) & vec3i(1, 2, 4)) != vec3i(0));
}

// Node heights of a corner's triangle, scaled for W = a + b + c; the fourth lies behind the diagonal, where it ends.
fn corner_heights(signs: vec3f) -> vec4f {
    let h = 1.0 / light.map_width;
    let near = 1.0 - h;
    let x = height_towards(signs * vec3f(1.0, near, near));
    let y = height_towards(signs * vec3f(near, 1.0, near));
    let z = height_towards(signs * vec3f(near, near, 1.0));
    return vec4f(x, y, z, y) / (3.0 - 2.0 * h);
}
