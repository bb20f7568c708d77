//! What can be wrong with a file.

use std::fmt::Display;
use std::path::PathBuf;
use thiserror::Error;

/// A file that cannot become a scene; the text is one line and names the place at fault.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImportError {
    /// Something is wrong in this file.
    #[error("{}: {error}", one_line(path.display()))]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: Box<Self>,
    },
    /// The file cannot be read at all.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The file is neither binary glTF nor JSON, or is cut short.
    #[error("not a glTF file: {0}")]
    Container(String),
    /// The JSON part is not JSON.
    #[error("not valid JSON: {0}")]
    Json(String),
    /// The file cannot be understood without an extension that is not supported.
    #[error("requires the extension {0:?}, which is not supported")]
    Extension(String),
    /// A glTF object holds something that makes no sense.
    #[error("{place}: {reason}")]
    Item {
        /// The object or the way to it, such as `scene 0 extras.medium.sigma_s` or `nodes[3].mesh`.
        place: String,
        /// What is wrong there.
        reason: String,
    },
    /// A picture that cannot be used as a light texture.
    #[error("not usable as a light texture: {0}")]
    Image(String),
    /// The scene has more triangles than a 32-bit index reaches.
    #[error("the scene has {0} triangles; at most 2^31 can be indexed")]
    TooManyTriangles(u64),
}

impl ImportError {
    /// An error at `place`, which may hold names out of the file.
    pub(super) fn at(place: impl Display, reason: impl Display) -> Self {
        Self::Item { place: one_line(place), reason: one_line(reason) }
    }
}

/// What errors and notes call an object of the document, such as `node 3 "lamp"`.
pub(super) fn place(word: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{word} {index} {}", quoted(name)),
        None => format!("{word} {index}"),
    }
}

/// Text of a file or a library on one line and of bearable length, for use in an error.
pub(super) fn one_line(text: impl Display) -> String {
    const LONGEST: usize = 300;
    let mut line = String::new();
    for c in text.to_string().trim_end().chars().take(LONGEST) {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
    }
    line
}

/// A name out of a file, quoted and of bearable length.
pub(super) fn quoted(name: &str) -> String {
    const LONGEST: usize = 60;
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}", format!("{}...", &name[..end])),
        None => format!("{name:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_stay_on_one_line() {
        let error = ImportError::InFile {
            path: "a\nb.glb".into(),
            error: Box::new(ImportError::at("node 0", "c\r\nd\n")),
        };
        assert_eq!(error.to_string(), "a\\nb.glb: node 0: c\\r\\nd");
        assert_eq!(place("node", 3, None), "node 3");
        assert_eq!(place("node", 3, Some("lamp\n")), "node 3 \"lamp\\n\"");
        assert_eq!(quoted(&"é".repeat(100)).chars().count(), 65);
    }
}
