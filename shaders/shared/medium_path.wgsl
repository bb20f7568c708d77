// How much medium lies on a way, and how dense it is at a point; points and ways in the world's axes, from the eye.
//
// The importing pass declares `density_grid` and the override constants `BOUNDED` (the medium fills a box) and
// `DENSITY`. Twins: crates/scene/src/{medium,medium_path,aabb}.rs.

#import view
#import elementary

const UNIFORM_DENSITY: u32 = 0u;
const HEIGHT_DENSITY: u32 = 1u;
const GRID_DENSITY: u32 = 2u;

// The part of a piece of a way inside a box.
fn box_piece(low: vec3f, high: vec3f, origin: vec3f, direction: vec3f, piece: vec2f) -> vec2f {
    // along an axis in which the way does not move it is in the slab from the beginning to the end, or never
    let still = direction == vec3f(0.0);
    let divisor = select(direction, vec3f(1.0), still);
    let a = (low - origin) / divisor;
    let b = (high - origin) / divisor;
    let is_in = (origin >= low) & (origin <= high);
    let enter = select(min(a, b), select(vec3f(ENDLESS), vec3f(-ENDLESS), is_in), still);
    let leave = select(max(a, b), select(vec3f(-ENDLESS), vec3f(ENDLESS), is_in), still);
    let start = max(max(enter.x, enter.y), max(enter.z, piece.x));
    let end = min(min(leave.x, leave.y), min(leave.z, piece.y));
    return select(vec2f(piece.x), vec2f(start, end), start <= end);
}

// Density of the grid at a point: trilinear between cell centres, 0 outside the box.
fn grid_density(point: vec3f) -> f32 {
    if any(point < view.grid_min) || any(point > view.grid_max) {
        return 0.0;
    }
    let cells = vec3f(textureDimensions(density_grid));
    let share = (point - view.grid_min) / (view.grid_max - view.grid_min);
    let at = clamp(share * cells - 0.5, vec3f(0.0), cells - 1.0);
    let low = vec3i(at);
    let f = at - vec3f(low);
    let last = vec3i(cells) - 1;
    var planes = vec2f();
    for (var dz = 0; dz < 2; dz++) {
        let z = min(low.z + dz, last.z);
        let y = min(low.y + 1, last.y);
        let x = min(low.x + 1, last.x);
        let near = mix(
            textureLoad(density_grid, vec3i(low.xy, z), 0).r,
            textureLoad(density_grid, vec3i(x, low.y, z), 0).r, f.x,
        );
        let far = mix(
            textureLoad(density_grid, vec3i(low.x, y, z), 0).r,
            textureLoad(density_grid, vec3i(x, y, z), 0).r, f.x,
        );
        planes[dz] = mix(near, far, f.y);
    }
    return mix(planes.x, planes.y, f.z);
}

// Density at a point, bounds aside; 1/1.
fn density_at(point: vec3f) -> f32 {
    if DENSITY == HEIGHT_DENSITY {
        return exp(-max(point.y - view.height_y0, 0.0) / view.height_scale);
    }
    if DENSITY == GRID_DENSITY {
        return grid_density(point);
    }
    return 1.0;
}

// One side of the height y0: all below it, or all above.
fn height_piece(height: f32, slope: f32, length: f32) -> f32 {
    let inside = height + slope * select(0.5 * length, 1.0, length >= 1e29);
    if inside <= 0.0 {
        return length;
    }
    if length >= 1e29 {
        let at_start = exp(-max(height, 0.0) / view.height_scale);
        return select(ENDLESS, at_start * view.height_scale / slope, slope > 0.0);
    }
    // from the lower end, where the density is larger: from the upper one a long way down is 0 times infinity
    let lowest = height + min(slope, 0.0) * length;
    return exp(-max(lowest, 0.0) / view.height_scale) * length * phi(length * abs(slope) / view.height_scale);
}

// Integral of the density over a piece of a way; units: m.
fn optical_path(origin: vec3f, direction: vec3f, whole: vec2f) -> f32 {
    var piece = whole;
    if BOUNDED {
        piece = box_piece(view.bounds_min, view.bounds_max, origin, direction, piece);
    }
    if DENSITY == GRID_DENSITY {
        piece = box_piece(view.grid_min, view.grid_max, origin, direction, piece);
    }
    if !(piece.y > piece.x) {
        return 0.0;
    }
    if DENSITY == HEIGHT_DENSITY {
        let height = origin.y - view.height_y0;
        let slope = direction.y;
        // where the way passes y0, if it does
        var cut = piece.y;
        if slope != 0.0 {
            let crossing = -height / slope;
            cut = select(piece.y, crossing, crossing > piece.x && crossing < piece.y);
        }
        let first = height_piece(height + slope * piece.x, slope, cut - piece.x);
        if cut >= piece.y {
            return first;
        }
        return first + height_piece(height + slope * cut, slope, piece.y - cut);
    }
    if DENSITY == GRID_DENSITY {
        let length = piece.y - piece.x;
        let count = clamp(ceil(length / view.grid_step), 1.0, 16384.0);
        let width = length / count;
        var sum = 0.0;
        for (var i = 0.0; i < count; i += 1.0) {
            sum += grid_density(origin + (piece.x + width * (i + 0.5)) * direction);
        }
        return sum * width;
    }
    return piece.y - piece.x;
}
