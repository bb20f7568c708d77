//! One light as one ray sees it: steps along the ray, and the airlight of its pieces.

use glam::Vec3;
use media_math::{
    Foot, HomogeneousMedium, PhaseFunction, airlight, airlight_anisotropic, directional_airlight,
};
use scene::{DRay, Interval, Light, Medium, SpotCone, SpotLight};

/// The least extinction of the channels that are attenuated at all; infinite in clear air.
pub(crate) fn least_extinction(coefficients: &HomogeneousMedium<f32, [f32; 3]>) -> f64 {
    let attenuated = coefficients.sigma_t().into_iter().filter(|&sigma_t| sigma_t > 0.0);
    f64::from(attenuated.fold(f32::INFINITY, f32::min))
}

/// A step of a march; the last one of an infinite ray has no end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) start: f64,
    /// Where visibility is asked.
    pub(crate) middle: f64,
    pub(crate) end: f64,
}

/// One light as one ray sees it.
pub(crate) struct Piece<'a> {
    coefficients: HomogeneousMedium<f32, [f32; 3]>,
    phase: PhaseFunction<f32>,
    light: &'a Light,
    /// Of a spot light.
    cone: Option<SpotCone<'a>>,
    ray: DRay,
    foot: Foot<f32>,
    /// Phase value of a directional light.
    sun_phase: f32,
    /// Where the medium begins; units: m.
    entry: f64,
}

impl<'a> Piece<'a> {
    pub(crate) fn new(medium: &Medium, light: &'a Light, ray: &DRay, entry: f64) -> Self {
        let local = |position: Vec3| {
            let to = position.as_dvec3() - ray.at(entry);
            let foot = Foot::new(to.to_array(), ray.direction.to_array());
            // a ray through the light itself has infinite airlight: move it aside by a rounding
            let least = (1e-12 * to.length()).max(1e-12);
            Foot { x_foot: foot.x_foot as f32, h: foot.h.max(least) as f32 }
        };
        let (foot, sun_phase) = match light {
            Light::Point(light) => (local(light.position), 0.0),
            Light::Spot(light) => (local(light.position), 0.0),
            Light::Directional(light) => {
                let (to_light, view) = (-light.direction.as_dvec3(), ray.direction);
                let phase = medium.phase.widen().value_between(to_light.to_array(), view.to_array());
                (Foot { x_foot: 0.0, h: 1.0 }, phase as f32)
            }
        };
        Self {
            coefficients: medium.coefficients,
            phase: medium.phase,
            light,
            cone: light.cone(),
            ray: *ray,
            foot,
            sun_phase,
            entry,
        }
    }

    /// `samples` steps over a span.
    ///
    /// Equal ones, as in the paper, where the span ends. Along an infinite ray, where there are none, steps of equal
    /// angle at a local light, and of equal transmittance for a directional one: either way each holds a like share
    /// of the airlight. A local light's angles also divide a span that was cut from an `endless` one.
    pub(crate) fn steps(
        &self,
        span: Interval,
        samples: u32,
        endless: bool,
    ) -> impl Iterator<Item = Step> + use<> {
        let samples = if span.is_empty() { 0 } else { samples };
        let (count, infinite) = (f64::from(samples), span.end.is_infinite());
        let (x_foot, h) = (self.entry + f64::from(self.foot.x_foot), f64::from(self.foot.h));
        let sigma_t = least_extinction(&self.coefficients);
        let angle_at = |x: f64| ((x - x_foot) / h).atan();
        let (angle, last_angle) = (angle_at(span.start), angle_at(span.end));
        let directional = matches!(self.light, Light::Directional(_));
        let at = move |i: f64| {
            let t = i / count;
            if !infinite && (directional || !endless) {
                span.start + (span.end - span.start) * t
            } else if directional {
                span.start - (-t).ln_1p() / sigma_t
            } else {
                x_foot + h * (angle + (last_angle - angle) * t).tan()
            }
        };
        (0..samples).map(move |i| {
            let i = f64::from(i);
            let end = if i + 1.0 == count { span.end } else { at(i + 1.0) };
            Step { start: if i == 0.0 { span.start } else { at(i) }, middle: at(i + 0.5), end }
        })
    }

    /// Airlight of a fully lit piece, times `factor`.
    pub(crate) fn airlight(&self, start: f64, end: f64, factor: Vec3) -> Vec3 {
        if end <= start {
            return Vec3::ZERO;
        }
        let (x0, x1) = ((start - self.entry) as f32, (end - self.entry) as f32);
        let intensity = match self.light {
            Light::Point(light) => factor * light.intensity,
            Light::Spot(light) => return factor * self.spot_airlight(light, start, end),
            Light::Directional(light) => {
                let irradiance = (factor * light.irradiance).to_array();
                return directional_airlight(&self.coefficients, self.sun_phase, irradiance, x0, x1).into();
            }
        };
        airlight(&self.coefficients, &self.phase, intensity.to_array(), &self.foot, x0, x1).into()
    }

    /// Airlight of a lit piece in the light of a spot without a picture: of constant intensity inside the inner cone, by
    /// quadrature of its falloff outside.
    fn spot_airlight(&self, light: &SpotLight, start: f64, end: f64) -> Vec3 {
        let inner = light.clip_within(&self.ray, Interval::new(start, end), f64::from(light.inner));
        let x = |at: f64| (at - self.entry) as f32;
        let falloff = |from: f64, to: f64| {
            if to <= from {
                return Vec3::ZERO;
            }
            let intensity = |at: f32, _| self.intensity_at(f64::from(at) + self.entry).to_array();
            airlight_anisotropic(&self.coefficients, &self.phase, &self.foot, x(from), x(to), intensity)
                .into()
        };
        if inner.is_empty() {
            return falloff(start, end);
        }
        let intensity = light.intensity.to_array();
        let middle =
            airlight(&self.coefficients, &self.phase, intensity, &self.foot, x(inner.start), x(inner.end));
        falloff(start, inner.start) + Vec3::from(middle) + falloff(inner.end, end)
    }

    /// Intensity of a local light towards the ray at distance `x`; units: W/sr.
    pub(crate) fn intensity_at(&self, x: f64) -> Vec3 {
        match self.light {
            Light::Point(light) => light.intensity,
            Light::Spot(light) => {
                let w = self.ray.at(x) - light.position.as_dvec3();
                self.cone.map_or(Vec3::ZERO, |cone| cone.intensity_towards(w).as_vec3())
            }
            Light::Directional(light) => light.irradiance,
        }
    }

    /// Phase value at distance `x`; units: sr⁻¹.
    pub(crate) fn phase_at(&self, x: f64) -> f32 {
        if let Light::Directional(_) = self.light {
            return self.sun_phase;
        }
        let a = (x - self.entry) as f32 - self.foot.x_foot;
        let d = a.hypot(self.foot.h);
        let r = if a < 0.0 { self.foot.h * (self.foot.h / (d - a)) } else { d + a };
        self.phase.at(r, self.foot.h)
    }

    /// ∫ dx/d² over a step; units: 1/m.
    pub(crate) fn inverse_square(&self, step: Step) -> f64 {
        let h = f64::from(self.foot.h);
        let a = step.start - self.entry - f64::from(self.foot.x_foot);
        let width = step.end - step.start;
        (h * width).atan2(h * h + a * (a + width)) / h
    }
}
