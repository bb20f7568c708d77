// The silhouette edges of a mesh as a light sees them: the rims of its shadow volume.
//
// Every triangle is oriented towards the light, so that each blocks once and nothing ever cancels; an edge on which they
// run against each other bounds nothing and is dropped. In: planes of the triangles and edges with the triangles on
// them. Out: a list of directed edges, and the arguments of the passes that go over it.
// Twin: crates/hybrid-march/src/silhouette.rs.

struct Source {
    light: vec4f, // from the mesh's middle (m) and 1; of a directional light the unit way to it and 0
    edges: u32,
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

// Words of the list's head: how many edges there are, a dispatch of 64 threads each, a draw of two triangles each.
struct Head {
    count: atomic<u32>,
    groups: atomic<u32>,
    groups_y: u32,
    groups_z: u32,
    vertices: u32,
    instances: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> source: Source;
// normal and offset of each triangle's plane, from the mesh's middle: normal . p + offset = 0
@group(0) @binding(1) var<storage, read> planes: array<vec4f>;
// two vertices and two sides; a side is 2 triangle + 1 where that runs from the second vertex to the first
@group(0) @binding(2) var<storage, read> edges: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> head: Head;
@group(0) @binding(4) var<storage, read_write> found: array<vec2u>;

const NO_SIDE: u32 = 0xffffffffu;

// +1 where the side's triangle, oriented towards the light, runs from the first vertex to the second.
fn run_of(side: u32) -> i32 {
    if side == NO_SIDE {
        return 0;
    }
    let plane = planes[side >> 1u];
    let faces = dot(plane, source.light) >= 0.0;
    return select(-1, 1, faces == ((side & 1u) == 0u));
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let index = (group.y * groups.x + group.x) * 64u + thread;
    if index >= source.edges {
        return;
    }
    let edge = edges[index];
    let net = run_of(edge.z) + run_of(edge.w);
    if net == 0 {
        return;
    }
    let at = atomicAdd(&head.count, 1u);
    atomicMax(&head.groups, at / 64u + 1u);
    atomicMax(&head.instances, at + 1u);
    found[at] = select(edge.yx, edge.xy, net > 0);
}
