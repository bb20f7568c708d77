// Elementary functions without the builtins whose accuracy WGSL leaves open.
//
// Builtin atan may err by thousands of ULP, log by 2^-21 near 1, sin and cos by 2^-11; exp, sqrt and division are good
// enough and are used as they are. Twin: crates/media-math takes these from the standard library.

// length of a ray without end; not infinity, which WGSL may assume away
const ENDLESS: f32 = 1e30;
const PI: f32 = 3.14159265;
const HALF_PI: f32 = 1.57079633;

// Natural logarithm of a positive normal number.
fn accurate_log(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    var e = f32(i32(bits >> 23u) - 127);
    var m = bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
    if m > 1.41421356 {
        m = 0.5 * m;
        e = e + 1.0;
    }
    // ln m = 2 artanh s with |s| <= 0.172: what is left out is below 1e-9
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let p = 1.0 + z * (1.0 / 3.0 + z * (0.2 + z * (1.0 / 7.0 + z * (1.0 / 9.0 + z * (1.0 / 11.0)))));
    return e * 0.693147181 + 2.0 * s * p;
}

// ln(1 + x) for x >= 0, accurate for small x.
fn accurate_log1p(x: f32) -> f32 {
    if x > 1.0 {
        return accurate_log(1.0 + x);
    }
    let s = x / (2.0 + x);
    let z = s * s;
    let tail = 1.0 / 9.0 + z * (1.0 / 11.0 + z * (1.0 / 13.0 + z * (1.0 / 15.0)));
    return 2.0 * s * (1.0 + z * (1.0 / 3.0 + z * (0.2 + z * (1.0 / 7.0 + z * tail))));
}

// e^y - 1 for y >= 0, accurate for small y.
fn accurate_expm1(y: f32) -> f32 {
    if y > 0.5 {
        return exp(y) - 1.0;
    }
    let p = 1.0 + y / 5.0 * (1.0 + y / 6.0 * (1.0 + y / 7.0 * (1.0 + y / 8.0)));
    return y * (1.0 + y / 2.0 * (1.0 + y / 3.0 * (1.0 + y / 4.0 * p)));
}

// Arc tangent for t in [0, 1].
fn atan_unit(t: f32) -> f32 {
    let high = t > 0.414213562;
    let s = select(t, (t - 1.0) / (t + 1.0), high);
    let z = s * s;
    let tail = 1.0 / 9.0 - z * (1.0 / 11.0 - z * (1.0 / 13.0 - z * (1.0 / 15.0 - z / 17.0)));
    let p = s * (1.0 - z * (1.0 / 3.0 - z * (0.2 - z * (1.0 / 7.0 - z * tail))));
    return select(p, 0.785398163 + p, high);
}

// Angle of (x, y) from the x axis for y >= 0, in [0, pi].
fn accurate_angle(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    if ax == 0.0 && y == 0.0 {
        return 0.0;
    }
    let steep = y > ax;
    let a = atan_unit(select(y / max(ax, 1e-37), ax / max(y, 1e-37), steep));
    let acute = select(a, HALF_PI - a, steep);
    return select(acute, PI - acute, x < 0.0);
}

// Sine for b in [0, 1].
fn sin_unit(b: f32) -> f32 {
    let z = b * b;
    return b * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0)))));
}

// Cosine for b in [0, 1].
fn cos_unit(b: f32) -> f32 {
    let z = b * b;
    return 1.0 - z / 2.0 * (1.0 - z / 12.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0 * (1.0 - z / 90.0))));
}

// Tangent for x in (-pi/2, pi/2).
fn accurate_tan(x: f32) -> f32 {
    let a = abs(x);
    if a <= 0.785398163 {
        return sign(x) * sin_unit(a) / cos_unit(a);
    }
    // pi/2 in two parts, of which the second is what the first lost
    let rest = (HALF_PI - a) - 4.37113883e-8;
    return sign(x) * cos_unit(rest) / max(sin_unit(rest), 1e-30);
}

// (1 - e^(-y))/y for y of either sign, 1 at 0.
fn phi(y: f32) -> f32 {
    if abs(y) >= 0.5 {
        return (1.0 - exp(-y)) / y;
    }
    let tail = 1.0 - y / 5.0 * (1.0 - y / 6.0 * (1.0 - y / 7.0 * (1.0 - y / 8.0)));
    return 1.0 - y / 2.0 * (1.0 - y / 3.0 * (1.0 - y / 4.0 * tail));
}
