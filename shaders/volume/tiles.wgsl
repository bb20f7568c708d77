// Frontmost and backmost side faces of a shadow volume, by tile of a view's pixels: conservative, nothing is missed.
//
// Each thread walks the tiles that one face touches, row by row. 1/z of a face's plane is linear over the image, so its
// range over a tile lies at the corners; together with the face's own range it bounds where the face is met. In: the list
// of silhouette.wgsl. Out: two words a tile, the greatest 1/z and the complement of the least, both kept as maxima; 0
// where there is no face. Twin: crates/hybrid-march/src/face_bounds.rs.

#import volume

struct Head {
    count: u32,
    groups: u32,
    groups_y: u32,
    groups_z: u32,
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(2) var<storage, read> head: Head;
@group(0) @binding(3) var<storage, read> found: array<vec2u>;
@group(0) @binding(4) var<storage, read_write> tiles: array<atomic<u32>>;

// What rounding may take from a position in the image; units: tiles.
const SLACK: f32 = 2e-3;

// Corners of the clipped face in tiles, and their number: a plane cuts off at most one corner more than it adds.
var<private> outline: array<vec2f, 5>;
var<private> outline_size: u32;

fn add_corner(at: vec4f) {
    if outline_size < 5u {
        outline[outline_size] = (at.xy / at.z - volume.offset) / vec2f(volume.scale_x, volume.scale_y);
        outline_size += 1u;
    }
}

// Clips the face at the near plane and projects what is left.
fn clip(face: Face) {
    outline_size = 0u;
    var before = corner(face, 3u);
    for (var k = 0u; k < 4u; k++) {
        let here = corner(face, k);
        let near_before = before.z - volume.near;
        let near_here = here.z - volume.near;
        if (near_before >= 0.0) != (near_here >= 0.0) {
            let t = near_before / (near_before - near_here);
            let crossing = mix(before, here, t);
            add_corner(vec4f(crossing.xy, volume.near, crossing.w));
        }
        if near_here >= 0.0 {
            add_corner(here);
        }
        before = here;
    }
}

// The outline's range of columns within a row's band.
fn columns(low: f32, high: f32) -> vec2f {
    var range = vec2f(1e30, -1e30);
    var p = outline[outline_size - 1u];
    for (var k = 0u; k < outline_size; k++) {
        let q = outline[k];
        let least = min(p.y, q.y);
        let most = max(p.y, q.y);
        if most >= low && least <= high {
            let rise = q.y - p.y;
            let flat_edge = abs(rise) < 1e-12;
            let inverse = 1.0 / select(rise, 1.0, flat_edge);
            let t0 = select(clamp((low - p.y) * inverse, 0.0, 1.0), 0.0, flat_edge);
            let t1 = select(clamp((high - p.y) * inverse, 0.0, 1.0), 1.0, flat_edge);
            let x0 = p.x + t0 * (q.x - p.x);
            let x1 = p.x + t1 * (q.x - p.x);
            range = vec2f(min(range.x, min(x0, x1)), max(range.y, max(x0, x1)));
        }
        p = q;
    }
    return range;
}

fn keep(tile: u32, range: vec2f) {
    let front = bitcast<u32>(range.y);
    let back = ~bitcast<u32>(range.x);
    // most tiles have what is offered: reading is cheaper than writing
    if atomicLoad(&tiles[2u * tile]) < front {
        atomicMax(&tiles[2u * tile], front);
    }
    if atomicLoad(&tiles[2u * tile + 1u]) < back {
        atomicMax(&tiles[2u * tile + 1u], back);
    }
}

fn walk(face: Face) {
    clip(face);
    if outline_size < 3u {
        return;
    }
    var least = outline[0];
    var most = outline[0];
    for (var k = 1u; k < outline_size; k++) {
        least = min(least, outline[k]);
        most = max(most, outline[k]);
    }
    let size = vec2f(volume.size);
    if any(most < vec2f(-SLACK)) || any(least > size + SLACK) {
        return;
    }
    let own = inverse_range(face);
    // 1/z = plane.x u + plane.y v + plane.z, in tiles
    let n = face.normal;
    var plane = vec3f(n.x * volume.scale_x, n.y * volume.scale_y, n.x * volume.offset.x + n.y * volume.offset.y + n.z);
    // a plane through the eye has no such form
    let bounded = abs(face.offset) > 1e-6 * max(length(face.a), length(face.b));
    plane /= select(1.0, face.offset, bounded);
    let half_range = 0.5 * (abs(plane.x) + abs(plane.y));
    let first = u32(clamp(floor(least.y - SLACK), 0.0, size.y - 1.0));
    let last = u32(clamp(floor(most.y + SLACK), 0.0, size.y - 1.0));
    for (var row = first; row <= last; row++) {
        let across = columns(f32(row) - SLACK, f32(row) + 1.0 + SLACK);
        if across.y < -SLACK || across.x > size.x + SLACK {
            continue;
        }
        let start = u32(clamp(floor(across.x - SLACK), 0.0, size.x - 1.0));
        let to = u32(clamp(floor(across.y + SLACK), 0.0, size.x - 1.0));
        for (var column = start; column <= to; column++) {
            var range = own;
            if bounded {
                let at = vec2f(f32(column), f32(row)) + 0.5;
                let terms = vec3f(plane.x * at.x, plane.y * at.y, plane.z);
                let middle = terms.x + terms.y + terms.z;
                let rounding = 2e-6 * (abs(terms.x) + abs(terms.y) + abs(terms.z));
                let reach = half_range + rounding;
                range = vec2f(
                    clamp(middle - reach, own.x, own.y), clamp(middle + reach, own.x, own.y),
                );
            }
            keep(row * volume.size.x + column, range);
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= head.count {
        return;
    }
    let edge = found[id.x];
    let p = positions[edge.x];
    let q = positions[edge.y];
    // a side, or both; asked of the pair, since lavapipe would compile anew what a uniform alone decides
    let last = select(1.0, -1.0, (volume.margin == 0.0) & (id.x < head.count));
    for (var apart = -1.0; apart <= last; apart += 2.0) {
        let face = face_of(p, q, select(apart, 0.0, volume.margin == 0.0));
        if face.found {
            walk(face);
        }
    }
}
