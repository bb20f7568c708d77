//! Loops on all threads, or on one without the feature `rayon`; results do not depend on which.

use crate::Counts;

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// Calls `row` for each piece of `width` values with its index; returns the sum of what is counted.
pub(crate) fn rows<T: Send>(
    values: &mut [T],
    width: usize,
    row: impl Fn(usize, &mut [T]) -> Counts + Sync,
) -> Counts {
    let width = width.max(1);
    #[cfg(feature = "rayon")]
    let counts = values.par_chunks_mut(width).enumerate().map(|(i, values)| row(i, values));
    #[cfg(feature = "rayon")]
    return counts.reduce(Counts::default, |a, b| a + b);
    #[cfg(not(feature = "rayon"))]
    values.chunks_mut(width).enumerate().map(|(i, values)| row(i, values)).sum()
}

/// Calls `item` for each index below `count`.
pub(crate) fn each(count: usize, item: impl Fn(usize) + Sync + Send) {
    #[cfg(feature = "rayon")]
    (0..count).into_par_iter().for_each(item);
    #[cfg(not(feature = "rayon"))]
    (0..count).for_each(item);
}
