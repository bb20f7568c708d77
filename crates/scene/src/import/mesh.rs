//! Mesh primitives into world-space triangles.

use super::accessor::{Indices, Positions};
use super::buffers::Buffers;
use super::document::{Document, List};
use super::error::ImportError;
use super::json::Item;
use super::nodes::Node;
use super::notes::Notes;
use crate::Mesh;
use glam::Vec3;

/// A primitive of a mesh before it is put into the world.
#[derive(Debug, Clone)]
pub(super) struct Primitive<'a> {
    /// Such as `mesh 2 "wall" primitive 1`.
    place: String,
    positions: Positions<'a>,
    indices: Option<Indices<'a>>,
    mode: Mode,
    /// Index into the document's materials.
    pub(super) material: Option<usize>,
}

/// How indices become triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

/// The primitives of `mesh`, one of the document's meshes; those that are not triangles are noted and left out.
pub(super) fn primitives<'a>(
    document: &Document<'_>,
    buffers: &'a Buffers<'_>,
    mesh: &Item<'_>,
    notes: &mut Notes,
) -> Result<Vec<Primitive<'a>>, ImportError> {
    let mut primitives = Vec::new();
    for (index, item) in mesh.need("primitives")?.elements()?.enumerate() {
        let item = item.called(format!("{} primitive {index}", mesh.place()));
        let mode = match item.get("mode")? {
            None => Mode::Triangles,
            Some(mode) => match mode.whole()? {
                0..=3 => {
                    notes.add("points and lines are skipped", item.place());
                    continue;
                }
                4 => Mode::Triangles,
                5 => Mode::Strip,
                6 => Mode::Fan,
                other => return Err(mode.error(format!("must be 0 to 6, got {other}"))),
            },
        };
        primitives.push(Primitive::new(document, buffers, &item, mode, notes)?);
    }
    Ok(primitives)
}

impl<'a> Primitive<'a> {
    fn new(
        document: &Document<'_>,
        buffers: &'a Buffers<'_>,
        item: &Item<'_>,
        mode: Mode,
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let position = item.need("attributes")?.need("POSITION")?;
        let (_, positions) = document.refer(List::Accessors, &position)?;
        let positions = Positions::new(document, buffers, &positions)?;
        if u32::try_from(positions.count()).is_err() {
            return Err(
                item.error(format!("{} positions are more than 32-bit indices reach", positions.count()))
            );
        }
        let indices = document
            .follow(List::Accessors, item, "indices")?
            .map(|(_, indices)| Indices::new(document, buffers, &indices))
            .transpose()?;
        let material = document.follow(List::Materials, item, "material")?.map(|(index, _)| index);
        if item.get("targets")?.is_some() {
            notes.add("morph targets are ignored", item.place());
        }
        let primitive = Self { place: item.place().into(), positions, indices, mode, material };
        let corners = primitive.corner_count();
        if mode == Mode::Triangles && !corners.is_multiple_of(3) {
            notes.add("corners that do not fill a triangle are left out", item.place());
        }
        Ok(primitive)
    }

    fn corner_count(&self) -> usize {
        self.indices.as_ref().map_or(self.positions.count(), Indices::count)
    }

    /// Number of triangles, known without reading them.
    pub(super) fn triangle_count(&self) -> usize {
        match self.mode {
            Mode::Triangles => self.corner_count() / 3,
            Mode::Strip | Mode::Fan => self.corner_count().saturating_sub(2),
        }
    }

    fn error(&self, reason: String) -> ImportError {
        ImportError::Item { place: self.place.clone(), reason }
    }

    /// Triangles as indices into the accessor's positions, all in range; `flip` turns them over.
    fn triangles(&self, flip: bool) -> Result<Vec<[u32; 3]>, ImportError> {
        let total = self.positions.count();
        let corner = |at: usize| {
            // positions are no more than 2^32
            let index = self.indices.as_ref().map_or(at as u32, |indices| indices.get(at));
            if (index as usize) < total {
                Ok(index)
            } else {
                Err(self.error(format!("index {index} is out of range for {total} positions")))
            }
        };
        let triangle = |i: usize| {
            // the order of corners in strips and fans is glTF's, with which all triangles face the same way
            let [a, b, c] = match self.mode {
                Mode::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
                Mode::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
                Mode::Fan => [i + 1, i + 2, 0],
            };
            let [b, c] = if flip { [c, b] } else { [b, c] };
            Ok([corner(a)?, corner(b)?, corner(c)?])
        };
        (0..self.triangle_count()).map(triangle).collect()
    }

    /// The primitive where `node` puts it.
    ///
    /// Positions that no triangle uses are left out: primitives often share one large array, and bounds shall mean
    /// what is there to be seen. A mirroring transform turns the triangles over, so that they keep their front.
    pub(super) fn instance(&self, node: &Node<'_>, material: usize) -> Result<Mesh, ImportError> {
        let world_from_node = node.world_from_node;
        let mut triangles = self.triangles(world_from_node.matrix3.determinant() < 0.0)?;
        let used = renumber(&mut triangles, self.positions.count());
        let position = |index: usize| {
            let local = Vec3::from_array(self.positions.get(index));
            if !local.is_finite() {
                return Err(self.error(format!("position {index} is not finite: {local}")));
            }
            let world = world_from_node.transform_point3(local.as_dvec3()).as_vec3();
            if !world.is_finite() {
                let node = node.item.place();
                return Err(
                    self.error(format!("{node} puts position {index} out of the range of 32-bit numbers"))
                );
            }
            Ok(world)
        };
        let positions = match used {
            Some(used) => used.into_iter().map(|index| position(index as usize)).collect::<Result<_, _>>()?,
            None => (0..self.positions.count()).map(position).collect::<Result<_, _>>()?,
        };
        Mesh::new(positions, triangles, material).map_err(|error| self.error(error.to_string()))
    }
}

/// If some of `total` positions are unused, numbers those in use from 0 on, in their order, and returns them.
fn renumber(triangles: &mut [[u32; 3]], total: usize) -> Option<Vec<u32>> {
    let mut is_used = vec![false; total];
    for &index in triangles.as_flattened() {
        is_used[index as usize] = true;
    }
    let used: Vec<u32> = (0..).zip(&is_used).filter(|(_, used)| **used).map(|(index, _)| index).collect();
    if used.len() == total {
        return None;
    }
    let mut numbers = vec![0; total];
    for (number, &index) in (0..).zip(&used) {
        numbers[index as usize] = number;
    }
    for index in triangles.as_flattened_mut() {
        *index = numbers[*index as usize];
    }
    Some(used)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unused_positions_go() {
        let mut triangles = [[5, 1, 3], [3, 1, 5]];
        assert_eq!(renumber(&mut triangles, 7), Some(vec![1, 3, 5]));
        assert_eq!(triangles, [[2, 0, 1], [1, 0, 2]]);
        let mut triangles = [[2, 1, 0]];
        assert_eq!(renumber(&mut triangles, 3), None);
        assert_eq!(triangles, [[2, 1, 0]]);
        assert_eq!(renumber(&mut [], 2), Some(vec![]));
    }
}
