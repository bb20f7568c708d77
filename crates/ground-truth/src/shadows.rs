//! Whose shadows the reference integrates between.

use scene::LitIntervals;

use crate::ExactShadows;

/// The reference's own shadows, or somebody else's.
pub(crate) enum Shadows<'a> {
    /// Those of the triangles.
    Exact(ExactShadows<'a>),
    /// What a caller found: a map's traversal, shadow volumes.
    Given(&'a dyn LitIntervals),
}

impl Shadows<'_> {
    /// Who is asked which pieces of a view ray are lit.
    pub(crate) fn of_medium(&self) -> &dyn LitIntervals {
        match self {
            Self::Exact(shadows) => shadows,
            Self::Given(shadows) => *shadows,
        }
    }
}

impl std::fmt::Debug for Shadows<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Exact(_) => f.write_str("Exact"),
            Self::Given(_) => f.write_str("Given"),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Reference, Settings};
    use glam::{DVec3, Vec3};
    use scene::{
        Bvh, DRay, Interval, Light, LightId, LitIntervals, Medium, PointLight, SpotLight, procedural,
    };

    /// Lit between 1 m and 2 m of every ray, as far as that was asked for.
    struct Window;

    impl LitIntervals for Window {
        fn lit_intervals(&self, _: &DRay, span: Interval, _: LightId, out: &mut Vec<Interval>) {
            out.clear();
            out.extend(Some(span.intersect(Interval::new(1.0, 2.0))).filter(|piece| !piece.is_empty()));
        }
    }

    #[test]
    fn given_pieces_are_what_is_integrated() {
        let scene = procedural::generate("sphere").unwrap();
        let bvh = Bvh::build(&scene).unwrap();
        let medium = Medium::homogeneous([0.1, 0.2, 0.3], [0.05; 3]).unwrap();
        let from = Vec3::new(0.5, 3.0, 0.2);
        let lights = [
            Light::Point(PointLight::new(from, Vec3::ONE).unwrap()),
            Light::Spot(SpotLight::new(from, Vec3::NEG_Y, 0.5, 1.2, Vec3::ONE).unwrap()),
        ];
        for light in &lights {
            let lights = std::slice::from_ref(light);
            let open = Settings { shadows_in_medium: false, ..Settings::default() };
            let reference =
                |settings| Reference::new(&scene.materials, &bvh, &medium, lights, settings).unwrap();
            let window = reference(Settings::default()).with_shadows(&Window);
            let ray = DRay { origin: DVec3::new(-1.0, 2.6, 0.0), direction: DVec3::X };
            let unshadowed = reference(open);
            let expected = unshadowed.airlight(&ray, 2.0) - unshadowed.airlight(&ray, 1.0);
            let got = window.airlight(&ray, 5.0);
            assert!(expected.min_element() > 0.0);
            assert!(((got - expected) / expected).abs().max_element() < 1e-8, "{got} {expected}");
            // and without shadows nobody is asked
            let all = reference(open).with_shadows(&Window);
            assert_eq!(all.airlight(&ray, 5.0), unshadowed.airlight(&ray, 5.0));
        }
    }
}
