//! Whether a file is the one that is known by its name.

use std::path::Path;

use scene::import::load_gltf_bytes;
use sha2::{Digest, Sha256};

use super::known::KnownScene;
use crate::output_file::read_input;

/// What became of a file.
#[derive(Debug)]
pub(super) enum State {
    /// It is there, bit by bit.
    Present,
    /// It is not there.
    Missing,
    /// Another file has its name.
    Altered {
        /// Checksum in hexadecimal digits; empty where it cannot be read.
        sha256: String,
        /// What it holds instead.
        found: String,
    },
}

impl State {
    /// Compares a file of `folder` with its checksum, and one that has another with what is `known` of it.
    pub(super) fn of(folder: &Path, file: &str, sha256: &str, known: Option<&KnownScene>) -> Self {
        let path = folder.join(file);
        if !path.exists() {
            return Self::Missing;
        }
        let bytes = match read_input(&path) {
            Ok(bytes) => bytes,
            Err(failure) => return Self::Altered { sha256: String::new(), found: failure.to_string() },
        };
        let found = checksum(&bytes);
        if found == sha256.to_lowercase() {
            return Self::Present;
        }
        Self::Altered { sha256: found, found: describe(&bytes, known) }
    }

    /// Place in a count of all three.
    pub(super) fn index(&self) -> usize {
        match self {
            Self::Present => 0,
            Self::Missing => 1,
            Self::Altered { .. } => 2,
        }
    }
}

impl std::fmt::Display for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Present => f.write_str("present"),
            Self::Missing => f.write_str("missing"),
            Self::Altered { found, .. } => write!(f, "altered: {found}"),
        }
    }
}

/// SHA-256 in hexadecimal digits.
pub(super) fn checksum(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What is in a file of another checksum, in words.
fn describe(bytes: &[u8], known: Option<&KnownScene>) -> String {
    let scene = match load_gltf_bytes(bytes, None) {
        Ok(scene) => scene,
        Err(error) => return error.to_string(),
    };
    let triangles = scene.triangle_count();
    let Some(known) = known else { return format!("{triangles} triangles") };
    let (bounds, wanted) = (scene.bounds(), known.bounds());
    // the known box is rounded to four decimals
    let tolerance = 1e-4 + 1e-4 * wanted.diagonal();
    let same = [bounds.min - wanted.min, bounds.max - wanted.max];
    let place =
        if same.iter().all(|d| d.abs().max_element() <= tolerance) { "in its box" } else { "in another box" };
    format!("{triangles} triangles {place}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_sha_256() {
        // FIPS 180-2, appendix B.1
        let digits = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(checksum(b"abc"), digits);
    }
}
