//! Tables of F, as the papers use them, for comparison.
//!
//! [`FTable`] holds F(u, v) once for all scenes (SRNN05); [`FrameTable`] holds F′(cos γ, x) = A₀ F(A₁, A₂(x)) for one
//! light and medium, so that a step costs one lookup (WR08 §3.4). Both are then *subtracted*, which loses what short
//! intervals have in common: a share of hard cases comes out wrong by more than 10⁻³ whatever the table's size. The
//! interval form of [`airlight`](crate::airlight) is the default for that reason.

use alloc::vec::Vec;

use super::foot::Foot;
use super::special::sun_f;
use crate::{HomogeneousMedium, Real, TableError, airlight_isotropic};

/// How u is spread over a table's columns; w runs over [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warp {
    /// u = w·u_max, clamped above.
    Linear {
        /// The largest u that is resolved.
        u_max: f64,
    },
    /// u/(1 + u) = w: all u ≥ 0.
    Rational,
    /// u/(1 + u) = w²: all u ≥ 0, denser near 0, where F changes like u ln u.
    RationalSquared,
}

impl Warp {
    fn u(self, w: f64) -> f64 {
        match self {
            Self::Linear { u_max } => w * u_max,
            Self::Rational => w / (1.0 - w),
            Self::RationalSquared => w * w / (1.0 - w * w),
        }
    }

    /// Table coordinate of `u`, in [0, 1].
    fn w<T: Real>(self, u: T) -> T {
        match self {
            Self::Linear { u_max } => (u / T::lit(u_max)).min(T::one()),
            Self::Rational => u / (T::one() + u),
            Self::RationalSquared => (u / (T::one() + u)).sqrt(),
        }
    }
}

/// How a table is read between entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear in both directions: 4 entries.
    Bilinear,
    /// Catmull-Rom in both directions: 16 entries.
    Bicubic,
}

/// A grid of values over the unit square, entries on the border included.
#[derive(Debug, Clone, PartialEq)]
struct Grid<T> {
    size: usize,
    values: Vec<T>,
}

impl<T: Real> Grid<T> {
    fn new(size: usize, mut value: impl FnMut(f64, f64) -> f64) -> Result<Self, TableError> {
        if !(2..=16384).contains(&size) {
            return Err(TableError::Size { size });
        }
        let last = (size - 1) as f64;
        let at = |i: usize| i as f64 / last;
        let values = (0..size * size).map(|i| T::lit(value(at(i % size), at(i / size)))).collect();
        Ok(Self { size, values })
    }

    fn entry(&self, x: isize, y: isize) -> T {
        let clamp = |i: isize| i.clamp(0, self.size as isize - 1) as usize;
        self.values[clamp(x) + self.size * clamp(y)]
    }

    fn read(&self, x: T, y: T, interpolation: Interpolation) -> T {
        let last = T::lit((self.size - 1) as f64);
        let (x, y) = (x.max(T::zero()).min(T::one()) * last, y.max(T::zero()).min(T::one()) * last);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (x0, y0) = (x0.to_isize().unwrap_or(0), y0.to_isize().unwrap_or(0));
        let mix = |a: T, b: T, t: T| a + (b - a) * t;
        match interpolation {
            Interpolation::Bilinear => {
                let row = |dy| mix(self.entry(x0, y0 + dy), self.entry(x0 + 1, y0 + dy), fx);
                mix(row(0), row(1), fy)
            }
            Interpolation::Bicubic => {
                let row = |dy| {
                    let e = |dx| self.entry(x0 + dx, y0 + dy);
                    catmull_rom([e(-1), e(0), e(1), e(2)], fx)
                };
                catmull_rom([row(-1), row(0), row(1), row(2)], fy)
            }
        }
    }
}

fn catmull_rom<T: Real>(p: [T; 4], t: T) -> T {
    let c = T::lit;
    let a = c(3.0) * (p[1] - p[2]) + p[3] - p[0];
    let b = c(2.0) * p[0] - c(5.0) * p[1] + c(4.0) * p[2] - p[3];
    p[1] + c(0.5) * t * (p[2] - p[0] + t * (b + t * a))
}

