//! The shader library: WGSL files that import shared ones, put together here.
//!
//! A line `#import NAME` stands for `shaders/shared/NAME.wgsl`; each file comes in once. Nothing else is preprocessed:
//! variants use WGSL's own `override` constants.

use crate::CreateError;

#[cfg(test)]
mod uniform_branches;

/// A shader file of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct File {
    /// Path under `shaders/` without its ending.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(File { name: $name, text: include_str!(concat!("../shaders/", $name, ".wgsl")) }),*]
    };
}

/// Files that others import: functions and structs; bindings only where many passes share them (`shared/bindings`).
pub const SHARED: &[File] = files![
    "shared/airlight",
    "shared/bindings",
    "shared/bindings_bvh",
    "shared/bindings_view",
    "shared/blocks",
    "shared/bvh",
    "shared/elementary",
    "shared/faces",
    "shared/frame_table",
    "shared/froxel",
    "shared/froxel_voxels",
    "shared/froxel_which",
    "shared/hybrid",
    "shared/hybrid_textured",
    "shared/judge",
    "shared/leaf_head",
    "shared/light",
    "shared/light_crossing",
    "shared/light_mesh",
    "shared/light_mips",
    "shared/light_path",
    "shared/map_nodes",
    "shared/march",
    "shared/march_varying",
    "shared/medium_path",
    "shared/phase",
    "shared/piece",
    "shared/pixels",
    "shared/pixels_listed",
    "shared/prediction",
    "shared/ray_list",
    "shared/sampling",
    "shared/shadow_map",
    "shared/sight_map",
    "shared/sight_rays",
    "shared/steps",
    "shared/tessellation",
    "shared/traversal",
    "shared/view",
    "shared/volume",
];

/// Passes: one entry point each.
pub const PASSES: &[File] = files![
    "frame/composite",
    "frame/downsample",
    "frame/ray_ends",
    "frame/surfaces",
    "frame/upsample",
    "froxel/accumulate",
    "froxel/apply",
    "froxel/grid",
    "froxel/lighting",
    "froxel/mark",
    "froxel/near",
    "froxel/reach",
    "froxel/tile_ends",
    "lightvolume/criterion",
    "lightvolume/gate",
    "lightvolume/grid",
    "lightvolume/hierarchy",
    "lightvolume/indexed_grid",
    "lightvolume/leaf_surface",
    "lightvolume/leaves",
    "lightvolume/mesh",
    "lightvolume/seams",
    "lightvolume/settle",
    "lightvolume/walls",
    "map/depth",
    "map/heights",
    "map/pyramid",
    "probe/airlight",
    "probe/occlusion",
    "probe/special",
    "sample/budget",
    "sample/close",
    "sample/keep",
    "sample/lattice",
    "sample/refine",
    "sample/survey",
    "sample/tolerance",
    "scatter/exact",
    "scatter/frame_table",
    "scatter/hybrid",
    "scatter/hybrid_rays",
    "scatter/hybrid_textured",
    "scatter/hybrid_textured_rays",
    "scatter/light_volume",
    "scatter/march",
    "scatter/march_rays",
    "scatter/march_varying",
    "scatter/march_varying_rays",
    "volume/face_depths",
    "volume/faces",
    "volume/merge",
    "volume/resolve",
    "volume/silhouette",
    "volume/tiles",
];

/// The text of a pass with everything that it imports in front.
///
/// # Errors
/// [`CreateError::Shader`] if the pass is unknown, an import is, or files import each other in a circle.
pub fn assemble(pass: &str) -> Result<String, CreateError> {
    assemble_with(pass, &|name| name)
}

/// The same of a scattering pass over the pixels of a list instead of all.
///
/// # Errors
/// As [`assemble`].
pub fn assemble_listed(pass: &str) -> Result<String, CreateError> {
    assemble_with(pass, &|name| if name == "pixels" { "pixels_listed" } else { name })
}

