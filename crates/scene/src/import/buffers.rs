//! Buffers and views of them.

use super::error::{ImportError, place};
use super::uri;
use gltf::Document;
use gltf::buffer::{Buffer, Source, View};
use std::borrow::Cow;
use std::path::Path;

/// The bytes of all buffers of a document.
#[derive(Debug)]
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

impl<'a> Buffers<'a> {
    /// Collects the buffers; `bin` is the chunk of binary glTF, `base` the folder of relative URIs.
    pub(super) fn load(
        document: &Document,
        bin: Option<&'a [u8]>,
        base: Option<&Path>,
    ) -> Result<Self, ImportError> {
        let load = |buffer: Buffer<'_>| load(&buffer, bin.filter(|_| buffer.index() == 0), base);
        document.buffers().map(load).collect::<Result<_, _>>().map(Self)
    }

    /// The part of a buffer that `view` means.
    pub(super) fn view(&self, view: &View<'_>) -> Result<&[u8], ImportError> {
        let (buffer, start, length) = (view.buffer(), view.offset(), view.length());
        let bytes = &self.0[buffer.index()];
        start.checked_add(length).and_then(|end| bytes.get(start..end)).ok_or_else(|| {
            let (buffer, total) = (place("buffer", buffer.index(), buffer.name()), bytes.len());
            let reason = format!("{length} bytes from {start} on do not fit in {buffer}, which has {total}");
            ImportError::at(place_of(view), reason)
        })
    }

    /// Number of bytes in all buffers together.
    pub(super) fn total(&self) -> usize {
        self.0.iter().map(|bytes| bytes.len()).sum()
    }
}

/// What errors call a view.
pub(super) fn place_of(view: &View<'_>) -> String {
    place("buffer view", view.index(), view.name())
}

fn load<'a>(
    buffer: &Buffer<'_>,
    bin: Option<&'a [u8]>,
    base: Option<&Path>,
) -> Result<Cow<'a, [u8]>, ImportError> {
    let place = place("buffer", buffer.index(), buffer.name());
    let length = buffer.length();
    let mut bytes = match (buffer.source(), bin) {
        (Source::Uri(uri), _) => Cow::Owned(uri::read(uri, &place, base, length as u64)?),
        (Source::Bin, Some(bin)) => Cow::Borrowed(bin),
        (Source::Bin, None) => {
            return Err(ImportError::at(place, "has no uri, and the file has no binary chunk for it"));
        }
    };
    if bytes.len() < length {
        let reason = format!("should have {length} bytes, but only {} are there", bytes.len());
        return Err(ImportError::at(place, reason));
    }
    // the binary chunk is padded, and a data URI may be longer than need be
    match &mut bytes {
        Cow::Owned(bytes) => bytes.truncate(length),
        Cow::Borrowed(bytes) => *bytes = &bytes[..length],
    }
    Ok(bytes)
}
