// The exact lit pieces of a view ray against a map: a walk over its min-max pyramid. Nothing is sampled.
//
// Pieces are kept and integrated once the walk is over: some software drivers execute both sides of every branch, so
// that nothing that costs anything may be inside the walk's loops but the walk. A ray with more pieces than are kept is
// walked again for the rest.
//
// The importing pass declares what shadow_map.wgsl asks for, the texture `pyramid` (mip l holds least and greatest
// height of blocks of 2^l cells, for every second l) and the override constant `LINEAR`. Twins:
// crates/shadowmap/src/{walk,cells,traversal,seams}.rs.

#import shadow_map

// levels of the pyramid that are built: blocks grow four times a side from one to the next
const LEVEL_STEP: u32 = 2u;
// a walk visits no more blocks than this: some drivers cut loops silently at 65,535 trips
const MOST_BLOCKS: i32 = 60000;

// lit pieces that are kept from one walk
const KEPT: u32 = 16u;
var<private> pieces: array<vec2f, KEPT>;
// pieces that the walk has found, and those of them that earlier walks have dealt with
var<private> found: u32;
var<private> dealt_with: u32;
// the lit piece that may still go on
var<private> open_piece: vec2f;

fn keep(piece: vec2f) {
    // wraps around, and so is no slot, for a piece that was dealt with
    let slot = found - dealt_with;
    if slot < KEPT {
        pieces[slot] = piece;
    }
    found += 1u;
}

// Adds a lit piece; one that follows the last without a gap prolongs it.
fn push_piece(x0: f32, x1: f32) {
    if x1 > x0 {
        let was_open = open_piece.y > open_piece.x;
        let joins = was_open && open_piece.y == x0;
        if was_open && !joins {
            keep(open_piece);
        }
        open_piece = vec2f(select(x0, open_piece.x, joins), x1);
    }
}

// A stretch of a ray in a parameter s in which texel coordinates and 1/depth are linear, as in perspective-correct
// interpolation; s rises along the ray, from -1 to 0 or from 0 to 1, and is 0 at the end that is deeper in the map, where
// depths change fastest with it.
struct Stretch {
    x0: f32,      // ends of the stretch; units: m
    x1: f32,
    inverse0: f32, // 1/w there; 1 in an orthographic map
    inverse1: f32,
    s0: f32,      // -1 or 0
    x_open: f32,  // where a piece began that was open before the stretch: at any lesser s
}

var<private> stretch: Stretch;

// The distance of a parameter.
fn x_of(s: f32) -> f32 {
    let near = select(1.0 - s, -s, stretch.s0 < 0.0) * stretch.inverse0;
    let far = select(s, 1.0 + s, stretch.s0 < 0.0) * stretch.inverse1;
    let x = (stretch.x0 * near + stretch.x1 * far) / (near + far);
    let inside = min(max(x, stretch.x0), stretch.x1);
    // both ends are what they are, so that pieces of neighbouring stretches meet
    let before = select(stretch.x0, stretch.x_open, s < stretch.s0);
    return select(select(inside, stretch.x1, s >= stretch.s0 + 1.0), before, s <= stretch.s0);
}

// Turns the pieces from slot `first` on, and the open one, into distances.
fn leave_stretch(first: u32) {
    let last = min(found - dealt_with, KEPT);
    for (var i = first; i < last; i++) {
        pieces[i] = vec2f(x_of(pieces[i].x), x_of(pieces[i].y));
    }
    let open = open_piece.y > open_piece.x;
    open_piece = select(vec2f(), vec2f(x_of(open_piece.x), x_of(open_piece.y)), open);
}

// The root of a line within a piece.
fn root_within(line: vec2f, x0: f32, x1: f32) -> f32 {
    return max(min(-line.x / line.y, x1), x0);
}

// The part of a piece where height w <= own; `behind` is their difference, linear in x.
fn push_before(behind: vec2f, x0: f32, x1: f32) {
    let dark0 = at(behind, x0) > 0.0;
    let dark1 = at(behind, x1) > 0.0;
    let root = root_within(behind, x0, x1);
    let first = select(x0, select(x1, root, dark0 != dark1), dark0);
    let last = select(x1, select(x0, root, dark0 != dark1), dark1);
    push_piece(first, last);
}

