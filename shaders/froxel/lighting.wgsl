// What each froxel of a view scatters towards the eye, by metre, and how dense the medium is in it (Hillaire 2015;
// Stojanovic et al. 2023, section 3.1.3), over the frames before where they are kept.
//
// Twin: crates/froxel-grid/src/lighting.rs.

#import froxel
#import froxel_voxels
#import froxel_which
#import phase
#import medium_path

override BOUNDED: bool = false;
override DENSITY: u32 = 0u;
override ISOTROPIC: bool = true;
// whether the channels are attenuated alike
override ACHROMATIC: bool = true;
override HOFFMAN_PREETHAM: bool = false;
// whether slices behind those of the view's own volume read the grid
override GRID: bool = false;
// whether some light has a picture
override TEXTURED: bool = false;
// whether froxels are kept for the frame after, and those of the frame before are there
override TEMPORAL: bool = false;
override HISTORY: bool = false;

@group(2) @binding(1) var<uniform> view: View;
@group(2) @binding(2) var density_grid: texture_3d<f32>;
// the volume of the frame before
@group(2) @binding(3) var history: texture_3d<f32>;
// W/(m^3 sr) in rgb, density in alpha; -1 where a froxel is not lit
@group(2) @binding(4) var lit_volume: texture_storage_3d<rgba32float, write>;
// pictures of all lights, row by row; linear RGB
@group(2) @binding(5) var<storage, read> pictures: array<vec4f>;

// side of a square over which 1/h has the mean that it has at this share of it
const MEAN_OFFSET: f32 = 0.284;

fn picture_texel(light: FroxelLight, at: vec2i) -> vec3f {
    let inside = clamp(at, vec2i(0), vec2i(light.picture) - 1);
    return pictures[light.first_texel + u32(inside.y) * light.picture.x + u32(inside.x)].rgb;
}

fn picture_colour(light: FroxelLight, from_light: vec3f) -> vec3f {
    let k = light.tan_outer * dot(from_light, light.axis);
    let at = vec2f(0.5 + 0.5 * dot(from_light, light.right) / k, 0.5 - 0.5 * dot(from_light, light.top) / k);
    let texel = at * vec2f(light.picture);
    if light.nearest_texel != 0u {
        return picture_texel(light, vec2i(floor(texel)));
    }
    let low = floor(texel - 0.5);
    let f = texel - 0.5 - low;
    let upper = mix(picture_texel(light, vec2i(low)), picture_texel(light, vec2i(low) + vec2i(1, 0)), f.x);
    let lower =
        mix(picture_texel(light, vec2i(low) + vec2i(0, 1)), picture_texel(light, vec2i(low) + vec2i(1, 1)), f.x);
    return mix(upper, lower, f.y);
}

// Radiant intensity towards a point; units: W/sr.
fn intensity_towards(light: FroxelLight, from_light: vec3f) -> vec3f {
    if light.kind == POINT_LIGHT {
        return light.power;
    }
    let cosine = dot(from_light, light.axis) / max(length(from_light), 1e-30);
    let share = clamp((min(cosine, 1.0) - light.cos_outer) / max(light.cos_inner - light.cos_outer, 0.001), 0.0, 1.0);
    var colour = light.power * share * share;
    if TEXTURED && light.picture.x > 0u {
        colour *= picture_colour(light, from_light);
    }
    return colour;
}

// Mean of 1/d^2 over a slice of a ray from the eye; a froxel is as wide as its tile, so that the ray passes the light at
// no less than the mean distance of a froxel's rays; units: 1/m^2.
fn mean_inverse_square(to_light: vec3f, direction: vec3f, slice: vec2f, width: f32) -> f32 {
    let foot = dot(to_light, direction);
    let h = max(length(to_light - foot * direction), MEAN_OFFSET * width);
    let depth = slice.y - slice.x;
    let angle = accurate_angle(h * depth, h * h + (slice.x - foot) * (slice.y - foot));
    return angle / (h * depth);
}

// Phase value between unit vectors to the light and along the view ray; units: 1/sr.
fn phase_of(to_light: vec3f, direction: vec3f) -> f32 {
    if ISOTROPIC {
        return INV_4PI;
    }
    var sum = 0.0;
    for (var i = 0u; i < lobe_count(); i++) {
        let lobe = view.lobes[i];
        sum += lobe.x * lobe_between(Lobe(u32(lobe.y), lobe.z), to_light, direction);
    }
    return sum;
}

// Density between a point (from the eye) and a light, summed up; units: m.
fn way_path(light: FroxelLight, point: vec3f, to_light: vec3f) -> f32 {
    if light.kind == DIRECTIONAL_LIGHT {
        if !BOUNDED && DENSITY != GRID_DENSITY {
            return 0.0;
        }
        return optical_path(point, light.position, vec2f(0.0, ENDLESS));
    }
    let distance = length(to_light);
    return optical_path(point, to_light / max(distance, 1e-30), vec2f(0.0, distance));
}

