//! The march through a textured spot light's cone, in three segments.
//!
//! (Wyman and Ramsey 2008, sections 3.2 and 3.3): where a picture colours the light, the intensity is no constant of a
//! lit piece, and steps are needed in the light too. A ray is clipped to the cone and cut at the frontmost and the
//! backmost face of the shadow volumes; before and behind them it is lit, so that only the steps between them ask for
//! visibility, and each segment has a number of steps of its own.
//!
//! A step counts with the picture's mean over it ([`LightMips::line`]) and the falloff's (Simpson's rule over its ends
//! and its middle), times its airlight in light of unit intensity, which is exact.
//!
//! ```text
//!           cone     frontmost face      backmost face     cone
//!   eye o----|=============|- - - - - - - - -|==============|----> view ray
//!                  lit         visibility?          lit
//! ```

use glam::{DVec3, Vec3};
use media_math::{Foot, airlight, directional_airlight};
use scene::{AirlightModel, DRay, Interval, LightId, Medium, Refusal, SpotCone, SpotLight};

use crate::{LightMips, Marched, Occluders};

/// How far inside a segment its ends are asked for light, as a share of it: off the surface that may bound it.
const INSIDE: f64 = 1e-3;

/// Where the steps of a segment lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// Steps of equal length. A segment without end has none: there it is [`Placement::EqualAngle`].
    EqualDistance,
    /// Steps of equal angle seen from the light.
    ///
    /// The picture is a function of direction, so each step crosses a like share of it, and of 1/d²
    /// (Wyman and Ramsey 2008, Fig. 4 right and section 3.4). In Hoffman and Preetham's model, which has no 1/d²,
    /// equal distances need about half as many steps.
    #[default]
    EqualAngle,
}

/// The march through one spot light's cone.
#[derive(Debug, Clone, Copy)]
pub struct TexturedMarch<'a> {
    medium: &'a Medium,
    light: &'a SpotLight,
    cone: SpotCone<'a>,
    id: LightId,
    /// The light's picture at every size; `None`: the picture itself at each step's middle.
    pub mips: Option<&'a LightMips>,
    /// What casts shadows; `None` if nothing does.
    pub occluders: Option<Occluders<'a>>,
    /// Steps before, between and behind the shadow volumes' faces.
    pub samples: [u32; 3],
    /// Where the steps of a segment lie.
    pub placement: Placement,
    /// Further lookups that bisect each boundary of shadow found between two steps.
    pub refine: u32,
    /// Whether faces are those of a part of the casters: visibility is then asked outside of them too.
    pub partial: bool,
    /// How airlight is formed.
    pub model: AirlightModel,
}

/// A step: a piece of the ray and the distance in its middle, at which visibility is asked.
#[derive(Debug, Clone, Copy)]
struct Step {
    start: f64,
    middle: f64,
    end: f64,
}

/// A lookup's answer.
#[derive(Debug, Clone, Copy)]
struct Known {
    at: f64,
    visibility: f32,
}

/// The light as one ray sees it.
struct Aspect {
    ray: DRay,
    light: DVec3,
    /// Distance along the ray of the point nearest to the light, and the light's from the ray; units: m.
    foot: Foot<f64>,
}

impl<'a> TexturedMarch<'a> {
    /// The march of `light`, whose shadows are asked for as `id`: 50 steps a segment as in the paper, of equal angle,
    /// boundaries not bisected, Sun's model, no mips and no occluders. Set the fields to change that.
    ///
    /// # Errors
    /// [`Refusal`] if the medium has a density or bounds, or emits.
    pub fn new(medium: &'a Medium, light: &'a SpotLight, id: LightId) -> Result<Self, Refusal> {
        let refusal = |feature| Refusal { technique: "hybrid", feature, instead: "brute-force" };
        if medium.density.is_some() {
            return Err(refusal("a heterogeneous density"));
        }
        if medium.emission != [0.0; 3] {
            return Err(refusal("an emitting medium"));
        }
        if medium.bounds.is_some() {
            return Err(refusal("a bounded medium"));
        }
        Ok(Self {
            medium,
            light,
            cone: light.cone(),
            id,
            mips: None,
            occluders: None,
            samples: [50; 3],
            placement: Placement::default(),
            refine: 0,
            partial: false,
            model: AirlightModel::default(),
        })
    }

