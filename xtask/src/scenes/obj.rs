//! Wavefront OBJ with its material files, read by the crate `tobj`.

use std::path::Path;

use glam::Vec3;
use scene::{Material, Mesh, Scene};
use tobj::{LoadError, LoadOptions};

use crate::output_file::read_input;

/// Reads polygons as fans of triangles, and diffuse colours from the material files in `folder`.
///
/// A material file that is not there leaves surfaces white: many models are passed on without theirs.
pub(super) fn read(bytes: &[u8], folder: Option<&Path>) -> Result<Scene, String> {
    let options =
        LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let text = kept(bytes, |keyword, _| keyword != "vt" && keyword != "vn");
    let materials = |name: &Path| {
        let path = folder.unwrap_or(Path::new("")).join(name);
        let bytes = read_input(&path).map_err(|_| LoadError::OpenFileFailed)?;
        tobj::load_mtl_buf(&mut kept(&bytes, is_colour).as_bytes())
    };
    let (models, materials) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, materials).map_err(|e| e.to_string())?;
    let mut scene = Scene::default();
    for material in materials.unwrap_or_default() {
        // the format's default is a light grey
        let base_color = material.diffuse.unwrap_or([0.8; 3]).map(|c| c.clamp(0.0, 1.0));
        if base_color.iter().any(|c| c.is_nan()) {
            return Err(format!("the colour of material {:?} is not a number", material.name));
        }
        scene.materials.push(Material { name: material.name, base_color });
    }
    let white = scene.materials.len();
    scene.materials.push(Material { name: String::new(), base_color: [1.0; 3] });
    for model in models {
        let positions =
            model.mesh.positions.as_chunks().0.iter().map(|p: &[f32; 3]| Vec3::from(*p)).collect();
        let triangles = model.mesh.indices.as_chunks().0.to_vec();
        let material = model.mesh.material_id.unwrap_or(white);
        scene.meshes.push(Mesh::new(positions, triangles, material).map_err(|e| e.to_string())?);
    }
    Ok(scene)
}

/// The lines of a text by their keyword and the number of values after it.
///
/// What is not needed is not parsed, and so not in the way: `tobj` is not proof against all that lines on textures,
/// normals and other properties of a material may say. Names in other encodings do no harm either.
fn kept(bytes: &[u8], keep: impl Fn(&str, usize) -> bool) -> String {
    let mut text = String::with_capacity(bytes.len());
    for line in String::from_utf8_lossy(bytes).lines() {
        let mut words = line.split_whitespace();
        if let Some(keyword) = words.next()
            && keep(keyword, words.count())
        {
            text += line;
            text += "\n";
        }
    }
    text
}

/// Whether a line of a material file starts a material or gives its colour.
fn is_colour(keyword: &str, values: usize) -> bool {
    keyword == "newmtl" || (keyword == "Kd" && values >= 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    #[test]
    fn polygons_become_triangles_with_their_colours() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\nKs 1\nillum x\n").unwrap();
        let text =
            format!("mtllib a.mtl\n{QUAD}usemtl red\nf 1/1/1 2/1/1 3/1/1 4/1/1\nusemtl none\nf -4 -3 -2\n");
        let scene = read(text.as_bytes(), Some(folder.path())).unwrap();
        assert_eq!(scene.triangle_count(), 3);
        let colours: Vec<[f32; 3]> =
            scene.meshes.iter().map(|mesh| scene.materials[mesh.material].base_color).collect();
        assert_eq!(colours, [[1.0, 0.0, 0.0], [1.0; 3]]);
        let without = read(text.as_bytes(), None).unwrap();
        assert_eq!(without.triangle_count(), 3);
    }

    #[test]
    fn nonsense_is_refused() {
        let bad = [
            "f 1 2 9",
            "f 0 1 2",
            "f 1 2 -9",
            "f a b c",
            "f 1/x 2 3",
            "v 0 0",
            "v 0 0 nan\nf 1 2 5",
            "f 1 2 9223372036854775807",
            "f 1 2 -9223372036854775808",
            "usemtl",
        ];
        for line in bad {
            assert!(read(format!("{QUAD}{line}\n").as_bytes(), None).is_err(), "{line}");
        }
        // far out of range, but nothing that is read
        assert!(read(format!("{QUAD}f 1/-9223372036854775808 2/4 3/9\n").as_bytes(), None).is_ok());
        assert_eq!(read(b"\xff\xfe", None).unwrap().triangle_count(), 0);
    }
}
