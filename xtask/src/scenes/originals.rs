//! Models as they are published, made into the scenes that they are.
//!
//! Names tell little (there are two models called `sponza.obj`), so a model is known by its shape: how many triangles
//! it has, and the proportions of the box around them. All files are read before any is written.

use std::fs;
use std::path::{Path, PathBuf};

use scene::Scene;

use super::fit::Fit;
use super::glb;
use super::known::{Known, KnownScene};
use super::read::{ENDINGS, Format};
use super::state::checksum;
use crate::failure::{Failure, Outcome};
use crate::output_file::{check_writable, read_input, stage};

/// Converts what is known of a folder and the folders in it; says of every model what became of it.
pub(super) fn convert(folder: &Path, output: &Path, known: &Known) -> Outcome<Vec<String>> {
    if output.exists() && !output.is_dir() {
        return Err(Failure::input(format!("--output {}: is not a folder", output.display())));
    }
    let models = models(folder)?;
    if models.is_empty() {
        return Err(Failure::input(format!("--originals {}: holds no {ENDINGS} file", folder.display())));
    }
    let (mut lines, mut files) = (Vec::new(), Vec::<(PathBuf, Vec<u8>)>::new());
    for (path, format) in &models {
        let scene = format.read(path)?;
        let count = scene.triangle_count();
        let found = known.scenes.iter().filter_map(|known| Some((known, Fit::find(&scene, known)?)));
        let nearest = found.min_by_key(|(known, _)| known.triangles.abs_diff(count));
        let what = match nearest {
            None => format!("{count} triangles, the shape of no known scene"),
            Some((known, fit)) => {
                let target = output.join(&known.file);
                let name = target.display();
                if target.exists() {
                    format!("{name} is there already")
                } else if files.iter().any(|(other, _)| *other == target) {
                    format!("{name} is made of another one")
                } else {
                    let bytes = whole(path, known, &scene, &fit)?;
                    files.push((target.clone(), bytes));
                    format!("{name}, {count} triangles of {} known", known.triangles)
                }
            }
        };
        lines.push(format!("{}: {what}", path.display()));
    }
    if files.is_empty() {
        return Ok(lines);
    }
    fs::create_dir_all(output)
        .map_err(|e| Failure::input(format!("--output {}: cannot be made: {e}", output.display())))?;
    for (path, _) in &files {
        check_writable(path)?;
    }
    let staged: Vec<_> = files.iter().map(|(path, bytes)| stage(path, bytes)).collect::<Outcome<_>>()?;
    staged.into_iter().try_for_each(|file| file.commit())?;
    Ok(lines)
}

/// The file of a known scene: the original itself if it is that file, else what is made of it.
fn whole(path: &Path, known: &KnownScene, scene: &Scene, fit: &Fit) -> Outcome<Vec<u8>> {
    let bytes = read_input(path)?;
    if checksum(&bytes) == known.sha256 {
        return Ok(bytes);
    }
    glb::write(scene, fit).map_err(|what| Failure::input(format!("{}: {what}", path.display())))
}

/// All models in a folder and in the folders in it, by name; links to folders are not followed.
fn models(folder: &Path) -> Outcome<Vec<(PathBuf, Format)>> {
    let (mut models, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        let unreadable = |e| Failure::input(format!("--originals: {}: {e}", folder.display()));
        for entry in fs::read_dir(&folder).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let path = entry.path();
            if entry.file_type().map_err(unreadable)?.is_dir() {
                folders.push(path);
            } else if let Some(format) = Format::of(&path) {
                models.push((path, format));
            }
        }
    }
    models.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(models)
}
