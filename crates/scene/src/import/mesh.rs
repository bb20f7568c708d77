//! Mesh primitives into world-space triangles.

use super::accessor;
use super::buffers::Buffers;
use super::error::{ImportError, place};
use super::nodes::Node;
use super::notes::Notes;
use crate::Mesh;
use glam::Vec3;
use gltf::Semantic;
use gltf::mesh::Mode;
use gltf::mesh::util::{ReadIndices, ReadPositions};

/// A primitive of a mesh before it is put into the world.
#[derive(Debug, Clone)]
pub(super) struct Primitive<'a> {
    /// Such as `mesh 2 "wall" primitive 1`.
    place: String,
    positions: ReadPositions<'a>,
    indices: Option<ReadIndices<'a>>,
    shape: Shape,
    /// Index into the document's materials.
    pub(super) material: Option<usize>,
}

/// How indices become triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    List,
    Strip,
    Fan,
}

/// The primitives of `mesh`; those that are not triangles are noted and left out.
pub(super) fn primitives<'a>(
    buffers: &'a Buffers<'_>,
    mesh: &gltf::Mesh<'_>,
    notes: &mut Notes,
) -> Result<Vec<Primitive<'a>>, ImportError> {
    let mut primitives = Vec::new();
    for item in mesh.primitives() {
        let place = format!("{} primitive {}", place("mesh", mesh.index(), mesh.name()), item.index());
        let shape = match item.mode() {
            Mode::Triangles => Shape::List,
            Mode::TriangleStrip => Shape::Strip,
            Mode::TriangleFan => Shape::Fan,
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                notes.add("points and lines are skipped", &place);
                continue;
            }
        };
        primitives.push(Primitive::new(buffers, &item, place, shape, notes)?);
    }
    Ok(primitives)
}

impl<'a> Primitive<'a> {
    fn new(
        buffers: &'a Buffers<'_>,
        item: &gltf::Primitive<'_>,
        place: String,
        shape: Shape,
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let positions = item.get(&Semantic::Positions);
        let positions = positions.ok_or_else(|| ImportError::at(&place, "has no positions"))?;
        let positions = accessor::positions(buffers, &positions)?;
        let indices = item.indices().map(|indices| accessor::indices(buffers, &indices)).transpose()?;
        if item.morph_targets().len() > 0 {
            notes.add("morph targets are ignored", &place);
        }
        let primitive = Self { place, positions, indices, shape, material: item.material().index() };
        if shape == Shape::List && !primitive.corner_count().is_multiple_of(3) {
            notes.add("corners that do not fill a triangle are left out", &primitive.place);
        }
        Ok(primitive)
    }

    fn corner_count(&self) -> usize {
        self.indices.as_ref().map_or(self.positions.len(), |indices| indices.clone().into_u32().len())
    }

    /// Number of triangles, known without reading them.
    pub(super) fn triangle_count(&self) -> usize {
        match self.shape {
            Shape::List => self.corner_count() / 3,
            Shape::Strip | Shape::Fan => self.corner_count().saturating_sub(2),
        }
    }

    fn error(&self, reason: String) -> ImportError {
        ImportError::at(&self.place, reason)
    }

    /// Triangles as indices into the accessor's positions, all in range; `flip` turns them over.
    fn triangles(&self, flip: bool) -> Result<Vec<[u32; 3]>, ImportError> {
        let total = self.positions.len();
        let corners: Vec<u32> = match &self.indices {
            Some(indices) => indices.clone().into_u32().collect(),
            None => (0..).take(total).collect(),
        };
        if let Some(index) = corners.iter().find(|&&index| index as usize >= total) {
            return Err(self.error(format!("index {index} is out of range for {total} positions")));
        }
        let triangle = |i: usize| {
            // the order of corners in strips and fans is glTF's, with which all triangles face the same way
            let [a, b, c] = match self.shape {
                Shape::List => [3 * i, 3 * i + 1, 3 * i + 2],
                Shape::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
                Shape::Fan => [i + 1, i + 2, 0],
            };
            let [b, c] = if flip { [c, b] } else { [b, c] };
            [corners[a], corners[b], corners[c]]
        };
        Ok((0..self.triangle_count()).map(triangle).collect())
    }

    /// The primitive where `node` puts it.
    ///
    /// Positions that no triangle uses are left out: primitives often share one large array, and bounds shall mean
    /// what is there to be seen. A mirroring transform turns the triangles over, so that they keep their front.
    pub(super) fn instance(&self, node: &Node<'_>, material: usize) -> Result<Mesh, ImportError> {
        let world_from_node = node.world_from_node;
        let mut triangles = self.triangles(world_from_node.matrix3.determinant() < 0.0)?;
        let is_used = renumber(&mut triangles, self.positions.len());
        let position = |(index, local): (usize, [f32; 3])| {
            let local = Vec3::from_array(local);
            if !local.is_finite() {
                return Err(self.error(format!("position {index} is not finite: {local}")));
            }
            let world = world_from_node.transform_point3(local.as_dvec3()).as_vec3();
            if !world.is_finite() {
                let reason = format!("puts position {index} out of the range of 32-bit numbers");
                return Err(self.error(format!("{} {reason}", node.place())));
            }
            Ok(world)
        };
        let positions = self.positions.clone().enumerate().filter(|&(index, _)| is_used[index]);
        let positions = positions.map(position).collect::<Result<_, _>>()?;
        Mesh::new(positions, triangles, material).map_err(|error| self.error(error.to_string()))
    }
}

/// Numbers those of `total` positions that triangles use from 0 on, in their order; returns which they are.
fn renumber(triangles: &mut [[u32; 3]], total: usize) -> Vec<bool> {
    let mut is_used = vec![false; total];
    for &index in triangles.as_flattened() {
        is_used[index as usize] = true;
    }
    let count_before =
        |count: &mut u32, &used: &bool| Some(std::mem::replace(count, *count + u32::from(used)));
    let numbers: Vec<u32> = is_used.iter().scan(0, count_before).collect();
    for index in triangles.as_flattened_mut() {
        *index = numbers[*index as usize];
    }
    is_used
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unused_positions_go() {
        let mut triangles = [[5, 1, 3], [3, 1, 5]];
        assert_eq!(renumber(&mut triangles, 7), [false, true, false, true, false, true, false]);
        assert_eq!(triangles, [[2, 0, 1], [1, 0, 2]]);
        let mut triangles = [[2, 1, 0]];
        assert_eq!(renumber(&mut triangles, 3), [true; 3]);
        assert_eq!(triangles, [[2, 1, 0]]);
        assert_eq!(renumber(&mut [], 2), [false; 2]);
    }
}
