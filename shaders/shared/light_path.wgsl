// How much medium lies between a point and a light.
//
// In: the importing pass declares the uniforms `view` and `light`, the override constant `LIGHT` and what medium_path.wgsl
// asks for. Out: a length. Twin: `light_path` in crates/scene/src/medium_path.rs.

#import light
#import medium_path

// Integral of the density between a point (world axes, from the eye) and the light; a directional light reaches every
// point of an unbounded medium unattenuated; units: m.
fn light_path(point: vec3f) -> f32 {
    if LIGHT == DIRECTIONAL {
        if !BOUNDED && DENSITY != GRID_DENSITY {
            return 0.0;
        }
        return optical_path(point, light.world, vec2f(0.0, ENDLESS));
    }
    let to = light.world - point;
    let distance = length(to);
    return optical_path(point, to / max(distance, 1e-30), vec2f(0.0, distance));
}
