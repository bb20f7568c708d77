//! Buffers and views of them.

use super::document::{Document, List};
use super::error::ImportError;
use super::json::Item;
use super::uri;
use std::borrow::Cow;
use std::path::Path;

/// The bytes of all buffers of a document.
#[derive(Debug)]
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

/// A part of a buffer.
#[derive(Debug, Clone)]
pub(super) struct View<'a> {
    /// The bytes of the view.
    pub(super) bytes: &'a [u8],
    /// Distance from one element to the next, if the view states one; units: bytes.
    pub(super) stride: Option<u64>,
    /// What errors call the view.
    pub(super) place: String,
}

impl<'a> Buffers<'a> {
    /// Collects the buffers; `bin` is the chunk of binary glTF, `base` the folder of relative URIs.
    pub(super) fn load(
        document: &Document<'a>,
        bin: Option<&'a [u8]>,
        base: Option<&Path>,
    ) -> Result<Self, ImportError> {
        document
            .all(List::Buffers)
            .enumerate()
            .map(|(i, item)| load(&item, bin.filter(|_| i == 0), base))
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// The part of a buffer that `view`, one of the document's views, means.
    pub(super) fn view(&self, document: &Document<'_>, view: &Item<'_>) -> Result<View<'_>, ImportError> {
        let (buffer, item) = document.refer(List::Buffers, &view.need("buffer")?)?;
        let bytes = &self.0[buffer];
        let length = view.need("byteLength")?.whole()?;
        let start = view.get("byteOffset")?.map_or(Ok(0), |offset| offset.whole())?;
        let range = start
            .checked_add(length)
            .and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        let bytes = range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            let place = item.place();
            view.error(format!(
                "{length} bytes from {start} on do not fit in {place}, which has {}",
                bytes.len()
            ))
        })?;
        let stride = view.get("byteStride")?.map(|stride| stride.whole()).transpose()?;
        Ok(View { bytes, stride, place: view.place().into() })
    }

    /// Number of bytes in all buffers together.
    pub(super) fn total(&self) -> usize {
        self.0.iter().map(|bytes| bytes.len()).sum()
    }
}

fn load<'a>(
    item: &Item<'a>,
    bin: Option<&'a [u8]>,
    base: Option<&Path>,
) -> Result<Cow<'a, [u8]>, ImportError> {
    let length = item.need("byteLength")?.whole()?;
    let mut bytes = match (item.get("uri")?, bin) {
        (Some(uri), _) => Cow::Owned(uri::read(&uri, base, length)?),
        (None, Some(bin)) => Cow::Borrowed(bin),
        (None, None) => return Err(item.error("has no uri, and the file has no binary chunk for it")),
    };
    if (bytes.len() as u64) < length {
        return Err(item.error(format!("should have {length} bytes, but only {} are there", bytes.len())));
    }
    // the binary chunk is padded, and a data URI may be longer than need be
    match &mut bytes {
        Cow::Owned(bytes) => bytes.truncate(length as usize),
        Cow::Borrowed(bytes) => *bytes = &bytes[..length as usize],
    }
    Ok(bytes)
}