    /// Airlight of the light along `ray` up to `end` metres (may be infinite).
    ///
    /// `faces` holds the distances along the ray of the frontmost and the backmost shadow-volume face; `None` where
    /// the ray meets none, which is then one segment of `samples[0]` steps. A segment beside the faces asks for
    /// visibility after all if it is dark at its outer end, or the last one at its beginning: that is a camera inside
    /// a volume, or a surface that ends the ray inside one.
    pub fn airlight(&self, ray: &DRay, end: f64, faces: Option<Interval>) -> Marched {
        let mut sum = Marched::default();
        let span = self.light.clip(ray, Interval::new(0.0, end));
        // also for an end that is no number
        if !(span.end > span.start) || self.medium.coefficients.is_clear() {
            return sum;
        }
        let aspect = Aspect::new(ray, self.light);
        let mut radiance = DVec3::ZERO;
        // the visibility that was found last, and where
        let mut known = Known { at: span.start, visibility: 1.0 };
        for (i, segment) in segments(span, faces).into_iter().enumerate() {
            if segment.is_empty() {
                continue;
            }
            let shadowed = match (i, faces) {
                (1, _) => true,
                _ if self.partial => true,
                (0, Some(_)) => self.is_dark(&aspect, segment, INSIDE, &mut sum),
                _ => {
                    self.is_dark(&aspect, segment, INSIDE, &mut sum)
                        || self.is_dark(&aspect, segment, 1.0 - INSIDE, &mut sum)
                }
            };
            if !shadowed {
                radiance += self.correction(
                    &aspect,
                    known,
                    Known { at: segment.start, visibility: 1.0 },
                    segment.start,
                    &mut sum,
                );
                known = Known { at: segment.end, visibility: 1.0 };
            }
            for step in self.steps(&aspect, segment, self.samples[i]) {
                sum.samples += 1;
                let visibility = if shadowed { self.visibility(&aspect, step.middle, &mut sum) } else { 1.0 };
                if visibility > 0.0 {
                    radiance += f64::from(visibility) * self.step_airlight(&aspect, step.start, step.end);
                }
                if shadowed {
                    let found = Known { at: step.middle, visibility };
                    radiance += self.correction(&aspect, known, found, step.start, &mut sum);
                    known = found;
                }
            }
        }
        sum.airlight = radiance.as_vec3();
        sum
    }

    /// What the steps before and after `border` got wrong where visibility changes between two lookups: its boundary is
    /// bisected, and the piece between that and the border changes sides.
    fn correction(
        &self,
        aspect: &Aspect,
        known: Known,
        found: Known,
        border: f64,
        sum: &mut Marched,
    ) -> DVec3 {
        if known.visibility == found.visibility || self.refine == 0 || !found.at.is_finite() {
            return DVec3::ZERO;
        }
        let (mut low, mut high) = (known.at, found.at);
        for _ in 0..self.refine {
            let middle = 0.5 * (low + high);
            if self.visibility(aspect, middle, sum) == known.visibility {
                low = middle;
            } else {
                high = middle;
            }
        }
        let boundary = 0.5 * (low + high);
        let change = f64::from(found.visibility - known.visibility);
        if boundary < border {
            change * self.step_airlight(aspect, boundary, border)
        } else {
            -change * self.step_airlight(aspect, border, boundary)
        }
    }

    fn visibility(&self, aspect: &Aspect, x: f64, sum: &mut Marched) -> f32 {
        let Some(occluders) = &self.occluders else { return 1.0 };
        sum.rays += 1;
        occluders.visibility.visibility(aspect.ray.at(x).as_vec3(), self.id)
    }

    /// Whether shadow falls on the point at `share` of a segment.
    fn is_dark(&self, aspect: &Aspect, segment: Interval, share: f64, sum: &mut Marched) -> bool {
        self.visibility(aspect, self.place(aspect, segment, share), sum) < 1.0
    }

    /// The distance at `share` of a segment, in the measure in which its steps are equal.
    fn place(&self, aspect: &Aspect, segment: Interval, share: f64) -> f64 {
        if self.placement == Placement::EqualDistance && segment.end.is_finite() {
            segment.start + share * segment.length()
        } else {
            aspect.at_angle(segment, share)
        }
    }

    /// `count` steps over a segment.
    fn steps(&self, aspect: &Aspect, segment: Interval, count: u32) -> impl Iterator<Item = Step> {
        let at = move |i: u32| match i {
            0 => segment.start,
            i if i == count => segment.end,
            i => self.place(aspect, segment, f64::from(i) / f64::from(count)),
        };
        (0..count).map(move |i| {
            let (start, end) = (at(i), at(i + 1));
            Step { start, middle: self.middle(aspect, start, end), end }
        })
    }