struct Sample {
    point: vec3f,     // units: m
    from_eye: vec3f,  // the same without the eye
    direction: vec3f, // unit
    slice: vec2f,     // distances at which its slice begins and ends
    width: f32,       // of the froxel; units: m
}

// What a light that nothing shadows adds to a froxel, over its density and scattering coefficient; units: W/(m^2 sr).
fn unshadowed(light: FroxelLight, froxel: Sample, eye: vec3f) -> vec3f {
    let to_light = select(light.position - froxel.point, light.position, light.kind == DIRECTIONAL_LIGHT);
    let unit = to_light / max(length(to_light), 1e-30);
    var arriving = light.power;
    if light.kind != DIRECTIONAL_LIGHT {
        arriving = intensity_towards(light, -to_light);
        if !HOFFMAN_PREETHAM {
            let from_eye = light.position - eye;
            arriving *= mean_inverse_square(from_eye, froxel.direction, froxel.slice, froxel.width);
        }
    }
    if !HOFFMAN_PREETHAM {
        let path = way_path(light, froxel.from_eye, to_light);
        if ACHROMATIC {
            arriving *= exp(-view.sigma_t.x * path);
        } else {
            arriving *= exp(-view.sigma_t * path);
        }
    }
    return arriving * phase_of(unit, froxel.direction);
}

