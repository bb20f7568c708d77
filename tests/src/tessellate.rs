//! Triangles for the solids of the reference scenes.
//!
//! Fine enough that what separates the picture of the triangles from that of the solid is confined to silhouettes:
//! 81,920 triangles a sphere, 1024 sides a cylinder.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use scene::Mesh;

/// Sides of a cylinder.
const SIDES: u32 = 1024;

/// How often each face of the icosahedron is quartered.
const SUBDIVISIONS: usize = 6;

/// Half the side of the square that stands for a plane; units: m.
const PLANE: f64 = 600.0;

fn mesh(positions: impl IntoIterator<Item = DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::new(positions.into_iter().map(|p| p.as_vec3()).collect(), triangles, 0).unwrap()
}

/// A sphere whose vertices lie on it.
pub fn sphere(center: DVec3, radius: f64) -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut points: Vec<DVec3> = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
        .into_iter()
        .flat_map(|(a, b)| [DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)])
        .map(DVec3::normalize)
        .collect();
    // the faces are the triples of neighbours: vertices one edge apart
    let edge = 1.0 / (golden * 5.0_f64.sqrt()).sqrt() * 2.0;
    let near = |a: u32, b: u32| points[a as usize].distance(points[b as usize]) < 1.01 * edge;
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            faces.extend((b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(a, c)).map(|c| [a, b, c]));
        }
    }
    assert_eq!(faces.len(), 20, "an icosahedron");
    for _ in 0..SUBDIVISIONS {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(points.iter().map(|&p| center + radius * p), faces)
}

/// A large square for a plane.
pub fn plane(point: DVec3, normal: DVec3) -> Mesh {
    let u = normal.any_orthogonal_vector().normalize() * PLANE;
    let v = normal.normalize().cross(u);
    let corners = [point - u - v, point + u - v, point + u + v, point - u + v];
    mesh(corners, vec![[0, 1, 2], [0, 2, 3]])
}

/// A box with its own axes; the axes are of unit length.
pub fn block(center: DVec3, half: DVec3, axes: [DVec3; 3]) -> Mesh {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        center + sign(0) * half.x * axes[0] + sign(1) * half.y * axes[1] + sign(2) * half.z * axes[2]
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh((0..8).map(corner), quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// An axis-aligned box around two corners.
pub fn cuboid(min: Vec3, max: Vec3) -> Mesh {
    let (min, max) = (min.as_dvec3(), max.as_dvec3());
    block(0.5 * (min + max), 0.5 * (max - min), [DVec3::X, DVec3::Y, DVec3::Z])
}

/// A cylinder, closed at both ends.
pub fn cylinder(p0: DVec3, p1: DVec3, radius: f64) -> Mesh {
    let axis = (p1 - p0).normalize();
    let u = axis.any_orthogonal_vector().normalize() * radius;
    let v = axis.cross(u);
    let mut points = vec![p0, p1];
    let mut faces = Vec::new();
    for i in 0..SIDES {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(SIDES)).sin_cos();
        points.extend([p0 + cos * u + sin * v, p1 + cos * u + sin * v]);
        let (a, b) = (2 + 2 * i, 2 + 2 * ((i + 1) % SIDES));
        faces.extend([[a, b, b + 1], [a, b + 1, a + 1], [0, b, a], [1, a + 1, b + 1]]);
    }
    mesh(points, faces)
}
