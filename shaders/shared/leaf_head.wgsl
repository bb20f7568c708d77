// What the leaves of a tessellation are counted in; the arguments of the draw lie among it.
// Twin: crates/gpu-backend/src/lightvolume/tessellation.rs.

struct Head {
    indices: atomic<u32>,   // from here five words of an indexed draw
    instances: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
    leaves: atomic<u32>,    // written so far
    counted: atomic<u32>,   // leaves of all faces
    left_out: atomic<u32>,  // finest levels for which there was no room, on the face where they were most
}
