// What a light's map says of a point: texels as steps, filtered shares, moments, or the surface between texel centres.
//
// A map holds heights: 1/depth in perspective and cube maps, -depth in orthographic ones, so that more is nearer to
// the light and a plane in the world is linear over the texels. Along a view ray every coordinate is linear in the
// distance x. A point is lit where height W <= own, with own = 1 in perspective and -depth in orthographic maps.
//
// The importing pass declares the textures `heights` (one layer a face) and `moments`, and the override constants
// `LIGHT` (light.wgsl) and `LOOKUP`. Twins: crates/shadowmap/src/{face,cube,lookup,variance,cells,seams}.rs.

#import map_nodes

const NEAREST: u32 = 0u;
const PERCENTAGE_CLOSER: u32 = 1u;
const VARIANCE: u32 = 2u;
const LINEAR_SURFACE: u32 = 3u;

// Linear functions (value at x = 0, slope) of the distance along a ray.
//
// X and Y run from -W to W across the map; for a cube X, Y and W are the world's axes from the light.
struct MapPath {
    x: vec2f,
    y: vec2f,
    w: vec2f,
    depth: vec2f,
}

fn at(line: vec2f, x: f32) -> f32 {
    return line.x + line.y * x;
}

fn along_ray(row: vec4f, ray: ViewRay) -> vec2f {
    return vec2f(row.w, dot(row.xyz, ray.direction));
}

fn map_path(ray: ViewRay) -> MapPath {
    return MapPath(
        along_ray(light.rows[0], ray),
        along_ray(light.rows[1], ray),
        along_ray(light.rows[2], ray),
        along_ray(light.rows[3], ray),
    );
}

// Where the point at distance x falls; w = 0 if the map does not see it.
fn locate(path: MapPath, x: f32) -> MapPoint {
    let p = vec3f(at(path.x, x), at(path.y, x), at(path.w, x));
    if LIGHT == POINT {
        return on_cube(p);
    }
    if LIGHT == DIRECTIONAL {
        let u = 0.5 * light.map_width * (1.0 + p.x);
        let v = 0.5 * light.map_height * (1.0 + p.y);
        let inside = abs(p.x) <= 1.0 && abs(p.y) <= 1.0;
        return MapPoint(0, u, v, select(0.0, 1.0, inside), -at(path.depth, x));
    }
    let inside = p.z > 0.0 && abs(p.x) <= p.z && abs(p.y) <= p.z;
    let scale = 1.0 / max(p.z, 1e-30);
    let u = 0.5 * light.map_width * (1.0 + p.x * scale);
    let v = 0.5 * light.map_height * (1.0 + p.y * scale);
    return MapPoint(0, u, v, select(0.0, p.z, inside), 1.0);
}

// Whether a point lies before the texel that it falls in.
fn nearest_lit(p: MapPoint) -> bool {
    return height_at(p.face, i32(p.u), i32(p.v)) * p.w <= p.own;
}

// One comparison of a filter, `shift` texels from the point's own texel position, maybe beyond the edge of its face.
fn tap(p: MapPoint, u: f32, v: f32) -> bool {
    if u >= 0.0 && v >= 0.0 && u < light.map_width && v < light.map_height {
        return nearest_lit(MapPoint(p.face, u, v, p.w, p.own));
    }
    if LIGHT != POINT {
        return light.outside == 1u;
    }
    // the square goes on in the plane of the face, and the face that sees its point answers
    let x = (2.0 * u / light.map_width - 1.0) * p.w;
    let y = (2.0 * v / light.map_width - 1.0) * p.w;
    var d = vec3f(-x, -y, -p.w);
    switch p.face {
        case 0: { d = vec3f(p.w, -y, -x); }
        case 1: { d = vec3f(-p.w, -y, x); }
        case 2: { d = vec3f(x, p.w, y); }
        case 3: { d = vec3f(x, -p.w, -y); }
        case 4: { d = vec3f(x, -y, p.w); }
        default: {}
    }
    return nearest_lit(on_cube(d));
}

// Lit share of a square of `kernel` texels around the point; every texel counts by the part that is covered.
fn closer_share(p: MapPoint) -> f32 {
    let width = i32(light.kernel);
    let reach = 0.5 * f32(width);
    let first = floor(vec2f(p.u, p.v) - reach);
    let fraction = vec2f(p.u, p.v) - reach - first;
    var sum = 0.0;
    for (var j = 0; j <= width; j++) {
        let row = select(select(1.0, fraction.y, j == width), 1.0 - fraction.y, j == 0);
        for (var i = 0; i <= width; i++) {
            let weight = row * select(select(1.0, fraction.x, i == width), 1.0 - fraction.x, i == 0);
            if weight > 0.0 && tap(p, first.x + f32(i) + 0.5, first.y + f32(j) + 0.5) {
                sum += weight;
            }
        }
    }
    return sum / f32(width * width);
}