/// F(u, v) over all u ≥ 0 and v in [0, π/2], the same for every scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FTable<T> {
    warp: Warp,
    grid: Grid<T>,
}

impl<T: Real> FTable<T> {
    /// A table of `size` × `size` entries, computed in `f64`.
    ///
    /// # Errors
    /// [`TableError::Size`] unless 2 ≤ `size` ≤ 16384.
    pub fn new(size: usize, warp: Warp) -> Result<Self, TableError> {
        let grid = Grid::new(size, |w, v| {
            let (u, v) = (warp.u(w), v * core::f64::consts::FRAC_PI_2);
            if u.is_finite() { sun_f(u, v) } else { 0.0 }
        })?;
        Ok(Self { warp, grid })
    }

    /// F(u, v) from the table.
    pub fn f(&self, u: T, v: T, interpolation: Interpolation) -> T {
        self.grid.read(self.warp.w(u), v / T::FRAC_PI_2(), interpolation)
    }

    /// Entries a side.
    pub fn size(&self) -> usize {
        self.grid.size
    }

    /// Airlight I₀A₀[F(A₁, A₂(x₁)) − F(A₁, A₂(x₀))] of an isotropic medium.                  (WR08 Eq. 2 to 5)
    ///
    /// Deviation: A₀'s exponent and A₁ take σ_t where the paper prints κ_s. Arguments as for
    /// [`airlight`](crate::airlight), one channel; NaN or infinite where A₀ is.
    pub fn airlight(
        &self,
        sigma_s: T,
        sigma_t: T,
        intensity: T,
        foot: &Foot<T>,
        x0: T,
        x1: T,
        interpolation: Interpolation,
    ) -> T {
        literal_airlight(sigma_s, sigma_t, intensity, foot, x0, x1, |u, v| self.f(u, v, interpolation))
    }
}

/// I₀A₀[F(A₁, A₂(x₁)) − F(A₁, A₂(x₀))] as printed, with any F.                              (WR08 Eq. 2 to 5)
///
/// With an exact F it is the bound for every table. See [`FTable::airlight`].
pub fn literal_airlight<T: Real>(
    sigma_s: T,
    sigma_t: T,
    intensity: T,
    foot: &Foot<T>,
    x0: T,
    x1: T,
    f: impl Fn(T, T) -> T,
) -> T {
    let a0 = sigma_s * (-sigma_t * foot.x_foot).exp() / (T::TAU() * foot.h);
    let a1 = sigma_t * foot.h;
    let a2 = |x: T| T::FRAC_PI_4() + T::lit(0.5) * ((x - foot.x_foot) / foot.h).atan();
    intensity * a0 * (f(a1, a2(x1)) - f(a1, a2(x0)))
}

/// F′(cos γ, x) = A₀ F(A₁, A₂(x)).                                                         (WR08 §3.4)
fn f_prime<T: Real>(sigma_s: T, sigma_t: T, light_distance: T, cos_gamma: T, x: T) -> T {
    let h = light_distance * (T::one() - cos_gamma * cos_gamma).sqrt();
    let x_foot = light_distance * cos_gamma;
    let a0 = sigma_s * (-sigma_t * x_foot).exp() / (T::TAU() * h);
    let a2 = T::FRAC_PI_4() + T::lit(0.5) * ((x - x_foot) / h).atan();
    a0 * sun_f(sigma_t * h, a2)
}

/// F′(cos γ, x) = A₀ F(A₁, A₂(x)) for one eye, light and medium.                            (WR08 §3.4)
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTable<T> {
    x_max: f64,
    grid: Grid<T>,
}

