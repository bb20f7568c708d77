// Whether a quad of a tessellation is too coarse. The importing pass declares the texture `heights`.
// Twin: crates/lightvolume/src/{edge_map,distance}.rs.

#import tessellation

const LAPLACIAN: u32 = 0u;

// LAPLACIAN, or 1 for the distance; a constant, since some drivers execute both sides of every branch
override CRITERION: u32 = 1u;

// What is known of the cells under a quad: the error so far, or the greatest Laplacian (m); and the least height.
alias Judged = vec2f;

struct Verdict {
    value: f32, // is compared with the threshold; units: m
    judged: Judged,
}

fn tree_height(face: u32, node: vec2u) -> f32 {
    let height = textureLoad(heights, node, face, 0).r;
    return select(height, max(height, -tree.far), tree.flat == 1u);
}

// A difference of heights in metres, next to the least height.
fn in_metres(difference: f32, least: f32) -> f32 {
    let most = 1.0 / max(least, 1.0 / tree.far);
    return select(difference * most * most, difference, tree.flat == 1u);
}

// |Laplacian| of the depth at a node; units: m.
fn laplacian(face: u32, node: vec2u) -> f32 {
    let h = tree_height(face, node);
    let low = max(node, vec2u(1u)) - 1u;
    let high = min(node + 1u, tree.last);
    let around = tree_height(face, vec2u(low.x, node.y)) + tree_height(face, vec2u(high.x, node.y))
        + tree_height(face, vec2u(node.x, low.y)) + tree_height(face, vec2u(node.x, high.y));
    return in_metres(abs(around - 4.0 * h), h);
}

// The greatest Laplacian over the nodes of a quad of level 1.
fn laplacian_of(face: u32, quad: vec2u) -> f32 {
    var most = 0.0;
    for (var j = 0u; j < 3u; j++) {
        for (var i = 0u; i < 3u; i++) {
            most = max(most, laplacian(face, min(2u * quad + vec2u(i, j), tree.last)));
        }
    }
    return most;
}

// The heights of a quad's corners, of the middles between them, and of its centre, row by row.
struct Nine {
    h00: f32,
    top: f32,
    h10: f32,
    left: f32,
    centre: f32,
    right: f32,
    h01: f32,
    bottom: f32,
    h11: f32,
}

fn heights_of(face: u32, level: u32, quad: vec2u) -> Nine {
    let near = corner_of(level, quad);
    let far = corner_of(level, quad + 1u);
    let middle = middle_of_quad(level, quad);
    return Nine(
        tree_height(face, near), tree_height(face, vec2u(middle.x, near.y)), tree_height(face, vec2u(far.x, near.y)),
        tree_height(face, vec2u(near.x, middle.y)), tree_height(face, middle), tree_height(face, vec2u(far.x, middle.y)),
        tree_height(face, vec2u(near.x, far.y)), tree_height(face, vec2u(middle.x, far.y)), tree_height(face, far),
    );
}

fn middle_of_quad(level: u32, quad: vec2u) -> vec2u {
    return min((quad << vec2u(level)) + (1u << (level - 1u)), tree.last);
}

// How far the surface moves if a quad is not split, given the same of its children.
//
// Its triangles and those of its children differ most at the five nodes that the children add, since the one diagonal lies
// on the other. Where the quad sticks out of the map it does not: then both differ from the bilinear surface by no more
// than a quarter of its twist each, and by what the nodes do.
fn distance_of_quad(level: u32, quad: vec2u, h: Nine, below: Judged) -> Verdict {
    var least = min(min(min(h.h00, h.h10), min(h.h01, h.h11)), min(min(h.top, h.bottom), min(h.left, h.right)));
    least = min(min(least, h.centre), below.y);
    var most: f32;
    if all(((quad + 1u) << vec2u(level)) <= tree.last) {
        most = max(abs(h.top - 0.5 * (h.h00 + h.h10)), abs(h.bottom - 0.5 * (h.h01 + h.h11)));
        most = max(most, max(abs(h.left - 0.5 * (h.h00 + h.h01)), abs(h.right - 0.5 * (h.h10 + h.h11))));
        most = max(most, abs(h.centre - 0.5 * (h.h10 + h.h01)));
    } else {
        let near = corner_of(level, quad);
        let at = vec2f(middle_of_quad(level, quad) - near) / vec2f(corner_of(level, quad + 1u) - near);
        most = max(abs(h.top - mix(h.h00, h.h10, at.x)), abs(h.bottom - mix(h.h01, h.h11, at.x)));
        most = max(most, max(abs(h.left - mix(h.h00, h.h01, at.y)), abs(h.right - mix(h.h10, h.h11, at.y))));
        most = max(most, abs(h.centre - mix(mix(h.h00, h.h10, at.x), mix(h.h01, h.h11, at.x), at.y)));
        most = 2.0 * most + 0.5 * abs(h.h00 - h.h10 - h.h01 + h.h11);
    }
    // the stitches to finer neighbours add no more than a node differs by
    return Verdict(in_metres(below.x + 2.0 * most, least), Judged(below.x + most, least));
}

// Judges a quad of level 1 or more; `below` is the greatest and the least of its children's.
fn judge(face: u32, level: u32, quad: vec2u, below: Judged) -> Verdict {
    if CRITERION == LAPLACIAN {
        var most = below.x;
        if level == 1u {
            most = laplacian_of(face, quad);
        }
        return Verdict(most, Judged(most, 0.0));
    }
    return distance_of_quad(level, quad, heights_of(face, level, quad), below);
}
