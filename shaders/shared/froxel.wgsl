// Froxels: where they are, which lights shine on them, and on which of those the casters may throw a shadow.
//
// Points are in the world's axes and absolute, as voxels are, by the operations of crates/froxel-grid in their order, so
// that CPU and GPU trace and read the same voxels. Layout in Rust: crates/gpu-backend/src/froxel/layout.rs.

#import elementary

const FROXEL_MOST_LIGHTS: u32 = 32u;
const FROXEL_MOST_VIEWS: u32 = 256u;

// lights for which a mask has room: 8, 16 or 32
override LIGHT_BITS: u32 = 8u;
// whether there are more lights than that
override SELECTS: bool = false;
// lights of the frame. The first eight come one by one instead of in loops: so their places are constants, and a driver
// that runs threads side by side reads them once for all
override LIGHTS: u32 = 1u;

const POINT_LIGHT: u32 = 0u;
const SPOT_LIGHT: u32 = 1u;
const DIRECTIONAL_LIGHT: u32 = 2u;

struct FroxelLight {
    position: vec3f,     // units: m; of a directional light the unit way to it
    kind: u32,
    axis: vec3f,         // unit; the way the light travels along its axis
    cos_outer: f32,
    power: vec3f,        // units: W/sr, or W/m^2 of a directional light
    cos_inner: f32,
    right: vec3f,        // unit; to the right of a spot's picture
    tan_outer: f32,
    top: vec3f,          // unit; to the top of a spot's picture
    first_texel: u32,    // of its picture, among those of all lights
    picture: vec2u,      // columns and rows of its picture; 0 without one
    nearest_texel: u32,  // 1 where a picture is read without interpolation
    is_shadowed: u32,    // 1 where the casters throw shadows in it
}

struct FroxelFrame {
    box_min: vec3f,      // around the casters; units: m
    light_count: u32,
    box_max: vec3f,
    view_count: u32,
    grid_min: vec3f,     // around the voxels: a voxel wider
    parity: u32,         // of the layers of voxels that count in this frame
    grid_max: vec3f,
    everything: u32,     // 1 where all layers are traced whatever their parity
    medium_min: vec3f,   // around the medium; units: m
    slices: u32,
    medium_max: vec3f,
    near_slices: u32,    // those whose shadows are in a volume of the view's own
    dims: vec3u,         // voxels along x, y and z
    voxel_size: f32,     // units: m
    tile: u32,           // pixels along the side of a froxel
    near_side: u32,      // froxels along the side of a cell of that volume
    fine_slices: u32,    // those that read the finer of two grids
    ratio: u32,          // voxels of that along the side of one of the other
    range: f32,          // distance at which the last slice ends; units: m
    growth: f32,         // e^curve - 1; 0 where all slices are equally deep
    curve: f32,
    jitter: f32,         // share of a slice at which it is sampled
    bricks: u32,         // places for bricks, a power of two; 0 where voxels are dense
    blocks: u32,         // blocks of voxels to look at
    first_light: u32,    // 0, see light_at
    _pad1: u32,
    sigma_t: vec3f,      // units: 1/m
    _pad2: u32,
    starts: array<vec4f, 257>, // where each slice begins, where it ends, and twice nothing; units: m
    lights: array<FroxelLight, FROXEL_MOST_LIGHTS>,
}

struct FroxelView {
    eye: vec3f,        // units: m
    first_tile: u32,   // among the tiles of all views
    right: vec3f,      // unit
    first_word: u32,   // of its masks, among those of all views
    up: vec3f,         // unit
    _pad0: u32,
    forward: vec3f,    // unit
    _pad1: u32,
    scale: vec2f,      // tangents by pixel
    offset: vec2f,     // tangents at the upper left corner
    size: vec2u,       // units: pixels
    tiles: vec2u,      // columns and rows of froxels
}

struct FroxelViews {
    views: array<FroxelView, FROXEL_MOST_VIEWS>,
}

@group(0) @binding(0) var<uniform> froxels: FroxelFrame;
@group(0) @binding(1) var<uniform> froxel_views: FroxelViews;
// farthest end of a ray in each tile of each view, and behind those of all views the same of the tiles around; units: m
@group(0) @binding(2) var<storage, read_write> reaches: array<f32>;
// masks of the views' own volumes: a word has consecutive slices of a cell's column
@group(0) @binding(3) var<storage, read_write> near_masks: array<u32>;
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>, 8>;

