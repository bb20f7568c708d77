//! Lit pieces of a ray as they are found: joined where they meet, sorted at the end.

use scene::Interval;

/// Gaps and pieces shorter than this share of their distance are rounding.
const ROUNDING: f64 = 1e-13;

/// Collects lit pieces.
#[derive(Debug)]
pub(crate) struct Pieces<'a> {
    out: &'a mut Vec<Interval>,
}

impl<'a> Pieces<'a> {
    /// Clears `out`.
    pub(crate) fn new(out: &'a mut Vec<Interval>) -> Self {
        out.clear();
        Self { out }
    }

    /// Adds a piece; one that follows the last without a gap prolongs it.
    #[inline]
    pub(crate) fn push(&mut self, piece: Interval) {
        if piece.is_empty() {
            return;
        }
        if let Some(last) = self.out.last_mut()
            && last.end == piece.start
        {
            last.end = piece.end;
            return;
        }
        self.out.push(piece);
    }

    /// Sorts, joins what meets or overlaps but for a rounding, and drops what is only a rounding long.
    pub(crate) fn finish(self) {
        let out = self.out;
        if !out.is_sorted_by(|a, b| a.start <= b.start) {
            out.sort_unstable_by(|a, b| a.start.total_cmp(&b.start));
        }
        let slack = |at: f64| ROUNDING * at.abs();
        let mut kept = 0;
        for i in 0..out.len() {
            let piece = out[i];
            if kept > 0 && piece.start <= out[kept - 1].end + slack(piece.start) {
                out[kept - 1].end = out[kept - 1].end.max(piece.end);
            } else {
                out[kept] = piece;
                kept += 1;
            }
        }
        out.truncate(kept);
        out.retain(|piece| piece.length() > slack(piece.start));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_sorted_and_without_roundings() {
        let mut out = vec![Interval::new(0.0, 1.0)];
        let mut pieces = Pieces::new(&mut out);
        for (a, b) in [(5.0, 6.0), (6.0, 7.0), (1.0, 2.0), (2.0 + 1e-14, 3.0), (4.0, 4.0), (8.0, 8.0 + 1e-14)]
        {
            pieces.push(Interval::new(a, b));
        }
        pieces.push(Interval::new(9.0, f64::INFINITY));
        pieces.finish();
        let found: Vec<_> = out.iter().map(|i| (i.start, i.end)).collect();
        assert_eq!(found, [(1.0, 3.0), (5.0, 7.0), (9.0, f64::INFINITY)]);
    }
}
