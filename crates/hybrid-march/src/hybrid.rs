//! The hybrid of shadow volumes and ray marching (Wyman and Ramsey 2008, section 3.1).
//!
//! A march looks for shadows only between the frontmost and the backmost side face of a light's shadow volume on the ray;
//! before the one and behind the other everything is lit, and a ray without faces takes no step at all. A ray that starts
//! or ends in shadow meets no face there, so visibility is asked at its ends as well.
//!
//! ```text
//!           frontmost face      backmost face
//!   eye o--------|- - - - - - - - -|-------------|surface
//!         lit        visibility?        lit
//! ```
//!
//! The march's own error is where it believes the boundaries between the faces to be: each may be bisected by further
//! lookups, which costs few where the boundaries are few.

use glam::Vec3;
use scene::{AirlightModel, DRay, Interval, Light, LightId, Medium, Refusal, SpotLight};

use crate::brute_force::{Marched, Occluders};
use crate::light_mips::LightMips;
use crate::piece::{Piece, least_extinction};
use crate::textured::{Placement, TexturedMarch};

/// How far before its end a ray is asked whether it ends in shadow, as a share of its length: a surface's own triangle
/// must not answer.
const BEFORE_END: f64 = 1e-6;

/// How far behind its start a ray without faces is asked whether it starts in shadow, as a share of the ray.
const BEHIND_START: f64 = 1e-4;

/// Bisections, at least, of the boundary behind the faces of a ray that ends in shadow.
const LEAST_TAIL: u32 = 8;

/// Optical depth behind which no step is taken on an endless ray: e^(−16) is 10⁻⁷.
const MARCH_DEPTH: f64 = 16.0;

/// What a march between faces needs to know about a frame.
#[derive(Clone, Copy)]
pub struct Hybrid<'a> {
    medium: &'a Medium,
    lights: &'a [Light],
    occluders: Option<Occluders<'a>>,
    samples: u32,
    refine: u32,
    model: AirlightModel,
    /// Steps in each of the lit segments before and behind the faces, for spots that have no closed form along a ray:
    /// textured ones, and all in Hoffman and Preetham's model.
    pub lit_samples: u32,
    /// Where steps lie. Endless rays have no steps of equal length, and directional lights none of equal angle.
    pub placement: Placement,
    /// The picture of each light at every size, by its index; `None`, or no entry, to read it at each step's middle.
    pub mips: &'a [Option<LightMips>],
    /// Whether `faces` are those of a part of the casters: shadows are then looked up in all of a spot's cone, as if the
    /// others were in its picture (section 5). Lights of other kinds are marched along the whole ray.
    pub partial: bool,
}

impl std::fmt::Debug for Hybrid<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Hybrid")
            .field("lights", &self.lights.len())
            .field("samples", &self.samples)
            .field("refine", &self.refine)
            .finish_non_exhaustive()
    }
}

impl<'a> Hybrid<'a> {
    /// A march of `samples` steps between the faces of each light's shadow volume, with `refine` bisections of every
    /// boundary found; `occluders` is `None` if nothing casts a shadow.
    ///
    /// Through the cone of a spot that has no closed form along a ray it goes as [`TexturedMarch`] does: there are as many
    /// steps in light as between the faces, of equal angle, without mips. Set the fields to change that.
    ///
    /// # Errors
    /// As [`Hybrid::check`].
    pub fn new(
        medium: &'a Medium,
        lights: &'a [Light],
        occluders: Option<Occluders<'a>>,
        samples: u32,
        refine: u32,
        model: AirlightModel,
    ) -> Result<Self, Refusal> {
        Self::check(medium, lights, model)?;
        Ok(Self {
            medium,
            lights,
            occluders,
            samples,
            refine,
            model,
            lit_samples: samples,
            placement: Placement::default(),
            mips: &[],
            partial: false,
        })
    }

    /// Whether the hybrid can take a medium and lights.
    ///
    /// # Errors
    /// [`Refusal`] if the medium is heterogeneous, glows or has bounds, or if there is a point light in Hoffman and
    /// Preetham's model, which has no closed form for it and no cone to march through.
    pub fn check(medium: &Medium, lights: &[Light], model: AirlightModel) -> Result<(), Refusal> {
        let feature = if medium.density.is_some() {
            "a heterogeneous density"
        } else if medium.emission != [0.0; 3] {
            "an emitting medium"
        } else if medium.bounds.is_some() {
            "a bounded medium"
        } else if model == AirlightModel::HoffmanPreetham
            && lights.iter().any(|light| matches!(light, Light::Point(_)))
        {
            "Hoffman and Preetham's model for a point light"
        } else {
            return Ok(());
        };
        Err(Refusal { technique: "hybrid", feature, instead: "brute-force" })
    }

