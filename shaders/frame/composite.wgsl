// Puts a view's airlight over the picture of its surfaces: surface x transmittance + airlight.
//
// Blending does the product: `airlight` gives radiance and, where all channels are attenuated alike, the transmittance
// in alpha; else `attenuate` is drawn before it. Twin: crates/gpu-backend/src/fog/composite.rs.

#import bindings_view
#import medium_path

// the view's airlight
@group(0) @binding(2) var airlight: texture_2d<f32>;

override BOUNDED: bool = false;
override DENSITY: u32 = 0u;
// whether the channels are attenuated one by one: this draws their transmittance
override ATTENUATES: bool = false;

@vertex
fn vs_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // one triangle that covers the view
    return vec4f(4.0 * f32(index & 1u) - 1.0, 2.0 * f32(index & 2u) - 1.0, 0.0, 1.0);
}

@fragment
fn fs_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let end = textureLoad(ray_ends, pixel, 0).r;
    let ray = view_ray(pixel);
    let path = optical_path(vec3f(), to_world(ray.direction), vec2f(0.0, end));
    let transmittance = exp(-view.sigma_t * path);
    if ATTENUATES {
        return vec4f(transmittance, 1.0);
    }
    return vec4f(textureLoad(airlight, pixel, 0).rgb, transmittance.x);
}
