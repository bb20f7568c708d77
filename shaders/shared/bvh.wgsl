// Shadow rays through a compressed wide bounding volume hierarchy.
//
// Eight children a node, their boxes in bytes on a grid of the node's own: Ylitie, Karras and Laine 2017, Efficient
// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs. Triangles by Moeller and Trumbore's test.
//
// In: the importing pass declares, with a group and a binding of its choice,
//     var<storage, read> bvh_nodes: array<BvhNode>          80 bytes each, the root first
//     var<storage, read> bvh_triangles: array<BvhTriangle>  48 bytes each
// as crates/gpu-backend/src/bvh uploads them; a scene without triangles is one node without children.
// Out: whether something lies in the way. Twin: crates/scene/src/bvh/wide_bvh/walk.rs.
//
// Children are visited in the order of their slots. Sorting them by the ray's octant, as the paper does for the nearest
// hit, saves a shadow ray nothing along random ways and 9 % of its nodes at best on the way to a light.
//
// A walk visits each node once at most and tests each of its triangles once, and the loops take no other trip: 5 to 7
// on average and 107 at most for 100,000 rays through a hall and a street. Software drivers that end a loop after
// 65,535 trips matter only where a ray meets the boxes of tens of thousands of triangles.

// WideBvh::STACK: no hierarchy that is uploaded needs more
const BVH_STACK: u32 = 32u;
// WideBvh::GROWTH
const BVH_GROWTH: f32 = 4e-6;
// least component of a direction relative to the largest: below, the ray moves by less than any rounding
const BVH_MIN_COMPONENT: f32 = 1e-18;
// least determinant of a triangle test, whose inverse is a number; units: m^3
const BVH_MIN_DETERMINANT: f32 = 1.2e-38;

struct BvhNode {
    origin: vec3f,       // smallest corner of the grid; units: m
    exponents: u32,      // bytes 0 to 2: exponent bits of the grid's step per axis; byte 3: bit i if child i is a node
    first_child: u32,    // index of the first child that is a node; the others follow
    first_triangle: u32, // index of the first triangle of the children that are leaves
    contents: vec2u,     // byte per child: a one per triangle << 5 | its first triangle, or for a node 1 << 5 | 24 + i
    min_x: vec2u,        // byte per child: smallest corner on the grid
    max_x: vec2u,        // byte per child: largest corner
    min_y: vec2u,
    max_y: vec2u,
    min_z: vec2u,
    max_z: vec2u,
}

struct BvhTriangle {
    corner: vec3f, // units: m
    _pad0: f32,
    edge1: vec3f,  // second corner less the first; units: m
    _pad1: f32,
    edge2: vec3f,  // third corner less the first; units: m
    _pad2: f32,
}

// Where a ray is on the grid of a node: at parameter start + step q on plane q, less or more by the growth.
struct BvhSlabs {
    near: vec3f, // start less growth
    far: vec3f,  // start plus growth
    step: vec3f,
}

// Inverse of a direction with a length, components next to zero replaced.
fn bvh_inverse(direction: vec3f, longest: f32) -> vec3f {
    let least = BVH_MIN_COMPONENT * longest;
    let signed_least = select(vec3f(least), vec3f(-least), direction < vec3f(0.0));
    return 1.0 / select(direction, signed_least, abs(direction) < vec3f(least));
}

fn bvh_slabs(node_origin: vec3f, exponents: u32, origin: vec3f, inverse: vec3f) -> BvhSlabs {
    let bits = (vec3u(exponents) >> vec3u(0u, 8u, 16u)) & vec3u(255u);
    let scale = bitcast<vec3f>(bits << vec3u(23u));
    let offset = node_origin - origin;
    let grow = BVH_GROWTH * (abs(offset) + 255.0 * scale) * abs(inverse);
    let start = offset * inverse;
    return BvhSlabs(start - grow, start + grow, scale * inverse);
}

