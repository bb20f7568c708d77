// The side faces of a shadow volume, the frontmost and the backmost kept as greatest values by blending. Out: 1/z and
// -1/z; units: 1/m. In and twin: see faces.wgsl among the shared files.

#import faces

@vertex
fn vs_main(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> Seen {
    return seen_of(vertex, index);
}

@fragment
fn fs_main(seen: Seen) -> @location(0) vec4f {
    let inverse = inverse_at(seen);
    return vec4f(inverse, -inverse, 0.0, 0.0);
}
