//! G(z) = Im[e^z E₁(z)], the tail of the airlight integral.
//!
//! With z = σ_t(R − ih), 1/(1 + t²) = Im 1/(t − i) turns the airlight integral from R to infinity into an exponential
//! integral: ∫_R^∞ h e^(−σ_t(s − R))/(h² + s²) ds = G(z). Re z ≥ 0 and Im z ≤ 0 always, so the path stays clear of
//! E₁'s cut on the negative axis, and the scaling by e^z removes every overflow. G is positive and falls with R.

use crate::Real;

/// Euler's constant.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Poles and weights of G(x − ib)/b ≈ Σ w/((x + p)² + b²), a positive rule for ∫ e^(−t)/((x + t)² + b²) dt.
///
/// Fitted here by least squares with reweighting towards the largest relative error over 1 ≤ |z| ≤ 1000; it errs by at
/// most 2.4·10⁻⁸ there, below the rounding of `f32`. Six poles reach 5·10⁻⁶, which the difference of two tails may
/// double.
const POLES: [(f64, f64); 8] = [
    (0.0406021412386992, 0.09990966649164869),
    (0.21317265968005705, 0.19506812466604564),
    (0.5274840054784787, 0.23135271114015765),
    (1.0157129094732502, 0.21681939591663432),
    (1.7656473571429108, 0.15881987625982838),
    (2.9448157972849596, 0.07775062782115422),
    (4.85646969856221, 0.019007903868668158),
    (8.181689317817366, 0.0012716701902700256),
];

/// G/h at σ_t > 0, path excess `r` and light offset `h` > 0; units: 1/length.
///
/// |z| below [`Real::SERIES_RADIUS`]: power series. Beyond: in `f32` a sum of real poles, which needs no complex
/// arithmetic, cancels nothing and holds at h = 0; in `f64` a continued fraction. An infinite `r` gives 0.
#[inline]
pub(crate) fn tail_over_h<T: Real>(sigma_t: T, r: T, h: T) -> T {
    let (x, b) = (sigma_t * r, sigma_t * h);
    if x == T::infinity() {
        return T::zero();
    }
    if x.max(b) < T::lit(T::SERIES_RADIUS) && x * x + b * b < T::lit(T::SERIES_RADIUS * T::SERIES_RADIUS) {
        return series(x, b, h.atan2(r)) / h;
    }
    let over_b = if T::USE_POLES { poles(x, b) } else { continued_fraction(x, b) };
    sigma_t * over_b
}

/// G(x − ib) by E₁(z) = −γ − ln z − Σ (−z)^k/(k·k!); `angle` is −arg z.
#[inline]
fn series<T: Real>(x: T, b: T, angle: T) -> T {
    let mut power = (T::one(), T::zero()); // (−z)^k/k!
    let mut sum = (T::zero(), T::zero());
    for k in 1..=T::SERIES_TERMS {
        let inverse = T::one() / T::lit(k as f64);
        // (p + iq)(−x + ib)
        power = ((-power.0 * x - power.1 * b) * inverse, (power.0 * b - power.1 * x) * inverse);
        sum = (sum.0 + power.0 * inverse, sum.1 + power.1 * inverse);
    }
    let (long, short) = (x.max(b), x.min(b));
    let ratio = short / long;
    let log_abs = long.ln() + T::lit(0.5) * (ratio * ratio).ln_1p();
    let real = -T::lit(EULER_GAMMA) - log_abs - sum.0;
    let imaginary = angle - sum.1;
    x.exp() * (b.cos() * imaginary - b.sin() * real)
}

/// G(x − ib)/b for |z| ≥ 1 as Σ w/((x + p)² + b²).
#[inline]
fn poles<T: Real>(x: T, b: T) -> T {
    POLES.iter().fold(T::zero(), |sum, &(pole, weight)| {
        let shifted = x + T::lit(pole);
        sum + T::lit(weight) / (shifted * shifted + b * b)
    })
}

/// G(x − ib)/b for |z| ≥ 3 by the even part of E₁'s continued fraction,
/// e^z E₁ = 1/(z + 1 − 1/(z + 3 − 4/(z + 5 − 9/(z + 7 − …)))), evaluated from the back.
///
/// The imaginary part is carried divided by b, so that it keeps its digits as h → 0.
fn continued_fraction<T: Real>(x: T, b: T) -> T {
    let size = x.max(b).to_f64().unwrap_or(f64::INFINITY);
    // measured: enough for 1e-16 at |z| ≥ 3
    let levels = if size < 6.0 {
        64
    } else if size < 20.0 {
        36
    } else {
        16
    };
    // denominator of the level below: re + i·b·im
    let mut re = x + T::lit(f64::from(2 * levels + 1));
    let mut im = -T::one();
    for k in (1..=levels).rev() {
        let n2 = T::lit(f64::from(k * k));
        let scale = n2 / (re * re + b * b * im * im);
        // n²/(re + ib·im) = n²(re − ib·im)/|…|²
        re = x + T::lit(f64::from(2 * k - 1)) - scale * re;
        im = -T::one() + scale * im;
    }
    -im / (re * re + b * b * im * im)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::adaptive;

    /// ∫_R^∞ e^(−σ(s − R))/(h² + s²) ds over the variable y of e^y = 1 + (s − R)/(R + h).
    fn by_quadrature(sigma: f64, r: f64, h: f64) -> f64 {
        let from = r + h;
        let end = (1.0 + (40.0 / sigma) / from).ln();
        adaptive(
            &mut |y| {
                let s = r + from * y.exp_m1();
                (-sigma * (s - r)).exp() / (h * h + s * s) * from * y.exp()
            },
            0.0,
            end,
            1e-14,
            30,
        )
    }

    #[test]
    fn all_branches_agree_with_the_integral() {
        let (mut worst, mut worst32) = (0.0_f64, 0.0_f64);
        for i in 0..40 {
            for j in 0..40 {
                let r = 10.0_f64.powf(-4.0 + 0.2 * f64::from(i));
                let h = 10.0_f64.powf(-4.0 + 0.2 * f64::from(j));
                let exact = by_quadrature(1.0, r, h);
                worst = worst.max((tail_over_h(1.0, r, h) / exact - 1.0).abs());
                // the rounding of r and h to f32 is no part of the error
                let (r, h) = (r as f32, h as f32);
                let exact = by_quadrature(1.0, f64::from(r), f64::from(h));
                worst32 = worst32.max((f64::from(tail_over_h(1.0, r, h)) / exact - 1.0).abs());
            }
        }
        assert!(worst < 3e-13, "f64: {worst:e}");
        assert!(worst32 < 4e-6, "f32: {worst32:e}");
    }

    #[test]
    fn limits() {
        assert_eq!(tail_over_h(0.5, f64::INFINITY, 1.0), 0.0);
        // thin: the angle that is left
        assert!((tail_over_h(1e-14, 2.0, 3.0) * 3.0 / 3.0_f64.atan2(2.0) - 1.0).abs() < 1e-12);
        // no offset: 1/R − σ e^(σR) E₁(σR) stays finite
        assert!(tail_over_h(1.0_f32, 1.0, 1e-15).is_finite() && tail_over_h(1.0_f64, 4.0, 0.0) > 0.0);
    }
}
