// The exact lit pieces of a view ray against a map: a walk over its min-max pyramid. Nothing is sampled.
//
// The importing pass declares what shadow_map.wgsl asks for, the texture `pyramid` (mip l holds least and greatest
// height of blocks of 2^l cells, for every second l) and the override constant `LINEAR`; it defines
// `take_piece(x0, x1)`, which is given every lit piece. Twins: crates/shadowmap/src/{walk,cells,traversal,seams}.rs.

#import shadow_map

// levels of the pyramid that are built: blocks grow four times a side from one to the next
const LEVEL_STEP: u32 = 2u;
// a walk visits no more blocks than this: some drivers cut loops silently at 65,535 trips
const MOST_BLOCKS: i32 = 60000;

// Keeps lit pieces of a ray until enough of them have come, joined where they meet.
fn push_piece(x0: f32, x1: f32) {
    if !(x1 > x0) {
        return;
    }
    if open_piece.y == x0 && open_piece.y > open_piece.x {
        open_piece.y = x1;
        return;
    }
    close_piece();
    open_piece = vec2f(x0, x1);
}

fn close_piece() {
    if open_piece.y > open_piece.x {
        take_piece(open_piece.x, open_piece.y);
    }
    open_piece = vec2f();
}

var<private> open_piece: vec2f;

// The root of a line within a piece.
fn root_within(line: vec2f, x0: f32, x1: f32) -> f32 {
    return max(min(-line.x / line.y, x1), x0);
}

// The part of a piece where height w <= own, which is linear in x.
fn push_before(behind: vec2f, x0: f32, x1: f32) {
    let dark0 = at(behind, x0) > 0.0;
    let dark1 = at(behind, x1) > 0.0;
    if dark0 && dark1 {
        return;
    }
    if dark0 == dark1 {
        push_piece(x0, x1);
        return;
    }
    let root = root_within(behind, x0, x1);
    push_piece(select(x0, root, dark0), select(x1, root, dark1));
}

// A cell whose nodes are joined by two triangles; u and v from the cell's first node, times w.
fn push_triangles(cell: vec4f, u: vec2f, v: vec2f, w: vec2f, own: vec2f, x0: f32, x1: f32) {
    let diagonal = u + v - w;
    let low0 = at(diagonal, x0) > 0.0;
    let low1 = at(diagonal, x1) > 0.0;
    var cut = x1;
    if low0 != low1 {
        cut = root_within(diagonal, x0, x1);
    }
    for (var part = 0; part < 2; part++) {
        let a = select(cut, x0, part == 0);
        let b = select(x1, cut, part == 0);
        if !(b > a) {
            continue;
        }
        let lower = select(low1, low0, part == 0);
        let corner = select(cell.x, cell.w, lower);
        let along_u = select(cell.y, cell.z, lower);
        let along_v = select(cell.z, cell.y, lower);
        if LIGHT == DIRECTIONAL && min(corner, min(along_u, along_v)) <= NOTHING {
            push_piece(a, b);
            continue;
        }
        let p = select(u, w - u, lower);
        let q = select(v, w - v, lower);
        push_before(w * corner + p * (along_u - corner) + q * (along_v - corner) - own, a, b);
    }
}

// Lit pieces of x0 to x1, on which (u, v)/w stays within a face's cells.
fn walk_face(face: i32, u: vec2f, v: vec2f, w: vec2f, own: vec2f, x0: f32, x1: f32) {
    let shrink = select(0, 1, LINEAR);
    let cells = vec2i(i32(light.map_width), i32(light.map_height)) - shrink;
    var level = light.map_top;
    var cell = texel_at(u, v, w, x0, vec2i(0), cells - 1);
    // whether the coordinates grow along the ray
    let growth = vec2f(u.y * w.x - u.x * w.y, v.y * w.x - v.x * w.y);
    var x = x0;
    var w_here = at(w, x0);
    var own_here = at(own, x0);
    for (var i = 0; i < MOST_BLOCKS; i++) {
        let first = (cell >> vec2u(level)) << vec2u(level);
        let size = 1 << level;
        let border = select(first, first + size, growth > vec2f(0.0));
        // where the ray leaves the block
        let exits = vec2f(leaves(u, w, growth.x, border.x), leaves(v, w, growth.y, border.y));
        let next = clamp(min(exits.x, exits.y), x, x1);
        let w_next = at(w, next);
        let own_next = at(own, next);
        let range = textureLoad(pyramid, cell >> vec2u(level), face, level).rg;
        let lit = range.y * w_here <= own_here && range.y * w_next <= own_next;
        let dark = range.x * w_here > own_here && range.x * w_next > own_next;
        if !lit && !dark && level > 0u {
            level -= LEVEL_STEP;
            let last = min(first + size, cells) - 1;
            cell = texel_at(u, v, w, x, first, last);
            continue;
        }
        if lit {
            push_piece(x, next);
        } else if !dark {
            if LINEAR {
                let nodes = cell_heights(face, cell.x, cell.y);
                push_triangles(nodes, u - f32(cell.x) * w, v - f32(cell.y) * w, w, own, x, next);
            } else {
                push_before(range.x * w - own, x, next);
            }
        }
        if next >= x1 {
            return;
        }
        x = next;
        w_here = w_next;
        own_here = own_next;
        // over the border, and up to the largest block that begins there
        let by_column = exits.x <= exits.y;
        let crossed = select(border.y, border.x, by_column);
        if by_column {
            cell.x = select(border.x - 1, border.x, growth.x > 0.0);
        } else {
            cell.y = select(border.y - 1, border.y, growth.y > 0.0);
        }
        if any(cell < vec2i(0)) || any(cell >= cells) {
            return;
        }
        level = min(firstTrailingBit(u32(crossed)) & ~1u, light.map_top);
    }
}

