// Airlight of a point light over an interval of a view ray.
//
// L(x0, x1) = integral of sigma_s p I0/d^2 e^(-sigma_t (d + x)) dx              (WR08 Eq. 1, BSA10 Eq. 1)
//
// A short interval goes by Gauss-Legendre in tan(xi - xi0), a long one by the difference of two tails
// G(z) = Im[e^z E1(z)]; a phase function by a composite rule in a logarithmic variable. No antiderivative is rounded
// and subtracted where that would lose digits. Twins: crates/media-math/src/optics/{foot,airlight,composite,
// exponential_integral,phase}.rs, function by function.

#import elementary
#import phase

// see media-math's Real for f32
const MIN_RELATIVE_H: f32 = 1e-15;
const FAR: f32 = 1e12;
const PANEL_FAR: f32 = 1e9;
const PANEL_CUT: f32 = 18.0;
const PANEL_LENGTH: f32 = 1.5;
const SERIES_TERMS: i32 = 12;
const EULER_GAMMA: f32 = 0.577215665;

const GL4 = array<vec2f, 4>(
    vec2f(-0.339981044, 0.652145155), vec2f(0.339981044, 0.652145155),
    vec2f(-0.861136312, 0.347854845), vec2f(0.861136312, 0.347854845),
);
const GL8 = array<vec2f, 8>(
    vec2f(-0.183434642, 0.362683783), vec2f(0.183434642, 0.362683783),
    vec2f(-0.525532410, 0.313706646), vec2f(0.525532410, 0.313706646),
    vec2f(-0.796666477, 0.222381034), vec2f(0.796666477, 0.222381034),
    vec2f(-0.960289856, 0.101228536), vec2f(0.960289856, 0.101228536),
);
const POLES = array<vec2f, 8>(
    vec2f(0.0406021412, 0.0999096665),
    vec2f(0.21317266, 0.195068125),
    vec2f(0.527484005, 0.231352711),
    vec2f(1.01571291, 0.216819396),
    vec2f(1.76564736, 0.158819876),
    vec2f(2.9448158, 0.0777506278),
    vec2f(4.8564697, 0.0190079039),
    vec2f(8.18168932, 0.00127167019),
);

// A point light relative to a view ray.
struct Foot {
    x_foot: f32, // distance along the ray of the point nearest to the light; units: m
    h: f32,      // distance of the light from the ray's line; units: m
}

// An interval in the variables of media-math's foot.rs; lengths in `unit` metres.
struct Span {
    h: f32,
    r0: f32,      // path excess at the near end
    dr: f32,      // R1 - R0
    q: f32,       // tan(xi1 - xi0)/h
    near: f32,    // x0 + d0
    angle_y: f32, // the angle at the light is that of (angle_x, angle_y)
    angle_x: f32,
    unit: f32,
}

// The interval from x0 to x1 > x0.
fn span_of(foot: Foot, x0_m: f32, x1_m: f32) -> Span {
    var a0 = x0_m - foot.x_foot;
    var a1 = x1_m - foot.x_foot;
    var h = abs(foot.h);
    var length = x1_m - x0_m;
    var x0 = x0_m;
    var unit = 1.0;
    var scale = max(abs(a0), h);
    if scale == 0.0 {
        scale = min(length, 1.0);
    }
    if scale < 1e-3 || scale >= 1e6 {
        // the power of two below
        unit = bitcast<f32>(bitcast<u32>(scale) & 0x7f800000u);
        a0 = a0 / unit;
        a1 = a1 / unit;
        h = h / unit;
        length = length / unit;
        x0 = x0 / unit;
        scale = scale / unit;
    }
    h = max(h, MIN_RELATIVE_H * scale);
    let h2 = h * h;
    let d0 = sqrt(a0 * a0 + h2);
    let near = x0 + d0;
    if a1 < 0.0 {
        // all of it before the light: h^2 is taken out of q, which stays finite on the axis
        let d1 = sqrt(a1 * a1 + h2);
        let rho0 = 1.0 / (d0 - a0);
        let rho1 = 1.0 / (d1 - a1);
        let slope = length * (rho0 + rho1) / (d0 + d1);
        let q = slope / (1.0 + h2 * rho0 * rho1);
        return Span(h, h2 * rho0, h2 * slope, q, near, h * length, h2 + a0 * a1, unit);
    }
    let r0 = select(d0 + a0, h2 / (d0 - a0), a0 < 0.0);
    if a1 > FAR * scale {
        return Span(h, r0, ENDLESS, 1.0 / r0, near, h, a0, unit);
    }
    let d1 = sqrt(a1 * a1 + h2);
    let r1 = d1 + a1;
    let dr = length * (r0 + r1) / (d0 + d1);
    return Span(h, r0, dr, dr / (h2 + r0 * r1), near, h * length, h2 + a0 * a1, unit);
}

// G/h by the power series of E1, for |z| < 1.
fn series(x: f32, b: f32, angle: f32) -> f32 {
    var power = vec2f(1.0, 0.0);
    var sum = vec2f(0.0, 0.0);
    for (var k = 1; k <= SERIES_TERMS; k++) {
        let n = f32(k);
        power = vec2f(-power.x * x - power.y * b, power.x * b - power.y * x) / n;
        sum = sum + power / n;
    }
    let long = max(x, b);
    let ratio = min(x, b) / long;
    let log_abs = accurate_log(long) + 0.5 * accurate_log1p(ratio * ratio);
    let real = -EULER_GAMMA - log_abs - sum.x;
    let imaginary = angle - sum.y;
    return exp(x) * (cos_unit(b) * imaginary - sin_unit(b) * real);
}

