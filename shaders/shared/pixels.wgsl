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
    return light.adds < REFINES || so_far(pixel).a > 0.0;
}

// Adds a light's radiance to that of the lights before. What was not asked for keeps what it has.
fn add_radiance(pixel: vec2u, radiance: vec3f) {
    var sum = vec4f(radiance, 0.0);
    if light.adds == ADDS {
        sum += so_far(pixel);
    } else if light.adds >= REFINES {
        let kept = so_far(pixel);
        let wanted = kept.a > 0.0;
        let refined = radiance + select(vec3f(), kept.rgb, light.adds == REFINES_FURTHER);
        sum = vec4f(select(kept.rgb, refined, wanted), kept.a);
    }
    set_so_far(pixel, sum);
}

// The same of radiance that rounding may have made negative: what is taken away is added to alpha.
fn add_clamped(pixel: vec2u, radiance: vec3f) {
    let below = max(max(-radiance.r, -radiance.g), max(-radiance.b, 0.0));
    let kept = max(radiance, vec3f());
    if light.adds >= REFINES {
        add_radiance(pixel, kept);
        return;
    }
    var sum = vec4f(kept, below);
    if light.adds == ADDS {
        sum += so_far(pixel);
    }
    set_so_far(pixel, sum);
}
