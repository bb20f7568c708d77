// The airlight of the three pixels behind a known one - to its right, below, and across - from the known ones around them,
// with estimates of the errors. Twin: crates/hybrid-march/src/adaptive/prediction.rs.

#import sampling

// Inverse depths that differ by less than this share are on one plane; the same three times as far away.
const SAME_PLANE: f32 = 0.02;
const SAME_PLANE_FAR: f32 = 0.06;

// Beside a depth edge, what a relative difference of inverse depths of this much and more takes away from a value's weight.
const SAME_DEPTH: f32 = 1e-3;

// Share of the values' spread that an estimated error is at least.
const LEAST_ESTIMATE: f32 = 1.0 / 32.0;

// Four known values that differ by so many times the root of the budget, over the stride they leave, are as good as equal.
const EQUAL: f32 = 1.6;

// The estimate of what nothing can be said of.
const UNKNOWN: f32 = 3e38;

struct Prediction {
    value: vec3f,
    estimate: f32, // units: W/(m^2 sr)
}

// What is known of a pixel: the one at the edge for those outside.
struct Known {
    value: vec3f,
    inverse_depth: f32,
}

fn known_at(pixel: vec2i) -> Known {
    let place = place_of(vec2u(clamp(pixel, vec2i(0), vec2i(view.size) - 1)));
    return Known(values[place].rgb, inverse_depths[place]);
}

// From pixels at half a stride alone: four, or two of them twice, the first and the last opposite of each other. `corners` is
// by how much four around the pixel differ, below 0 where they are not all in the picture, `equal` what that is where they are as good as equal; `curves` whether more of
// them would tell more.
struct Near {
    prediction: Prediction,
    own: f32,
    spread: f32,
    curves: bool,
}

fn near(pixel: vec2i, a: Known, b: Known, c: Known, d: Known, are_there: bool, corners: f32, equal: f32) -> Near {
    let own = inverse_depths[place_of(vec2u(clamp(pixel, vec2i(0), vec2i(view.size) - 1)))];
    let depths = vec4f(a.inverse_depth, b.inverse_depth, c.inverse_depth, d.inverse_depth);
    let least = min(min(a.value, b.value), min(c.value, d.value));
    let most = max(max(a.value, b.value), max(c.value, d.value));
    let spread = length(most - least);
    let plane = dot(depths, vec4f(0.25));
    let twist = depths.x + depths.w - depths.y - depths.z;
    let is_flat = abs(own - plane) <= SAME_PLANE * max(own, plane) && abs(twist) <= 2.0 * SAME_PLANE * own;
    var value = 0.25 * (a.value + b.value + c.value + d.value);
    let is_even = corners >= 0.0 && corners <= equal;
    var estimate = select(0.5, LEAST_ESTIMATE, is_even) * spread;
    if !is_flat {
        let farthest = min(min(depths.x, depths.y), min(depths.z, depths.w));
        let nearest = max(max(depths.x, depths.y), max(depths.z, depths.w));
        let is_between = own >= (1.0 - SAME_PLANE) * farthest && own <= (1.0 + SAME_PLANE) * nearest;
        let weights = 1.0 / (abs(depths - own) / max(own, 1e-30) + SAME_DEPTH);
        value = weights.x * a.value + weights.y * b.value + weights.z * c.value + weights.w * d.value;
        value /= dot(weights, vec4f(1.0));
        // two of them may agree by chance
        estimate = select(UNKNOWN, 0.5 * select(spread, corners, corners >= 0.0), is_between);
    }
    let prediction = Prediction(value, select(UNKNOWN, estimate, are_there));
    return Near(prediction, own, spread, are_there && is_flat && !is_even);
}

// The same with the pixels in line at one and a half strides.
fn curved(pixel: Near, sum: vec3f, far: vec3f, far_depth: f32, are_there: bool) -> Prediction {
    let cubic = (9.0 * sum - far) / 8.0;
    let estimate = max(length(cubic - pixel.prediction.value), LEAST_ESTIMATE * pixel.spread);
    let own = pixel.own;
    if pixel.curves && are_there && abs(own - far_depth) <= SAME_PLANE_FAR * own {
        return Prediction(max(cubic, vec3f()), estimate);
    }
    return pixel.prediction;
}

// Of the pixels to the right of a known one, below, and across.
fn predictions(known: vec2i, stride: i32) -> array<Prediction, 3> {
    let half = stride / 2;
    let size = vec2i(view.size);
    let next = known + stride;
    let a = known_at(known);
    let b = known_at(vec2i(next.x, known.y));
    let c = known_at(vec2i(known.x, next.y));
    let d = known_at(next);
    let has = next < size;
    let equal = EQUAL * sqrt(level.budget) * sampling.unit / f32(half);
    let least = min(min(a.value, b.value), min(c.value, d.value));
    let most = max(max(a.value, b.value), max(c.value, d.value));
    let corners = select(-1.0, length(most - least), all(has));
    let row = near(known + vec2i(half, 0), a, b, a, b, has.x, corners, equal);
    let column = near(known + vec2i(0, half), a, c, a, c, has.y, corners, equal);
    let across = near(known + half, a, b, c, d, all(has), corners, equal);
    var found = array<Prediction, 3>(row.prediction, column.prediction, across.prediction);
    if row.curves || column.curves || across.curves {
        let before = known - stride;
        let behind = next + stride;
        let has_far = vec4<bool>(before >= vec2i(0), behind < size);
        let west = known_at(vec2i(before.x, known.y));
        let east = known_at(vec2i(behind.x, known.y));
        let north = known_at(vec2i(known.x, before.y));
        let south = known_at(vec2i(known.x, behind.y));
        let north_west = known_at(before);
        let north_east = known_at(vec2i(behind.x, before.y));
        let south_west = known_at(vec2i(before.x, behind.y));
        let south_east = known_at(behind);
        found[0] = curved(
            row, 0.5 * (a.value + b.value), 0.5 * (west.value + east.value),
            0.5 * (west.inverse_depth + east.inverse_depth), has_far.x && has_far.z,
        );
        found[1] = curved(
            column, 0.5 * (a.value + c.value), 0.5 * (north.value + south.value),
            0.5 * (north.inverse_depth + south.inverse_depth), has_far.y && has_far.w,
        );
        let far = north_west.value + north_east.value + south_west.value + south_east.value;
        let far_depths = north_west.inverse_depth + north_east.inverse_depth + south_west.inverse_depth
            + south_east.inverse_depth;
        let sum = a.value + b.value + c.value + d.value;
        found[2] = curved(across, 0.25 * sum, 0.25 * far, 0.25 * far_depths, all(has_far));
    }
    return found;
}

// Which of the three pixels there are.
fn are_there(known: vec2i, half: i32) -> vec3<bool> {
    let is_known = all(known < vec2i(view.size));
    let has = known + half < vec2i(view.size);
    return vec3<bool>(is_known && has.x, is_known && has.y, is_known && all(has));
}
