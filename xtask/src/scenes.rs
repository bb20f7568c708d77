//! `scenes`: which of the papers' meshes are there, where the others are published, and originals made into them.
//!
//! What is known of the meshes is in `scenes/known.toml`; which set-up wants which is in `scenes.toml`.

mod fit;
mod glb;
mod known;
mod manifest;
mod obj;
mod off;
mod originals;
mod ply;
mod read;
mod state;
mod stl;
mod three_ds;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::{Failure, Outcome};
use crate::repro::{SCENES, scenes_folder};
use crate::setups::Setups;
use known::{Known, KnownScene};
use manifest::Manifest;
use state::State;

/// List the papers' meshes: which are there, and where the others are published.
#[derive(Debug, Args)]
pub(crate) struct ScenesArgs {
    /// Folder with the scenes' meshes; AIRLIGHT_SCENES does the same.
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
    /// Folder with models as they are published (.obj, .ply, .stl, .off, .3ds, .gltf, .glb); those that are known are converted.
    #[arg(long, value_name = "DIR", requires = "output")]
    originals: Option<PathBuf>,
    /// Where the converted ones go; what is there already stays.
    #[arg(short, long, value_name = "DIR", requires = "originals")]
    output: Option<PathBuf>,
}

pub(crate) fn run(args: &ScenesArgs) -> Outcome {
    let known = Known::load()?;
    let setups = Setups::load(None)?;
    if let Some(folder) = &args.scenes {
        check_folder("--scenes", folder)?;
    }
    // the output may not be there yet
    let folder = match (&args.scenes, &args.output, scenes_folder()) {
        (Some(folder), ..) | (None, Some(folder), _) => Some(folder.clone()),
        (None, None, Some(folder)) => {
            check_folder(SCENES, &folder)?;
            Some(folder)
        }
        (None, None, None) => None,
    };
    // whatever can be refused is, before anything is written
    let manifest = folder.as_deref().map(Manifest::of).transpose()?.unwrap_or_default();
    let mut text = String::new();
    if let (Some(originals), Some(output)) = (&args.originals, &args.output) {
        check_folder("--originals", originals)?;
        for line in originals::convert(originals, output, &known)? {
            text += &format!("{line}\n");
        }
        text += "\n";
    }
    match &folder {
        Some(folder) => text += &list(folder, &manifest, &known, &setups),
        None => {
            tracing::info!("neither --scenes nor {SCENES} names a folder: none of them is looked for");
            text += &known.scenes.iter().map(|scene| entry(scene, "", &setups)).collect::<String>();
        }
    }
    for absent in &known.absent {
        text += &format!("{}: no file stands for it\n", absent.row);
        line(&mut text, "original", Some(&absent.original));
        line(&mut text, "note", Some(&absent.note));
    }
    crate::print(&text);
    Ok(())
}

fn check_folder(name: &str, folder: &Path) -> Outcome {
    if folder.is_dir() {
        return Ok(());
    }
    Err(Failure::input(format!("{name} {}: is not a folder", folder.display())))
}

/// What a folder holds of the known scenes, and of what its manifest names beside them.
fn list(folder: &Path, manifest: &Manifest, known: &Known, setups: &Setups) -> String {
    let (mut text, mut counts) = (String::new(), [0; 3]);
    for scene in &known.scenes {
        let state = State::of(folder, &scene.file, &scene.sha256, Some(scene));
        counts[state.index()] += 1;
        let listed = manifest.entries.iter().find(|entry| entry.file == scene.file);
        let as_listed = match (&state, listed) {
            (State::Altered { sha256, .. }, Some(entry)) if *sha256 == entry.sha256 => {
                "; its checksum is that of manifest.json"
            }
            _ => "",
        };
        text += &entry(scene, &format!("{state}{as_listed}"), setups);
    }
    for other in manifest.beside(known) {
        let state = State::of(folder, &other.file, &other.sha256, None);
        text += &format!("{:<28}{state}; of manifest.json alone\n", other.file);
        line(&mut text, "stands for", other.row());
        line(&mut text, "licence", other.licence.as_deref());
        line(&mut text, "made from", other.source.as_deref());
    }
    let [present, missing, altered] = counts;
    let _ = writeln!(
        text,
        "{}: {present} of {} known scenes present, {missing} missing, {altered} altered",
        folder.display(),
        known.scenes.len()
    );
    text
}

/// All that is known of a scene, under the state that its file is in.
fn entry(scene: &KnownScene, state: &str, setups: &Setups) -> String {
    let mut text = format!("{:<28}{state}", scene.file).trim_end().to_owned() + "\n";
    line(&mut text, "stands for", Some(&format!("{} ({})", scene.row, scene.kind)));
    line(&mut text, "triangles", Some(&scene.triangles.to_string()));
    let wanting = setups.entries().iter().find(|setup| setup.file.as_ref() == Some(&scene.file));
    line(
        &mut text,
        "set-up",
        Some(&wanting.map_or("none".into(), |setup| {
            let stand_in = setup.stand_in.as_ref().map(|name| format!(", where procedural:{name} stands in"));
            format!("{}{}", setup.id, stand_in.unwrap_or_default())
        })),
    );
    line(&mut text, "licence", Some(&scene.licence));
    line(&mut text, "original", scene.original.as_deref());
    line(&mut text, "the paper's", scene.papers_own.as_deref());
    line(&mut text, "made from", Some(&scene.made_from));
    line(&mut text, "note", scene.note.as_deref());
    text
}

fn line(text: &mut String, name: &str, value: Option<&str>) {
    if let Some(value) = value {
        let _ = writeln!(text, "    {name:<12}{value}");
    }
}