    /// Whether a spot's cone is marched in light too: its intensity has no closed form along a ray, or its shadows may lie
    /// anywhere.
    fn marches_in_light(&self, spot: &SpotLight) -> bool {
        spot.texture.is_some() || self.model == AirlightModel::HoffmanPreetham || self.partial
    }

    /// Airlight of all lights along `ray` up to `end` metres (may be infinite).
    ///
    /// `faces` holds, for each light by its index, the distances along the ray of the frontmost and the backmost side
    /// face ([`FaceBounds::at`](crate::FaceBounds::at), [`ShadowVolume::faces`](crate::ShadowVolume::faces)), which may
    /// lie beyond `end`; `None`, or no entry, where the ray meets none. A ray that starts in shadow is right without, but
    /// marched to its end.
    pub fn airlight(&self, ray: &DRay, end: f64, faces: &[Option<Interval>]) -> Marched {
        let mut sum = Marched::default();
        if self.medium.coefficients.is_clear() {
            return sum;
        }
        for (i, light) in self.lights.iter().enumerate() {
            let (id, faces) = (LightId(i), faces.get(i).copied().flatten());
            let piece = match light {
                Light::Spot(spot) if self.marches_in_light(spot) => {
                    self.march_textured(ray, end, id, spot, faces, &mut sum);
                    continue;
                }
                Light::Spot(spot) => spot.clip(ray, Interval::new(0.0, end)),
                _ => Interval::new(0.0, end),
            };
            // also for an end that is no number
            if piece.end > piece.start {
                self.march(ray, piece, id, faces, &mut sum);
            }
        }
        sum
    }

    fn march_textured(
        &self,
        ray: &DRay,
        end: f64,
        id: LightId,
        spot: &SpotLight,
        faces: Option<Interval>,
        sum: &mut Marched,
    ) {
        // refuses what `new` has refused already
        let Ok(mut march) = TexturedMarch::new(self.medium, spot, id) else { return };
        march.occluders = self.occluders;
        march.mips = self.mips.get(id.0).and_then(Option::as_ref);
        march.samples = [self.lit_samples, self.samples, self.lit_samples];
        (march.placement, march.refine) = (self.placement, self.refine);
        (march.model, march.partial) = (self.model, self.partial);
        let marched = march.airlight(ray, end, faces);
        sum.airlight += marched.airlight;
        sum.samples += marched.samples;
        sum.rays += marched.rays;
    }

    /// The part of the ray in which the light shines.
    fn march(&self, ray: &DRay, piece: Interval, id: LightId, faces: Option<Interval>, sum: &mut Marched) {
        let aspect = Piece::new(self.medium, &self.lights[id.0], ray, 0.0);
        let mut walk = Walk {
            hybrid: self,
            ray,
            id,
            aspect: &aspect,
            state: 1.0,
            from: piece.start,
            seen_at: piece.start,
            sum,
        };
        let between = walk.between(piece, faces);
        walk.state = between.first;
        if let Some(marched) = between.marched {
            walk.seen_at = marched.start;
            // on an endless ray the backmost face may be so far that steps of equal length would pass all else
            let angles = self.placement == Placement::EqualAngle || piece.end.is_infinite();
            for step in aspect.steps(marched, self.samples, angles) {
                walk.sum.samples += 1;
                let visibility = walk.visibility(step.middle);
                walk.step_to(step.middle, visibility, step.start, self.refine);
            }
            if let Some(last) = between.last {
                walk.step_to(marched.end, last, marched.end, self.refine);
            }
        }
        if let Some(dark) = between.tail {
            walk.step_to(piece.end, dark, piece.end, self.refine.max(LEAST_TAIL));
        }
        walk.finish(piece.end);
    }
}

/// What lies between the faces of a ray, and what is known outside.
struct Between {
    /// Where steps are taken; `None` if nothing may be shadowed.
    marched: Option<Interval>,
    /// Visibility just behind where the piece starts.
    first: f32,
    /// Visibility where the march ends, if it is known.
    last: Option<f32>,
    /// Visibility at the end of a ray that is lit behind the faces and dark there.
    tail: Option<f32>,
}

