//! Which quads are split, such that edge neighbours differ by at most one level.                       (BSA10 §4.1)

use crate::nodes::Nodes;
use crate::quads::{Layer, Quads};
use crate::{Criterion, distance, edge_map};

/// Split flags of the quads of one face.
#[derive(Debug, Clone)]
pub(crate) struct Hierarchy {
    quads: Quads,
    /// Of the levels from 1 on; a cell is never split.
    levels: Vec<Layer<bool>>,
}

impl Hierarchy {
    /// Splits the quads of `face` whose criterion exceeds `threshold` metres, and what balance asks for besides.
    ///
    /// With `border`, every quad at the border is split down to cells, so that cells of another face may follow.
    pub(crate) fn new(
        nodes: &Nodes<'_>,
        face: usize,
        quads: Quads,
        criterion: Criterion,
        threshold: f32,
        border: bool,
    ) -> Self {
        let values = match criterion {
            Criterion::Laplacian => edge_map::levels(nodes, face, &quads),
            Criterion::Distance => distance::levels(nodes, face, &quads),
        };
        let levels = (1..).zip(&values).map(|(level, layer)| {
            Layer::new(layer.size(), |x, y| {
                // split where rounding left no number
                let fine = layer.get(x, y).is_some_and(|value| value <= threshold);
                !fine || (border && quads.at_border(level, x, y))
            })
        });
        let mut hierarchy = Self { quads, levels: levels.collect() };
        hierarchy.balance();
        hierarchy
    }

    /// The quads that the flags belong to.
    pub(crate) fn quads(&self) -> &Quads {
        &self.quads
    }

    /// Whether a quad is split; false where there is none.
    #[inline]
    pub(crate) fn is_split(&self, level: u32, x: u32, y: u32) -> bool {
        let layer = (level as usize).checked_sub(1).and_then(|index| self.levels.get(index));
        layer.and_then(|layer| layer.get(x, y)).unwrap_or(false)
    }

    /// Bit 1, 2, 4, 8: whether the neighbour of the same level above, right, below, left is split.
    pub(crate) fn configuration(&self, level: u32, x: u32, y: u32) -> u32 {
        let before = |at: u32| at.wrapping_sub(1);
        let neighbours = [(x, before(y)), (x + 1, y), (x, y + 1), (before(x), y)];
        let bit = |i: usize| u32::from(self.is_split(level, neighbours[i].0, neighbours[i].1)) << i;
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    /// Splits every quad that has a split child, or a split child of an edge neighbour at its edge; from small to large.
    fn balance(&mut self) {
        for level in 2..=self.quads.top() {
            let (columns, rows) = self.quads.count(level);
            for y in 0..rows {
                for x in 0..columns {
                    if !self.is_split(level, x, y) && self.must_split(level, x, y) {
                        self.levels[level as usize - 1].set(x, y, true);
                    }
                }
            }
        }
    }

    fn must_split(&self, level: u32, x: u32, y: u32) -> bool {
        let (x, y) = (2 * x, 2 * y);
        let before = |at: u32| at.wrapping_sub(1);
        let inside = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let around = [
            (x, before(y)),
            (x + 1, before(y)),
            (x + 2, y),
            (x + 2, y + 1),
            (x, y + 2),
            (x + 1, y + 2),
            (before(x), y),
            (before(x), y + 1),
        ];
        inside.into_iter().chain(around).any(|(x, y)| self.is_split(level - 1, x, y))
    }
}
