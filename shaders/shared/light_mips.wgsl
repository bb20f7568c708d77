// A spot's picture at every size: its mean along a segment, from samples no finer than they can resolve.
//
// The importing pass declares `light`, the texture `mips` and the sampler `smooth_sampler`. Twin:
// crates/hybrid-march/src/light_mips.rs.

#import light

// Samples along a segment.
const TAPS: u32 = 4u;

fn mip_colour(at: vec2f, level: f32) -> vec3f {
    let blended = textureSampleLevel(mips, smooth_sampler, at, level).rgb;
    if (light.nearest_texel == 0u) | (level >= 1.0) {
        return blended;
    }
    // the texel itself at the finest level
    let size = vec2i(textureDimensions(mips, 0));
    let texel = textureLoad(mips, clamp(vec2i(floor(at * vec2f(size))), vec2i(0), size - 1), 0).rgb;
    return mix(texel, textureSampleLevel(mips, smooth_sampler, at, 1.0).rgb, level);
}

// Mean colour between two positions on the picture.
fn line_colour(near: vec2f, far: vec2f) -> vec3f {
    let first = clamp(near, vec2f(0.0), vec2f(1.0));
    let last = clamp(far, vec2f(0.0), vec2f(1.0));
    let across = last - first;
    let texels = length(across * vec2f(textureDimensions(mips, 0)));
    // the builtin's error is far below a level
    let level = log2(max(texels / f32(TAPS), 1.0));
    var sum = vec3f();
    for (var i = 0u; i < TAPS; i++) {
        sum += mip_colour(first + (f32(i) + 0.5) / f32(TAPS) * across, level);
    }
    return sum / f32(TAPS);
}
