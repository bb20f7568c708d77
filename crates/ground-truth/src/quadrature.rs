//! Adaptive quadrature of three channels at once.

use glam::DVec3;
use media_math::quadrature::gauss_legendre;

/// Most bisections of one integral: those that the hardest reference cases take are a few hundred.
const MOST_SPLITS: u32 = 1 << 14;

/// ∫_a^b f to `tolerance`, relative to the whole; both ends finite.
///
/// With 8 nodes where 4 agree with them, which between the texels of a light's picture they nearly always do, with 12 where
/// 8 do; else by bisection until 12 nodes agree with twice 12.
///
/// Ends with what it has after [`MOST_SPLITS`], and where a value is not finite: what never agrees would otherwise take
/// all of the 2⁴⁰ pieces that the depth allows.
pub(crate) fn adaptive(f: &mut impl FnMut(f64) -> DVec3, a: f64, b: f64, tolerance: f64) -> DVec3 {
    let mut whole = rule(f, 4, a, b);
    for nodes in [8, 12] {
        let coarse = std::mem::replace(&mut whole, rule(f, nodes, a, b));
        if (whole - coarse).abs().max_element() <= tolerance * whole.abs().max_element() {
            return whole;
        }
    }
    let mut left_over = MOST_SPLITS;
    split(f, a, b, whole, tolerance * whole.abs().max_element(), 40, &mut left_over)
}

fn rule(f: &mut impl FnMut(f64) -> DVec3, nodes: usize, a: f64, b: f64) -> DVec3 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    gauss_legendre::<f64>(nodes).fold(DVec3::ZERO, |sum, (x, w)| sum + w * f(middle + half * x)) * half
}

fn split(
    f: &mut impl FnMut(f64) -> DVec3,
    a: f64,
    b: f64,
    coarse: DVec3,
    allowed: f64,
    depth: u32,
    left_over: &mut u32,
) -> DVec3 {
    let middle = 0.5 * (a + b);
    let (left, right) = (rule(f, 12, a, middle), rule(f, 12, middle, b));
    let fine = left + right;
    // the floor: below it the rules differ by rounding alone
    let close = (fine - coarse).abs().max_element() <= allowed.max(1e-15 * fine.abs().max_element());
    if depth == 0 || *left_over == 0 || close || !fine.is_finite() {
        return fine;
    }
    *left_over -= 1;
    // the error does not halve with the interval: a peak keeps it, and the rest has none
    split(f, a, middle, left, allowed, depth - 1, left_over)
        + split(f, middle, b, right, allowed, depth - 1, left_over)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_narrow_peak() {
        let h = 1e-4;
        let mut f = |x: f64| DVec3::new(h / (x * x + h * h), 1.0, (-x).exp());
        let got = adaptive(&mut f, -1.0, 3.0, 1e-10);
        let exact = DVec3::new((3.0 / h).atan() + (1.0 / h).atan(), 4.0, 1.0_f64.exp() - (-3.0_f64).exp());
        assert!((got / exact - 1.0).abs().max_element() < 1e-9, "{got} {exact}");
    }

    #[test]
    fn ends_where_nothing_agrees() {
        // not a number, too large for one, and noise
        let got = adaptive(&mut |x| DVec3::splat(if x > 0.3 { f64::NAN } else { 1.0 }), 0.0, 1.0, 1e-10);
        assert!(got.is_nan());
        let got = adaptive(&mut |_| DVec3::splat(f64::INFINITY), 0.0, 1.0, 1e-10);
        assert!(!got.is_finite());
        let mut count = 0_u32;
        let noise = |_| {
            count += 1;
            DVec3::splat(f64::from(count.wrapping_mul(2_654_435_761) >> 8))
        };
        assert!(adaptive(&mut { noise }, 0.0, 1.0, 1e-10).is_finite());
        assert!(count < 100 * MOST_SPLITS, "{count}");
    }
}
