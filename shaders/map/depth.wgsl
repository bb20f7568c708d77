// Depth of the nearest triangle, as a light's face or a camera sees it.
//
// In: triangles, one an instance, relative to their middle. Out: device depth, 1 at the near plane (near/depth in
// perspective, 1 - depth/far without). A pixel's depth is that of the triangle's plane on the ray through the pixel's
// centre: what a rasteriser interpolates is off by up to its grid (1/256 of a pixel) along steep surfaces, and by the
// rounding of the near end wherever a triangle reaches past the eye. Twin: crates/shadowmap/src/raster.rs.

struct Eye {
    right: vec3f,     // world axes
    near: f32,        // units: m; 0 if rays are parallel
    down: vec3f,      // world axes
    inverse_far: f32, // units: 1/m; used if rays are parallel
    forward: vec3f,   // world axes
    perspective: u32, // 0: rays are parallel
    origin: vec3f,    // from the triangles' middle; units: m
    _pad0: f32,
    rest: vec3f,      // what rounding took from `origin`; units: m
    _pad1: f32,
    half: vec2f,      // half the image along right and down: a tangent, or units: m
    texel: vec2f,     // 2 half/size
}

@group(0) @binding(0) var<uniform> eye: Eye;

struct Seen {
    @builtin(position) position: vec4f,
    // the triangle's plane in the eye's axes: normal . point = offset
    @location(0) @interpolate(flat) normal: vec3f,
    @location(1) @interpolate(flat) offset: f32,
    // depths of the corners, least and most: where a triangle is seen edge on, nothing else bounds the rounding
    @location(2) @interpolate(flat) between: vec2f,
}

fn turned(v: vec3f) -> vec3f {
    return vec3f(dot(v, eye.right), dot(v, eye.down), dot(v, eye.forward));
}

fn seen(corner: vec3f) -> vec3f {
    return turned((corner - eye.origin) - eye.rest);
}

@vertex
fn vs_main(
    @location(0) first: vec3f,
    @location(1) second: vec3f,
    @location(2) third: vec3f,
    @builtin(vertex_index) index: u32,
) -> Seen {
    let a = seen(first);
    let b = seen(second);
    let c = seen(third);
    var corner = a;
    if index == 1u {
        corner = b;
    } else if index == 2u {
        corner = c;
    }
    let normal = cross(turned(second - first), turned(third - first));
    let least = min(a.z, min(b.z, c.z));
    let most = max(a.z, max(b.z, c.z));
    let aside = vec2f(corner.x, -corner.y) / eye.half;
    // without perspective nothing is clipped: what lies before the plane of depth 0 is drawn at depth 0
    var position = vec4f(aside, 0.5, 1.0);
    if eye.perspective == 1u {
        position = vec4f(aside, eye.near, corner.z);
    }
    return Seen(position, normal, dot(normal, a), vec2f(least, most));
}

@fragment
fn fs_main(triangle: Seen) -> @builtin(frag_depth) f32 {
    let aside = triangle.position.xy * eye.texel - eye.half;
    let n = triangle.normal;
    if eye.perspective == 1u {
        let depth = triangle.offset / (dot(n.xy, aside) + n.z);
        return eye.near / clamp(depth, max(triangle.between.x, eye.near), triangle.between.y);
    }
    let depth = (triangle.offset - dot(n.xy, aside)) / n.z;
    return 1.0 - max(clamp(depth, triangle.between.x, triangle.between.y), 0.0) * eye.inverse_far;
}
