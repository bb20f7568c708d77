//! Whether a light volume is what it should be: closed, oriented, conforming.

use std::fmt;

use thiserror::Error;

use crate::{LightVolume, Vertex, VertexKind};

/// What is wrong with a mesh, and where.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum Defect {
    /// A triangle with an index that is no vertex, or the same twice.
    #[error("triangle {triangle} has no three vertices: {indices:?}")]
    Indices {
        /// Index of the triangle.
        triangle: usize,
        /// Its indices.
        indices: [u32; 3],
    },
    /// Two vertices at one place.
    #[error("two vertices are {vertex}")]
    Twins {
        /// One of them.
        vertex: Place,
    },
    /// A vertex that no triangle has.
    #[error("vertex {vertex} belongs to no triangle")]
    Unused {
        /// Index of the vertex.
        vertex: u32,
    },
    /// An edge that does not meet exactly one reverse edge: a hole, a fold, or a triangle turned over.
    #[error("the edge from {from} to {to} is not met by exactly one reverse edge")]
    Edge {
        /// Where it begins.
        from: Place,
        /// Where it ends.
        to: Place,
    },
    /// A triangle of the surface that is turned over or has no area in texel coordinates.
    #[error("surface triangle {triangle} on face {face} has area {area} texels²")]
    Area {
        /// Index of the triangle.
        triangle: usize,
        /// Its face.
        face: u16,
        /// Its area, negative if it is turned over; units: texels².
        area: f64,
    },
    /// The surface triangles of a face do not cover the rectangle between its outermost centres.
    #[error("the triangles of face {face} cover {covered} of {expected} texels²")]
    Cover {
        /// The face.
        face: u16,
        /// Sum of areas; units: texels².
        covered: f64,
        /// Area of the rectangle; units: texels².
        expected: f64,
    },
    /// V − E + F is not that of a sphere.
    #[error("the Euler characteristic is {characteristic}, that of a closed volume is 2")]
    Euler {
        /// Vertices − edges + triangles.
        characteristic: i64,
    },
}

/// Which vertex: its index, and where on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the vertex.
    pub index: u32,
    /// The vertex.
    pub vertex: Vertex,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Vertex { x, y, kind, face, .. } = self.vertex;
        write!(f, "{} ({kind:?} at column {x}, row {y}, face {face})", self.index)
    }
}

impl LightVolume {
    /// Checks that the mesh is closed and oriented (every directed edge meets its reverse once), that the triangles of
    /// every face cover the rectangle between its outermost centres exactly once, that no vertex is double or unused,
    /// and that the whole is a sphere. A mesh without triangles is fine.
    ///
    /// # Errors
    /// The first [`Defect`] found.
    pub fn validate(&self) -> Result<(), Defect> {
        self.check_vertices()?;
        self.check_cover()?;
        let edges = self.check_edges()?;
        let count = |n: usize| n as i64;
        let characteristic = count(self.vertices().len()) - count(edges) + count(self.triangles().len());
        if characteristic == if self.triangles().is_empty() { 0 } else { 2 } {
            Ok(())
        } else {
            Err(Defect::Euler { characteristic })
        }
    }

    fn place(&self, index: u32) -> Place {
        Place { index, vertex: self.vertices()[index as usize] }
    }

    /// Indices exist, every vertex is used, none is double.
    fn check_vertices(&self) -> Result<(), Defect> {
        let mut used = vec![false; self.vertices().len()];
        for (triangle, &indices) in self.triangles().iter().enumerate() {
            let [a, b, c] = indices;
            let exist = indices.iter().all(|&i| (i as usize) < used.len());
            if !exist || a == b || b == c || c == a {
                return Err(Defect::Indices { triangle, indices });
            }
            indices.iter().for_each(|&i| used[i as usize] = true);
        }
        if let Some(vertex) = used.iter().position(|&used| !used) {
            return Err(Defect::Unused { vertex: vertex as u32 });
        }
        let key = |&i: &u32| {
            let Vertex { x, y, kind, face, .. } = self.vertices()[i as usize];
            (kind, face, y.to_bits(), x.to_bits())
        };
        let mut order: Vec<u32> = (0..self.vertices().len() as u32).collect();
        order.sort_unstable_by_key(key);
        match order.windows(2).find(|pair| key(&pair[0]) == key(&pair[1])) {
            Some(pair) => Err(Defect::Twins { vertex: self.place(pair[0]) }),
            None => Ok(()),
        }
    }

