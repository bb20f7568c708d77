// What every scattering pass reads and writes: group 0 for the view, group 1 for the light. Where a light lacks
// something, a texture of one texel stands in and is not read. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

#import bindings_view
#import light

@group(0) @binding(3) var scattered: texture_storage_2d<rgba32float, write>;

@group(1) @binding(0) var<uniform> light: Light;
// the light's map, a layer a face; r32float
@group(1) @binding(1) var heights: texture_2d_array<f32>;
// least and greatest height of blocks of cells; rg32float
@group(1) @binding(2) var pyramid: texture_2d_array<f32>;
// moments of depth; rg32float
@group(1) @binding(3) var moments: texture_2d_array<f32>;
// a spot's picture, linear RGB; rgba32float
@group(1) @binding(4) var picture: texture_2d<f32>;
// 1/z of the frontmost and the backmost face of the light's shadow volume, 0 where there is none; rg32float; units: 1/m
@group(1) @binding(5) var faces: texture_2d<f32>;
// a spot's picture at every size, linear RGB, filterable
@group(1) @binding(6) var mips: texture_2d<f32>;
@group(1) @binding(7) var smooth_sampler: sampler;
// airlight of this frame and light by angle, see frame_table.wgsl; rgba32float
@group(1) @binding(8) var frame_table: texture_2d<f32>;

// one of POINT, SPOT, DIRECTIONAL
override LIGHT: u32 = 0u;
// whether the spot has a picture
override TEXTURED: bool = false;
// whether the light has a map
override SHADOWED: bool = true;
// whether a map's texel centres are joined by triangles
override LINEAR: bool = false;
// how a map is looked up, see shadow_map.wgsl
override LOOKUP: u32 = 0u;
// whether the channels are attenuated alike
override ACHROMATIC: bool = true;
// whether the phase function is isotropic
override ISOTROPIC: bool = true;

// The pixel of a thread of a tile of 8 x 8, in Z order: threads that run together have rays close together.
fn pixel_of(tile: vec2u, index: u32) -> vec2u {
    let x = (index & 1u) | ((index >> 1u) & 2u) | ((index >> 2u) & 4u);
    let y = ((index >> 1u) & 1u) | ((index >> 2u) & 2u) | ((index >> 3u) & 4u);
    return tile * 8u + vec2u(x, y);
}

// Whether a pixel's airlight is asked for: all of them, or those that were left over at a lower resolution.
fn is_wanted(pixel: vec2u) -> bool {
    return light.adds < REFINES || textureLoad(before, pixel, 0).a > 0.0;
}

// Adds a light's radiance to that of the lights before. What was not asked for keeps what it has.
fn add_radiance(pixel: vec2u, radiance: vec3f) {
    var sum = vec4f(radiance, 0.0);
    if light.adds == ADDS {
        sum += textureLoad(before, pixel, 0);
    } else if light.adds >= REFINES {
        let kept = textureLoad(before, pixel, 0);
        let wanted = kept.a > 0.0;
        let refined = radiance + select(vec3f(), kept.rgb, light.adds == REFINES_FURTHER);
        sum = vec4f(select(kept.rgb, refined, wanted), kept.a);
    }
    textureStore(scattered, pixel, sum);
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
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
