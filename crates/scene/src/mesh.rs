//! Triangle meshes.

use crate::{Aabb, SceneError};
use glam::Vec3;

/// Triangles in world space that share a material.
///
/// Indices are in range and positions finite: [`Mesh::new`] sees to it. Triangles may be degenerate, duplicated or
/// wound either way.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`](crate::Scene::materials).
    pub material: usize,
}

impl Mesh {
    /// A mesh from positions (in m) and triangles as triples of indices into them.
    ///
    /// # Errors
    /// [`SceneError::Mesh`] if a position is not finite or an index is out of range.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: usize) -> Result<Self, SceneError> {
        if let Some(at) = positions.iter().position(|p| !p.is_finite()) {
            return Err(SceneError::Mesh(format!("position {at} is not finite: {}", positions[at])));
        }
        if let Some(&index) = triangles.iter().flatten().find(|&&index| index as usize >= positions.len()) {
            return Err(SceneError::Mesh(format!(
                "index {index} is out of range for {} positions",
                positions.len()
            )));
        }
        Ok(Self { positions, triangles, material })
    }

    /// Vertex positions; units: m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Triangles as indices into [`Mesh::positions`].
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Corner positions of every triangle.
    pub fn corners(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|i| self.positions[i as usize]))
    }

    /// The smallest box around the positions.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.positions.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused() {
        let square = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        assert!(Mesh::new(square.clone(), vec![[0, 1, 2]], 0).is_ok());
        assert!(Mesh::new(square, vec![[0, 1, 3]], 0).is_err());
        assert!(Mesh::new(vec![Vec3::NAN], vec![], 0).is_err());
        assert!(Mesh::new(vec![], vec![], 0).unwrap().bounds().is_empty());
    }
}