    /// Areas in texel coordinates are positive and sum to the rectangle's. They are exact: halves of integers.
    fn check_cover(&self) -> Result<(), Defect> {
        let faces = self.projection().faces();
        let mut covered = vec![0.0; faces.len()];
        for (triangle, indices) in self.triangles().iter().enumerate() {
            let [a, b, c] = indices.map(|i| self.vertices()[i as usize]);
            let surface = [a, b, c].iter().all(|v| v.kind == VertexKind::Surface && v.face == a.face);
            if !surface {
                continue;
            }
            let edge = |to: Vertex| (f64::from(to.x) - f64::from(a.x), f64::from(to.y) - f64::from(a.y));
            let ((px, py), (qx, qy)) = (edge(b), edge(c));
            let face = &faces[usize::from(a.face)];
            let turn = face.right.cross(face.down).dot(face.forward).signum();
            let area = 0.5 * turn * (px * qy - py * qx);
            if !(area > 0.0) {
                return Err(Defect::Area { triangle, face: a.face, area });
            }
            covered[usize::from(a.face)] += area;
        }
        let (columns, rows) = self.map_size();
        let expected = f64::from(columns - 1) * f64::from(rows - 1);
        match covered.iter().position(|&covered| covered != expected) {
            Some(face) => Err(Defect::Cover { face: face as u16, covered: covered[face], expected }),
            None => Ok(()),
        }
    }

    /// Directed edges and their reverses pair up; how many pairs.
    fn check_edges(&self) -> Result<usize, Defect> {
        // edges that rise in index, and the reverses of those that fall
        let (mut rising, mut falling) = (Vec::new(), Vec::new());
        let half = self.triangles().len().div_ceil(2) * 3;
        rising.reserve(half);
        falling.reserve(half);
        for &[a, b, c] in self.triangles() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let key = |low: u32, high: u32| u64::from(low) << 32 | u64::from(high);
                if from < to { rising.push(key(from, to)) } else { falling.push(key(to, from)) }
            }
        }
        rising.sort_unstable();
        falling.sort_unstable();
        let ends = |key: u64| (self.place((key >> 32) as u32), self.place(key as u32));
        // a missing edge is found at the first difference, a doubled one as its own neighbour
        let double = |edges: &[u64]| edges.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        let differ = rising.iter().zip(&falling).find(|(a, b)| a != b).map(|(&a, &b)| a.min(b));
        let longer = if rising.len() > falling.len() { &rising } else { &falling };
        let rest = longer.get(rising.len().min(falling.len())).copied();
        match double(&rising).or(double(&falling)).or(differ).or(rest) {
            Some(key) => {
                let (from, to) = ends(key);
                Err(Defect::Edge { from, to })
            }
            None => Ok(rising.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Criterion, Options, Tessellation};
    use glam::{DVec2, DVec3};
    use shadowmap::{DepthMap, Projection};

    /// A flat map with one deep node: leaves of several sizes.
    fn volume() -> LightVolume {
        let mut depths = vec![2.0; 81];
        depths[12] = 3.0;
        let projection = Projection::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec2::ONE).unwrap();
        let map = DepthMap::new(projection, (9, 9), depths).unwrap();
        let tessellation = Tessellation::Adaptive { criterion: Criterion::Distance, threshold: 0.1 };
        LightVolume::build(&map, &Options::new(tessellation)).unwrap()
    }

    fn defect(change: impl FnOnce(&mut Vec<[u32; 3]>)) -> Defect {
        let mut volume = volume();
        assert_eq!(volume.validate(), Ok(()));
        change(volume.triangles_mut());
        volume.validate().unwrap_err()
    }

    #[test]
    fn every_defect_is_found() {
        let missing = defect(|triangles| {
            triangles.pop();
        });
        assert!(matches!(missing, Defect::Edge { .. }), "{missing}");
        let hole = defect(|triangles| {
            triangles.remove(3);
        });
        assert!(matches!(hole, Defect::Cover { face: 0, .. }), "{hole}");
        let turned = defect(|triangles| triangles[0].reverse());
        assert!(matches!(turned, Defect::Area { triangle: 0, area, .. } if area < 0.0), "{turned}");
        let wall = defect(|triangles| {
            if let Some(last) = triangles.last_mut() {
                last.reverse();
            }
        });
        assert!(matches!(wall, Defect::Edge { .. }), "{wall}");
        let twice = defect(|triangles| triangles.push(triangles[triangles.len() - 1]));
        assert!(matches!(twice, Defect::Edge { .. }), "{twice}");
        let none = defect(|triangles| triangles[1] = [0, 0, 99_999]);
        assert!(matches!(none, Defect::Indices { triangle: 1, .. }), "{none}");
        assert!(matches!(defect(Vec::clear), Defect::Unused { vertex: 0 }));
        assert!(turned.to_string().starts_with("surface triangle 0 on face 0 has area -"));
    }
}