fn bvh_bytes(word: u32) -> vec4u {
    return (vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(255u);
}

// The children among four whose boxes the ray meets: bit 24 + i for child i that is a node, below the bits of its
// triangles. The words hold the planes through which the ray enters and leaves per axis.
fn bvh_four_hits(slabs: BvhSlabs, enter: vec3u, leave: vec3u, contents_word: u32, far: f32) -> u32 {
    let enter_x = vec4f(bvh_bytes(enter.x)) * slabs.step.x + slabs.near.x;
    let enter_y = vec4f(bvh_bytes(enter.y)) * slabs.step.y + slabs.near.y;
    let enter_z = vec4f(bvh_bytes(enter.z)) * slabs.step.z + slabs.near.z;
    let leave_x = vec4f(bvh_bytes(leave.x)) * slabs.step.x + slabs.far.x;
    let leave_y = vec4f(bvh_bytes(leave.y)) * slabs.step.y + slabs.far.y;
    let leave_z = vec4f(bvh_bytes(leave.z)) * slabs.step.z + slabs.far.z;
    let first = max(max(enter_x, enter_y), max(enter_z, vec4f(0.0)));
    let last = min(min(leave_x, leave_y), min(leave_z, vec4f(far)));
    let contents_bytes = bvh_bytes(contents_word);
    let bits = select(vec4u(0u), (contents_bytes >> vec4u(5u)) << (contents_bytes & vec4u(31u)), first <= last);
    return bits.x | bits.y | bits.z | bits.w;
}

// The children of a node that the ray meets, bits as above.
fn bvh_hits(node: BvhNode, origin: vec3f, inverse: vec3f, far: f32) -> u32 {
    let slabs = bvh_slabs(node.origin, node.exponents, origin, inverse);
    let backward = inverse < vec3f(0.0);
    let enter_x = select(node.min_x, node.max_x, backward.x);
    let leave_x = select(node.max_x, node.min_x, backward.x);
    let enter_y = select(node.min_y, node.max_y, backward.y);
    let leave_y = select(node.max_y, node.min_y, backward.y);
    let enter_z = select(node.min_z, node.max_z, backward.z);
    let leave_z = select(node.max_z, node.min_z, backward.z);
    let low = bvh_four_hits(
        slabs, vec3u(enter_x.x, enter_y.x, enter_z.x), vec3u(leave_x.x, leave_y.x, leave_z.x), node.contents.x, far,
    );
    let high = bvh_four_hits(
        slabs, vec3u(enter_x.y, enter_y.y, enter_z.y), vec3u(leave_x.y, leave_y.y, leave_z.y), node.contents.y, far,
    );
    return low | high;
}

// Whether the triangle lies at a parameter in (0, far).
fn bvh_blocks(triangle: BvhTriangle, origin: vec3f, direction: vec3f, far: f32) -> bool {
    let p = cross(direction, triangle.edge2);
    let determinant = dot(triangle.edge1, p);
    // a ray within the triangle's plane; what 1/0 would be is left open
    if abs(determinant) < BVH_MIN_DETERMINANT {
        return false;
    }
    let inverse = 1.0 / determinant;
    let offset = origin - triangle.corner;
    let q = cross(offset, triangle.edge1);
    let u = dot(offset, p) * inverse;
    let v = dot(direction, q) * inverse;
    let t = dot(triangle.edge2, q) * inverse;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < far;
}

// Whether a triangle lies at a parameter in (0, far) on origin + t direction; the direction has any length, and nothing
// blocks one of none. To a point light: its position less the origin, and far = 1. To a directional light: against its
// direction, and a large finite far.
fn occluded(origin: vec3f, direction: vec3f, far: f32) -> bool {
    let size = abs(direction);
    let longest = max(size.x, max(size.y, size.z));
    if longest == 0.0 {
        return false;
    }
    let inverse = bvh_inverse(direction, longest);
    var stack: array<vec2u, BVH_STACK>;
    var depth = 0u;
    // index of the first child that is a node; the children to visit in the upper byte, all that are nodes in the
    // lower; at first the root alone
    var group = vec2u(0u, 1u << 24u);
    loop {
        let slot = firstTrailingBit(group.y >> 24u);
        let before = group.y & ((1u << slot) - 1u);
        let index = group.x + countOneBits(before);
        group.y ^= 1u << (24u + slot);
        if (group.y >> 24u) != 0u {
            stack[depth] = group;
            depth++;
        }
        let hits = bvh_hits(bvh_nodes[index], origin, inverse, far);
        let first_triangle = bvh_nodes[index].first_triangle;
        var triangles = hits & 0x00ffffffu;
        while triangles != 0u {
            let triangle = first_triangle + firstTrailingBit(triangles);
            triangles &= triangles - 1u;
            if bvh_blocks(bvh_triangles[triangle], origin, direction, far) {
                return true;
            }
        }
        group = vec2u(bvh_nodes[index].first_child, (hits & 0xff000000u) | (bvh_nodes[index].exponents >> 24u));
        if (group.y >> 24u) == 0u {
            if depth == 0u {
                break;
            }
            depth--;
            group = stack[depth];
        }
    }
    return false;
}
