//! `manifest.json` of a scenes folder: what its owner says is in it.

use std::path::Path;

use serde::Deserialize;

use super::known::Known;
use crate::failure::{Failure, Outcome};
use crate::output_file::read_input;

/// The manifest of a folder; empty where there is none.
#[derive(Debug, Default)]
pub(super) struct Manifest {
    pub(super) entries: Vec<Listed>,
}

/// One file of it; what else it says of the file is not read.
#[derive(Debug, Deserialize)]
pub(super) struct Listed {
    pub(super) file: String,
    pub(super) sha256: String,
    paper_row: Option<String>,
    pub(super) licence: Option<String>,
    pub(super) source: Option<String>,
}

impl Listed {
    /// The row of a paper that it stands for.
    pub(super) fn row(&self) -> Option<&str> {
        self.paper_row.as_deref()
    }
}

impl Manifest {
    /// Reads the manifest of a folder, if it has one.
    pub(super) fn of(folder: &Path) -> Outcome<Self> {
        let path = folder.join("manifest.json");
        if !path.exists() {
            return Ok(Self::default());
        }
        let wrong = |what: String| Failure::input(format!("{}: {what}", path.display()));
        let entries: Vec<Listed> =
            serde_json::from_slice(&read_input(&path)?).map_err(|e| wrong(e.to_string()))?;
        for entry in &entries {
            // nothing outside of the folder is read
            if Path::new(&entry.file).file_name() != Some(entry.file.as_ref()) {
                return Err(wrong(format!("{:?} is not the name of a file in its folder", entry.file)));
            }
        }
        Ok(Self { entries })
    }

    /// What it lists that is not known.
    pub(super) fn beside<'a>(&'a self, known: &'a Known) -> impl Iterator<Item = &'a Listed> {
        self.entries.iter().filter(|entry| known.scenes.iter().all(|scene| scene.file != entry.file))
    }
}
