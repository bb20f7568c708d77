//! More lights than a mask has bits: the strongest at each place keep theirs (section 3.1.1).

use glam::Vec3;
use scene::Light;

/// Chooses the lights that a mask has room for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Strongest<'a> {
    lights: &'a [Light],
    bits: u32,
}

/// The largest component of what arrives at a point without fog and cone; units: W/m².
fn strength(light: &Light, point: Vec3) -> f32 {
    let local = |position: Vec3, intensity: Vec3| {
        intensity.max_element() / (point - position).length_squared().max(1e-12)
    };
    match light {
        Light::Point(light) => local(light.position, light.intensity),
        Light::Spot(light) => local(light.position, light.intensity),
        Light::Directional(light) => light.irradiance.max_element(),
    }
}

impl<'a> Strongest<'a> {
    pub(crate) fn new(lights: &'a [Light], bits: u32) -> Self {
        Self { lights, bits }
    }

    /// The chosen lights of a mask that is traced from `point`, one bit a light; of equal ones those of lower index.
    pub(crate) fn chosen(&self, point: Vec3) -> u32 {
        let count = self.lights.len();
        if count <= self.bits as usize {
            return (1_u64 << count).wrapping_sub(1) as u32;
        }
        let mut order: Vec<(f32, usize)> =
            self.lights.iter().map(|light| strength(light, point)).zip(0..).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        order[..self.bits as usize].iter().fold(0, |chosen, &(_, light)| chosen | 1 << light)
    }
}

/// Which bit of a mask is a light's; `None` where it was not chosen.
pub(crate) fn bit_of(chosen: u32, light: usize) -> Option<u32> {
    let bit = 1_u32 << light;
    (chosen & bit != 0).then(|| 1 << (chosen & (bit - 1)).count_ones())
}

/// The bits of a mask for some of the chosen lights.
pub(crate) fn compact(chosen: u32, lights: u32) -> u32 {
    crate::needs::bits(chosen & lights)
        .filter_map(|light| bit_of(chosen, light))
        .fold(0, |mask, bit| mask | bit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{DirectionalLight, PointLight};

    #[test]
    fn the_weakest_is_left_out() {
        let lamp =
            |x: f32, i: f32| Light::Point(PointLight::new(Vec3::new(x, 0.0, 0.0), Vec3::splat(i)).unwrap());
        let mut lights: Vec<Light> = (0..9).map(|i| lamp(i as f32, 1.0)).collect();
        let chosen = |lights: &[Light], x: f32| Strongest::new(lights, 8).chosen(Vec3::new(x, 0.0, 0.0));
        assert_eq!(chosen(&lights[..8], 0.0), 0xff);
        assert_eq!(chosen(&lights, 0.0), 0x0ff);
        assert_eq!(chosen(&lights, 8.0), 0x1fe);
        // a tie of the two outermost: the lower index stays
        assert_eq!(chosen(&lights, 4.0), 0x0ff);
        lights[4] = Light::Directional(DirectionalLight::new(Vec3::X, Vec3::splat(1e-9)).unwrap());
        assert_eq!(chosen(&lights, 0.0), 0x1ef);
        assert_eq!((bit_of(0x1ef, 3), bit_of(0x1ef, 4), bit_of(0x1ef, 5)), (Some(8), None, Some(16)));
        assert_eq!(compact(0x1ef, 0x130), 0x90);
    }
}