// A cell whose nodes are joined by two triangles; u and v from the cell's first node, times w.
fn push_triangles(cell: vec4f, u: vec2f, v: vec2f, w: vec2f, own: vec2f, x0: f32, x1: f32) {
    let diagonal = u + v - w;
    let low0 = at(diagonal, x0) > 0.0;
    let low1 = at(diagonal, x1) > 0.0;
    let cut = select(x1, root_within(diagonal, x0, x1), low0 != low1);
    for (var part = 0; part < 2; part++) {
        let a = select(cut, x0, part == 0);
        let b = select(x1, cut, part == 0);
        let lower = select(low1, low0, part == 0);
        let corner = select(cell.x, cell.w, lower);
        let along_u = select(cell.y, cell.z, lower);
        let along_v = select(cell.z, cell.y, lower);
        let p = select(u, w - u, lower);
        let q = select(v, w - v, lower);
        var behind = w * corner + p * (along_u - corner) + q * (along_v - corner) - own;
        if LIGHT == DIRECTIONAL && min(corner, min(along_u, along_v)) <= NOTHING {
            behind = vec2f(-1.0, 0.0);
        }
        if b > a {
            push_before(behind, a, b);
        }
    }
}

// Lit pieces of x0 to x1, on which (u, v)/w stays within a face's cells.
//
// The inner loop has no branch: what a thread does not do, it does with values that change nothing.
fn walk_face(face: i32, u: vec2f, v: vec2f, w: vec2f, own: vec2f, x0: f32, x1: f32) {
    let cells = vec2i(i32(light.map_width), i32(light.map_height)) - select(0, 1, LINEAR);
    // texel coordinates and height at both ends
    let inverse = 1.0 / max(vec2f(at(w, x0), at(w, x1)), vec2f(1e-30));
    let start = vec3f(at(u, x0), at(v, x0), at(own, x0)) * inverse.x;
    let end = vec3f(at(u, x1), at(v, x1), at(own, x1)) * inverse.y;
    let from_far = LIGHT != DIRECTIONAL && inverse.y < inverse.x;
    let anchor = select(start, end, from_far);
    let slope = end - start;
    let s0 = select(0.0, -1.0, from_far);
    let s1 = s0 + 1.0;
    let carries = open_piece.y > open_piece.x && open_piece.y == x0;
    if !carries && open_piece.y > open_piece.x {
        keep(open_piece);
    }
    let slot = select(0u, found - dealt_with, found > dealt_with);
    stretch = Stretch(x0, x1, inverse.x, inverse.y, s0, open_piece.x);
    // lit so far, and since when: a piece that comes from before began before the stretch does
    var was_lit = carries;
    var since = s0 - 1.0;

    let step = select(vec2i(0), vec2i(1), slope.xy > vec2f(0.0));
    // the border at index k is passed at k per_cell + at_first; that of a coordinate that stands still, never
    let still = abs(slope.xy) < vec2f(1e-30);
    let per_cell = select(1.0 / slope.xy, vec2f(0.0), still);
    let at_first = select(-anchor.xy * per_cell, vec2f(ENDLESS), still);
    let per_height = 1.0 / select(slope.z, 1.0, abs(slope.z) < 1e-37);
    var level = light.map_top;
    var cell = clamp(vec2i(floor(start.xy)), vec2i(0), cells - 1);
    var s = s0;
    var going = x1 > x0;
    loop {
        // a cell whose triangles decide, and until when the ray is in it
        var waits = false;
        var waits_until = s;
        loop {
            if !going || waits {
                break;
            }
            let block = cell >> vec2u(level);
            let border = (block + step) << vec2u(level);
            // where the ray leaves the block
            let exits = vec2f(border) * per_cell + at_first;
            let by_column = exits.x <= exits.y;
            let next = max(min(min(exits.x, exits.y), s1), s);
            let range = textureLoad(pyramid, block, face, level).rg;
            let height = anchor.z + slope.z * s;
            let height_next = anchor.z + slope.z * next;
            let lit = range.y <= min(height, height_next);
            let undecided = !lit && range.x <= max(height, height_next);
            let descends = undecided && level > 0u;
            let passes = undecided && level == 0u;
            if LINEAR {
                waits = passes;
                waits_until = next;
            }
            // a texel is lit up to where the ray passes its height, or from there on
            let root = max(min((range.x - anchor.z) * per_height, next), s);
            let lit_before = !LINEAR && passes && range.x <= height;
            let lit_first = lit || lit_before;
            let lit_last = lit || (!LINEAR && passes && !lit_before);
            let began = select(s, since, was_lit);
            let stays = descends || (LINEAR && passes);
            let stopped = was_lit && !lit_first && !stays;
            if stopped || lit_before {
                keep(vec2f(began, select(root, s, stopped)));
            }
            since = select(since, select(root, began, lit_first), lit_last);
            was_lit = select(lit_last, was_lit, stays);
            // down into the block, or over its border and up to the largest block that begins there
            let first = block << vec2u(level);
            let here = vec2i(floor(anchor.xy + slope.xy * s));
            let inside = max(min(here, min(first + (1 << level), cells) - 1), first);
            let beyond = border + step - 1;
            let over = vec2i(select(cell.x, beyond.x, by_column), select(beyond.y, cell.y, by_column));
            if !(LINEAR && passes) {
                cell = select(over, inside, descends);
                let above = min(level_at(select(border.y, border.x, by_column)), light.map_top);
                level = select(above, level - LEVEL_STEP, descends);
                s = select(next, s, descends);
                going = descends || (next < s1 && all(vec2u(cell) < vec2u(cells)));
            }
        }
        if LINEAR {
            if waits {
                open_piece = select(vec2f(), vec2f(since, s), was_lit);
                let nodes = cell_heights(face, cell.x, cell.y);
                let du = vec2f(anchor.x - f32(cell.x), slope.x);
                let dv = vec2f(anchor.y - f32(cell.y), slope.y);
                push_triangles(nodes, du, dv, vec2f(1.0, 0.0), vec2f(anchor.z, slope.z), s, waits_until);
                was_lit = open_piece.y > open_piece.x && open_piece.y == waits_until;
                if open_piece.y > open_piece.x && !was_lit {
                    keep(open_piece);
                }
                since = open_piece.x;
                let border = cell + step;
                let exits = vec2f(border) * per_cell + at_first;
                let by_column = exits.x <= exits.y;
                let beyond = border + step - 1;
                cell = vec2i(select(cell.x, beyond.x, by_column), select(beyond.y, cell.y, by_column));
                level = min(level_at(select(border.y, border.x, by_column)), light.map_top);
                s = waits_until;
                going = s < s1 && all(vec2u(cell) < vec2u(cells));
            }
        }
        if !going {
            break;
        }
    }
    open_piece = select(vec2f(), vec2f(since, s1), was_lit);
    leave_stretch(slot);
}