/// A march along one ray in one light: runs of equal visibility, each evaluated once.
struct Walk<'w, 'a> {
    hybrid: &'w Hybrid<'a>,
    ray: &'w DRay,
    id: LightId,
    aspect: &'w Piece<'w>,
    /// Visibility of the run.
    state: f32,
    /// Where the run starts.
    from: f64,
    /// Where its visibility was last seen.
    seen_at: f64,
    sum: &'w mut Marched,
}

impl Walk<'_, '_> {
    fn visibility(&mut self, x: f64) -> f32 {
        let Some(occluders) = &self.hybrid.occluders else { return 1.0 };
        self.sum.rays += 1;
        occluders.visibility.visibility(self.ray.at(x).as_vec3(), self.id)
    }

    fn between(&mut self, piece: Interval, faces: Option<Interval>) -> Between {
        // of a part of the casters faces say nothing; without occluders nothing is shadowed, whatever they say
        let faces = if self.hybrid.partial { Some(piece) } else { faces };
        let faces = faces.filter(|_| self.hybrid.occluders.is_some());
        let front = faces.map(|faces| faces.start.clamp(piece.start, piece.end));
        let first = self.at_start(piece, front);
        let mut between = Between { marched: None, first, last: None, tail: None };
        let Some(faces) = faces else {
            if self.hybrid.occluders.is_some() {
                // nothing changes along the ray; but a shadow ray may slip through between two triangles: one answer does
                // not decide it
                let (dark, at_end) = self.behind(piece, piece.length());
                if dark || between.first < 1.0 {
                    between.marched = Some(piece);
                    between.last = at_end;
                } else {
                    between.tail = at_end.filter(|&seen| seen < 1.0);
                }
            }
            return between;
        };
        let back = faces.end.clamp(piece.start, piece.end);
        let (goes_on, at_end) = self.behind(Interval::new(back, piece.end), piece.length());
        let front = front.filter(|_| between.first == 1.0).unwrap_or(piece.start);
        let end = if goes_on { piece.end } else { self.seen_until(back, piece) };
        between.marched = Some(Interval::new(front.min(end), end));
        between.last = if goes_on { at_end } else { Some(1.0) };
        between.tail = at_end.filter(|&seen| !goes_on && seen < 1.0);
        between
    }

    /// What is seen where the ray starts: before its frontmost face, at `front`, nothing changes, so it is asked halfway.
    /// Not at the eye: there all rays would get one answer, and a wrong one where it lies on a face or in line with an edge.
    fn at_start(&mut self, piece: Interval, front: Option<f64>) -> f32 {
        let ahead = Interval::new(piece.start, front.unwrap_or(piece.end));
        // the middle of the first of so many steps
        let steps = if front.is_some() { 1 } else { (0.5 / BEHIND_START) as u32 };
        let step = self.aspect.steps(ahead, steps, false).next();
        self.visibility(step.map_or(piece.start, |step| step.middle))
    }

    /// Whether the ray is dark behind its faces, so that the march goes on to its end, and what is seen just before a
    /// finite end; `length` is that of the whole piece.
    ///
    /// Behind the backmost face nothing changes before the surface that ends the ray. So it is asked halfway: at the face
    /// rounding would answer, and so it may just before the surface.
    fn behind(&mut self, rest: Interval, length: f64) -> (bool, Option<f32>) {
        let at_end = rest.end.is_finite().then(|| self.visibility(rest.end - BEFORE_END * length));
        if rest.end.is_infinite() && self.seen_until(rest.start, rest) < rest.start {
            return (false, None);
        }
        let halfway = self.aspect.steps(rest, 1, false).next();
        (halfway.is_none_or(|step| self.visibility(step.middle) < 1.0), at_end)
    }

    /// How much of the way to a face is worth steps: a face of an endless ray may be thousands of scenes away.
    fn seen_until(&self, back: f64, piece: Interval) -> f64 {
        if piece.end.is_infinite() {
            back.min(MARCH_DEPTH / least_extinction(&self.hybrid.medium.coefficients))
        } else {
            back
        }
    }

    /// Goes on to `x`, where `visibility` was seen; where that is another than the run's, the run ends at `border`, or at
    /// the boundary that `bisections` lookups find between there and where the run's visibility was last seen.
    fn step_to(&mut self, x: f64, visibility: f32, border: f64, bisections: u32) {
        if visibility != self.state {
            let border =
                if bisections > 0 && x.is_finite() { self.bisect(x, border, bisections) } else { border };
            self.finish(border);
            (self.from, self.state) = (border, visibility);
        }
        self.seen_at = x;
    }