// Slices that a thread takes. Threads side by side run until the last of them is done: one that begins behind all surfaces
// ends at once, where a thread for each froxel would cost as much as one that is lit.
const SLICES_A_THREAD: u32 = 8u;

// indices of counts
const NEAR_RAYS: u32 = 0u;
const GRID_RAYS: u32 = 1u;
const FROXELS: u32 = 2u;
const VOXELS: u32 = 3u;
const BRICKS_USED: u32 = 4u;
const MISSED: u32 = 5u;
const DROPPED: u32 = 6u;
const NOT_FINITE: u32 = 7u;

// A light. Lights are read at fixed places where their loop is unrolled; what a driver knows of a place lets lavapipe compile
// the kinds of the lights into the shader, in every dispatch.
fn light_at(i: u32) -> FroxelLight {
    return froxels.lights[froxels.first_light + i];
}

// Distance at which a slice begins; units: m.
fn slice_start(k: u32) -> f32 {
    return froxels.starts[k].x;
}

// The distance at a share of a slice; units: m.
fn slice_distance(k: u32, share: f32) -> f32 {
    let slice = froxels.starts[k];
    return slice.x + share * (slice.y - slice.x);
}

// Unit vector through the middle of a cell of `side` x `side` froxels.
fn froxel_direction(view: FroxelView, cell: vec2u, side: u32) -> vec3f {
    let width = f32(froxels.tile * side);
    let tangent = (vec2f(cell) + 0.5) * width * view.scale + view.offset;
    let length = sqrt(tangent.x * tangent.x + tangent.y * tangent.y + 1.0);
    return (tangent.x / length) * view.right + (tangent.y / length) * view.up + (1.0 / length) * view.forward;
}

// How far froxels of a tile are lit: to the farthest surface in it and in those around, which are interpolated; units: m.
fn reach_of(view: FroxelView, tile: vec2u) -> f32 {
    let count = arrayLength(&reaches) / 2u;
    return reaches[count + view.first_tile + tile.y * view.tiles.x + tile.x];
}

fn is_within(point: vec3f, low: vec3f, high: vec3f) -> bool {
    return all(point >= low) && all(point <= high);
}

// The way to a light, as a shadow ray takes it: all of it to a local light, a unit vector to a directional one.
fn way_to(light: FroxelLight, point: vec3f) -> vec3f {
    return select(light.position - point, light.position, light.kind == DIRECTIONAL_LIGHT);
}

// How far along it that light is.
fn way_end(light: FroxelLight) -> f32 {
    return select(1.0, ENDLESS, light.kind == DIRECTIONAL_LIGHT);
}

// Where the way to a light enters a box: 0 inside, -1 where it passes by.
fn way_entry(light: FroxelLight, point: vec3f, low: vec3f, high: vec3f) -> f32 {
    let way = way_to(light, point);
    // along an axis in which the way does not move it is in the slab from the beginning to the end, or never
    let still = way == vec3f(0.0);
    let divisor = select(way, vec3f(1.0), still);
    let a = (low - point) / divisor;
    let b = (high - point) / divisor;
    let is_in = (point >= low) & (point <= high);
    let enter = select(min(a, b), select(vec3f(ENDLESS), vec3f(-ENDLESS), is_in), still);
    let leave = select(max(a, b), select(vec3f(-ENDLESS), vec3f(ENDLESS), is_in), still);
    let near = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let far = min(min(leave.x, leave.y), min(leave.z, way_end(light)));
    return select(select(-1.0, near, near <= far), 0.0, all(is_in));
}

// Whether something may shadow a point: not where the way to the light passes by the casters' box.
fn may_be_shadowed(light: FroxelLight, point: vec3f) -> bool {
    return way_entry(light, point, froxels.box_min, froxels.box_max) >= 0.0;
}

// The point that asks in a point's place for a light's shadow in the grid: where its way enters, since nothing outside
// blocks it.
fn stand_in(light: FroxelLight, point: vec3f) -> vec3f {
    return point + max(way_entry(light, point, froxels.grid_min, froxels.grid_max), 0.0) * way_to(light, point);
}

// Whether a light shines on a point at all.
fn shines(light: FroxelLight, point: vec3f) -> bool {
    if light.kind != SPOT_LIGHT {
        return true;
    }
    let from_light = point - light.position;
    return dot(light.axis, from_light) > light.cos_outer * length(from_light);
}

