//! What a `uri` field refers to: data inside it, or a file beside the document.
//!
//! The crate's own import would follow absolute paths and `file:` URIs, and read files of any kind and length.

use super::error::{ImportError, one_line, quoted};
use data_url::{DataUrl, DataUrlError};
use std::fmt::Display;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Reads up to `limit` bytes of what `uri`, a field of the object called `place`, refers to.
///
/// Files are looked up in the folder `base`; without one they are refused.
pub(super) fn read(uri: &str, place: &str, base: Option<&Path>, limit: u64) -> Result<Vec<u8>, ImportError> {
    let read = match DataUrl::process(uri) {
        Ok(data) => data.decode_to_vec().map(|(bytes, _)| bytes).map_err(|error| error.to_string()),
        Err(DataUrlError::NotADataUrl) => file_path(uri, base).and_then(|path| read_file(&path, limit)),
        Err(error) => Err(error.to_string()),
    };
    read.map_err(|reason| ImportError::at(format!("{place} uri"), reason))
}

fn file_path(uri: &str, base: Option<&Path>) -> Result<PathBuf, String> {
    let Some(base) = base else {
        return Err(format!("refers to the file {}, but only data URIs can be read here", quoted(uri)));
    };
    if let Some((scheme, _)) = uri.split(['/', '?', '#']).next().and_then(|start| start.split_once(':')) {
        let scheme = quoted(scheme);
        return Err(format!("only data URIs and relative paths can be read, not the scheme {scheme}"));
    }
    let path = percent_encoding::percent_decode_str(uri).decode_utf8();
    let path = path.map_err(|_| "is not UTF-8 once its % codes are resolved")?;
    if path.is_empty() || Path::new(&*path).has_root() {
        return Err(format!("must be a relative path, got {}", quoted(&path)));
    }
    Ok(base.join(&*path))
}

fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let bad = |error: &dyn Display| format!("{} cannot be read: {error}", one_line(path.display()));
    // asked before opening: a pipe would block and a device never end
    let meta = std::fs::metadata(path).map_err(|error| bad(&error))?;
    if !meta.is_file() {
        return Err(bad(&"it is not a file"));
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(|error| bad(&error))?;
    file.take(limit).read_to_end(&mut bytes).map_err(|error| bad(&error))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str, base: Option<&Path>) -> Result<Vec<u8>, String> {
        read(text, "buffer 0", base, 4).map_err(|error| error.to_string())
    }

    #[test]
    fn data() {
        assert_eq!(load("data:application/octet-stream;base64,AQID", None).unwrap(), [1, 2, 3]);
        assert_eq!(load("data:;base64,AQI=", None).unwrap(), [1, 2]);
        assert_eq!(load("DATA:;BASE64,AQI", None).unwrap(), [1, 2]);
        assert_eq!(load("data:text/plain,a%20b", None).unwrap(), b"a b");
        assert!(load("data:;base64", None).unwrap_err().contains("missing comma"));
        assert!(load("data:;base64,A*", None).unwrap_err().starts_with("buffer 0 uri: "));
    }

    #[test]
    fn files() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a b.bin"), [1, 2, 3, 4, 5]).unwrap();
        assert!(load("a.bin", None).unwrap_err().contains("only data URIs"));
        let load = |text: &str| load(text, Some(folder.path()));
        assert_eq!(load("a%20b.bin").unwrap(), [1, 2, 3, 4]);
        assert_eq!(load("./a b.bin").unwrap(), [1, 2, 3, 4]);
        assert!(load("none.bin").unwrap_err().contains("none.bin cannot be read"));
        assert!(load(".").unwrap_err().contains("not a file"));
        assert!(load("/etc/hosts").unwrap_err().contains("relative"));
        assert!(load("").unwrap_err().contains("relative"));
        assert!(load("file:///etc/hosts").unwrap_err().contains("scheme \"file\""));
        assert!(load("%ff").unwrap_err().contains("UTF-8"));
        assert!(load("%00").unwrap_err().contains("cannot be read"));
    }
}