// G/h at extinction sigma_t > 0, path excess r and light offset h.
fn tail_over_h(sigma_t: f32, r: f32, h: f32) -> f32 {
    let x = sigma_t * r;
    let b = sigma_t * h;
    if max(x, b) < 1.0 && x * x + b * b < 1.0 {
        return series(x, b, accurate_angle(h, r)) / h;
    }
    var sum = 0.0;
    for (var i = 0; i < 8; i++) {
        let pole = POLES[i];
        let shifted = x + pole.x;
        sum += pole.y / (shifted * shifted + b * b);
    }
    return sigma_t * sum;
}

// [G(R0) - e^(-sigma_t dR) G(R1)]/(2 pi h).
fn tail_difference(span: Span, sigma_t: f32) -> f32 {
    if sigma_t * max(span.r0, span.h) < 1.2e-38 {
        return INV_4PI * accurate_angle(span.angle_y, span.angle_x) / span.h;
    }
    var beyond = 0.0;
    if span.dr < ENDLESS && sigma_t * span.dr < 88.0 {
        beyond = exp(-sigma_t * span.dr) * tail_over_h(sigma_t, span.r0 + span.dr, span.h);
    }
    return 2.0 * INV_4PI * (tail_over_h(sigma_t, span.r0, span.h) - beyond);
}

// R - R0 at a node y of the short rule, and the weight of dR/(h^2 + R^2) per unit of the node's own.
fn short_node(span: Span, y: f32) -> vec2f {
    let hq = span.h * span.q;
    let p = span.q / (1.0 + sqrt(1.0 + hq * hq));
    let hp = span.h * p;
    let hp2 = hp * hp;
    let s = p * (1.0 + y) / (1.0 - hp2 * y);
    let m = span.h * span.h + span.r0 * span.r0;
    return vec2f(m * s / (1.0 - span.r0 * s), p / (1.0 + hp2 * y * y));
}

// Integral of p e^(-sigma_t (R - R0))/d^2 for p = 1/(4 pi), in the span's unit of length.
fn isotropic_integral(span: Span, sigma_t: f32) -> f32 {
    if sigma_t * span.dr <= 1.0 && span.q * span.r0 <= 0.5 && span.q * span.h <= 1.0 {
        var sum = 0.0;
        for (var i = 0; i < 4; i++) {
            let node = short_node(span, GL4[i].x);
            sum += GL4[i].y * node.y * exp(-sigma_t * node.x);
        }
        return 2.0 * INV_4PI * sum;
    }
    return tail_difference(span, sigma_t);
}

// A node of the composite rule.
struct PathNode {
    delta: f32,  // R - R0, in the span's unit of length
    weight: f32, // quadrature weight times dx/d^2
}

// How the composite rule divides a span: panels of 8 nodes in y = ln(1 + (R - R0)/from), or the short rule's 4 nodes
// where nothing turns.
struct Panels {
    count: i32,      // panels; 0 for the short rule
    half_width: f32, // in y
    start: f32,      // R_s
    begin: f32,      // R0 + R_s
}

// The division for a lobe that turns at `scale` h.
fn panels_of(span: Span, sigma_t: f32, scale: f32) -> Panels {
    let start = scale * span.h;
    let begin = span.r0 + start;
    if span.dr <= 0.25 * begin && sigma_t * span.dr <= 1.0 {
        return Panels(0, 0.0, start, begin);
    }
    var reach = min(span.dr, (span.r0 + span.h) * PANEL_FAR);
    if sigma_t * reach > PANEL_CUT {
        reach = PANEL_CUT / sigma_t;
    }
    let y_end = accurate_log1p(reach / begin);
    let count = max(ceil(y_end / PANEL_LENGTH), 1.0);
    return Panels(i32(count), 0.5 * y_end / count, start, begin);
}

fn node_count(panels: Panels) -> i32 {
    return select(8 * panels.count, 4, panels.count == 0);
}

fn path_node(span: Span, panels: Panels, index: i32) -> PathNode {
    if panels.count == 0 {
        let node = short_node(span, GL4[index].x);
        return PathNode(node.x, 2.0 * GL4[index].y * node.y);
    }
    let y = panels.half_width * (2.0 * f32(index / 8) + 1.0 + GL8[index % 8].x);
    let delta = panels.begin * accurate_expm1(y);
    let r = span.r0 + delta;
    let weight = GL8[index % 8].y * panels.half_width * (r + panels.start);
    return PathNode(delta, 2.0 * weight / (span.h * span.h + r * r));
}

// Integral of p e^(-sigma_t (R - R0))/d^2 for a lobe, by the composite rule.
fn lobe_integral(span: Span, sigma_t: f32, lobe: Lobe) -> f32 {
    let panels = panels_of(span, sigma_t, lobe_feature(lobe));
    let count = node_count(panels);
    var sum = 0.0;
    for (var i = 0; i < count; i++) {
        let node = path_node(span, panels, i);
        sum += node.weight * lobe_at(lobe, span.r0 + node.delta, span.h) * exp(-sigma_t * node.delta);
    }
    return sum;
}

// Airlight from x0 to x1; g = 0 is isotropic; units: W/(m^2 sr).
fn airlight(sigma_s: f32, sigma_t: f32, intensity: f32, g: f32, foot: Foot, x0: f32, x1: f32) -> f32 {
    if !(x1 > x0) || sigma_s == 0.0 {
        return 0.0;
    }
    let span = span_of(foot, x0, x1);
    let extinction = sigma_t * span.unit;
    var integral = 0.0;
    if g == 0.0 {
        integral = isotropic_integral(span, extinction);
    } else {
        integral = lobe_integral(span, extinction, Lobe(HENYEY_GREENSTEIN_LOBE, g));
    }
    // in two halves: each is representable long after the whole is not
    let half = exp(-0.5 * extinction * span.near);
    return ((sigma_s * intensity) * half) * (integral / span.unit) * half;
}