    /// The end of the run's visibility before `x`. A `border` at either end is that of a face: it is kept if no lookup
    /// finds the boundary farther from it than the last ones reach.
    fn bisect(&mut self, x: f64, border: f64, bisections: u32) -> f64 {
        let (mut low, mut high) = (self.seen_at, x);
        for _ in 0..bisections {
            let middle = 0.5 * (low + high);
            if self.visibility(middle) == self.state {
                low = middle;
            } else {
                high = middle;
            }
        }
        if border == low || border == high { border } else { 0.5 * (low + high) }
    }

    /// Adds the airlight of the run, which ends at `x`.
    fn finish(&mut self, x: f64) {
        if self.state > 0.0 {
            self.sum.airlight += self.state * self.aspect.airlight(self.from, x, Vec3::ONE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BruteForce;
    use glam::DVec3;
    use scene::{Aabb, Density, DirectionalLight, LightTexture, PointLight, TextureFilter, Visibility};
    use std::sync::Arc;

    /// Dark in pieces of the x axis.
    struct Bands(Vec<(f32, f32)>);

    impl Visibility for Bands {
        fn visibility(&self, point: Vec3, _: LightId) -> f32 {
            f32::from(!self.0.iter().any(|&(from, to)| point.x > from && point.x < to))
        }
    }

    fn lights() -> [Light; 3] {
        let spot = SpotLight::new(Vec3::new(3.0, 2.0, 1.0), Vec3::NEG_Y, 0.5, 1.0, Vec3::ONE).unwrap();
        [
            Light::Point(PointLight::new(Vec3::new(1.0, 1.0, -1.0), Vec3::ONE).unwrap()),
            Light::Spot(spot),
            Light::Directional(DirectionalLight::new(Vec3::new(0.2, -1.0, 0.3), Vec3::ONE).unwrap()),
        ]
    }

    fn ray(x: f64) -> DRay {
        DRay { origin: DVec3::new(x, 0.0, 0.0), direction: DVec3::X }
    }

    fn fog() -> Medium {
        Medium::homogeneous([0.1, 0.2, 0.3], [0.02; 3]).unwrap()
    }

    /// Airlight of what is lit of the x axis from `start` to `end`.
    fn exact(light: &Light, start: f64, end: f64, bands: &[(f32, f32)]) -> Vec3 {
        let (medium, lights) = (fog(), std::slice::from_ref(light));
        let march =
            BruteForce { medium: &medium, lights, occluders: None, samples: 1, model: AirlightModel::Sun };
        let until =
            |x: f32| march.airlight(&ray(start), (f64::from(x) - start).clamp(0.0, end - start)).airlight;
        bands.iter().fold(march.airlight(&ray(start), end - start).airlight, |sum, &(from, to)| {
            sum + until(from) - until(to)
        })
    }

    /// What the march makes of the bands, with the faces at `faces` on the x axis.
    fn marched(
        light: &Light,
        span: (f64, f64),
        bands: &[(f32, f32)],
        faces: Option<(f64, f64)>,
        (samples, refine): (u32, u32),
    ) -> Marched {
        let (medium, lights) = (fog(), std::slice::from_ref(light));
        let visibility = Bands(bands.to_vec());
        let occluders = Some(Occluders { visibility: &visibility, bounds: Aabb::EMPTY });
        let hybrid = Hybrid::new(&medium, lights, occluders, samples, refine, AirlightModel::Sun).unwrap();
        let faces = faces.map(|(a, b)| Interval::new(a - span.0, b - span.0));
        hybrid.airlight(&ray(span.0), span.1 - span.0, &[faces])
    }

    fn error(got: Vec3, exact: Vec3) -> f32 {
        ((got - exact) / exact).abs().max_element()
    }

    #[test]
    fn nothing_is_marched_without_a_face() {
        for light in &lights() {
            let got = marched(light, (0.0, 8.0), &[], None, (50, 6));
            assert_eq!((got.samples, got.rays), (0, 3), "{light:?}");
            assert!(error(got.airlight, exact(light, 0.0, 8.0, &[])) < 1e-6);
        }
        // and nothing at all without occluders or in clear air
        let (medium, lights) = (fog(), lights());
        let hybrid = Hybrid::new(&medium, &lights, None, 50, 6, AirlightModel::Sun).unwrap();
        let faces = [Some(Interval::new(1.0, 2.0)); 3];
        let got = hybrid.airlight(&ray(0.0), 8.0, &faces);
        assert!(got.samples == 0 && got.rays == 0 && got.airlight.min_element() > 0.0);
        assert_eq!(hybrid.airlight(&ray(0.0), f64::NAN, &faces), Marched::default());
        let clear = Medium::homogeneous([0.0; 3], [0.0; 3]).unwrap();
        let hybrid = Hybrid::new(&clear, &lights, None, 50, 6, AirlightModel::Sun).unwrap();
        assert_eq!(hybrid.airlight(&ray(0.0), 8.0, &[]), Marched::default());
    }

    #[test]
    fn boundaries_at_faces_are_exact() {
        let bands = [(2.0, 3.5)];
        for (light, end) in lights().iter().flat_map(|light| [(light, 8.0), (light, f64::INFINITY)]) {
            let got = marched(light, (0.0, end), &bands, Some((2.0, 3.5)), (5, 0));
            assert_eq!(got.samples, 5);
            assert!(error(got.airlight, exact(light, 0.0, end, &bands)) < 2e-6, "{light:?} {end}");
        }
    }

    #[test]
    fn rays_start_and_end_in_shadow() {
        let bands = [(2.0, 3.5)];
        // no face where the shadow has begun before, or ends later
        let cases = [
            ((2.5, 8.0), Some((3.5, 3.5))),
            ((0.0, 3.0), Some((2.0, 2.0))),
            ((0.0, 3.0), Some((2.0, 3.5))),
            ((2.1, 3.4), None),
            // the volume's face lies behind the end, and before the start
            ((0.0, 1.5), Some((2.0, 3.5))),
            ((4.0, 6.0), Some((2.0, 3.5))),
        ];
        for (light, (span, faces)) in lights().iter().flat_map(|light| cases.map(|case| (light, case))) {
            let got = marched(light, span, &bands, faces, (400, 12)).airlight;
            let exact = exact(light, span.0, span.1, &bands);
            assert!((got - exact).abs().max_element() < 1e-5, "{light:?} {span:?} {faces:?}: {got} {exact}");
        }
    }

    #[test]
    fn a_volume_need_not_be_left() {
        for light in &lights() {
            let got =
                marched(light, (0.0, f64::INFINITY), &[(2.0, f32::INFINITY)], Some((2.0, 2.0)), (50, 0));
            // the first step is dark: its start is the face
            assert!(error(got.airlight, exact(light, 0.0, 2.0, &[])) < 2e-6, "{light:?}");
            // so it is on a ray that a surface ends before it leaves the volume, wherever rounding puts the face
            for face in [2.0 - 1e-9, 2.0 + 1e-9] {
                let got = marched(light, (0.0, 4.0), &[(2.0, 9.0)], Some((face, face)), (50, 0));
                assert!(error(got.airlight, exact(light, 0.0, 2.0, &[])) < 2e-6, "{light:?}");
            }
        }
    }

    #[test]
    fn a_face_beyond_all_that_is_seen_takes_no_steps_from_what_is() {
        let bands = [(2.0, 3.5), (1e7, 2e7)];
        for light in &lights() {
            let got = marched(light, (0.0, f64::INFINITY), &bands, Some((2.0, 2e7)), (400, 10)).airlight;
            assert!(error(got, exact(light, 0.0, f64::INFINITY, &bands[..1])) < 1e-3, "{light:?}");
        }
    }

    #[test]
    fn faces_of_a_part_of_the_casters_are_no_bounds() {
        let (medium, lights, bands) = (fog(), lights(), [(2.0, 3.5)]);
        let visibility = Bands(bands.to_vec());
        let occluders = Some(Occluders { visibility: &visibility, bounds: Aabb::EMPTY });
        for faces in [None, Some(Interval::new(3.0, 3.2))] {
            let mut hybrid =
                Hybrid::new(&medium, &lights[..1], occluders, 50, 10, AirlightModel::Sun).unwrap();
            hybrid.partial = true;
            let got = hybrid.airlight(&ray(0.0), 8.0, &[faces]).airlight;
            assert!(error(got, exact(&lights[0], 0.0, 8.0, &bands)) < 1e-3, "{faces:?}");
        }
    }

    #[test]
    fn refinement_finds_boundaries_between_samples() {
        let bands = [(2.0, 2.71), (3.3, 4.0)];
        for light in &lights() {
            let exact = exact(light, 0.0, 8.0, &bands);
            // bounds of a tile are wider than the ray's own
            let errors = [0, 3, 12].map(|refine| {
                let got = marched(light, (0.0, 8.0), &bands, Some((1.4, 5.2)), (10, refine));
                assert_eq!((got.samples, got.rays), (10, 13 + 4 * u64::from(refine)), "{light:?}");
                error(got.airlight, exact)
            });
            assert!(
                errors[0] > 3.0 * errors[1] && errors[1] > 20.0 * errors[2] && errors[2] < 1e-4,
                "{errors:?}"
            );
        }
    }

    #[test]
    fn shadow_just_before_the_end_is_found() {
        // the spot's cone ends before
        let [point, _, sun] = lights();
        for light in &[point, sun] {
            let bands = [(2.0, 3.5), (7.97, 8.1)];
            let got = marched(light, (0.0, 8.0), &bands, Some((2.0, 3.5)), (5, 0));
            let bisected = 4.5 / 512.0 / 8.0;
            assert!(error(got.airlight, exact(light, 0.0, 8.0, &bands)) < bisected, "{light:?}");
            assert_eq!(got.rays, 5 + 3 + u64::from(LEAST_TAIL));
        }
    }

    #[test]
    fn filtered_visibility_dims() {
        struct Half;
        impl Visibility for Half {
            fn visibility(&self, point: Vec3, _: LightId) -> f32 {
                if point.x > 2.0 && point.x < 3.0 { 0.5 } else { 1.0 }
            }
        }
        let (medium, lights) = (fog(), lights());
        let occluders = Some(Occluders { visibility: &Half, bounds: Aabb::EMPTY });
        let hybrid = Hybrid::new(&medium, &lights[..1], occluders, 8, 0, AirlightModel::Sun).unwrap();
        let got = hybrid.airlight(&ray(0.0), 8.0, &[Some(Interval::new(2.0, 3.0))]).airlight;
        let (lit, dark) = (exact(&lights[0], 0.0, 8.0, &[]), exact(&lights[0], 0.0, 8.0, &[(2.0, 3.0)]));
        assert!(error(got, 0.5 * (lit + dark)) < 1e-6);
    }

    #[test]
    fn pictures_are_marched_in_their_cone() {
        let mut lights = lights();
        let texture = LightTexture::new(1, 1, vec![[1.0; 3]], TextureFilter::Nearest).unwrap();
        if let Light::Spot(spot) = &mut lights[1] {
            spot.texture = Some(Arc::new(texture));
        }
        let plain = marched(&lights[0], (0.0, 8.0), &[], None, (300, 0));
        let (medium, visibility) = (fog(), Bands(vec![(2.0, 3.5)]));
        let occluders = Some(Occluders { visibility: &visibility, bounds: Aabb::EMPTY });
        let hybrid = Hybrid::new(&medium, &lights[..2], occluders, 300, 0, AirlightModel::Sun).unwrap();
        let got = hybrid.airlight(&ray(0.0), 8.0, &[None, Some(Interval::new(2.0, 3.5))]);
        let white = marched(&self::lights()[1], (0.0, 8.0), &[(2.0, 3.5)], Some((2.0, 3.5)), (300, 0));
        assert!(got.samples > 300 && error(got.airlight - plain.airlight, white.airlight) < 2e-2);
    }

    #[test]
    fn what_has_no_closed_form_is_refused() {
        let (fog, lights) = (fog(), lights());
        let refusal =
            |medium: &Medium, lights: &[Light], model| Hybrid::new(medium, lights, None, 9, 0, model).err();
        let (sun, hp) = (AirlightModel::Sun, AirlightModel::HoffmanPreetham);
        assert_eq!(refusal(&fog, &lights, sun), None);
        assert_eq!(refusal(&fog, &lights[2..], hp), None);
        let bounds = Some(Aabb { min: Vec3::ZERO, max: Vec3::ONE });
        let cases = [
            (Medium { density: Some(Density::height(0.0, 1.0).unwrap()), ..fog.clone() }, sun),
            (Medium { emission: [1.0; 3], ..fog.clone() }, sun),
            (Medium { bounds, ..fog.clone() }, sun),
            (fog.clone(), hp),
        ];
        for (medium, model) in cases {
            let refusal = refusal(&medium, &lights[..2], model).unwrap();
            assert_eq!((refusal.technique, refusal.instead), ("hybrid", "brute-force"));
        }
        // a spot is marched in light as well
        assert_eq!(refusal(&fog, &lights[1..2], hp), None);
    }
}
