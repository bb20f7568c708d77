//! What closes the surface of a map to a volume: walls to the light, skirts and a cap, or seams between faces.

use glam::DVec3;

use crate::builder::Builder;
use crate::vertex::Frame;
use crate::{Vertex, VertexKind};

/// The vertices on the border of a single image, in the order in which its triangles run along it.
fn border(builder: &Builder<'_>) -> Vec<u32> {
    let (columns, rows) = builder.nodes.size();
    let (right, bottom) = (columns - 1, rows - 1);
    let top = (0..right).map(|x| (x, 0));
    let down = (0..bottom).map(|y| (right, y));
    let back = (1..=right).rev().map(|x| (x, bottom));
    let up = (1..=bottom).rev().map(|y| (0, y));
    top.chain(down).chain(back).chain(up).filter_map(|(x, y)| builder.existing(0, x, y)).collect()
}

/// Pairs of neighbours on a closed loop.
fn edges(border: &[u32]) -> impl Iterator<Item = (usize, usize)> + use<> {
    let count = border.len();
    (0..count).map(move |i| (i, (i + 1) % count))
}

/// Walls from the border to the light.                                                          (BSA10 §4, Fig. 4d)
pub(crate) fn walls(builder: &mut Builder<'_>) {
    let border = border(builder);
    let apex =
        builder.vertex(Vertex { x: 0.0, y: 0.0, height: 1.0, depth: 0.0, kind: VertexKind::Apex, face: 0 });
    for (i, next) in edges(&border) {
        builder.triangles.push([apex, border[next], border[i]]);
    }
}

/// Skirts from the border down to the far plane, and a cap there, which together enclose what is in shadow.
///
/// The cap is a fan around its middle, not two triangles, so that no vertex of a skirt lies inside one of its edges.
pub(crate) fn skirts(builder: &mut Builder<'_>) {
    let (border, far) = (border(builder), builder.nodes.far);
    let below = |x: f32, y: f32| Vertex { x, y, height: -far, depth: far, kind: VertexKind::Far, face: 0 };
    let mut feet = Vec::with_capacity(border.len());
    for &node in &border {
        let at = builder.vertices[node as usize];
        feet.push(builder.vertex(below(at.x, at.y)));
    }
    let (columns, rows) = builder.nodes.size();
    let middle = builder.vertex(below(0.5 * (columns - 1) as f32, 0.5 * (rows - 1) as f32));
    for (i, next) in edges(&border) {
        let triangles = [
            [border[next], border[i], feet[i]],
            [border[next], feet[i], feet[next]],
            [middle, feet[next], feet[i]],
        ];
        builder.triangles.extend(triangles);
    }
}

/// Joins the outermost nodes of a cube's faces: a strip along each edge, a triangle at each corner.
///
/// The strip of two faces has nodes (i, 0) on the face of lower index and (i, 1) on the other, i along the positive axis
/// of the world; its cells are cut from (i + 1, 0) to (i, 1), as any cell is.
pub(crate) fn seams(builder: &mut Builder<'_>, frame: &Frame) {
    let n = builder.nodes.size().0;
    for a in 0..4 {
        // the faces of higher index that are not opposite
        for b in 2 * (a / 2) + 2..6 {
            strip(builder, frame, (a, b), n);
        }
    }
    for corner in 0..8 {
        let faces = [0, 1, 2].map(|axis| 2 * axis + (corner >> axis & 1));
        let [x, y, z] = faces.map(|face| {
            let others = faces.into_iter().filter(|&other| other != face);
            let towards = others.fold(DVec3::ZERO, |sum, other| sum + forward(frame, other));
            outermost(builder, frame, face, towards, n)
        });
        facing(builder, frame, [x, y, z]);
    }
}

fn forward(frame: &Frame, face: usize) -> DVec3 {
    frame.projection().faces()[face].forward
}

/// The vertex of the node of `face` that lies farthest `towards`: components of ±1 along two of its axes, or a share of
/// the way along one of them.
fn outermost(builder: &mut Builder<'_>, frame: &Frame, face: usize, towards: DVec3, n: u32) -> u32 {
    let axes = &frame.projection().faces()[face];
    let last = f64::from(n - 1);
    let index = |along: f64| (0.5 * last * (1.0 + along)).round().clamp(0.0, last) as u32;
    let (x, y) = (index(towards.dot(axes.right)), index(towards.dot(axes.down)));
    builder.node(face, x, y)
}

fn strip(builder: &mut Builder<'_>, frame: &Frame, (a, b): (usize, usize), n: u32) {
    let (to_a, to_b) = (forward(frame, a), forward(frame, b));
    let along = to_a.cross(to_b).abs();
    let at = |builder: &mut Builder<'_>, i: u32, side: usize| {
        let (face, other) = if side == 0 { (a, to_b) } else { (b, to_a) };
        // node i of n from −1 to 1
        let share = (2.0 * f64::from(i) - f64::from(n - 1)) / f64::from(n.max(2) - 1);
        outermost(builder, frame, face, other + share * along, n)
    };
    for i in 0..n - 1 {
        let corners = [(i, 0), (i + 1, 0), (i, 1), (i + 1, 1)].map(|(i, side)| at(builder, i, side));
        facing(builder, frame, [corners[0], corners[1], corners[2]]);
        facing(builder, frame, [corners[3], corners[2], corners[1]]);
    }
}

/// Adds a triangle in the orientation that shows its back to a ray from the light.
fn facing(builder: &mut Builder<'_>, frame: &Frame, [a, b, c]: [u32; 3]) {
    let [p, q, r] = [a, b, c].map(|i| frame.point(&builder.vertices[i as usize]).place);
    builder.triangles.push(if p.cross(q).dot(r) > 0.0 { [a, b, c] } else { [a, c, b] });
}
