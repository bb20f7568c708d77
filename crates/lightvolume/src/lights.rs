//! The light volumes of a scene's lights as the answer to "which pieces of this ray do the lights reach".

use std::cell::RefCell;

use media_math::Boundary;
use scene::{DRay, Interval, Light, LightId, LitIntervals};
use shadowmap::ProjectionKind;

use crate::{LightVolume, LightVolumeError, RayIndex, intervals};

thread_local! {
    /// Boundaries of one ray, kept for their memory.
    static BOUNDARIES: RefCell<Vec<Boundary<f64>>> = const { RefCell::new(Vec::new()) };
}

/// Lit intervals of view rays between the crossings of light volumes.
///
/// A spot's cone is taken into account: outside of it nothing is lit. A light without a volume has no shadows.
#[derive(Debug)]
pub struct LightVolumes<'a> {
    lights: &'a [Light],
    volumes: Vec<Option<RayIndex<'a>>>,
}

impl<'a> LightVolumes<'a> {
    /// Prepares one volume per light, `None` for a light that nothing shadows.
    ///
    /// # Errors
    /// [`LightVolumeError::Count`] unless there are as many volumes as lights; [`LightVolumeError::WrongVolume`] if a
    /// point light has a volume other than a cube's, a directional light one that is not orthographic, or a spot one
    /// that is.
    pub fn new(volumes: &'a [Option<LightVolume>], lights: &'a [Light]) -> Result<Self, LightVolumeError> {
        check(volumes, lights)?;
        Ok(Self {
            lights,
            volumes: volumes.iter().map(|volume| volume.as_ref().map(RayIndex::new)).collect(),
        })
    }

    /// The lights.
    pub fn lights(&self) -> &'a [Light] {
        self.lights
    }

    /// Memory beside the volumes' own; units: bytes.
    pub fn bytes(&self) -> usize {
        self.volumes.iter().flatten().map(RayIndex::bytes).sum()
    }

    /// The part of `span` in which a light shines at all: a spot's cone.
    fn extent(&self, ray: &DRay, span: Interval, light: LightId) -> Interval {
        match &self.lights[light.0] {
            Light::Spot(spot) => spot.clip(ray, span),
            Light::Point(_) | Light::Directional(_) => span,
        }
    }

    /// Writes where `ray` leaves and enters the light within `span` to `out` (cleared first), in no order, as
    /// [`RayIndex::crossings`]. The borders of a spot's cone are boundaries too; the part of the span inside it is
    /// returned.
    ///
    /// # Panics
    /// If there is no such light.
    pub fn boundaries(
        &self,
        ray: &DRay,
        span: Interval,
        light: LightId,
        out: &mut Vec<Boundary<f64>>,
    ) -> Interval {
        let span = self.extent(ray, span, light);
        match &self.volumes[light.0] {
            Some(index) => index.crossings(ray, span, out),
            None => {
                out.clear();
                if !span.is_empty() {
                    let [_, end] = Boundary::of_interval(span.start, span.end);
                    out.push(end);
                }
            }
        }
        span
    }
}

/// Checks that every light has a volume that can serve it.
fn check(volumes: &[Option<LightVolume>], lights: &[Light]) -> Result<(), LightVolumeError> {
    if volumes.len() != lights.len() {
        return Err(LightVolumeError::Count { lights: lights.len(), volumes: volumes.len() });
    }
    for (index, (volume, light)) in volumes.iter().zip(lights).enumerate() {
        let Some(volume) = volume else { continue };
        let projection = volume.projection().kind();
        let (serves, kind) = match light {
            Light::Point(_) => (projection == ProjectionKind::Cube, "point"),
            Light::Spot(_) => (projection != ProjectionKind::Orthographic, "spot"),
            Light::Directional(_) => (projection == ProjectionKind::Orthographic, "directional"),
        };
        if !serves {
            let map = match projection {
                ProjectionKind::Perspective => "a perspective",
                ProjectionKind::Orthographic => "an orthographic",
                ProjectionKind::Cube => "a cube",
            };
            return Err(LightVolumeError::WrongVolume { light: index, map, kind });
        }
    }
    Ok(())
}

impl LitIntervals for LightVolumes<'_> {
    fn lit_intervals(&self, ray: &DRay, span: Interval, light: LightId, out: &mut Vec<Interval>) {
        BOUNDARIES.with_borrow_mut(|boundaries| {
            let span = self.boundaries(ray, span, light, boundaries);
            intervals::between(boundaries, span, out);
        });
    }
}