impl<T: Real> FrameTable<T> {
    /// A table of `size` × `size` entries over cos γ in [−1, 1] and x in [0, `x_max`] metres, for a light
    /// `light_distance` metres from the eye; coefficients in m⁻¹.
    ///
    /// A₀ grows without bound towards cos γ = ±1; the outermost columns are read half an entry inside.
    ///
    /// # Errors
    /// [`TableError::Size`] unless 2 ≤ `size` ≤ 16384; [`TableError::Value`] if a coefficient is negative or not finite, or
    /// a distance not positive and finite.
    pub fn new(
        size: usize,
        sigma_s: f64,
        sigma_t: f64,
        light_distance: f64,
        x_max: f64,
    ) -> Result<Self, TableError> {
        check_problem(sigma_s, sigma_t, light_distance)?;
        check_distance("an end", x_max)?;
        let inset = 1.0 - 1.0 / size.max(2) as f64;
        let grid = Grid::new(size, |w, x| {
            let cos_gamma = (2.0 * w - 1.0).clamp(-inset, inset);
            f_prime(sigma_s, sigma_t, light_distance, cos_gamma, x * x_max)
        })?;
        Ok(Self { x_max, grid })
    }

    /// Airlight I₀[F′(cos γ, x₁) − F′(cos γ, x₀)]; distances beyond the table's end count as its end.
    pub fn airlight(&self, intensity: T, cos_gamma: T, x0: T, x1: T) -> T {
        let at = |x: T| {
            let x = x / T::lit(self.x_max);
            self.grid.read(T::lit(0.5) * (cos_gamma + T::one()), x, Interpolation::Bilinear)
        };
        intensity * (at(x1) - at(x0))
    }
}

fn check_distance(name: &'static str, value: f64) -> Result<(), TableError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(TableError::Value { name, value, needed: "positive and finite, in metres" })
    }
}

/// Coefficients and a distance for which airlight is defined.
fn check_problem(sigma_s: f64, sigma_t: f64, light_distance: f64) -> Result<(), TableError> {
    for (name, value) in [("a sigma_s", sigma_s), ("a sigma_t", sigma_t)] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(TableError::Value { name, value, needed: "at least 0 and finite" });
        }
    }
    check_distance("a light's distance", light_distance)
}

/// A per-frame table like [`FrameTable`] without its singularity: a better parametrisation of the same lookup.
///
/// Over the angle ψ at the light between the eye and the point at distance x,
///
/// ```text
/// L(0, x) = κ_s I₀/(4π h) ∫₀^ψ e^(−κ_t(d + x)) dψ′ = κ_s I₀/(4π h) · ψ · M(γ, ψ/(π − γ))
/// ```
///
/// M is a mean of exponentials between 0 and 1 for every ray, cos γ = ±1 included, and is what the table holds; ψ/h, which
/// diverges, is computed. The last row is the ray without end. Short intervals still are differences of two such values.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleTable<T> {
    light_distance: f64,
    sigma_s: f64,
    grid: Grid<T>,
}

impl<T: Real> AngleTable<T> {
    /// A table of `size` × `size` entries over γ in [0, π] and all x ≥ 0, for a light `light_distance` metres from the
    /// eye; coefficients in m⁻¹.
    ///
    /// # Errors
    /// [`TableError::Size`] unless 2 ≤ `size` ≤ 16384; [`TableError::Value`] if a coefficient is negative or not finite, or
    /// the distance not positive and finite.
    pub fn new(size: usize, sigma_s: f64, sigma_t: f64, light_distance: f64) -> Result<Self, TableError> {
        check_problem(sigma_s, sigma_t, light_distance)?;
        // with unit scattering, so that a medium that only absorbs has a table too
        let medium =
            HomogeneousMedium::with_extinction(1.0, sigma_t).map_err(|_| TableError::Size { size })?;
        let grid =
            Grid::new(size, |column, row| mean_over_angle::<f64>(&medium, light_distance, column, row))?;
        Ok(Self { light_distance, sigma_s, grid })
    }

