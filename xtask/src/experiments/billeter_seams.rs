//! Errors where a view ray enters or leaves the light next to a seam of a cube map, and where it does so elsewhere.

use glam::DVec3;
use scene::{DRay, Interval, Light, LightId, LitIntervals};
use shadowmap::{Bias, ExactShadowMap, MapSurface};

use super::measure::{Arena, Measured};
use crate::failure::{Failure, Outcome};
use crate::image_file::Image;

/// How near is near; units: texels.
const NEAR: f64 = 2.0;

/// Root mean squares of the error on the map, as shares of that of the picture.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SeamErrors {
    /// Of pixels with a boundary of the light within two texels of a seam.
    pub(super) near: f64,
    /// Of pixels all of whose boundaries are elsewhere; those without any do not count.
    pub(super) elsewhere: f64,
    /// How many pixels are near.
    pub(super) pixels: usize,
}

/// The errors of `measured`, a picture under a point light with the map of `arena`.
pub(super) fn seam_errors(arena: &Arena, measured: &Measured) -> Outcome<SeamErrors> {
    let (maps, lights) = (&arena.map.maps.maps, &arena.setup.lights);
    let shadows =
        ExactShadowMap::new(maps, lights, MapSurface::Linear, Bias::NONE).map_err(Failure::program)?;
    let (mut near, mut elsewhere) = (Sum::default(), Sum::default());
    let (width, height) = arena.base.size;
    for pixel in 0..width * height {
        let ray = arena.setup.camera.pixel_ray(pixel % width, pixel / width, arena.base.size);
        let end = arena.rays.end(pixel as usize, arena.base.max_distance);
        let error = squared(&measured.image, &arena.map.exact, pixel as usize);
        match place(&shadows, lights, arena.base.map.side, &ray, end) {
            Some(true) => near.add(error),
            Some(false) => elsewhere.add(error),
            None => {}
        }
    }
    let mut all = Sum::default();
    let values = arena.map.exact.pixels.iter();
    values.for_each(|pixel| all.add(pixel.iter().map(|value| f64::from(*value).powi(2)).sum()));
    let scale = all.root();
    Ok(SeamErrors { near: near.root() / scale, elsewhere: elsewhere.root() / scale, pixels: near.count })
}

fn squared(a: &Image, b: &Image, pixel: usize) -> f64 {
    let pairs = a.pixels[pixel].iter().zip(&b.pixels[pixel]);
    pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
}

/// Whether a ray has a boundary of a point light's volume near a seam; `None` without a boundary.
fn place(shadows: &ExactShadowMap<'_>, lights: &[Light], side: u32, ray: &DRay, end: f64) -> Option<bool> {
    let mut found = None;
    let mut lit = Vec::new();
    for (index, light) in lights.iter().enumerate() {
        let Light::Point(lamp) = light else { continue };
        shadows.lit_intervals(ray, Interval::new(0.0, end), LightId(index), &mut lit);
        let boundaries = lit.iter().flat_map(|piece| [piece.start, piece.end]);
        for t in boundaries.filter(|t| *t > 0.0 && *t < end) {
            let near = seam_texels(ray.at(t) - lamp.position.as_dvec3(), side) <= NEAR;
            found = Some(near || found.unwrap_or_default());
        }
    }
    found
}

/// Distance on a cube's face from the nearest seam of the point towards `direction`; units: texels.
fn seam_texels(direction: DVec3, side: u32) -> f64 {
    let mut parts = direction.abs().to_array();
    parts.sort_by(f64::total_cmp);
    // the face has coordinates from -1 to 1
    0.5 * f64::from(side) * (1.0 - parts[1] / parts[2].max(f64::MIN_POSITIVE))
}

/// A mean in the making.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    sum: f64,
    count: usize,
}

impl Sum {
    fn add(&mut self, value: f64) {
        (self.sum, self.count) = (self.sum + value, self.count + 1);
    }

    /// Root of the mean; not a number without values.
    fn root(self) -> f64 {
        (self.sum / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::billeter_bench::{Division, linear};
    use crate::scene_args::SceneArgs;

    #[test]
    fn seams_are_counted_in_texels() {
        let texels = |x, y, z| seam_texels(DVec3::new(x, y, z), 8);
        // a face's centre is half of its texels away from each seam, an edge and a corner not at all
        assert_eq!((texels(0.0, -3.0, 0.0), texels(2.0, -2.0, 0.5), texels(1.0, 1.0, 1.0)), (4.0, 0.0, 0.0));
        assert!((texels(0.1, 0.75, 1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn errors_are_told_apart() {
        let setup = SceneArgs::default().resolve("procedural:sphere").unwrap();
        assert!(matches!(setup.lights[..], [Light::Point(_)]));
        let mut arena =
            Arena::new(&super::super::References::default(), "sphere", setup, linear(32, 16)).unwrap();
        let setting = Division::Indexed.setting(&arena, arena.base);
        let mut measured = arena.measure(None, &[setting]).unwrap().remove(0);
        let exact = seam_errors(&arena, &measured).unwrap();
        assert!(exact.pixels > 10 && exact.near < 1e-5 && exact.elsewhere < 1e-5, "{exact:?}");
        // an error at the pixels near a seam is theirs alone
        let maps = &arena.map.maps.maps;
        let shadows = ExactShadowMap::new(maps, &arena.setup.lights, MapSurface::Linear, Bias::NONE).unwrap();
        for (pixel, value) in measured.image.pixels.iter_mut().enumerate() {
            let ray = arena.setup.camera.pixel_ray(pixel as u32 % 32, pixel as u32 / 32, (32, 32));
            let end = arena.rays.end(pixel, f64::INFINITY);
            if place(&shadows, &arena.setup.lights, 16, &ray, end) == Some(true) {
                value[0] += 1.0;
            }
        }
        let wrong = seam_errors(&arena, &measured).unwrap();
        assert!(wrong.near > 1e-3 && wrong.elsewhere == exact.elsewhere, "{wrong:?}");
    }
}
