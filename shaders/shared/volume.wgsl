// The side faces of a shadow volume as a view sees them: an edge of the silhouette, extruded away from the light.
//
// Vectors are in the camera's basis (right, up, forward) with the eye at the origin. The importing pass declares the
// uniform `volume`. Twins: crates/gpu-backend/src/layout/volume.rs (layout),
// crates/hybrid-march/src/face_bounds.rs (functions).

struct Volume {
    right: vec3f,        // world axes
    scale_x: f32,        // tangent per tile, to the right
    up: vec3f,           // world axes
    scale_y: f32,        // tangent per tile, upwards: negative, row 0 is at the top
    forward: vec3f,      // world axes
    near: f32,           // nothing nearer to the eye's plane is seen; units: m
    eye: vec3f,          // from the mesh's middle, world axes; units: m
    margin: f32,         // how far faces are moved apart, per metre from the light (directional: units: m)
    rest: vec3f,         // what rounding took from `eye`; units: m
    directional: u32,
    light: vec3f,        // from the eye (m); of a directional light the unit way that it travels
    most_inverse: f32,   // 1/near
    offset: vec2f,       // tangent at the image's upper left corner
    size: vec2u,         // units: tiles
}

// A face as a polygon of four homogeneous corners: both ends of the edge, and the same infinitely far away.
struct Face {
    a: vec3f,
    b: vec3f,
    far_a: vec3f, // directions
    far_b: vec3f,
    normal: vec3f, // of the face's plane: normal . p = offset
    offset: f32,
    found: bool,   // whether the face has an area
}

fn in_view(p: vec4f) -> vec3f {
    let from_eye = (p.xyz - volume.eye) - volume.rest;
    return vec3f(dot(from_eye, volume.right), dot(from_eye, volume.up), dot(from_eye, volume.forward));
}

// The face of the edge from p to q (from the mesh's middle), moved aside by `apart` times the margin.
fn face_of(p: vec4f, q: vec4f, apart: f32) -> Face {
    var a = in_view(p);
    var b = in_view(q);
    let is_directional = volume.directional == 1u;
    var far_a = select(a - volume.light, volume.light, is_directional);
    var far_b = select(b - volume.light, volume.light, is_directional);
    let across = cross(far_a, select(far_b, b - a, is_directional));
    let size = length(across);
    if !(size > 0.0) {
        return Face(a, b, far_a, far_b, vec3f(), 0.0, false);
    }
    let normal = across / size;
    if apart != 0.0 {
        let reach_a = volume.margin * select(length(far_a), 1.0, is_directional);
        let reach_b = volume.margin * select(length(far_b), 1.0, is_directional);
        let along = (b - a) / max(length(b - a), 1e-30);
        let move_a = apart * reach_a * normal - reach_a * along;
        let move_b = apart * reach_b * normal + reach_b * along;
        a += move_a;
        b += move_b;
        far_a += select(move_a, vec3f(), is_directional);
        far_b += select(move_b, vec3f(), is_directional);
        let moved = cross(far_a, select(far_b, b - a, is_directional));
        let unit = moved / max(length(moved), 1e-30);
        return Face(a, b, far_a, far_b, unit, dot(unit, a), true);
    }
    return Face(a, b, far_a, far_b, normal, dot(normal, a), true);
}

// Corner k of a face, going round: xyz and w, 0 where it is infinitely far away.
fn corner(face: Face, k: u32) -> vec4f {
    switch k {
        case 0u: { return vec4f(face.a, 1.0); }
        case 1u: { return vec4f(face.b, 1.0); }
        case 2u: { return vec4f(face.far_b, 0.0); }
        default: { return vec4f(face.far_a, 0.0); }
    }
}

// Least and greatest 1/z of the part of a face before the eye; units: 1/m.
fn inverse_range(face: Face) -> vec2f {
    var range = vec2f(volume.most_inverse, 0.0);
    var behind = false;
    for (var k = 0u; k < 4u; k++) {
        let at = corner(face, k);
        if at.z > volume.near * at.w && at.z > 0.0 {
            let inverse = at.w / at.z;
            range = vec2f(min(range.x, inverse), max(range.y, inverse));
        } else {
            behind = true;
        }
    }
    return vec2f(range.x, select(range.y, volume.most_inverse, behind));
}
