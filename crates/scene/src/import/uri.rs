//! What a `uri` field refers to: data inside it, or a file beside the document.

use super::error::{ImportError, one_line, quoted};
use super::json::Item;
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Base64 as RFC 4648 has it, with or without the padding that some writers leave out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Reads up to `limit` bytes of what the text `uri` refers to; files are looked up in the folder `base`.
pub(super) fn read(uri: &Item<'_>, base: Option<&Path>, limit: u64) -> Result<Vec<u8>, ImportError> {
    let text = uri.text()?;
    match text.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data:") => read_data(uri, &text[5..]),
        _ => read_file(uri, &file_path(uri, text, base)?, limit),
    }
}

fn read_data(uri: &Item<'_>, text: &str) -> Result<Vec<u8>, ImportError> {
    let (header, data) = text.split_once(',').ok_or_else(|| uri.error("the data URI has no comma"))?;
    let bytes = percent_decode(data);
    if header.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        BASE64.decode(&bytes).map_err(|error| uri.error(format!("the data URI is not base64: {error}")))
    } else {
        Ok(bytes.into_owned())
    }
}

fn file_path(uri: &Item<'_>, text: &str, base: Option<&Path>) -> Result<PathBuf, ImportError> {
    let Some(base) = base else {
        return Err(
            uri.error(format!("refers to the file {}, but only data URIs can be read here", quoted(text)))
        );
    };
    let scheme = text.split(['/', '?', '#']).next().and_then(|start| start.split_once(':'));
    if let Some((scheme, _)) = scheme {
        let scheme = quoted(scheme);
        return Err(
            uri.error(format!("only data URIs and relative paths can be read, not the scheme {scheme}"))
        );
    }
    let decoded = percent_decode(text);
    let path =
        std::str::from_utf8(&decoded).map_err(|_| uri.error("is not UTF-8 once its % codes are resolved"))?;
    if path.is_empty() || Path::new(path).has_root() {
        return Err(uri.error(format!("must be a relative path, got {}", quoted(path))));
    }
    Ok(base.join(path))
}

fn read_file(uri: &Item<'_>, path: &Path, limit: u64) -> Result<Vec<u8>, ImportError> {
    let bad = |error: &dyn std::fmt::Display| {
        uri.error(format!("{} cannot be read: {error}", one_line(path.display())))
    };
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

/// Replaces %XX by the byte XX; a % that is followed by something else stays.
fn percent_decode(text: &str) -> Cow<'_, [u8]> {
    let bytes = text.as_bytes();
    if !bytes.contains(&b'%') {
        return Cow::Borrowed(bytes);
    }
    let digit = |at: usize| bytes.get(at).and_then(|&b| char::from(b).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], digit(at + 1), digit(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((16 * high + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    Cow::Owned(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn load(text: &str, base: Option<&Path>) -> Result<Vec<u8>, String> {
        let json = Value::from(text);
        read(&Item::object(&json, "buffer", 0), base, 4).map_err(|error| error.to_string())
    }

    #[test]
    fn percent_codes() {
        assert_eq!(&*percent_decode("a%20b%C3%a9"), "a b\u{e9}".as_bytes());
        assert_eq!(&*percent_decode("100%"), b"100%");
        assert_eq!(&*percent_decode("%zz%4"), b"%zz%4");
    }

    #[test]
    fn data() {
        assert_eq!(load("data:application/octet-stream;base64,AQID", None).unwrap(), [1, 2, 3]);
        assert_eq!(load("data:;base64,AQI=", None).unwrap(), [1, 2]);
        assert_eq!(load("DATA:;BASE64,AQI", None).unwrap(), [1, 2]);
        assert_eq!(load("data:text/plain,a%20b", None).unwrap(), b"a b");
        assert!(load("data:;base64", None).unwrap_err().contains("no comma"));
        assert!(load("data:;base64,A*", None).unwrap_err().contains("not base64"));
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
