// A side face of a shadow volume as two triangles, and the 1/z at a pixel's centre.
//
// What a rasteriser interpolates is off by its grid; the plane of the face is not. In: the list of silhouette.wgsl, an
// instance a face. Twin: crates/gpu-backend/src/volume/faces.rs.

#import volume

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<storage, read> positions: array<vec4f>;
@group(0) @binding(3) var<storage, read> found: array<vec2u>;

struct Seen {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) plane: vec4f,
    @location(1) @interpolate(flat) range: vec2f,
}

fn seen_of(vertex: u32, index: u32) -> Seen {
    let edge = found[index];
    let face = face_of(positions[edge.x], positions[edge.y], 0.0);
    // corners 0, 1, 2 and 0, 2, 3
    let k = select(select(vertex, 0u, vertex == 3u), vertex - 2u, vertex > 3u);
    let at = corner(face, k);
    let half = 0.5 * vec2f(volume.size) * vec2f(volume.scale_x, volume.scale_y);
    let middle = volume.offset + half;
    // y points upwards in clip space and scale_y is negative
    let aside = (at.xy - middle * at.z) / vec2f(half.x, -half.y);
    var seen: Seen;
    seen.position = select(vec4f(0.0), vec4f(aside, volume.near * at.w, at.z), face.found);
    seen.plane = vec4f(face.normal, face.offset);
    seen.range = inverse_range(face);
    return seen;
}

fn inverse_at(seen: Seen) -> f32 {
    let aside = seen.position.xy * vec2f(volume.scale_x, volume.scale_y) + volume.offset;
    let across = dot(seen.plane.xyz, vec3f(aside, 1.0));
    // a plane through the eye is met everywhere at once
    return clamp(across / select(seen.plane.w, 1e-30, seen.plane.w == 0.0), seen.range.x, seen.range.y);
}
