//! The crate's iterators over accessors, made from ranges that are known to be there.
//!
//! What the crate offers for this (`Primitive::reader`, `accessor::Iter::new`) computes ranges without regard to
//! overflow or to the size of elements. Everything is checked when an iterator is made, so that reading it cannot
//! fail, and nothing is allocated by a count that the bytes behind it do not bear out.

use super::buffers::{Buffers, place_of};
use super::error::{ImportError, place};
use gltf::Accessor;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::util::{ItemIter, SparseIndicesIter, SparseIter};
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::buffer::View;
use gltf::mesh::util::{ReadIndices, ReadPositions};

/// Positions: vectors of three `f32`.
pub(super) fn positions<'a>(
    buffers: &'a Buffers<'_>,
    accessor: &Accessor<'_>,
) -> Result<ReadPositions<'a>, ImportError> {
    check_shape(accessor, Dimensions::Vec3)?;
    match accessor.data_type() {
        DataType::F32 => items(buffers, accessor),
        // for those who require KHR_mesh_quantization, which is refused
        other => Err(error(accessor, format!("positions must be f32 (5126), got {}", other.as_gl_enum()))),
    }
}

/// Indices: scalars of an unsigned type.
pub(super) fn indices<'a>(
    buffers: &'a Buffers<'_>,
    accessor: &Accessor<'_>,
) -> Result<ReadIndices<'a>, ImportError> {
    check_shape(accessor, Dimensions::Scalar)?;
    match accessor.data_type() {
        DataType::U8 => items(buffers, accessor).map(ReadIndices::U8),
        DataType::U16 => items(buffers, accessor).map(ReadIndices::U16),
        DataType::U32 => items(buffers, accessor).map(ReadIndices::U32),
        other => {
            let types = "u8 (5121), u16 (5123) or u32 (5125)";
            Err(error(accessor, format!("indices must be {types}, got {}", other.as_gl_enum())))
        }
    }
}

fn error(accessor: &Accessor<'_>, reason: String) -> ImportError {
    ImportError::at(place("accessor", accessor.index(), accessor.name()), reason)
}

fn check_shape(accessor: &Accessor<'_>, wanted: Dimensions) -> Result<(), ImportError> {
    if accessor.dimensions() != wanted {
        return Err(error(accessor, format!("must be {wanted:?} here, got {:?}", accessor.dimensions())));
    }
    if accessor.normalized() {
        return Err(error(accessor, "positions and indices cannot be normalised".into()));
    }
    Ok(())
}

fn items<'a, T: Item>(buffers: &'a Buffers<'_>, accessor: &Accessor<'_>) -> Result<Iter<'a, T>, ImportError> {
    let place = place("accessor", accessor.index(), accessor.name());
    let count = accessor.count();
    if u32::try_from(count).is_err() {
        return Err(error(accessor, format!("{count} elements are more than 32-bit indices reach")));
    }
    let base = accessor.view().map(|view| strided(buffers, &view, accessor.offset(), count, &place));
    let base = base.transpose()?;
    let Some(sparse) = accessor.sparse() else {
        return base.map(Iter::Standard).ok_or_else(|| error(accessor, "has no bufferView".into()));
    };
    // zeros that no byte stands for; a limit of some kind keeps a tiny file from asking for gigabytes
    if base.is_none() && count > buffers.total() {
        let total = buffers.total();
        let reason =
            format!("{count} elements without a bufferView, but all buffers have {total} bytes only");
        return Err(error(accessor, reason));
    }
    let (values, indices, changes) = (sparse.values(), sparse.indices(), sparse.count());
    let values =
        strided(buffers, &values.view(), values.offset(), changes, &format!("{place} sparse.values"))?;
    let place = format!("{place} sparse.indices");
    let (view, offset) = (indices.view(), indices.offset());
    let indices = match indices.index_type() {
        IndexType::U8 => SparseIndicesIter::U8(strided(buffers, &view, offset, changes, &place)?),
        IndexType::U16 => SparseIndicesIter::U16(strided(buffers, &view, offset, changes, &place)?),
        IndexType::U32 => SparseIndicesIter::U32(strided(buffers, &view, offset, changes, &place)?),
    };
    check_order(indices.clone(), count, &place)?;
    Ok(Iter::Sparse(SparseIter::with_base_count(base, count, indices, values)))
}

/// Sparse indices must rise and mean elements that there are.
fn check_order(indices: SparseIndicesIter<'_>, total: usize, place: &str) -> Result<(), ImportError> {
    let mut last = None;
    for index in indices {
        if let Some(last) = last.filter(|&last| last >= index) {
            return Err(ImportError::at(place, format!("must rise strictly, but {index} follows {last}")));
        }
        if index as usize >= total {
            return Err(ImportError::at(
                place,
                format!("index {index} is out of range for {total} elements"),
            ));
        }
        last = Some(index);
    }
    Ok(())
}

/// `count` elements from byte `offset` of a view on, for the accessor or the part of one called `place`.
fn strided<'a, T: Item>(
    buffers: &'a Buffers<'_>,
    view: &View<'_>,
    offset: usize,
    count: usize,
    place: &str,
) -> Result<ItemIter<'a, T>, ImportError> {
    let size = size_of::<T>();
    let bytes = buffers.view(view)?;
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        let view = place_of(view);
        let reason = format!("elements of {size} bytes overlap in {view}, its byteStride is {stride}");
        return Err(ImportError::at(place, reason));
    }
    let length = match count {
        0 => Some(0),
        n => (n - 1).checked_mul(stride).and_then(|before| before.checked_add(size)),
    };
    length
        .and_then(|length| bytes.get(offset..)?.get(..length))
        .map(|bytes| ItemIter::new(bytes, stride))
        .ok_or_else(|| {
            let what = format!("{count} elements of {size} bytes, {stride} apart, from byte {offset} on");
            let reason = format!("{what} do not fit in {}, which has {} bytes", place_of(view), bytes.len());
            ImportError::at(place, reason)
        })
}
