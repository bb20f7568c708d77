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

// How far the surface moves if a quad is not split, given the same of its children.
//
// Its triangles and those of its children differ most at the five nodes that the children add, since the one diagonal lies
// on the other. Where the quad sticks out of the map it does not: then both differ from the bilinear surface by no more
// than a quarter of its twist each, and by what the nodes do.
fn distance_of_quad(face: u32, level: u32, quad: vec2u, below: Judged) -> Verdict {
    let near = corner_of(level, quad);
    let far = corner_of(level, quad + 1u);
    let middle = min((quad << vec2u(level)) + (1u << (level - 1u)), tree.last);
    let h00 = tree_height(face, near);
    let h10 = tree_height(face, vec2u(far.x, near.y));
    let h01 = tree_height(face, vec2u(near.x, far.y));
    let h11 = tree_height(face, far);
    let top = tree_height(face, vec2u(middle.x, near.y));
    let bottom = tree_height(face, vec2u(middle.x, far.y));
    let left = tree_height(face, vec2u(near.x, middle.y));
    let right = tree_height(face, vec2u(far.x, middle.y));
    let centre = tree_height(face, middle);
    var least = min(min(min(h00, h10), min(h01, h11)), min(min(top, bottom), min(left, right)));
    least = min(min(least, centre), below.y);
    var most: f32;
    if all(((quad + 1u) << vec2u(level)) <= tree.last) {
        most = max(abs(top - 0.5 * (h00 + h10)), abs(bottom - 0.5 * (h01 + h11)));
        most = max(most, max(abs(left - 0.5 * (h00 + h01)), abs(right - 0.5 * (h10 + h11))));
        most = max(most, abs(centre - 0.5 * (h10 + h01)));
    } else {
        let at = vec2f(middle - near) / vec2f(far - near);
        most = max(abs(top - mix(h00, h10, at.x)), abs(bottom - mix(h01, h11, at.x)));
        most = max(most, max(abs(left - mix(h00, h01, at.y)), abs(right - mix(h10, h11, at.y))));
        most = max(most, abs(centre - mix(mix(h00, h10, at.x), mix(h01, h11, at.x), at.y)));
        most = 2.0 * most + 0.5 * abs(h00 - h10 - h01 + h11);
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
    return distance_of_quad(face, level, quad, below);
}