// The cell that the ray is in at x, within limits.
fn texel_at(u: vec2f, v: vec2f, w: vec2f, x: f32, least: vec2i, most: vec2i) -> vec2i {
    let scale = 1.0 / max(at(w, x), 1e-30);
    return clamp(vec2i(floor(vec2f(at(u, x), at(v, x)) * scale)), least, most);
}

// Where u/w passes the border at `index` with growth of the given sign.
fn leaves(u: vec2f, w: vec2f, growth: f32, index: i32) -> f32 {
    let line = u - f32(index) * w;
    // a line without slope, or one that the ray only nears, is never passed
    let passed = (growth > 0.0 && line.y > 0.0) || (growth < 0.0 && line.y < 0.0);
    return select(ENDLESS, -line.x / line.y, passed);
}

// All of a spot's or a directional light's map.
fn walk_map(path: MapPath, piece: vec2f) {
    let inset = select(0.0, 0.5, LINEAR);
    let n = vec2f(light.map_width, light.map_height);
    let w = select(path.w, vec2f(1.0, 0.0), LIGHT == DIRECTIONAL);
    let u = 0.5 * n.x * (w + path.x) - inset * w;
    let v = 0.5 * n.y * (w + path.y) - inset * w;
    let own = select(vec2f(1.0, 0.0), -path.depth, LIGHT == DIRECTIONAL);
    let last = n - 2.0 * inset;
    var inside = nonnegative(w.x, w.y, piece);
    inside = nonnegative(u.x, u.y, inside);
    inside = nonnegative(v.x, v.y, inside);
    inside = nonnegative(last.x * w.x - u.x, last.x * w.y - u.y, inside);
    inside = nonnegative(last.y * w.x - v.x, last.y * w.y - v.y, inside);
    let empty = !(inside.y > inside.x) || min(last.x, last.y) <= 0.0;
    if light.outside == 1u {
        if empty {
            push_piece(piece.x, piece.y);
            return;
        }
        push_piece(piece.x, inside.x);
    }
    if !empty {
        walk_face(0, u, v, w, own, inside.x, inside.y);
        if light.outside == 1u {
            push_piece(inside.y, piece.y);
        }
    }
}

// The six faces of a cube map as steps, in the order in which the ray passes them.
fn walk_cube(path: MapPath, piece: vec2f) {
    var x = piece.x;
    var face = face_towards(vec3f(at(path.x, x), at(path.y, x), at(path.w, x)));
    for (var i = 0; i < 8; i++) {
        let offsets = seen_by(face, vec3f(path.x.x, path.y.x, path.w.x));
        let slopes = seen_by(face, vec3f(path.x.y, path.y.y, path.w.y));
        let right = vec2f(offsets.x, slopes.x);
        let down = vec2f(offsets.y, slopes.y);
        let w = vec2f(offsets.z, slopes.z);
        // the sides of the face, positive within
        var end = piece.y;
        var side = -1;
        for (var k = 0; k < 4; k++) {
            let line = w + select(1.0, -1.0, (k & 1) == 1) * select(right, down, k >= 2);
            if line.y < 0.0 {
                let root = -line.x / line.y;
                if root < end {
                    end = root;
                    side = k;
                }
            }
        }
        end = max(end, x);
        let half = 0.5 * light.map_width;
        if end > x {
            walk_face(face, half * (w + right), half * (w + down), w, vec2f(1.0, 0.0), x, end);
        }
        if side < 0 {
            return;
        }
        x = end;
        // over the side right = -w, right = w, down = -w or down = w
        face = neighbour(face, side);
    }
}

