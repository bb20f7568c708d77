//! The participating medium of a scene: coefficients, where it is, how dense, and whether it glows.

use crate::{Aabb, SceneError};
use glam::{DVec3, Vec3};
use media_math::{HomogeneousMedium, PhaseFunction};

/// RGB coefficients of a homogeneous medium in `f32`.
pub type RgbMedium = HomogeneousMedium<f32, [f32; 3]>;

/// How the airlight of a point or spot light is formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AirlightModel {
    /// Sun et al. 2005: light falls off with 1/d² and is attenuated on its way from the light.
    #[default]
    Sun,
    /// Hoffman and Preetham 2003, applied to local lights as Wyman and Ramsey do: the light's intensity counts as an
    /// irradiance, without 1/d² and without extinction on the light's way.
    HoffmanPreetham,
}

/// A participating medium.
///
/// Bounds, density and emission are part of the vocabulary for every technique; one that cannot take them says so
/// with a typed error.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Scattering and absorption where the density is 1; units: m⁻¹.
    pub coefficients: RgbMedium,
    /// Phase function.
    pub phase: PhaseFunction<f32>,
    /// Box outside which there is no medium; without one it is everywhere.
    pub bounds: Option<Aabb>,
    /// Factor on the coefficients over space; without one it is 1.
    pub density: Option<Density>,
    /// Emitted radiance per metre where the density is 1; units: W/(m³·sr).
    pub emission: [f32; 3],
}

impl Medium {
    /// An isotropic medium without bounds, density or emission; coefficients in m⁻¹.
    ///
    /// # Errors
    /// [`SceneError::Medium`] if a coefficient is negative or not finite.
    pub fn homogeneous(sigma_s: [f32; 3], sigma_a: [f32; 3]) -> Result<Self, SceneError> {
        Ok(Self {
            coefficients: RgbMedium::new(sigma_s, sigma_a)?,
            phase: PhaseFunction::ISOTROPIC,
            bounds: None,
            density: None,
            emission: [0.0; 3],
        })
    }

    /// Whether the coefficients are the same everywhere inside the bounds and nothing is emitted.
    pub fn is_homogeneous(&self) -> bool {
        self.density.is_none() && self.emission == [0.0; 3]
    }
}

/// How dense the medium is over space.
#[derive(Debug, Clone, PartialEq)]
pub enum Density {
    /// e^(−max(y − y0, 0)/scale).
    Height {
        /// Height up to which the density is 1; units: m.
        y0: f32,
        /// Height over which it falls to 1/e; units: m.
        scale: f32,
    },
    /// Trilinear between the centres of a grid of cells, clamped to the outermost centres, 0 outside the bounds.
    Grid(DensityGrid),
}

/// Densities on a regular grid over a box; x varies fastest, then y, then z.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityGrid {
    /// Cells along x, y and z.
    pub size: [u32; 3],
    /// The box that the cells fill; units: m.
    pub bounds: Aabb,
    /// One value a cell.
    pub values: Vec<f32>,
}

impl Density {
    /// Density that falls off above height `y0` with scale height `scale`; both in m.
    ///
    /// # Errors
    /// [`SceneError::Density`] if a value is not finite or `scale` is not positive.
    pub fn height(y0: f32, scale: f32) -> Result<Self, SceneError> {
        if y0.is_finite() && scale.is_finite() && scale > 0.0 {
            Ok(Self::Height { y0, scale })
        } else {
            Err(SceneError::Density(format!(
                "y0 must be finite and scale finite and positive, got {y0} and {scale}"
            )))
        }
    }

    /// Density at a point; 1/1.
    pub fn at(&self, point: DVec3) -> f64 {
        match self {
            Self::Height { y0, scale } => (-(point.y - f64::from(*y0)).max(0.0) / f64::from(*scale)).exp(),
            Self::Grid(grid) => grid.at(point),
        }
    }

