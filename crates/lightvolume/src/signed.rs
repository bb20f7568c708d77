//! Airlight as the paper sums it: one term for each boundary, in any order.                           (BSA10 Eq. 3)

use media_math::{Boundary, CompensatedSum, Real};
use scene::{AirlightModel, DRay, Interval, Light, LightId, Medium, Refusal};

use crate::LightVolumes;
use crate::lamp::{Haze, Lamp};

/// From which end of a ray the terms of the sum are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Anchor {
    /// Σ s_n L(start, x_n), as the paper has it.
    #[default]
    Near,
    /// L(start, end) where the start is lit, less Σ s_n L(x_n, end): smaller terms where boundaries lie far ahead.
    Far,
}

/// Airlight of view rays among light volumes as an unordered signed sum, in the precision `T`.
///
/// What additive blending of the volume's triangles comes to. Every term is rounded before it is added, so that in `f32`
/// the sum errs by about 10⁻⁵ of the *unshadowed* airlight, and may be slightly negative. On a CPU boundaries can be
/// sorted: [`LightVolumes`] as [`LitIntervals`](scene::LitIntervals) gives the pieces whose airlight is a sum of positive
/// terms.
#[derive(Debug)]
pub struct SignedAirlight<'a, T> {
    volumes: &'a LightVolumes<'a>,
    haze: Haze<T>,
    anchor: Anchor,
}

impl<'a, T: Real> SignedAirlight<'a, T> {
    /// Prepares the sum for a medium.
    ///
    /// # Errors
    /// As [`SignedAirlight::check`].
    pub fn new(medium: &Medium, volumes: &'a LightVolumes<'a>, anchor: Anchor) -> Result<Self, Refusal> {
        Self::check(medium, volumes.lights(), AirlightModel::Sun)?;
        Ok(Self { volumes, haze: Haze::new(medium), anchor })
    }

    /// Whether the sum can take a medium, lights and model.
    ///
    /// # Errors
    /// [`Refusal`] if the medium is heterogeneous, glows or has bounds, if a spot has a picture (the paper's own limit), or
    /// for Hoffman and Preetham's model of a local light: there a term is no closed form.
    pub fn check(medium: &Medium, lights: &[Light], model: AirlightModel) -> Result<(), Refusal> {
        let feature = if medium.density.is_some() {
            "a heterogeneous density"
        } else if medium.emission != [0.0; 3] {
            "an emitting medium"
        } else if medium.bounds.is_some() {
            "a bounded medium"
        } else if lights.iter().any(|light| matches!(light, Light::Spot(spot) if spot.texture.is_some())) {
            "a textured spot light"
        } else if model == AirlightModel::HoffmanPreetham
            && lights.iter().any(|light| !matches!(light, Light::Directional(_)))
        {
            "Hoffman and Preetham's model for a local light"
        } else {
            return Ok(());
        };
        Err(Refusal { technique: "light-volume", feature, instead: "brute-force" })
    }

    /// Airlight of all lights along `ray` up to `end` metres (may be infinite); units: W/(m²·sr).
    pub fn airlight(&self, ray: &DRay, end: f64) -> [T; 3] {
        let mut boundaries = Vec::new();
        let mut sums = [CompensatedSum::new(); 3];
        for light in 0..self.volumes.lights().len() {
            self.light(ray, end, LightId(light), &mut boundaries, &mut sums);
        }
        sums.map(|sum| sum.total())
    }

    /// Adds the terms of one light.
    fn light(
        &self,
        ray: &DRay,
        end: f64,
        id: LightId,
        boundaries: &mut Vec<Boundary<f64>>,
        sums: &mut [CompensatedSum<T>; 3],
    ) {
        let span = self.volumes.boundaries(ray, Interval::new(0.0, end), id, boundaries);
        if span.is_empty() {
            return;
        }
        let lamp = Lamp::new(&self.haze, &self.volumes.lights()[id.0], ray, span.start);
        let mut add = |sign: T, term: [T; 3]| {
            sums.iter_mut().zip(term).for_each(|(sum, term)| sum.add(sign * term));
        };
        if self.anchor == Anchor::Near {
            for boundary in boundaries {
                add(T::lit(boundary.sign()), lamp.airlight(span.start, boundary.distance));
            }
            return;
        }
        let lit: f64 = boundaries.iter().map(Boundary::sign).sum();
        if lit != 0.0 {
            add(T::lit(lit), lamp.airlight(span.start, span.end));
        }
        for boundary in boundaries {
            add(-T::lit(boundary.sign()), lamp.airlight(boundary.distance, span.end));
        }
    }
}