    /// The middle of a step: as much airlight on either side, but for what varies slowly.
    fn middle(&self, aspect: &Aspect, start: f64, end: f64) -> f64 {
        if self.model == AirlightModel::HoffmanPreetham && end.is_finite() {
            0.5 * (start + end)
        } else {
            aspect.half_angle(start, end)
        }
    }

    /// Airlight of a lit step; units: W/(m²·sr).
    fn step_airlight(&self, aspect: &Aspect, start: f64, end: f64) -> DVec3 {
        let step = Step { start, middle: self.middle(aspect, start, end), end };
        let (x0, x1) = (start as f32, end as f32);
        let coefficients = &self.medium.coefficients;
        let factor = |x: f64| {
            let w = aspect.light_to(x);
            let falloff = self.cone.falloff(w.dot(self.light.direction.as_dvec3()) / w.length());
            match self.model {
                AirlightModel::Sun => falloff,
                AirlightModel::HoffmanPreetham => falloff * self.phase(aspect, w),
            }
        };
        let mean = (factor(step.start) + 4.0 * factor(step.middle) + factor(step.end)) / 6.0;
        let intensity = (mean * self.colour(aspect, step) * self.light.intensity.as_dvec3()).as_vec3();
        let airlight: Vec3 = match self.model {
            AirlightModel::Sun => {
                let foot = Foot { x_foot: aspect.foot.x_foot as f32, h: aspect.foot.h as f32 };
                airlight(coefficients, &self.medium.phase, intensity.to_array(), &foot, x0, x1).into()
            }
            // the phase function is in the mean
            AirlightModel::HoffmanPreetham => {
                directional_airlight(coefficients, 1.0, intensity.to_array(), x0, x1).into()
            }
        };
        airlight.as_dvec3()
    }

    /// Phase value where light travels along `w`; units: sr⁻¹.
    fn phase(&self, aspect: &Aspect, w: DVec3) -> f64 {
        let to_light = -w.normalize_or_zero();
        let view = aspect.ray.direction;
        f64::from(self.medium.phase.value_between(to_light.as_vec3().to_array(), view.as_vec3().to_array()))
    }

    /// The picture's mean colour over a step.
    fn colour(&self, aspect: &Aspect, step: Step) -> DVec3 {
        let point = |x: f64| self.cone.texture_coordinates(aspect.light_to(x));
        if let Some(mips) = self.mips {
            return mips.line(point(step.start), point(step.end));
        }
        let (u, v) = point(step.middle);
        self.light.texture.as_ref().map_or(DVec3::ONE, |texture| texture.sample(u, v))
    }
}

/// A span before, between and behind the faces.
fn segments(span: Interval, faces: Option<Interval>) -> [Interval; 3] {
    let faces = faces.unwrap_or(Interval::new(span.end, span.end));
    // in this order the cuts are sorted and inside the span, whatever the faces are
    let front = faces.start.max(span.start).min(span.end);
    let back = faces.end.max(front).min(span.end);
    [Interval::new(span.start, front), Interval::new(front, back), Interval::new(back, span.end)]
}

impl Aspect {
    fn new(ray: &DRay, light: &SpotLight) -> Self {
        let light = light.position.as_dvec3();
        let to = light - ray.origin;
        let foot = Foot::new(to.to_array(), ray.direction.to_array());
        // a ray through the light itself has infinite airlight: move it aside by a rounding
        let least = (1e-12 * to.length()).max(1e-12);
        Self { ray: *ray, light, foot: Foot { h: foot.h.max(least), ..foot } }
    }

    /// The way from the light to the ray at distance `x`, of any length but 0; of an infinite distance, its direction.
    fn light_to(&self, x: f64) -> DVec3 {
        let w = self.ray.at(x) - self.light;
        if w.is_finite() && w != DVec3::ZERO { w } else { self.ray.direction }
    }

    /// Distance from the light to the ray at `x`; units: m.
    fn distance(&self, x: f64) -> f64 {
        (x - self.foot.x_foot).hypot(self.foot.h)
    }

    /// The distance along the ray at which `share` of the angle has passed that a segment spans, seen from the light.
    ///
    /// With a = x − x_f and δ the angle from the segment's start, x(δ) = x₀ + d₀² sin δ/(h cos δ − a₀ sin δ), and the
    /// whole angle is atan2(h L, h² + a₀a₁): no difference of nearly equal angles where the light is near the ray.
    fn at_angle(&self, segment: Interval, share: f64) -> f64 {
        let h = self.foot.h;
        let a = segment.start - self.foot.x_foot;
        let length = segment.length();
        let whole =
            if length.is_finite() { (h * length).atan2(h * h + a * (a + length)) } else { h.atan2(a) };
        let (sin, cos) = (share * whole).sin_cos();
        let x = segment.start + (h * h + a * a) * sin / (h * cos - a * sin);
        // rounding at a far end may pass it
        if x >= segment.start && x <= segment.end { x } else { segment.end }
    }