// Which of some lights reach a point by the voxel that it lies in.
fn voxel_lit(point: vec3f, fine: bool, asked: u32, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> u32 {
    return voxel_lit_at(voxel_at(point, fine), fine, asked, missed, dropped);
}

// The same by a voxel.
fn voxel_lit_at(at: vec3u, fine: bool, asked: u32, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> u32 {
    let voxel = alternate(at, fine);
    let chosen = chosen_lights(voxel_center(voxel, fine));
    *dropped += countOneBits(asked & ~chosen);
    let mask = voxel_mask(voxel, fine, countOneBits(asked & chosen), missed);
    return from_bits(mask, asked, chosen);
}

// How much of a light reaches a point by the eight voxels around it.
fn trilinear_visibility(point: vec3f, light: u32, fine: bool, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> f32 {
    let around = voxels_around(point, fine);
    var sum = 0.0;
    var drops = 0u;
    for (var i = 0u; i < 8u; i++) {
        let weight = corner_weight(around, i);
        if weight > 0.0 {
            var dropped_here = 0u;
            let lit = voxel_lit_at(corner_voxel(around, i), fine, 1u << light, missed, &dropped_here);
            sum += weight * f32((lit >> light) & 1u);
            drops = max(drops, dropped_here);
        }
    }
    *dropped += drops;
    return sum;
}

// The same by the view's own volume.
fn near_lit(froxel_view: FroxelView, tile: vec2u, k: u32, asked: u32, dropped: ptr<function, u32>) -> u32 {
    let mask = near_mask(froxel_view, tile, k);
    if !SELECTS {
        return mask & asked;
    }
    let direction = froxel_direction(froxel_view, tile / froxels.near_side, froxels.near_side);
    let chosen = chosen_lights(froxel_view.eye + slice_distance(k, froxels.jitter) * direction);
    *dropped += countOneBits(asked & ~chosen);
    return from_bits(mask, asked, chosen);
}

// The same by the grid. Outside of it a light's shadow is that of where the way to it enters.
fn grid_lit(point: vec3f, fine: bool, asked: u32, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> u32 {
    let is_inside = is_within(point, froxels.grid_min, froxels.grid_max);
    var lit = voxel_lit(point, fine, select(0u, asked, is_inside), missed, dropped);
    var left = select(asked, 0u, is_inside);
    while left != 0u {
        let i = firstTrailingBit(left);
        left &= left - 1u;
        lit |= voxel_lit(stand_in(light_at(i), point), fine, 1u << i, missed, dropped);
    }
    return lit;
}

// What the frames before knew of a froxel's middle: alpha is negative where that is nothing.
fn remembered(point: vec3f) -> vec4f {
    let place = froxel_place(which.before, point);
    if place.z < 0.0 {
        return vec4f(-1.0);
    }
    let at = place - 0.5;
    let low = floor(at);
    let share = at - low;
    let dims = vec3f(vec3u(which.before.tiles, froxels.slices));
    var sum = vec4f();
    var weights = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let upper = vec3<bool>((i & 1u) != 0u, (i & 2u) != 0u, (i & 4u) != 0u);
        let corner = low + select(vec3f(0.0), vec3f(1.0), upper);
        if any(corner < vec3f(0.0)) || any(corner >= dims) {
            continue;
        }
        let shares = select(1.0 - share, share, upper);
        let value = textureLoad(history, vec3i(corner), 0);
        let weight = select(0.0, shares.x * shares.y * shares.z, value.a >= 0.0);
        sum += weight * value;
        weights += weight;
    }
    if weights < 0.5 {
        return vec4f(-1.0);
    }
    return sum / weights;
}

// What a froxel knows of its shadows.
struct Reading {
    froxel: Sample,
    eye: vec3f,
    asked: u32,    // lights that something may shadow
    lit: u32,      // those of them that reach it
    is_far: bool,  // whether the grid says so
    is_fine: bool, // whether that is the finer one
}

// What a light adds to a froxel, over its density and scattering coefficient; units: W/(m^2 sr).
fn light_of_one(i: u32, reading: Reading, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> vec3f {
    let point = reading.froxel.point;
    let is_asked = ((reading.asked >> i) & 1u) != 0u;
    if !is_asked && !shines(light_at(i), point) {
        return vec3f();
    }
    var visibility = select(1.0, f32((reading.lit >> i) & 1u), is_asked);
    if TRILINEAR {
        if is_asked && reading.is_far {
            let read = stand_in(light_at(i), point);
            visibility = trilinear_visibility(read, i, reading.is_fine, missed, dropped);
        }
    }
    return visibility * unshadowed(light_at(i), reading.froxel, reading.eye);
}

// Radiance by metre of a froxel in front of the surfaces, and the density.
fn light_froxel(froxel_view: FroxelView, direction: vec3f, id: vec3u, missed: ptr<function, u32>, dropped: ptr<function, u32>) -> vec4f {
    let distance = slice_distance(id.z, froxels.jitter);
    let from_eye = distance * direction;
    let slice = froxels.starts[id.z].xy;
    let width = f32(froxels.tile) * froxel_view.scale.x * distance;
    let point = froxel_view.eye + from_eye;
    if !is_within(point, froxels.medium_min, froxels.medium_max) {
        return vec4f();
    }
    let density = density_at(from_eye);
    let asked = needs(point);
    let is_far = GRID && id.z >= froxels.near_slices;
    let is_fine = id.z < froxels.fine_slices;
    var lit = 0u;
    if GRID && !TRILINEAR {
        lit = grid_lit(point, is_fine, select(0u, asked, is_far), missed, dropped);
    }
    if id.z < froxels.near_slices {
        lit = near_lit(froxel_view, id.xy, id.z, asked, dropped);
    }
    let froxel = Sample(point, from_eye, direction, slice, width);
    let reading = Reading(froxel, froxel_view.eye, asked, lit, is_far, is_fine);
    var scattered = vec3f();
    if LIGHTS > 0u {
        scattered += light_of_one(0u, reading, missed, dropped);
    }
    if LIGHTS > 1u {
        scattered += light_of_one(1u, reading, missed, dropped);
    }
    if LIGHTS > 2u {
        scattered += light_of_one(2u, reading, missed, dropped);
    }
    if LIGHTS > 3u {
        scattered += light_of_one(3u, reading, missed, dropped);
    }
    if LIGHTS > 4u {
        scattered += light_of_one(4u, reading, missed, dropped);
    }
    if LIGHTS > 5u {
        scattered += light_of_one(5u, reading, missed, dropped);
    }
    if LIGHTS > 6u {
        scattered += light_of_one(6u, reading, missed, dropped);
    }
    if LIGHTS > 7u {
        scattered += light_of_one(7u, reading, missed, dropped);
    }
    for (var i = 8u; i < LIGHTS; i++) {
        scattered += light_of_one(i, reading, missed, dropped);
    }
    return vec4f(density * (view.emission + view.sigma_s * scattered), density);
}

// A froxel in front of the surfaces, over what is remembered of it.
fn froxel_value(froxel_view: FroxelView, direction: vec3f, id: vec3u) -> vec4f {
    var missed = 0u;
    var dropped = 0u;
    var value = light_froxel(froxel_view, direction, id, &missed, &dropped);
    let is_sound = all(value >= vec4f(0.0)) && all(value < vec4f(1e38));
    value = select(vec4f(), value, vec4<bool>(is_sound));
    if HISTORY {
        let middle = froxel_view.eye + slice_distance(id.z, 0.5) * direction;
        let before = remembered(middle);
        if before.a >= 0.0 {
            value = mix(before, value, which.newest);
        }
    }
    // rare, all of them
    if missed > 0u {
        atomicAdd(&counts[MISSED], missed);
    }
    if dropped > 0u {
        atomicAdd(&counts[DROPPED], dropped);
    }
    if !is_sound {
        atomicAdd(&counts[NOT_FINITE], 1u);
    }
    return value;
}

@compute @workgroup_size(4, 4, 4)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let froxel_view = froxel_views.views[which.view];
    let first = id.z * SLICES_A_THREAD;
    if any(id.xy >= froxel_view.tiles) || first >= froxels.slices {
        return;
    }
    let reach = reach_of(froxel_view, id.xy);
    let direction = froxel_direction(froxel_view, id.xy, 1u);
    let end = min(first + SLICES_A_THREAD, froxels.slices);
    var k = first;
    for (; k < end; k++) {
        if slice_start(k) >= reach {
            break;
        }
        textureStore(lit_volume, vec3u(id.xy, k), froxel_value(froxel_view, direction, vec3u(id.xy, k)));
    }
    // the frame after sees that there is nothing
    if TEMPORAL {
        for (; k < end; k++) {
            textureStore(lit_volume, vec3u(id.xy, k), vec4f(0.0, 0.0, 0.0, -1.0));
        }
    }
}