// Upper bound of the lit share from two moments (Chebyshev), interpolated between texel centres of the face.
fn variance_share(p: MapPoint) -> f32 {
    let last = vec2i(i32(light.map_width), i32(light.map_height)) - 1;
    let position = clamp(vec2f(p.u, p.v) - 0.5, vec2f(0.0), vec2f(last));
    let low = vec2i(position);
    let high = min(low + 1, last);
    let f = position - vec2f(low);
    let upper = mix(
        textureLoad(moments, low, p.face, 0).rg, textureLoad(moments, vec2i(high.x, low.y), p.face, 0).rg, f.x,
    );
    let lower = mix(
        textureLoad(moments, vec2i(low.x, high.y), p.face, 0).rg, textureLoad(moments, high, p.face, 0).rg, f.x,
    );
    let moment = mix(upper, lower, f.y);
    let planar = select(p.w, -p.own, LIGHT == DIRECTIONAL);
    let depth = min(planar / light.variance.x, 1.0);
    if depth <= moment.x {
        return 1.0;
    }
    let variance = max(moment.y - moment.x * moment.x, light.variance.y);
    let beyond = depth - moment.x;
    let bound = variance / (variance + beyond * beyond);
    return max((bound - light.variance.z) / (1.0 - light.variance.z), 0.0);
}

// Whether a triangle's height at (u, v) within the cell, times w, is at most own.
fn before_triangle(cell: vec4f, u: f32, v: f32, w: f32, own: f32) -> bool {
    let lower = u + v > 1.0;
    let corner = select(cell.x, cell.w, lower);
    let along_u = select(cell.y, cell.z, lower);
    let along_v = select(cell.z, cell.y, lower);
    if LIGHT == DIRECTIONAL && min(corner, min(along_u, along_v)) <= NOTHING {
        return true;
    }
    let p = select(u, 1.0 - u, lower);
    let q = select(v, 1.0 - v, lower);
    return (corner + p * (along_u - corner) + q * (along_v - corner)) * w <= own;
}

// Whether a point beyond the outermost centres of a cube's faces lies before the strips and corners that join them.
fn seam_lit(p: vec3f) -> bool {
    let n = light.map_width;
    let h = 1.0 / n;
    let near = 1.0 - h;
    let signs = select(vec3f(-1.0), vec3f(1.0), p >= vec3f(0.0));
    let a = abs(p);
    let beyond = a * (2.0 - h) - (a.yzx + a.zxy) * near;
    if all(beyond >= vec3f(0.0)) {
        let w = a.x + a.y + a.z;
        let share = (a.yz * (3.0 - 2.0 * h) - w * near) * n / w;
        return before_triangle(corner_heights(signs), share.x, share.y, w, 1.0);
    }
    // the strip along the axis of the smallest component
    let c = select(select(1, 0, a.x <= a.y), 2, a.z <= min(a.x, a.y));
    let first = select(0, 1, c == 0);
    let second = select(2, 1, c == 2);
    let w = a[first] + a[second];
    let own = Strip(first, second, c, signs[first], signs[second]);
    let u = 0.5 * n * (2.0 - h) * p[c] / w + 0.5 * (n - 1.0);
    let v = (a[second] - near * a[first]) * n / w;
    let i = clamp(i32(floor(u)), 0, i32(n) - 2);
    return before_triangle(strip_heights(own, i), u - f32(i), v, w, 1.0);
}

// Whether a point lies before the surface that joins the texel centres.
fn surface_lit(path: MapPath, x: f32) -> bool {
    let p = locate(path, x);
    let u = p.u - 0.5;
    let v = p.v - 0.5;
    let columns = light.map_width - 1.0;
    let rows = light.map_height - 1.0;
    let within = u >= 0.0 && v >= 0.0 && u <= columns && v <= rows && columns > 0.0 && rows > 0.0;
    if p.w > 0.0 && within {
        let column = min(i32(u), i32(columns) - 1);
        let row = min(i32(v), i32(rows) - 1);
        let cell = cell_heights(p.face, column, row);
        return before_triangle(cell, u - f32(column), v - f32(row), p.w, p.own);
    }
    if LIGHT == POINT {
        return seam_lit(vec3f(at(path.x, x), at(path.y, x), at(path.w, x)));
    }
    return light.outside == 1u;
}

// Visibility of the light at distance x, in [0, 1].
fn map_visibility(path: MapPath, x: f32) -> f32 {
    if LOOKUP == LINEAR_SURFACE {
        return select(0.0, 1.0, surface_lit(path, x));
    }
    let p = locate(path, x);
    if !(p.w > 0.0) {
        return select(0.0, 1.0, (light.outside == 1u) | (LIGHT == POINT));
    }
    if LOOKUP == PERCENTAGE_CLOSER {
        return closer_share(p);
    }
    if LOOKUP == VARIANCE {
        return variance_share(p);
    }
    return select(0.0, 1.0, nearest_lit(p));
}
