//! Where the view rays of a picture end: the stage that a frame without fog needs too.

use std::time::Instant;

use ground_truth::render_rows;
use scene::{Bvh, Camera, Hit};

/// In place of a triangle where a ray hits none.
pub(crate) const NO_TRIANGLE: u32 = u32::MAX;

/// What each pixel's ray hits, row by row from the top; any backend can take it from here.
#[derive(Debug, Clone)]
pub(crate) struct ViewRays {
    /// Distances to the surface, as a GPU takes them; +∞ where a ray hits none; units: m.
    pub(crate) ends: Vec<f32>,
    /// Indices into [`Bvh::triangles`]; [`NO_TRIANGLE`] where a ray hits none.
    pub(crate) triangles: Vec<u32>,
    /// The distances before they were rounded, for techniques that compute in `f64`.
    distances: Vec<f64>,
    /// Wall time of finding them; units: ms.
    pub(crate) ms: f64,
}

impl ViewRays {
    /// Finds what the rays through all pixels of a picture of `size` (width, height) hit, in parallel over rows.
    pub(crate) fn trace(camera: &Camera, bvh: &Bvh, size: (u32, u32)) -> Self {
        let started = Instant::now();
        let hits = render_rows(size, &|_| (), |x, y| {
            bvh.closest_hit(&camera.pixel_ray(x, y, size), f64::INFINITY).map_or(
                (f64::INFINITY, NO_TRIANGLE),
                // a hierarchy holds fewer triangles than that
                |hit| (hit.distance, u32::try_from(hit.triangle).unwrap_or(NO_TRIANGLE)),
            )
        });
        let (distances, triangles): (Vec<f64>, Vec<u32>) = hits.into_iter().unzip();
        let ends = distances.iter().map(|&distance| distance as f32).collect();
        Self { ends, triangles, distances, ms: started.elapsed().as_secs_f64() * 1e3 }
    }

    /// How far the ray of a pixel is integrated: to its surface, else to `max_distance`; units: m.
    pub(crate) fn end(&self, pixel: usize, max_distance: f64) -> f64 {
        let distance = self.distances[pixel];
        if self.triangles[pixel] == NO_TRIANGLE { max_distance } else { distance }
    }

    /// The same rays, none of which is integrated farther than `range` metres. What they hit is no longer known.
    pub(crate) fn up_to(&self, range: f32) -> Self {
        Self {
            ends: self.ends.iter().map(|end| end.min(range)).collect(),
            triangles: self.triangles.clone(),
            distances: self.distances.iter().map(|distance| distance.min(f64::from(range))).collect(),
            ms: self.ms,
        }
    }

    /// What the ray of a pixel hits.
    pub(crate) fn hit(&self, pixel: usize, bvh: &Bvh) -> Option<Hit> {
        bvh.hit_on(self.triangles[pixel] as usize, self.distances[pixel])
    }

    /// Memory; units: bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.ends) + size_of_val(&*self.triangles) + size_of_val(&*self.distances)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::procedural;

    #[test]
    fn rays_end_where_the_hierarchy_says() {
        let scene = procedural::generate("sphere").unwrap();
        let (bvh, camera, size) = (Bvh::build(&scene).unwrap(), &scene.cameras[0], (9, 7));
        let rays = ViewRays::trace(camera, &bvh, size);
        let mut hits = 0;
        for pixel in 0..63 {
            let ray = camera.pixel_ray(pixel as u32 % 9, pixel as u32 / 9, size);
            let hit = bvh.closest_hit(&ray, f64::INFINITY);
            assert_eq!(rays.hit(pixel, &bvh), hit);
            assert_eq!(rays.end(pixel, 5.0), hit.map_or(5.0, |hit| hit.distance));
            assert_eq!(rays.ends[pixel], hit.map_or(f32::INFINITY, |hit| hit.distance as f32));
            hits += usize::from(hit.is_some());
        }
        assert!(hits > 5 && hits < 63, "{hits}");
        let near = rays.up_to(3.0);
        assert!(near.ends.iter().zip(&rays.ends).all(|(near, far)| *near == far.min(3.0)));
        assert!((0..63).all(|pixel| near.end(pixel, 3.0) == rays.end(pixel, 3.0).min(3.0)));
        assert_eq!(rays.bytes(), 63 * 16);
    }
}
