//! Binary glTF: a header, a chunk of JSON and maybe a chunk of bytes.

use super::error::{ImportError, one_line};
use serde_json::Value;

/// The two parts of a glTF file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// The document.
    pub(super) json: Value,
    /// The chunk of bytes of binary glTF.
    pub(super) bin: Option<&'a [u8]>,
}

const JSON: [u8; 4] = *b"JSON";
const BIN: [u8; 4] = *b"BIN\0";

/// Splits a `.glb` into its parts; anything that starts like JSON is a `.gltf`.
pub(super) fn open(bytes: &[u8]) -> Result<Container<'_>, ImportError> {
    let bad = |why: &str| Err(ImportError::Container(why.into()));
    if bytes.is_empty() {
        return bad("the file is empty");
    }
    if bytes.starts_with(b"glTF") {
        return open_binary(bytes);
    }
    // a byte order mark is not allowed, but readers may let it pass
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if text.trim_ascii_start().first() != Some(&b'{') {
        return bad("it starts neither with \"glTF\" nor with a JSON object");
    }
    Ok(Container { json: parse(text)?, bin: None })
}

fn open_binary(bytes: &[u8]) -> Result<Container<'_>, ImportError> {
    let bad = |why: String| Err(ImportError::Container(why));
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return bad(format!("the file ends inside its header, after {} bytes", bytes.len()));
    };
    if version != 2 {
        return bad(format!("its container has version {version}, only 2 can be read"));
    }
    let Some(mut rest) = bytes.get(12..length as usize) else {
        return bad(format!("its header speaks of {length} bytes, the file has {}", bytes.len()));
    };
    let mut json = None;
    let mut bin = None;
    // chunks of unknown kinds may follow, and are skipped
    while bin.is_none() && !rest.is_empty() {
        let (Some(size), Some(kind)) = (word(rest, 0), rest.get(4..8)) else {
            return bad(format!("it ends inside a chunk's header, {} bytes before the end", rest.len()));
        };
        let Some((chunk, after)) = rest[8..].split_at_checked(size as usize) else {
            return bad(format!("a chunk of {size} bytes is cut off after {}", rest.len() - 8));
        };
        match (json.is_some(), kind == JSON, kind == BIN) {
            (false, true, _) => json = Some(parse(chunk)?),
            (false, false, _) => return bad("its first chunk is not JSON".into()),
            (true, _, true) => bin = Some(chunk),
            _ => {}
        }
        rest = after;
    }
    match json {
        Some(json) => Ok(Container { json, bin }),
        None => bad("it has no JSON chunk".into()),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

fn parse(text: &[u8]) -> Result<Value, ImportError> {
    // serde_json stops at a nesting of 128, so that no text can exhaust the stack
    serde_json::from_slice(text).map_err(|error| ImportError::Json(one_line(error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(kind: [u8; 4], bytes: &[u8]) -> Vec<u8> {
        [&(bytes.len() as u32).to_le_bytes(), &kind, bytes].concat()
    }

    fn glb(version: u32, chunks: &[Vec<u8>]) -> Vec<u8> {
        let body = chunks.concat();
        [&b"glTF"[..], &version.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }

    fn message(bytes: &[u8]) -> String {
        open(bytes).map(|_| String::new()).unwrap_or_else(|error| error.to_string())
    }

    #[test]
    fn both_forms_open() {
        let json = chunk(JSON, b"{}  ");
        let whole = glb(2, &[json.clone(), chunk(BIN, &[1, 2, 3, 4])]);
        assert_eq!(open(&whole).unwrap().bin, Some(&[1, 2, 3, 4][..]));
        assert_eq!(open(&glb(2, std::slice::from_ref(&json))).unwrap().bin, None);
        let odd = glb(2, &[json, chunk(*b"ODD!", &[9]), chunk(BIN, &[5])]);
        assert_eq!(open(&odd).unwrap().bin, Some(&[5][..]));
        assert!(open(b" \n{}").is_ok() && open(b"\xef\xbb\xbf{}").is_ok());
        // bytes after the stated length are not part of the file
        assert!(open(&[&whole[..], b"tail"].concat()).is_ok());
    }

    #[test]
    fn every_cut_is_noticed() {
        let whole = glb(2, &[chunk(JSON, b"{}  "), chunk(BIN, &[1, 2, 3, 4])]);
        for end in 0..whole.len() {
            assert!(
                message(&whole[..end]).starts_with("not a glTF file: "),
                "{end}: {}",
                message(&whole[..end])
            );
        }
        // the same with an honest header, as far as there is one
        for end in 12..whole.len() {
            let mut cut = whole[..end].to_vec();
            cut[8..12].copy_from_slice(&(end as u32).to_le_bytes());
            // 24 bytes are a file of a JSON chunk alone
            assert_eq!(message(&cut).is_empty(), end == 24, "{end}: {}", message(&cut));
        }
    }

    #[test]
    fn nonsense_is_refused() {
        assert_eq!(message(b""), "not a glTF file: the file is empty");
        assert!(message(b"\x89PNG").contains("starts neither"));
        assert!(message(&glb(1, &[])).contains("version 1"));
        assert!(message(&glb(2, &[chunk(BIN, b"")])).contains("first chunk"));
        assert!(message(&glb(2, &[])).contains("no JSON"));
        assert!(message(b"{\"a\": ").starts_with("not valid JSON: "));
        assert!(
            message("[{".repeat(100_000).replacen('[', "{\"a\":[", 1).as_bytes())
                .starts_with("not valid JSON")
        );
        // a stated length shorter than the header itself
        let mut short = glb(2, &[]);
        short[8] = 3;
        assert!(message(&short).contains("speaks of 3 bytes"));
    }
}