/// Puts a pass together; `stands_for` says which file an import means.
fn assemble_with(
    pass: &str,
    stands_for: &dyn Fn(&'static str) -> &'static str,
) -> Result<String, CreateError> {
    let file = find(PASSES, pass, pass)?;
    let mut done = Vec::new();
    let mut text = String::new();
    append(file, stands_for, &mut Vec::new(), &mut done, &mut text)?;
    Ok(text)
}

fn find(files: &'static [File], name: &str, asked_by: &str) -> Result<&'static File, CreateError> {
    files.iter().find(|file| file.name == name).ok_or_else(|| CreateError::Shader {
        file: asked_by.to_owned(),
        reason: format!("there is no file {name}.wgsl"),
    })
}

/// Appends what `file` imports, then `file`; `path` is how it was reached.
fn append(
    file: &'static File,
    stands_for: &dyn Fn(&'static str) -> &'static str,
    path: &mut Vec<&'static str>,
    done: &mut Vec<&'static str>,
    text: &mut String,
) -> Result<(), CreateError> {
    if done.contains(&file.name) {
        return Ok(());
    }
    if path.contains(&file.name) {
        let circle = path.join(" -> ");
        return Err(CreateError::Shader {
            file: file.name.to_owned(),
            reason: format!("imports itself: {circle} -> {}", file.name),
        });
    }
    path.push(file.name);
    let import = |line: &'static str| line.strip_prefix("#import ").map(str::trim);
    for name in file.text.lines().filter_map(import) {
        let name = stands_for(name);
        append(find(SHARED, &format!("shared/{name}"), file.name)?, stands_for, path, done, text)?;
    }
    path.pop();
    done.push(file.name);
    for line in file.text.lines().filter(|line| import(line).is_none()) {
        text.push_str(line);
        text.push('\n');
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_pass_validates_without_a_gpu() {
        assert!(!PASSES.is_empty());
        let listed = |pass: &&File| pass.name.starts_with("scatter/") && !pass.name.ends_with("_table");
        let whole = PASSES.iter().map(|pass| (pass, assemble(pass.name).unwrap()));
        // a light volume is drawn for all pixels at once
        let lists = PASSES.iter().filter(listed).filter(|pass| pass.name != "scatter/light_volume");
        let lists = lists.map(|pass| (pass, assemble_listed(pass.name).unwrap()));
        for (pass, text) in whole.chain(lists) {
            let module = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|e| panic!("{}: {}", pass.name, e.emit_to_string(&text)));
            let mut validator = naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            );
            validator
                .validate(&module)
                .unwrap_or_else(|e| panic!("{}: {}", pass.name, e.emit_to_string(&text)));
            let stages: Vec<naga::ShaderStage> = module.entry_points.iter().map(|e| e.stage).collect();
            let drawn = [naga::ShaderStage::Vertex, naga::ShaderStage::Fragment];
            assert!(
                stages == [naga::ShaderStage::Compute] || stages == drawn,
                "{} has the entry points {stages:?}",
                pass.name
            );
        }
    }

    #[test]
    fn no_file_is_an_orphan() {
        let mut on_disk = BTreeSet::new();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        for folder in std::fs::read_dir(&root).unwrap() {
            let folder = folder.unwrap();
            for file in std::fs::read_dir(folder.path()).unwrap() {
                let name = file.unwrap().file_name().into_string().unwrap();
                let stem = name.strip_suffix(".wgsl").expect("only shaders are here").to_owned();
                on_disk.insert(format!("{}/{stem}", folder.file_name().into_string().unwrap()));
            }
        }
        let known: BTreeSet<String> = SHARED.iter().chain(PASSES).map(|file| file.name.to_owned()).collect();
        assert_eq!(on_disk, known);
        for shared in SHARED {
            let imported = format!("#import {}", shared.name.trim_start_matches("shared/"));
            // it takes the place of another
            let imported =
                if imported == "#import pixels_listed" { "#import pixels".into() } else { imported };
            let users =
                SHARED.iter().chain(PASSES).filter(|file| file.text.lines().any(|line| line == imported));
            assert!(users.count() > 0, "nothing imports {}", shared.name);
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let error = assemble("probe/nothing").unwrap_err().to_string();
        assert!(error.contains("probe/nothing"), "{error}");
    }
}
