//! Adaptive quadrature of three channels at once.

use glam::DVec3;
use media_math::quadrature::gauss_legendre;

/// ∫_a^b f by bisection until 8 and 12 nodes agree to `tolerance`, relative to the whole; both ends finite.
pub(crate) fn adaptive(f: &mut impl FnMut(f64) -> DVec3, a: f64, b: f64, tolerance: f64) -> DVec3 {
    let whole = rule(f, 12, a, b);
    split(f, a, b, whole, tolerance * whole.abs().max_element(), 40)
}

fn rule(f: &mut impl FnMut(f64) -> DVec3, nodes: usize, a: f64, b: f64) -> DVec3 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    gauss_legendre::<f64>(nodes).fold(DVec3::ZERO, |sum, (x, w)| sum + w * f(middle + half * x)) * half
}

fn split(f: &mut impl FnMut(f64) -> DVec3, a: f64, b: f64, coarse: DVec3, allowed: f64, depth: u32) -> DVec3 {
    let middle = 0.5 * (a + b);
    let (left, right) = (rule(f, 12, a, middle), rule(f, 12, middle, b));
    let fine = left + right;
    // the floor: below it the rules differ by rounding alone
    let close = (fine - coarse).abs().max_element() <= allowed.max(1e-15 * fine.abs().max_element());
    if depth == 0 || close {
        return fine;
    }
    // the error does not halve with the interval: a peak keeps it, and the rest has none
    split(f, a, middle, left, allowed, depth - 1) + split(f, middle, b, right, allowed, depth - 1)
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
}
