// Halves the stride at which a picture's airlight is known: pixels halfway between are interpolated, or listed where that
// would err.
//
// A thread has the three pixels behind one that is known: to its right, below, and across. In and out: see sampling.wgsl.
// Twin: `Known::interpolate` in crates/hybrid-march/src/adaptive.rs.

#import sampling

// Inverse depths that differ by less than this share are on one plane; the same three times as far away.
const SAME_PLANE: f32 = 0.02;
const SAME_PLANE_FAR: f32 = 0.06;

// Share of the values' spread that the estimated error of a cubic is at least.
const SPREAD_OF_CUBIC: f32 = 0.125;

var<workgroup> group_count: atomic<u32>;
var<workgroup> group_first: u32;

fn plane_at(pixel: vec2i) -> f32 {
    return planes[place_of(vec2u(pixel))];
}

fn value_at(pixel: vec2i) -> vec3f {
    return values[place_of(vec2u(pixel))].rgb;
}

// What is known of the pixels in one line, at half a stride and at one and a half to both sides.
struct Line {
    sum: vec3f,
    least: vec3f,
    most: vec3f,
    planes: f32,
    far_sum: vec3f,
    far_planes: f32,
    has_near: bool,
    has_far: bool,
}

// The pixels along `way`, which is half a stride long.
fn line_along(pixel: vec2i, way: vec2i) -> Line {
    let most = vec2i(view.size) - 1;
    let near = array<vec2i, 2>(pixel - way, pixel + way);
    let far = array<vec2i, 2>(pixel - 3 * way, pixel + 3 * way);
    let has_near = all(min(near[0], near[1]) >= vec2i(0)) && all(max(near[0], near[1]) <= most);
    let has_far = all(min(far[0], far[1]) >= vec2i(0)) && all(max(far[0], far[1]) <= most);
    // what is not there is read at the edge, and not used
    let a = value_at(clamp(near[0], vec2i(0), most));
    let b = value_at(clamp(near[1], vec2i(0), most));
    let far_a = clamp(far[0], vec2i(0), most);
    let far_b = clamp(far[1], vec2i(0), most);
    let planes = plane_at(clamp(near[0], vec2i(0), most)) + plane_at(clamp(near[1], vec2i(0), most));
    return Line(
        a + b, min(a, b), max(a, b), planes,
        value_at(far_a) + value_at(far_b), plane_at(far_a) + plane_at(far_b),
        has_near, has_far,
    );
}

// The airlight of a pixel between known ones (rgb), and 1 in alpha if it is as good as wanted.
fn predicted(own: f32, line: Line, count: f32) -> vec4f {
    let plane = line.planes / count;
    let straight = line.sum / count;
    let spread = length(line.most - line.least);
    let cubic = (9.0 * line.sum - line.far_sum) / (8.0 * count);
    let curves = line.has_far && abs(own - line.far_planes / count) <= SAME_PLANE_FAR * own;
    let estimate = select(0.5 * spread, max(length(cubic - straight), SPREAD_OF_CUBIC * spread), curves);
    let flat = abs(own - plane) <= SAME_PLANE * max(own, plane);
    let good = line.has_near && flat && estimate <= sampling.error;
    return vec4f(select(straight, max(cubic, vec3f()), curves), select(0.0, 1.0, good));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) index: u32) {
    let half = i32(level.stride / 2u);
    let known = vec2i(id.xy * level.stride);
    let size = vec2i(view.size);
    let right = known + vec2i(half, 0);
    let below = known + vec2i(0, half);
    let across = known + half;
    // none of the three is in a picture that ends before this
    let inside = all(known < size);
    let has = vec3<bool>(inside && right.x < size.x, inside && below.y < size.y, inside && all(across < size));
    var is_listed = vec3<bool>(false);
    if inside {
        let edge = size - 1;
        let row = predicted(plane_at(min(right, edge)), line_along(right, vec2i(half, 0)), 2.0);
        let column = predicted(plane_at(min(below, edge)), line_along(below, vec2i(0, half)), 2.0);
        let down = line_along(across, vec2i(half, half));
        let up = line_along(across, vec2i(half, -half));
        let own = plane_at(min(across, edge));
        let both = Line(
            down.sum + up.sum, min(down.least, up.least), max(down.most, up.most), down.planes + up.planes,
            down.far_sum + up.far_sum, down.far_planes + up.far_planes,
            down.has_near && up.has_near, down.has_far && up.has_far,
        );
        var diagonals = predicted(own, both, 4.0);
        diagonals.a *= select(0.0, 1.0, abs(down.planes - up.planes) <= 2.0 * SAME_PLANE * own);
        let is_good = vec3f(row.a, column.a, diagonals.a) > vec3f(0.0);
        is_listed = has & !is_good;
        if has.x && is_good.x {
            values[place_of(vec2u(right))] = vec4f(row.rgb, 0.0);
        }
        if has.y && is_good.y {
            values[place_of(vec2u(below))] = vec4f(column.rgb, 0.0);
        }
        if has.z && is_good.z {
            values[place_of(vec2u(across))] = vec4f(diagonals.rgb, 0.0);
        }
    }
    // one place in the list for all of a group, so that rays that are traced together are close together
    let own = select(vec3u(0u), vec3u(1u), is_listed);
    var at = atomicAdd(&group_count, own.x + own.y + own.z);
    workgroupBarrier();
    if index == 0u {
        group_first = atomicAdd(&sampling.found, atomicLoad(&group_count));
    }
    workgroupBarrier();
    at += group_first;
    if is_listed.x {
        rays.pixels[at] = place_of(vec2u(right));
    }
    if is_listed.y {
        rays.pixels[at + own.x] = place_of(vec2u(below));
    }
    if is_listed.z {
        rays.pixels[at + own.x + own.y] = place_of(vec2u(across));
    }
}
