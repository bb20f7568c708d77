// The side faces of a shadow volume, one of the frontmost and the backmost kept by a depth test: for devices on which
// float32 does not blend. Out: near/z. In and twin: see faces.wgsl among the shared files.

#import faces

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> Seen {
    return seen_of(vertex, index);
}

@fragment
fn fs_main(seen: Seen) -> @builtin(frag_depth) f32 {
    return clamp(inverse_at(seen) * volume.near, 0.0, 1.0);
}
