//! Boundaries in order: the lit pieces between them.

use media_math::Boundary;
use scene::Interval;

use crate::ray_index::sign;

/// Gaps and pieces shorter than this share of their distance are rounding.
const ROUNDING: f64 = 1e-13;

/// Writes the lit pieces between complete `boundaries` of `span` to `out` (cleared first); sorts the boundaries.
pub(crate) fn between(boundaries: &mut [Boundary<f64>], span: Interval, out: &mut Vec<Interval>) {
    out.clear();
    boundaries.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
    // how often the start is lit: once or not at all
    let mut lit: i32 = boundaries.iter().map(|b| sign(b.crossing)).sum();
    let mut from = span.start;
    for boundary in boundaries.iter() {
        if lit > 0 {
            push(out, Interval::new(from, boundary.distance));
        }
        from = boundary.distance;
        lit -= sign(boundary.crossing);
    }
    out.retain(|piece| piece.length() > ROUNDING * piece.start.abs());
}

/// Adds a piece, or prolongs the last one if only rounding lies between.
fn push(out: &mut Vec<Interval>, piece: Interval) {
    match out.last_mut() {
        Some(last) if piece.start <= last.end + ROUNDING * piece.start.abs() => {
            last.end = last.end.max(piece.end);
        }
        _ if piece.is_empty() => {}
        _ => out.push(piece),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use media_math::Crossing::{EntersLight, LeavesLight};

    #[test]
    fn pieces_by_hand() {
        let at = |distance, crossing| Boundary { distance, crossing };
        let mut out = Vec::new();
        let mut found = |mut boundaries: Vec<Boundary<f64>>| {
            between(&mut boundaries, Interval::new(1.0, 9.0), &mut out);
            out.iter().map(|i| (i.start, i.end)).collect::<Vec<_>>()
        };
        assert_eq!(found(vec![]), []);
        assert_eq!(found(vec![at(9.0, LeavesLight)]), [(1.0, 9.0)]);
        assert_eq!(
            found(vec![at(6.0, EntersLight), at(8.0, LeavesLight), at(3.0, LeavesLight)]),
            [(1.0, 3.0), (6.0, 8.0)]
        );
        // two edges of one silhouette, exchanged by rounding
        let near = 3.0 + 1e-15;
        assert_eq!(
            found(vec![at(9.0, LeavesLight), at(near, EntersLight), at(3.0, LeavesLight)]),
            [(1.0, 9.0)]
        );
    }
}
