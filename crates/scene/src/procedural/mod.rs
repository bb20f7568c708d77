//! Generated scenes, so that a fresh clone shows and measures everything without a download.
//!
//! Each stands for a model of the papers, with the same number of triangles and the same character, or for a case
//! that is hard on one technique or another. All carry a camera, a light and a medium under which shadows matter (the light is
//! hidden from the camera wherever its glow would outshine them), are
//! the same on every run, and use metres with Y up. Closed shapes (`sphere`, `spring`, `blob-…`, `knot-…`) are
//! closed manifolds that face outwards; the others have open sheets, overlaps and single cards, as found models do.

mod blob;
mod builder;
mod canopy;
mod fence;
mod foliage;
mod grove;
mod hall;
mod hard;
mod isosurface;
mod knot;
mod lampshade;
mod noise;
mod slats;
mod sphere;
mod spring;
mod stage;
mod street;
#[cfg(test)]
mod topology;

use crate::Scene;
use thiserror::Error;

/// A name with its description and the function that builds it.
type Entry = (&'static str, &'static str, fn() -> Scene);

const SCENES: &[Entry] = &[
    ("sphere", "20,480 triangles; Wyman & Ramsey's Sphere", sphere::scene),
    (
        "sphere-plane",
        "81,922 triangles, a unit sphere over a wide floor under a point light",
        sphere::on_plane,
    ),
    ("spring", "31,936 triangles, a helix of 8 turns; Wyman & Ramsey's Spring", spring::scene),
    ("blob-24k", "24,000 triangles, a smooth body with lobes; for Wyman & Ramsey's Elephant", blob::blob_24k),
    ("blob-70k", "69,452 triangles, a furrowed body with lobes; for Wyman & Ramsey's Bunny", blob::blob_70k),
    ("blob-250k", "250,000 triangles, a tall dented body; for Wyman & Ramsey's Buddha", blob::blob_250k),
    (
        "knot-188k",
        "about 188,672 triangles, a lattice of many handles; for Billeter et al.'s Yeah Right",
        knot::knot_188k,
    ),
    (
        "knot-755k",
        "about 754,688 triangles, the same lattice; for Wyman & Ramsey's Yeah Right",
        knot::knot_755k,
    ),
    ("hall", "about 70,000 triangles, columns, galleries, windows; for Sponza and Sibenik", hall::scene),
    ("street", "280,000 triangles, house fronts and trees; for San Miguel and Bistro", street::scene),
    ("grove", "155,000 triangles, trees on hilly ground; for Wyman & Ramsey's Fairy", grove::scene),
    ("fence", "a chain-link fence with the light low behind it", fence::scene),
    ("canopy", "7,000 leaf cards over a floor, under a directional light", canopy::scene),
    ("slats", "8 tilted slats between the light and the viewer", slats::slats),
    ("slats-500", "500 tilted slats, 4 mm apart", slats::slats_500),
    ("lampshade", "a light inside an open, perforated lampshade", lampshade::scene),
    ("empty", "no triangle, only a light in fog", hard::empty),
    ("triangle", "a single triangle", hard::triangle),
    ("wall", "a light 0.1 mm in front of a wall", hard::wall),
];

/// Names that [`generate`] knows, with one line each.
pub const NAMES: &[(&str, &str)] = &{
    let mut names = [("", ""); SCENES.len()];
    let mut i = 0;
    while i < SCENES.len() {
        names[i] = (SCENES[i].0, SCENES[i].1);
        i += 1;
    }
    names
};

/// A name that no generated scene has.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("unknown procedural scene \"{name}\"; known: {}", NAMES.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "))]
pub struct UnknownScene {
    /// The name that was asked for.
    pub name: String,
}

/// Builds the scene of that name.
///
/// # Errors
/// [`UnknownScene`] if there is none; its text lists those there are.
///
/// ```
/// let scene = scene::procedural::generate("sphere")?;
/// assert_eq!(scene.triangle_count(), 20_480);
/// # Ok::<(), scene::procedural::UnknownScene>(())
/// ```
pub fn generate(name: &str) -> Result<Scene, UnknownScene> {
    let entry = SCENES.iter().find(|(known, ..)| *known == name);
    entry.map(|(.., build)| build()).ok_or_else(|| UnknownScene { name: name.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_complete_and_repeats() {
        for (name, description) in NAMES {
            let start = std::time::Instant::now();
            let scene = generate(name).unwrap();
            println!("{name}: {} triangles, {:?}", scene.triangle_count(), start.elapsed());
            assert!(!description.is_empty());
            // Mesh, Camera and the lights refuse what is not finite; what they refused would be noted
            assert_eq!(scene.notes, Vec::<String>::new(), "{name}");
            assert!(
                !scene.cameras.is_empty() && !scene.lights.is_empty() && scene.medium.is_some(),
                "{name}"
            );
            assert!(scene.meshes.iter().all(|mesh| mesh.material < scene.materials.len()), "{name}");
            assert!(scene.meshes.iter().flat_map(|m| m.positions()).all(|p| p.is_finite()), "{name}");
            assert!(scene.meshes.iter().all(|mesh| !mesh.triangles().is_empty()), "{name}");
            if scene.triangle_count() < 100_000 {
                assert_eq!(generate(name).unwrap(), scene, "{name}");
            }
        }
    }

    #[test]
    fn names_are_unique() {
        for (i, (name, _)) in NAMES.iter().enumerate() {
            assert!(NAMES[..i].iter().all(|(other, _)| other != name), "{name}");
        }
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_known_ones() {
        let text = generate("foo").unwrap_err().to_string();
        assert!(
            text.starts_with("unknown procedural scene \"foo\"; known: sphere, sphere-plane, spring, "),
            "{text}"
        );
        assert!(NAMES.iter().all(|(name, _)| text.contains(name)));
    }
}