    /// The largest density anywhere.
    pub fn max(&self) -> f64 {
        match self {
            Self::Height { .. } => 1.0,
            Self::Grid(grid) => f64::from(grid.values.iter().fold(0.0_f32, |a, &b| a.max(b))),
        }
    }
}

impl DensityGrid {
    /// A grid of `size` cells that fill `bounds`.
    ///
    /// # Errors
    /// [`SceneError::Density`] if a side is 0, the box is empty or not finite, the number of values does not match
    /// or a value is negative or not finite.
    pub fn new(size: [u32; 3], bounds: Aabb, values: Vec<f32>) -> Result<Self, SceneError> {
        let bad = |why: String| Err(SceneError::Density(why));
        let cells = size.iter().map(|&n| u64::from(n)).product::<u64>();
        if cells == 0 || cells != values.len() as u64 {
            return bad(format!("a grid of {size:?} cells cannot have {} values", values.len()));
        }
        if !(bounds.min.is_finite() && bounds.max.is_finite() && bounds.min.cmplt(bounds.max).all()) {
            return bad("a grid's bounds must be finite and of positive extent".into());
        }
        if values.iter().any(|&v| !(v.is_finite() && v >= 0.0)) {
            return bad("a grid's values must be finite and at least 0".into());
        }
        Ok(Self { size, bounds, values })
    }

    /// Density at a point: trilinear, 0 outside the bounds.
    pub fn at(&self, point: DVec3) -> f64 {
        if !self.bounds.contains(point) {
            return 0.0;
        }
        let (min, max) = (self.bounds.min.as_dvec3(), self.bounds.max.as_dvec3());
        let cells = DVec3::from_array(self.size.map(f64::from));
        let at = ((point - min) / (max - min) * cells - 0.5).clamp(DVec3::ZERO, cells - 1.0);
        let low = at.floor();
        let f = at - low;
        let value = |dx: f64, dy: f64, dz: f64| {
            let c = (low + DVec3::new(dx, dy, dz)).min(cells - 1.0);
            let index =
                c.x as usize + self.size[0] as usize * (c.y as usize + self.size[1] as usize * c.z as usize);
            f64::from(self.values[index])
        };
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let plane = |dz: f64| {
            mix(
                mix(value(0.0, 0.0, dz), value(1.0, 0.0, dz), f.x),
                mix(value(0.0, 1.0, dz), value(1.0, 1.0, dz), f.x),
                f.y,
            )
        };
        mix(plane(0.0), plane(1.0), f.z)
    }

    /// The shortest side of a cell; units: m.
    pub fn cell(&self) -> f64 {
        let extent = self.bounds.max - self.bounds.min;
        let size = Vec3::from_array(self.size.map(|n| n as f32));
        f64::from((extent / size).min_element())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_reads_cells_at_their_centres() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 1.0, 1.0) };
        let grid = DensityGrid::new([2, 1, 1], bounds, vec![1.0, 3.0]).unwrap();
        assert_eq!(grid.at(DVec3::new(0.5, 0.2, 0.9)), 1.0);
        assert_eq!(grid.at(DVec3::new(1.0, 0.5, 0.5)), 2.0);
        assert_eq!(grid.at(DVec3::new(0.0, 0.5, 0.5)), 1.0);
        assert_eq!(grid.at(DVec3::new(-0.1, 0.5, 0.5)), 0.0);
        assert!(DensityGrid::new([2, 1, 0], bounds, vec![]).is_err());
        assert!(DensityGrid::new([1, 1, 1], bounds, vec![-1.0]).is_err());
        assert!(DensityGrid::new([1, 1, 1], Aabb::EMPTY, vec![1.0]).is_err());
    }

    #[test]
    fn height_fog_by_hand() {
        let fog = Density::height(1.0, 2.0).unwrap();
        assert_eq!(fog.at(DVec3::ZERO), 1.0);
        assert!((fog.at(DVec3::new(0.0, 3.0, 0.0)) - (-1.0_f64).exp()).abs() < 1e-15);
        assert!(Density::height(0.0, 0.0).is_err() && Density::height(f32::NAN, 1.0).is_err());
    }
}