// Whether a light shines on a point and something may shadow it.
fn asks(i: u32, point: vec3f) -> bool {
    return light_at(i).is_shadowed != 0u && shines(light_at(i), point)
        && may_be_shadowed(light_at(i), point);
}

// All such lights, a bit each.
fn needs(point: vec3f) -> u32 {
    if !is_within(point, froxels.medium_min, froxels.medium_max) {
        return 0u;
    }
    var mask = 0u;
    if LIGHTS > 0u {
        mask |= u32(asks(0u, point));
    }
    if LIGHTS > 1u {
        mask |= u32(asks(1u, point)) << 1u;
    }
    if LIGHTS > 2u {
        mask |= u32(asks(2u, point)) << 2u;
    }
    if LIGHTS > 3u {
        mask |= u32(asks(3u, point)) << 3u;
    }
    if LIGHTS > 4u {
        mask |= u32(asks(4u, point)) << 4u;
    }
    if LIGHTS > 5u {
        mask |= u32(asks(5u, point)) << 5u;
    }
    if LIGHTS > 6u {
        mask |= u32(asks(6u, point)) << 6u;
    }
    if LIGHTS > 7u {
        mask |= u32(asks(7u, point)) << 7u;
    }
    for (var i = 8u; i < LIGHTS; i++) {
        mask |= u32(asks(i, point)) << i;
    }
    return mask;
}

// How bright a light is at a point, its cone aside.
fn strength(light: FroxelLight, point: vec3f) -> f32 {
    let power = max(light.power.x, max(light.power.y, light.power.z));
    if light.kind == DIRECTIONAL_LIGHT {
        return power;
    }
    let to = light.position - point;
    return power / max(dot(to, to), 1e-12);
}

// The lights that a mask at a point has room for: the strongest there.
fn chosen_lights(point: vec3f) -> u32 {
    if !SELECTS {
        return 0xffffffffu;
    }
    var chosen = 0u;
    for (var i = 0u; i < LIGHTS; i++) {
        let own = strength(light_at(i), point);
        var stronger = 0u;
        for (var j = 0u; j < LIGHTS; j++) {
            let other = strength(light_at(j), point);
            stronger += u32(other > own || (other == own && j < i));
        }
        chosen |= u32(stronger < LIGHT_BITS) << i;
    }
    return chosen;
}

// The bit of a light among the chosen ones.
fn light_bit(chosen: u32, light: u32) -> u32 {
    if !SELECTS {
        return light;
    }
    return countOneBits(chosen & ((1u << light) - 1u));
}

// A mask of lights as one of bits; those without a bit are left out.
fn to_bits(lights: u32, chosen: u32) -> u32 {
    if !SELECTS {
        return lights;
    }
    var bits = 0u;
    var left = lights & chosen;
    while left != 0u {
        let light = firstTrailingBit(left);
        left &= left - 1u;
        bits |= 1u << light_bit(chosen, light);
    }
    return bits;
}

// Bits of a mask as one of lights.
fn from_bits(bits: u32, lights: u32, chosen: u32) -> u32 {
    if !SELECTS {
        return bits & lights;
    }
    var lit = 0u;
    var left = lights & chosen;
    while left != 0u {
        let light = firstTrailingBit(left);
        left &= left - 1u;
        lit |= ((bits >> light_bit(chosen, light)) & 1u) << light;
    }
    return lit;
}

// The light of a bit.
fn light_of(chosen: u32, bit: u32) -> u32 {
    if !SELECTS {
        return bit;
    }
    var left = chosen;
    for (var i = 0u; i < bit; i++) {
        left &= left - 1u;
    }
    return firstTrailingBit(left);
}

// Word of a cell's mask in the volume of a view, and how far its bits are shifted in it.
fn near_place(view: FroxelView, cell: vec3u) -> vec2u {
    let cells = (view.tiles + froxels.near_side - 1u) / froxels.near_side;
    let bit = cell.z * LIGHT_BITS;
    return vec2u(view.first_word + ((bit >> 5u) * cells.y + cell.y) * cells.x + cell.x, bit & 31u);
}

// A froxel's mask in the volume of a view.
fn near_mask(view: FroxelView, tile: vec2u, k: u32) -> u32 {
    let place = near_place(view, vec3u(tile / froxels.near_side, k));
    return (near_masks[place.x] >> place.y) & (0xffffffffu >> (32u - LIGHT_BITS));
}