// The level of the largest block that begins at a border: its trailing zeros, down to an even number.
fn level_at(border: i32) -> u32 {
    // a power of two is exact as a float, and its exponent its logarithm
    let lowest = border & -border;
    let zeros = (bitcast<u32>(f32(lowest)) >> 23u) - 127u;
    return select(zeros & ~1u, 30u, border == 0);
}

// The cell that the ray is in at x, within limits.
fn cell_at(u: vec2f, w: vec2f, x: f32, most: i32) -> i32 {
    return clamp(i32(floor(at(u, x) / max(at(w, x), 1e-30))), 0, most);
}

// Where u/w passes the border at `index` with growth of the given sign.
fn leaves(u: vec2f, w: vec2f, growth: f32, index: i32) -> f32 {
    let line = u - f32(index) * w;
    // a line without slope, or one that the ray only nears, is never passed
    return select(ENDLESS, -line.x / line.y, line.y * sign(growth) > 0.0);
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
    let outside = light.outside == 1u;
    if empty {
        // all of the piece lies outside of the map
        inside = vec2f(piece.y, piece.y);
    }
    // nothing where it is dark; no branch on a uniform alone: see pixels.wgsl
    push_piece(piece.x, select(piece.x, inside.x, outside));
    walk_face(0, u, v, w, own, inside.x, inside.y);
    push_piece(inside.y, select(inside.y, piece.y, outside));
}

