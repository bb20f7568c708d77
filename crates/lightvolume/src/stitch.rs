//! The sixteen ways to cut a quad whose neighbours may be finer.                                       (BSA10 §4.1)
//!
//! ```text
//! 0---1---2        places around a quad: corners 0, 2, 4, 6 and the middles of edges,
//! |     / |        v downwards
//! 7   /   3
//! | /     |        the diagonal 2–6 is always kept: coarse triangulations nest in finer ones
//! 6---5---4
//! ```

/// The triangles of a quad, each three places around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stitch {
    places: [[u8; 3]; 6],
    count: usize,
}

impl Stitch {
    /// The triangles, two to six, in the orientation of perspective and orthographic maps.
    ///
    /// First those above the diagonal, then those below. Each begins with a place that no other triangle of the quad
    /// begins with.
    pub const fn triangles(&self) -> &[[u8; 3]] {
        self.places.split_at(self.count).0
    }
}

/// Offset of a place from a quad's upper left corner, in halves of its side: (columns, rows).
pub const PLACES: [(u32, u32); 8] = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

/// How a quad is cut, by the sum of 1, 2, 4, 8 for a neighbour above, right, below, left that is split.
pub const STITCHES: [Stitch; 16] = {
    let mut stitches = [Stitch { places: [[0; 3]; 6], count: 0 }; 16];
    let mut bits = 0;
    while bits < 16 {
        // the lower half is the upper one turned by half a turn
        let stitch = half(stitches[bits], bits & 1 != 0, bits & 8 != 0, 0);
        stitches[bits] = half(stitch, bits & 4 != 0, bits & 2 != 0, 4);
        bits += 1;
    }
    stitches
};

/// Adds the triangles on one side of the diagonal, with the middle of the top (bottom) and left (right) edge or without.
const fn half(stitch: Stitch, top: bool, left: bool, turn: u8) -> Stitch {
    match (top, left) {
        (false, false) => add(stitch, [0, 2, 6], turn),
        (true, false) => add(add(stitch, [0, 1, 6], turn), [1, 2, 6], turn),
        (false, true) => add(add(stitch, [0, 2, 7], turn), [7, 2, 6], turn),
        (true, true) => add(add(add(stitch, [0, 1, 7], turn), [1, 2, 7], turn), [7, 2, 6], turn),
    }
}

const fn add(mut stitch: Stitch, [a, b, c]: [u8; 3], turn: u8) -> Stitch {
    stitch.places[stitch.count] = [(a + turn) % 8, (b + turn) % 8, (c + turn) % 8];
    stitch.count += 1;
    stitch
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_by_hand() {
        assert_eq!(STITCHES[0].triangles(), [[0, 2, 6], [4, 6, 2]]);
        assert_eq!(STITCHES[1].triangles(), [[0, 1, 6], [1, 2, 6], [4, 6, 2]]);
        assert_eq!(STITCHES[2].triangles(), [[0, 2, 6], [4, 6, 3], [3, 6, 2]]);
        let all = [[0, 1, 7], [1, 2, 7], [7, 2, 6], [4, 5, 3], [5, 6, 3], [3, 6, 2]];
        assert_eq!(STITCHES[15].triangles(), all);
    }

    #[test]
    fn every_stitch_covers_its_quad_with_the_places_it_must_have() {
        for (bits, stitch) in STITCHES.iter().enumerate() {
            let mut twice = 0;
            let mut used = [false; 8];
            for triangle in stitch.triangles() {
                let [a, b, c] =
                    triangle.map(|place| PLACES[usize::from(place)]).map(|(x, y)| (x as i32, y as i32));
                let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
                assert!(area > 0, "{bits}: {triangle:?}");
                twice += area;
                triangle.iter().for_each(|&place| used[usize::from(place)] = true);
            }
            assert_eq!(twice, 8);
            let middles = [1, 3, 5, 7].map(|place| used[place]);
            assert_eq!(middles, [0, 1, 2, 3].map(|bit| bits >> bit & 1 == 1), "{bits}");
            let mut firsts: Vec<u8> = stitch.triangles().iter().map(|t| t[0]).collect();
            firsts.sort_unstable();
            firsts.dedup();
            assert_eq!(firsts.len(), stitch.triangles().len());
        }
    }
}
