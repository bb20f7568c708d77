//! Typed reads from buffers. Everything is checked when an accessor is made, so that reading it cannot fail, and
//! nothing is allocated by a count that the bytes behind it do not bear out.

use super::buffers::{Buffers, View};
use super::document::{Document, List};
use super::error::{ImportError, quoted};
use super::json::Item;

/// Positions: vectors of three `f32`.
#[derive(Debug, Clone)]
pub(super) struct Positions<'a>(Elements<'a>);

/// Indices: scalars of an unsigned type.
#[derive(Debug, Clone)]
pub(super) struct Indices<'a> {
    elements: Elements<'a>,
    kind: IndexType,
}

impl<'a> Positions<'a> {
    /// Reads `item`, one of the document's accessors.
    pub(super) fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        item: &Item<'_>,
    ) -> Result<Self, ImportError> {
        check_shape(item, "VEC3")?;
        let component = item.need("componentType")?;
        // other types are for those who require KHR_mesh_quantization, which is refused
        match component.whole()? {
            5126 => Elements::new(document, buffers, item, 12).map(Self),
            other => Err(component.error(format!("positions must be f32 (5126), got {other}"))),
        }
    }

    /// Number of positions.
    pub(super) fn count(&self) -> usize {
        self.0.count
    }

    /// One position.
    pub(super) fn get(&self, index: usize) -> [f32; 3] {
        let bytes = self.0.get(index);
        [0, 4, 8].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
    }
}

impl<'a> Indices<'a> {
    /// Reads `item`, one of the document's accessors.
    pub(super) fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        item: &Item<'_>,
    ) -> Result<Self, ImportError> {
        check_shape(item, "SCALAR")?;
        let kind = IndexType::of(item)?;
        Ok(Self { elements: Elements::new(document, buffers, item, kind.size())?, kind })
    }

    /// Number of indices.
    pub(super) fn count(&self) -> usize {
        self.elements.count
    }

    /// One index.
    pub(super) fn get(&self, index: usize) -> u32 {
        self.kind.value(self.elements.get(index))
    }
}

fn check_shape(item: &Item<'_>, shape: &str) -> Result<(), ImportError> {
    let kind = item.need("type")?;
    if kind.text()? != shape {
        return Err(kind.error(format!("must be {shape:?} here, got {}", quoted(kind.text()?))));
    }
    match item.get("normalized")? {
        Some(normalized) if normalized.flag()? => {
            Err(normalized.error("positions and indices cannot be normalised"))
        }
        _ => Ok(()),
    }
}

/// Type of an index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum IndexType {
    U8,
    U16,
    U32,
}

impl IndexType {
    /// The `componentType` of an accessor or of the sparse part of one.
    fn of(item: &Item<'_>) -> Result<Self, ImportError> {
        let component = item.need("componentType")?;
        match component.whole()? {
            5121 => Ok(Self::U8),
            5123 => Ok(Self::U16),
            5125 => Ok(Self::U32),
            other => {
                let types = "u8 (5121), u16 (5123) or u32 (5125)";
                Err(component.error(format!("indices must be {types}, got {other}")))
            }
        }
    }

    fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 => 4,
        }
    }

    fn value(self, bytes: &[u8]) -> u32 {
        match self {
            Self::U8 => u32::from(bytes[0]),
            Self::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U32 => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }
}

/// The bytes of an accessor's elements.
#[derive(Debug, Clone)]
struct Elements<'a> {
    count: usize,
    /// Without it all elements are 0, but for the overlay.
    base: Option<Strided<'a>>,
    overlay: Option<Overlay<'a>>,
}

impl<'a> Elements<'a> {
    /// Elements of `size` bytes.
    fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        item: &Item<'_>,
        size: usize,
    ) -> Result<Self, ImportError> {
        let count = item.need("count")?.whole()?;
        let has_view = item.get("bufferView")?.is_some();
        let base = has_view.then(|| Strided::new(document, buffers, item, count, size)).transpose()?;
        let sparse = item.get("sparse")?;
        if base.is_none() {
            if sparse.is_none() {
                return Err(
                    item.error("has neither a bufferView nor a sparse part, so there is nothing to read")
                );
            }
            // zeros that no byte stands for; a limit of some kind keeps a tiny file from asking for gigabytes
            let total = buffers.total();
            if count > total as u64 {
                let text =
                    format!("{count} elements without a bufferView, but all buffers have {total} bytes only");
                return Err(item.error(text));
            }
        }
        let overlay =
            sparse.map(|sparse| Overlay::new(document, buffers, &sparse, count, size)).transpose()?;
        // in range, since no element is less than a byte of a buffer in memory
        Ok(Self { count: count as usize, base, overlay })
    }

    fn get(&self, index: usize) -> &'a [u8] {
        if let Some(overlay) = &self.overlay
            && let Ok(at) = overlay.indices.binary_search(&(index as u64))
        {
            return overlay.values.get(at);
        }
        self.base.as_ref().map_or(&[0; 12], |base| base.get(index))
    }
}

/// Elements that replace some of those that they lie over.
#[derive(Debug, Clone)]
struct Overlay<'a> {
    /// Which elements are replaced, in rising order.
    indices: Vec<u64>,
    values: Strided<'a>,
}

impl<'a> Overlay<'a> {
    /// Elements of `size` bytes over `total` others.
    fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        sparse: &Item<'_>,
        total: u64,
        size: usize,
    ) -> Result<Self, ImportError> {
        let count = sparse.need("count")?.whole()?;
        let values = Strided::new(document, buffers, &sparse.need("values")?, count, size)?;
        let item = sparse.need("indices")?;
        let kind = IndexType::of(&item)?;
        let indices = Strided::new(document, buffers, &item, count, kind.size())?;
        let indices: Vec<_> = (0..count as usize).map(|at| u64::from(kind.value(indices.get(at)))).collect();
        if let Some(pair) = indices.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(item.error(format!("must rise strictly, but {} follows {}", pair[1], pair[0])));
        }
        if let Some(last) = indices.last().filter(|&&last| last >= total) {
            return Err(item.error(format!("index {last} is out of range for {total} elements")));
        }
        Ok(Self { indices, values })
    }
}

/// Elements at equal distances in a buffer.
#[derive(Debug, Clone)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    /// `count` elements of `size` bytes, where the `bufferView` and `byteOffset` of `item` say.
    fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        item: &Item<'_>,
        count: u64,
        size: usize,
    ) -> Result<Self, ImportError> {
        let (_, view) = document.refer(List::BufferViews, &item.need("bufferView")?)?;
        let View { bytes, stride, place } = buffers.view(document, &view)?;
        let offset = item.get("byteOffset")?.map_or(Ok(0), |offset| offset.whole())?;
        let stride = stride.unwrap_or(size as u64);
        if stride < size as u64 {
            return Err(item
                .error(format!("elements of {size} bytes overlap in {place}, its byteStride is {stride}")));
        }
        let end = match count {
            0 => Some(0),
            _ => {
                (count - 1).checked_mul(stride).and_then(|n| n.checked_add(offset)?.checked_add(size as u64))
            }
        };
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let text = format!("{count} elements of {size} bytes, {stride} apart, from byte {offset} on");
            return Err(item.error(format!("{text} do not fit in {place}, which has {} bytes", bytes.len())));
        }
        // the end is in range of usize, so the offset of a first element is, and the stride to a second
        let start = if count == 0 { bytes.len() } else { offset as usize };
        let stride = if count > 1 { stride as usize } else { size };
        Ok(Self { bytes: &bytes[start..], stride, size })
    }

    fn get(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}