// (right, down, forward) lines of a cube's face.
struct FaceLines {
    right: vec2f,
    down: vec2f,
    w: vec2f,
}

fn face_lines(path: MapPath, face: i32) -> FaceLines {
    let offsets = seen_by(face, vec3f(path.x.x, path.y.x, path.w.x));
    let slopes = seen_by(face, vec3f(path.x.y, path.y.y, path.w.y));
    return FaceLines(
        vec2f(offsets.x, slopes.x), vec2f(offsets.y, slopes.y), vec2f(offsets.z, slopes.z),
    );
}

// Side k of a face as a line that is positive within: right > -w, right < w, down > -w, down < w.
fn side_line(lines: FaceLines, reach: f32, k: i32) -> vec2f {
    let aside = select(lines.right, lines.down, k >= 2);
    return reach * lines.w + select(aside, -aside, (k & 1) == 1);
}

// The six faces of a cube map as steps, in the order in which the ray passes them.
fn walk_cube(path: MapPath, piece: vec2f) {
    var x = piece.x;
    var face = face_towards(vec3f(at(path.x, x), at(path.y, x), at(path.w, x)));
    // a line passes six faces at most, one more for a start on an edge
    for (var i = 0; i < 7; i++) {
        let lines = face_lines(path, face);
        var end = piece.y;
        var side = -1;
        for (var k = 0; k < 4; k++) {
            let line = side_line(lines, 1.0, k);
            let root = -line.x / line.y;
            if line.y < 0.0 && root < end {
                end = root;
                side = k;
            }
        }
        end = max(end, x);
        let half = 0.5 * light.map_width;
        let w = lines.w;
        walk_face(face, half * (w + lines.right), half * (w + lines.down), w, vec2f(1.0, 0.0), x, end);
        if side < 0 {
            break;
        }
        x = end;
        face = neighbour(face, side);
    }
}

// The face beyond side k of a cube's face.
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

// The six faces of a cube map within their outermost centres, then the seams between them.
fn walk_cube_surface(path: MapPath, piece: vec2f) {
    let n = light.map_width;
    let near = 1.0 - 1.0 / n;
    var faces = 0u;
    for (var face = 0; face < 6; face++) {
        let lines = face_lines(path, face);
        var inside = nonnegative(lines.w.x, lines.w.y, piece);
        for (var k = 0; k < 4; k++) {
            let line = side_line(lines, near, k);
            inside = nonnegative(line.x, line.y, inside);
        }
        faces |= select(0u, 1u << u32(face), inside.y > inside.x && n > 1.0);
    }
    for (var i = 0; i < 6; i++) {
        if faces == 0u {
            break;
        }
        let face = i32(firstTrailingBit(faces));
        faces &= faces - 1u;
        let lines = face_lines(path, face);
        var inside = nonnegative(lines.w.x, lines.w.y, piece);
        for (var k = 0; k < 4; k++) {
            let line = side_line(lines, near, k);
            inside = nonnegative(line.x, line.y, inside);
        }
        let w = lines.w;
        let u = 0.5 * n * (w + lines.right) - 0.5 * w;
        let v = 0.5 * n * (w + lines.down) - 0.5 * w;
        walk_face(face, u, v, w, vec2f(1.0, 0.0), inside.x, inside.y);
    }
    walk_seams(path, piece);
}

// A seam of a cube map, 12 strips and then 8 corners: the piece of the ray within, and its cells' coordinates.
struct Seam {
    piece: vec2f,
    u: vec2f,
    v: vec2f,
    w: vec2f,
}

