//! Times at equal error.

/// The x at which a falling curve of (x, error) first reaches `target`, interpolated in logarithms.
pub(super) fn interpolate(points: impl Iterator<Item = (f64, f64)>, target: f64) -> Option<f64> {
    let mut before: Option<(f64, f64)> = None;
    for (x, error) in points {
        if error <= target {
            let Some((x0, e0)) = before else { return Some(x) };
            let t = (e0 / target).ln() / (e0 / error.max(1e-300)).ln();
            return Some(x0 * (x / x0).powf(t));
        }
        before = Some((x, error));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_is_logarithmic() {
        let curve = [(10.0, 0.1), (100.0, 0.01), (1000.0, 0.001)];
        let at = |target| interpolate(curve.into_iter(), target);
        assert!((at(0.01).unwrap() - 100.0).abs() < 1e-9);
        assert!((at(0.0316227766).unwrap() - 31.6227766).abs() < 1e-5);
        assert_eq!((at(0.5), at(1e-4)), (Some(10.0), None));
    }
}