    /// Airlight between distances `x0` and `x1` (m, the second may be infinite) of an isotropic medium, for the ray that
    /// passes the light at `foot`.
    pub fn airlight(&self, intensity: T, foot: &Foot<T>, x0: T, x1: T) -> T {
        let distance = T::lit(self.light_distance);
        // a ray along the way from the light has no angle at all
        let h = foot.h.max(T::lit(LEAST_ANGLE) * distance);
        let gamma = h.atan2(foot.x_foot);
        let whole = T::PI() - gamma;
        // ψ M at a distance
        let at = |x: T| {
            let psi = if x.is_finite() {
                // |eye − light| is the same for all rays: h² + a₀ a(x) = d² − x x_f
                (h * x).atan2(distance * distance - x * foot.x_foot)
            } else {
                whole
            };
            psi * self.grid.read(gamma / T::PI(), psi / whole, Interpolation::Bilinear)
        };
        T::lit(self.sigma_s) * intensity / (T::lit(4.0) * T::PI() * h) * (at(x1) - at(x0))
    }
}

/// Nearest that γ comes to 0 and π; units: rad.
const LEAST_ANGLE: f64 = 1e-6;

/// M at shares of γ in [0, π] and of ψ in [0, π − γ], in a medium of unit scattering.
fn mean_over_angle<T: Real>(medium: &HomogeneousMedium<T>, light_distance: T, column: T, row: T) -> T {
    // on the axis itself the angle is 0 or π at once: a little beside it the mean is the same
    let least = T::lit(LEAST_ANGLE);
    let gamma = (column * T::PI()).max(least).min(T::PI() - least);
    let foot = Foot { x_foot: light_distance * gamma.cos(), h: light_distance * gamma.sin() };
    let psi = row * (T::PI() - gamma);
    if psi < T::lit(1e-9) {
        return (-medium.sigma_t() * light_distance).exp();
    }
    // law of sines; at the last row the ray is parallel to the way from the light
    let x = if row < T::one() { light_distance * psi.sin() / (gamma + psi).sin() } else { T::infinity() };
    airlight_isotropic(medium, T::one(), &foot, T::zero(), x) * T::lit(4.0) * T::PI() * foot.h / psi
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_table_is_right_next_to_the_axis_too() {
        let medium = HomogeneousMedium::<f64>::new(0.05, 0.02).unwrap();
        let table = AngleTable::<f64>::new(256, 0.05, 0.07, 5.0).unwrap();
        let printed = FrameTable::<f64>::new(256, 0.05, 0.07, 5.0, 20.0).unwrap();
        let (mut worst, mut worst_printed) = (0.0_f64, 0.0_f64);
        for gamma in [1e-4_f64, 0.003, 0.05, 0.7, 1.5, 2.4, 3.1, 3.1401] {
            let foot = Foot { x_foot: 5.0 * gamma.cos(), h: 5.0 * gamma.sin() };
            for (x0, x1) in [(0.0, 20.0), (1.0, 15.0), (0.0, f64::INFINITY), (2.0, 4.5)] {
                let exact = airlight_isotropic(&medium, 3.0, &foot, x0, x1);
                worst = worst.max((table.airlight(3.0, &foot, x0, x1) / exact - 1.0).abs());
                let literal = printed.airlight(3.0, gamma.cos(), x0, x1.min(20.0));
                worst_printed = worst_printed.max((literal / exact - 1.0).abs());
            }
        }
        assert!(worst < 2e-3 && worst_printed > 50.0 * worst, "{worst} against {worst_printed}");
        assert!(AngleTable::<f64>::new(1, 0.05, 0.07, 5.0).is_err());
    }

    #[test]
    fn entries_map_onto_themselves() {
        for warp in [Warp::Linear { u_max: 10.0 }, Warp::Rational, Warp::RationalSquared] {
            let table = FTable::<f64>::new(17, warp).unwrap();
            for i in 0..17 {
                for j in 0..16 {
                    let (u, v) =
                        (warp.u(f64::from(j) / 16.0), f64::from(i) / 16.0 * core::f64::consts::FRAC_PI_2);
                    for interpolation in [Interpolation::Bilinear, Interpolation::Bicubic] {
                        assert!((table.f(u, v, interpolation) - sun_f(u, v)).abs() < 1e-12);
                    }
                }
            }
        }
        assert!(FTable::<f32>::new(1, Warp::Rational).is_err());
        assert!(FTable::<f32>::new(1 << 20, Warp::Rational).is_err());
    }

    #[test]
    fn larger_tables_and_better_reads_are_better() {
        let medium = HomogeneousMedium::<f64>::new(0.05, 0.02).unwrap();
        let foot = Foot { x_foot: 3.0, h: 2.0 };
        let exact = airlight_isotropic(&medium, 1.0, &foot, 0.0, 12.0);
        let error = |size, interpolation| {
            let table = FTable::<f64>::new(size, Warp::RationalSquared).unwrap();
            (table.airlight(0.05, 0.07, 1.0, &foot, 0.0, 12.0, interpolation) / exact - 1.0).abs()
        };
        let (small, large) = (error(32, Interpolation::Bilinear), error(256, Interpolation::Bilinear));
        assert!(large < small && large < 1e-3, "{small} {large}");
        assert!(error(256, Interpolation::Bicubic) < 1e-5);
        let exact_f = literal_airlight(0.05, 0.07, 1.0, &foot, 0.0, 12.0, sun_f);
        assert!((exact_f / exact - 1.0).abs() < 1e-13);
    }

    #[test]
    fn an_angle_table_is_finite_on_the_axis() {
        let table = AngleTable::<f64>::new(64, 0.05, 0.07, 5.0).unwrap();
        let medium = HomogeneousMedium::new(0.05, 0.02).unwrap();
        // straight away from the light: there the integral is finite
        let foot = Foot { x_foot: -5.0, h: 0.0 };
        for end in [4.0, f64::INFINITY] {
            let (got, exact) =
                (table.airlight(3.0, &foot, 0.0, end), airlight_isotropic(&medium, 3.0, &foot, 0.0, end));
            assert!((got / exact - 1.0).abs() < 0.01, "{got} {exact}");
        }
        assert!(table.airlight(3.0, &Foot { x_foot: 5.0, h: 0.0 }, 0.0, 9.0).is_finite());
    }

    #[test]
    fn tables_of_nonsense_are_refused() {
        let frame = |s, t, d, end| FrameTable::<f32>::new(8, s, t, d, end);
        assert!(frame(0.1, 0.2, 3.0, 20.0).is_ok() && frame(0.0, 0.0, 3.0, 20.0).is_ok());
        assert!(matches!(frame(0.1, 0.2, 3.0, 0.0), Err(TableError::Value { name: "an end", .. })));
        for (s, t, d, end) in [(-0.1, 0.2, 3.0, 9.0), (0.1, f64::NAN, 3.0, 9.0), (0.1, 0.2, 0.0, 9.0)] {
            assert!(frame(s, t, d, end).is_err() && AngleTable::<f32>::new(8, s, t, d).is_err());
        }
        assert!(frame(0.1, 0.2, 3.0, f64::INFINITY).is_err());
    }

    #[test]
    fn frame_table_is_right_away_from_the_axis() {
        let medium = HomogeneousMedium::<f64>::new(0.05, 0.02).unwrap();
        let table = FrameTable::<f64>::new(512, 0.05, 0.07, 5.0, 20.0).unwrap();
        for cos_gamma in [-0.7_f64, 0.1, 0.8] {
            let foot = Foot { x_foot: 5.0 * cos_gamma, h: 5.0 * (1.0 - cos_gamma * cos_gamma).sqrt() };
            let exact = airlight_isotropic(&medium, 3.0, &foot, 1.0, 15.0);
            let got = table.airlight(3.0, cos_gamma, 1.0, 15.0);
            assert!((got / exact - 1.0).abs() < 1e-3, "{got} {exact}");
        }
        // finite where A₀ is not
        assert!(table.airlight(3.0, 1.0, 0.0, 20.0).is_finite());
    }
}