fn strip_seam(path: MapPath, strip: Strip, piece: vec2f) -> Seam {
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    let a = axis_line(path, strip.a, strip.sign_a);
    let b = axis_line(path, strip.b, strip.sign_b);
    let c = axis_line(path, strip.c, 1.0);
    let w = a + b;
    var inside = nonnegative(w.x, w.y, piece);
    inside = nonnegative(a.x - near * b.x, a.y - near * b.y, inside);
    inside = nonnegative(b.x - near * a.x, b.y - near * a.y, inside);
    let reach = near * w;
    let along = (2.0 - h) * c;
    inside = nonnegative(reach.x + along.x, reach.y + along.y, inside);
    inside = nonnegative(reach.x - along.x, reach.y - along.y, inside);
    return Seam(inside, 0.5 * n * along + 0.5 * (n - 1.0) * w, n * (b - near * a), w);
}

fn corner_seam(path: MapPath, signs: vec3f, piece: vec2f) -> Seam {
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    let a = axis_line(path, 0, signs.x);
    let b = axis_line(path, 1, signs.y);
    let c = axis_line(path, 2, signs.z);
    let w = a + b + c;
    var inside = nonnegative(w.x, w.y, piece);
    // beyond the ends of the three strips
    let x = a * (2.0 - h) - (b + c) * near;
    let y = b * (2.0 - h) - (a + c) * near;
    let z = c * (2.0 - h) - (a + b) * near;
    inside = nonnegative(x.x, x.y, inside);
    inside = nonnegative(y.x, y.y, inside);
    inside = nonnegative(z.x, z.y, inside);
    return Seam(inside, (b * (3.0 - 2.0 * h) - w * near) * n, (c * (3.0 - 2.0 * h) - w * near) * n, w);
}

// The seams that the ray passes, cell by cell.
fn walk_seams(path: MapPath, piece: vec2f) {
    let n = light.map_width;
    var seams = 0u;
    for (var i = 0; i < 12; i++) {
        let inside = strip_seam(path, strip(i), piece).piece;
        seams |= select(0u, 1u << u32(i), inside.y > inside.x && n > 1.0);
    }
    for (var i = 0; i < 8; i++) {
        let inside = corner_seam(path, corner_signs(i), piece).piece;
        seams |= select(0u, 1u << u32(12 + i), inside.y > inside.x);
    }
    var seam = Seam();
    var index = 0;
    var cell = 0;
    var x = 0.0;
    var going = false;
    for (var trips = 0; trips < MOST_BLOCKS; trips++) {
        if !going && seams == 0u {
            break;
        }
        if !going {
            index = i32(firstTrailingBit(seams));
            seams &= seams - 1u;
            let own_strip = strip_seam(path, strip(index), piece);
            let own_corner = corner_seam(path, corner_signs(index - 12), piece);
            if index < 12 {
                seam = own_strip;
            } else {
                seam = own_corner;
            }
            x = seam.piece.x;
            cell = cell_at(seam.u, seam.w, x, select(0, i32(n) - 2, index < 12));
            going = true;
        }
        let growth = seam.u.y * seam.w.x - seam.u.x * seam.w.y;
        let border = select(cell, cell + 1, growth > 0.0);
        let is_strip = index < 12;
        let exit = select(seam.piece.y, leaves(seam.u, seam.w, growth, border), is_strip);
        let next = clamp(exit, x, seam.piece.y);
        var nodes = corner_heights(corner_signs(index - 12));
        if is_strip {
            nodes = strip_heights(strip(index), cell);
        }
        let u = seam.u - f32(cell) * seam.w;
        push_triangles(nodes, u, seam.v, seam.w, vec2f(1.0, 0.0), x, next);
        cell = select(border - 1, border, growth > 0.0);
        x = next;
        going = is_strip && next < seam.piece.y && cell >= 0 && cell <= i32(n) - 2;
    }
}

// Finds the lit pieces of `piece` and keeps those that were not dealt with.
fn walk(path: MapPath, piece: vec2f) {
    found = 0u;
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
    if open_piece.y > open_piece.x {
        keep(open_piece);
    }
}
