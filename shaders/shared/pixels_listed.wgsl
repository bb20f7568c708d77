// Which pixel a thread of a scattering pass has, and what becomes of its radiance: the pixels of a list, in one buffer.
//
// Takes the place of pixels.wgsl, whose functions it has. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

#import ray_list

@group(0) @binding(2) var<storage, read> rays: RayList;
// radiance of every pixel (rgb) and the optical path so far of a march in several parts (a), row by row
@group(0) @binding(3) var<storage, read_write> values: array<vec4f>;

// The pixel of a thread of a group of 64; one outside of the picture where the list has ended.
fn pixel_of(group: vec2u, index: u32) -> vec2u {
    let at = (group.y * GROUPS_A_ROW + group.x) * 64u + index;
    let place = rays.pixels[min(at, arrayLength(&rays.pixels) - 1u)];
    return select(vec2u(0xffffffffu), vec2u(place % row_stride(), place / row_stride()), at < rays.count);
}

fn so_far(pixel: vec2u) -> vec4f {
    return values[place_of(pixel)];
}

fn set_so_far(pixel: vec2u, sum: vec4f) {
    values[place_of(pixel)] = sum;
}

// All that are listed are.
fn is_wanted(pixel: vec2u) -> bool {
    return true;
}

// No branch on a uniform alone: see pixels.wgsl.
fn add_radiance(pixel: vec2u, radiance: vec3f) {
    set_so_far(pixel, vec4f(radiance, 0.0) + select(vec4f(), so_far(pixel), light.adds == ADDS));
}
