// Which pixel a thread of a scattering pass has, and what becomes of its radiance: all pixels of a picture, by tiles, from
// one texture to another.
//
// The importing pass declares the uniforms `view` and `light`. pixels_listed.wgsl is the same for pixels of a list, and takes
// the place of this file in the passes that are made for it. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

// radiance of the lights before (rgb) and the optical path so far of a march in several parts (a)
@group(0) @binding(2) var before: texture_2d<f32>;
@group(0) @binding(3) var scattered: texture_storage_2d<rgba32float, write>;

// The pixel of a thread of a tile of 8 x 8, in Z order: threads that run together have rays close together.
fn pixel_of(tile: vec2u, index: u32) -> vec2u {
    let x = (index & 1u) | ((index >> 1u) & 2u) | ((index >> 2u) & 4u);
    let y = ((index >> 1u) & 1u) | ((index >> 2u) & 2u) | ((index >> 3u) & 4u);
    return tile * 8u + vec2u(x, y);
}

// Radiance and path of a pixel so far.
fn so_far(pixel: vec2u) -> vec4f {
    return textureLoad(before, pixel, 0);
}

// Sets what is so far.
fn set_so_far(pixel: vec2u, sum: vec4f) {
    textureStore(scattered, pixel, sum);
}

// Whether a pixel's airlight is asked for: all of them, or those that were left over at a lower resolution.
fn is_wanted(pixel: vec2u) -> bool {
    // not `||`: see `add`
    return (light.adds < REFINES) | (so_far(pixel).a > 0.0);
}

// Adds a light's radiance to that of the lights before, and `below` to alpha. What was not asked for keeps what it has.
//
// Nothing branches on a uniform alone: lavapipe compiles a shader anew for the values of such uniforms, in every dispatch.
fn add(pixel: vec2u, radiance: vec3f, below: f32) {
    let kept = so_far(pixel);
    let refines = light.adds >= REFINES;
    let wanted = !refines | (kept.a > 0.0);
    let before = select(vec3f(), kept.rgb, (light.adds == ADDS) | (light.adds == REFINES_FURTHER));
    let own = select(below, 0.0, refines);
    let alpha = select(0.0, kept.a, refines | (light.adds == ADDS));
    set_so_far(pixel, vec4f(select(kept.rgb, before + radiance, wanted), alpha + own));
}

fn add_radiance(pixel: vec2u, radiance: vec3f) {
    add(pixel, radiance, 0.0);
}

// The same of radiance that rounding may have made negative: what is taken away is added to alpha.
fn add_clamped(pixel: vec2u, radiance: vec3f) {
    let below = max(max(-radiance.r, -radiance.g), max(-radiance.b, 0.0));
    add(pixel, max(radiance, vec3f()), below);
}