// The face beyond a side of a cube's face.
fn neighbour(face: i32, side: i32) -> i32 {
    let sign = select(-1.0, 1.0, (side & 1) == 1);
    let x = select(sign, 0.0, side >= 2);
    let y = select(0.0, sign, side >= 2);
    switch face {
        case 0: { return face_towards(vec3f(0.0, -y, -x)); }
        case 1: { return face_towards(vec3f(0.0, -y, x)); }
        case 2: { return face_towards(vec3f(x, 0.0, y)); }
        case 3: { return face_towards(vec3f(x, 0.0, -y)); }
        case 4: { return face_towards(vec3f(x, -y, 0.0)); }
        default: { return face_towards(vec3f(-x, -y, 0.0)); }
    }
}

// A line of coordinate `axis` of the path from a cube's light.
fn axis_line(path: MapPath, axis: i32, sign: f32) -> vec2f {
    return sign * select(select(path.w, path.y, axis == 1), path.x, axis == 0);
}

// The six faces of a cube map within their outermost centres, the strips and the corners between them.
fn walk_cube_surface(path: MapPath, piece: vec2f) {
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    if n > 1.0 {
        for (var face = 0; face < 6; face++) {
            let offsets = seen_by(face, vec3f(path.x.x, path.y.x, path.w.x));
            let slopes = seen_by(face, vec3f(path.x.y, path.y.y, path.w.y));
            let right = vec2f(offsets.x, slopes.x);
            let down = vec2f(offsets.y, slopes.y);
            let w = vec2f(offsets.z, slopes.z);
            var inside = nonnegative(w.x, w.y, piece);
            for (var k = 0; k < 4; k++) {
                let line = near * w + select(1.0, -1.0, (k & 1) == 1) * select(right, down, k >= 2);
                inside = nonnegative(line.x, line.y, inside);
            }
            if inside.y > inside.x {
                let u = 0.5 * n * (w + right) - 0.5 * w;
                let v = 0.5 * n * (w + down) - 0.5 * w;
                walk_face(face, u, v, w, vec2f(1.0, 0.0), inside.x, inside.y);
            }
        }
        for (var i = 0; i < 12; i++) {
            walk_strip(path, strip(i), piece);
        }
    }
    for (var i = 0; i < 8; i++) {
        let signs = corner_signs(i);
        let a = axis_line(path, 0, signs.x);
        let b = axis_line(path, 1, signs.y);
        let c = axis_line(path, 2, signs.z);
        let w = a + b + c;
        var inside = nonnegative(w.x, w.y, piece);
        // beyond the ends of the three strips
        let ends = array<vec2f, 3>(
            a * (2.0 - h) - (b + c) * near, b * (2.0 - h) - (a + c) * near, c * (2.0 - h) - (a + b) * near,
        );
        for (var k = 0; k < 3; k++) {
            inside = nonnegative(ends[k].x, ends[k].y, inside);
        }
        if inside.y > inside.x {
            let u = (b * (3.0 - 2.0 * h) - w * near) * n;
            let v = (c * (3.0 - 2.0 * h) - w * near) * n;
            push_triangles(corner_heights(signs), u, v, w, vec2f(1.0, 0.0), inside.x, inside.y);
        }
    }
}

fn walk_strip(path: MapPath, strip: Strip, piece: vec2f) {
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    let a = axis_line(path, strip.a, strip.sign_a);
    let b = axis_line(path, strip.b, strip.sign_b);
    let c = axis_line(path, strip.c, 1.0);
    let w = a + b;
    let sides = array<vec2f, 4>(
        a - near * b, b - near * a, near * w + (2.0 - h) * c, near * w - (2.0 - h) * c,
    );
    var inside = nonnegative(w.x, w.y, piece);
    for (var k = 0; k < 4; k++) {
        inside = nonnegative(sides[k].x, sides[k].y, inside);
    }
    if !(inside.y > inside.x) {
        return;
    }
    let u = 0.5 * n * (2.0 - h) * c + 0.5 * (n - 1.0) * w;
    let v = n * (b - near * a);
    let growth = u.y * w.x - u.x * w.y;
    var x = inside.x;
    var cell = texel_at(u, v, w, x, vec2i(0), vec2i(i32(n) - 2, 0)).x;
    for (var i = 0; i < MOST_BLOCKS; i++) {
        let border = select(cell, cell + 1, growth > 0.0);
        let next = clamp(leaves(u, w, growth, border), x, inside.y);
        push_triangles(strip_heights(strip, cell), u - f32(cell) * w, v, w, vec2f(1.0, 0.0), x, next);
        cell = select(border - 1, border, growth > 0.0);
        if next >= inside.y || cell < 0 || cell > i32(n) - 2 {
            return;
        }
        x = next;
    }
}

// Gives every lit piece of `piece` to take_piece.
fn walk(path: MapPath, piece: vec2f) {
    open_piece = vec2f();
    if piece.y > piece.x {
        if LIGHT != POINT {
            walk_map(path, piece);
        } else if LINEAR {
            walk_cube_surface(path, piece);
        } else {
            walk_cube(path, piece);
        }
    }
    close_piece();
}
