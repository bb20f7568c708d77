//! The two forms of a glTF file: text, and a binary container around it.

use super::error::{ImportError, one_line};
use gltf::binary::{Error as GlbError, Glb};
use std::borrow::Cow;

/// The document's text, and the chunk of bytes of binary glTF.
pub(super) type Parts<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// Splits a `.glb` into its parts; anything that starts like JSON is a `.gltf`.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, ImportError> {
    let bad = |why: String| Err(ImportError::Container(why));
    if bytes.is_empty() {
        return bad("the file is empty".into());
    }
    if !bytes.starts_with(b"glTF") {
        // a byte order mark is not allowed, but readers may let it pass
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if text.trim_ascii_start().first() != Some(&b'{') {
            return bad("it starts neither with \"glTF\" nor with a JSON object".into());
        }
        return Ok((text.into(), None));
    }
    let Some(&[a, b, c, d]) = bytes.get(8..12) else {
        return bad(format!("the file ends inside its header, after {} bytes", bytes.len()));
    };
    // the crate takes what follows the stated length for a chunk, and subtracts the header's 12 bytes unchecked
    let length = u32::from_le_bytes([a, b, c, d]);
    let Some(stated) = bytes.get(..length as usize).filter(|stated| stated.len() >= 12) else {
        return bad(format!("its header speaks of {length} bytes, the file has {}", bytes.len()));
    };
    match Glb::from_slice(stated) {
        Ok(glb) => Ok((glb.json, glb.bin)),
        Err(gltf::Error::Binary(GlbError::Io(_))) => bad("it ends inside a chunk's header".into()),
        Err(error) => bad(one_line(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const JSON: [u8; 4] = *b"JSON";
    const BIN: [u8; 4] = *b"BIN\0";

    fn chunk(kind: [u8; 4], bytes: &[u8]) -> Vec<u8> {
        [&(bytes.len() as u32).to_le_bytes(), &kind, bytes].concat()
    }

    fn glb(version: u32, chunks: &[Vec<u8>]) -> Vec<u8> {
        let body = chunks.concat();
        [&b"glTF"[..], &version.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat()
    }

    fn message(bytes: &[u8]) -> String {
        split(bytes).map(|_| String::new()).unwrap_or_else(|error| error.to_string())
    }

    #[test]
    fn both_forms_open() {
        let bin = |bytes: &[u8]| split(bytes).unwrap().1.map(Cow::into_owned);
        let json = chunk(JSON, b"{}  ");
        let whole = glb(2, &[json.clone(), chunk(BIN, &[1, 2, 3, 4])]);
        assert_eq!(bin(&whole), Some(vec![1, 2, 3, 4]));
        assert_eq!(bin(&glb(2, std::slice::from_ref(&json))), None);
        // chunks of unknown kinds may follow
        assert_eq!(bin(&glb(2, &[json, chunk(BIN, &[5]), chunk(*b"ODD!", &[9])])), Some(vec![5]));
        assert!(split(b" \n{}").is_ok() && split(b"\xef\xbb\xbf{}").is_ok());
        // bytes after the stated length are not part of the file
        assert!(split(&[&whole[..], b"tail"].concat()).is_ok());
    }

    #[test]
    fn every_cut_is_noticed() {
        let whole = glb(2, &[chunk(JSON, b"{}  "), chunk(BIN, &[1, 2, 3, 4])]);
        for end in 0..whole.len() {
            let message = message(&whole[..end]);
            assert!(message.starts_with("not a glTF file: "), "{end}: {message}");
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
        assert!(message(&glb(1, &[])).contains("unsupported version"));
        assert!(message(&glb(2, &[chunk(BIN, b"")])).contains("not expecting BIN"));
        assert!(message(&glb(2, &[])).contains("chunk's header"));
        // a stated length shorter than the header itself
        let mut short = glb(2, &[]);
        short[8] = 3;
        assert!(message(&short).contains("speaks of 3 bytes"));
    }
}