    /// The distance that halves the angle between two: it divides their length as d₀ to d₁.
    fn half_angle(&self, start: f64, end: f64) -> f64 {
        let near = self.distance(start);
        if end.is_infinite() {
            return start + near;
        }
        start + (end - start) * near / (near + self.distance(end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BruteForce;
    use scene::{Aabb, Density, Light, Visibility};

    /// Dark between two heights.
    struct Slab(f32, f32);

    impl Visibility for Slab {
        fn visibility(&self, point: Vec3, _light: LightId) -> f32 {
            if point.y > self.0 && point.y < self.1 { 0.0 } else { 1.0 }
        }
    }

    fn occluders(slab: &Slab) -> Occluders<'_> {
        Occluders { visibility: slab, bounds: Aabb { min: Vec3::splat(-9.0), max: Vec3::splat(9.0) } }
    }

    fn spot() -> SpotLight {
        SpotLight::new(Vec3::new(3.0, 0.0, 0.0), Vec3::NEG_X, 0.4, 0.8, Vec3::new(3.0, 2.0, 1.0)).unwrap()
    }

    fn fog() -> Medium {
        Medium::homogeneous([0.1, 0.2, 0.3], [0.02; 3]).unwrap()
    }

    /// Upwards through the cone, which it enters at y ≈ −3 and leaves at y ≈ 3.
    fn ray() -> DRay {
        DRay { origin: DVec3::new(0.0, -5.0, 0.1), direction: DVec3::Y }
    }

    #[test]
    fn varying_media_are_refused() {
        let (light, fog, id) = (spot(), fog(), LightId(0));
        assert!(TexturedMarch::new(&fog, &light, id).is_ok());
        for (medium, feature) in [
            (Medium { density: Some(Density::height(0.0, 1.0).unwrap()), ..fog.clone() }, "density"),
            (Medium { emission: [1.0; 3], ..fog.clone() }, "emitting"),
            (Medium { bounds: Some(Aabb { min: Vec3::ZERO, max: Vec3::ONE }), ..fog.clone() }, "bounded"),
        ] {
            let refusal = TexturedMarch::new(&medium, &light, id).unwrap_err();
            assert!(refusal.technique == "hybrid" && refusal.feature.contains(feature), "{refusal}");
        }
    }

    #[test]
    fn without_a_picture_it_is_the_plain_march() {
        let (light, fog) = (spot(), fog());
        let lights = [Light::Spot(light.clone())];
        for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
            for end in [6.0, f64::INFINITY] {
                let plain =
                    BruteForce { medium: &fog, lights: &lights, occluders: None, samples: 4000, model }
                        .airlight(&ray(), end);
                for placement in [Placement::EqualAngle, Placement::EqualDistance] {
                    let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
                    (march.model, march.placement) = (model, placement);
                    let got = march.airlight(&ray(), end, None);
                    let error = (got.airlight / plain.airlight - 1.0).abs().max_element();
                    assert!(error < 1e-3, "{model:?} {placement:?} to {end}: {error}");
                    assert_eq!((got.samples, got.rays), (50, 0));
                }
            }
        }
    }

    #[test]
    fn steps_are_even_and_fit_together() {
        let (light, fog) = (spot(), fog());
        let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
        let aspect = Aspect::new(&ray(), &light);
        for end in [9.0, f64::INFINITY] {
            let segment = Interval::new(0.5, end);
            let steps: Vec<Step> = march.steps(&aspect, segment, 7).collect();
            assert!(steps[0].start == 0.5 && steps[6].end == end);
            assert!(steps.windows(2).all(|pair| pair[0].end == pair[1].start));
            let angle = |x: f64| ((x - aspect.foot.x_foot) / aspect.foot.h).atan();
            let whole = angle(end) - angle(0.5);
            for step in steps {
                assert!((angle(step.end) - angle(step.start) - whole / 7.0).abs() < 1e-12);
                assert!((angle(step.middle) - angle(step.start) - whole / 14.0).abs() < 1e-12);
            }
        }
        march.placement = Placement::EqualDistance;
        let steps: Vec<Step> = march.steps(&aspect, Interval::new(1.0, 8.0), 7).collect();
        assert!(steps.iter().all(|step| (step.end - step.start - 1.0).abs() < 1e-12));
    }

    #[test]
    fn only_the_middle_segment_asks() {
        let (light, fog, slab) = (spot(), fog(), Slab(-0.5, 0.5));
        let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
        march.occluders = Some(occluders(&slab));
        march.samples = [4, 16, 8];
        let marched = march.airlight(&ray(), 20.0, Some(Interval::new(4.5, 5.5)));
        // three lookups find that neither end of the ray is dark
        assert_eq!((marched.samples, marched.rays), (28, 19));
        march.occluders = None;
        let lit = march.airlight(&ray(), 20.0, None).airlight;
        let dark = {
            let x0 = march.airlight(&ray(), 4.5, None).airlight;
            lit - (march.airlight(&ray(), 5.5, None).airlight - x0)
        };
        assert!(marched.airlight.max_element() < 0.9 * lit.max_element());
        assert!((marched.airlight / dark - 1.0).abs().max_element() < 0.02, "{} {dark}", marched.airlight);
    }

    #[test]
    fn a_dark_end_of_the_ray_is_marched() {
        let (light, fog) = (spot(), fog());
        let exact = |from: f64, to: f64| {
            let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
            march.samples = [1000; 3];
            march.airlight(&ray(), to, None).airlight - march.airlight(&ray(), from, None).airlight
        };
        let airlight = |slab: Slab, faces: Option<Interval>, end: f64| {
            let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
            march.occluders = Some(occluders(&slab));
            march.samples = [400; 3];
            march.airlight(&ray(), end, faces).airlight
        };
        let check = |name: &str, got: Vec3, exact: Vec3| {
            assert!((got - exact).abs().max_element() < 0.01 * exact.max_element(), "{name}: {got} {exact}");
        };
        // the camera inside a volume, which ends at y = −1: the only face is a back face
        let face = |x: f64| Some(Interval::new(x, x));
        check("start", airlight(Slab(-9.0, -1.0), face(4.0), 20.0), exact(4.0, 20.0));
        // a surface inside a volume: the only face is a front face
        check("end", airlight(Slab(1.0, 9.0), face(6.0), 7.0), exact(0.0, 6.0));
        // no face at all, but all of the ray in one volume
        assert_eq!(airlight(Slab(-9.0, 9.0), None, 20.0), Vec3::ZERO);
        assert_eq!(airlight(Slab(0.0, 0.0), None, 20.0), airlight(Slab(0.0, 0.0), face(30.0), 20.0));
    }

    #[test]
    fn hard_rays_stay_finite() {
        let (fog, slab) = (fog(), Slab(-0.1, 0.1));
        let texture = scene::LightTexture::new(2, 1, vec![[1.0; 3], [0.5; 3]], Default::default()).unwrap();
        for outer in [0.01_f32, 0.8, 1.57] {
            let mut light = spot();
            (light.inner, light.outer) = (0.5 * outer, outer);
            light.texture = Some(std::sync::Arc::new(texture.clone()));
            let mips = LightMips::new(&texture, 0.0);
            let at = light.position.as_dvec3();
            let rays = [
                // from the light, through it, along its axis, away from it, past it by nearly nothing
                DRay { origin: at, direction: DVec3::NEG_X },
                DRay { origin: at, direction: DVec3::new(-1.0, 0.4, 0.0).normalize() },
                DRay { origin: at + 5.0 * DVec3::X, direction: DVec3::NEG_X },
                DRay { origin: DVec3::ZERO, direction: DVec3::X },
                DRay { origin: DVec3::ZERO, direction: DVec3::NEG_X },
                DRay { origin: DVec3::new(-1e5, 1e-6, 0.0), direction: DVec3::X },
            ];
            for ray in &rays {
                for end in [1e-9, 4.0, f64::INFINITY, f64::NAN] {
                    let faces = [None, Some(Interval::new(0.5, 2.0)), Some(Interval::new(f64::NAN, -3.0))];
                    for (faces, samples) in faces.into_iter().zip([[3; 3], [0, 1, 5], [1; 3]]) {
                        for model in [AirlightModel::Sun, AirlightModel::HoffmanPreetham] {
                            for placement in [Placement::EqualAngle, Placement::EqualDistance] {
                                let mut march = TexturedMarch::new(&fog, &light, LightId(0)).unwrap();
                                march.mips = Some(&mips);
                                march.occluders = Some(occluders(&slab));
                                (march.samples, march.model, march.placement) = (samples, model, placement);
                                let airlight = march.airlight(ray, end, faces).airlight;
                                assert!(
                                    airlight.is_finite() && airlight.min_element() >= 0.0,
                                    "{ray:?} to {end}, {march:?}: {airlight}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}
