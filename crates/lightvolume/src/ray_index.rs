//! A light volume's triangles in a hierarchy of boxes, so that a ray asks few of them.

use media_math::{Boundary, Crossing};
use scene::{DRay, Interval};

use crate::LightVolume;
use crate::line::{Block, Line};
use crate::vertex::Point;

/// Triangles in a box, and boxes in the next larger one.
const FAN: usize = 8;

/// A light volume that is ready to be crossed by view rays.
///
/// The triangles stay in the order of the mesh, which is that of a quadtree; eight that follow each other share a box.
#[derive(Debug)]
pub struct RayIndex<'a> {
    volume: &'a LightVolume,
    points: Vec<Point>,
    /// Boxes around [`FAN`] triangles, around [`FAN`] of those, and so on to a single one.
    levels: Vec<Vec<Block>>,
}

impl<'a> RayIndex<'a> {
    /// Sorts the triangles of a volume into boxes.
    pub fn new(volume: &'a LightVolume) -> Self {
        let points: Vec<Point> = volume.vertices().iter().map(|v| volume.frame().point(v)).collect();
        let point = |&index: &u32| Block::of(&points[index as usize]);
        let around = |block: Block, other: Block| block.union(&other);
        let mut level: Vec<Block> = volume
            .triangles()
            .chunks(FAN)
            .map(|triangles| triangles.iter().flatten().map(point).fold(Block::EMPTY, around))
            .collect();
        let mut levels = Vec::new();
        while level.len() > 1 {
            let above =
                level.chunks(FAN).map(|blocks| blocks.iter().fold(Block::EMPTY, Block::union)).collect();
            levels.push(std::mem::replace(&mut level, above));
        }
        levels.push(level);
        Self { volume, points, levels }
    }

    /// The volume.
    pub fn volume(&self) -> &'a LightVolume {
        self.volume
    }

    /// Memory of the boxes and of the vertices in the coordinates of rays, beside the volume's own; units: bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.points) + self.levels.iter().map(|level| size_of_val(&**level)).sum::<usize>()
    }

    /// Writes where `ray` leaves and enters light within `span` to `out` (cleared first), in no order.
    ///
    /// Complete in the sense of [`signed_airlight`](media_math::signed_airlight): a ray that is lit at the span's end
    /// leaves light there, so that the signs sum to 1 where its start is lit and to 0 where it is not. That holds for
    /// shadow volumes too, whose boundaries lack the light of the whole ray; here it is added.
    ///
    /// A boundary at infinity is one of a span without end.
    pub fn crossings(&self, ray: &DRay, span: Interval, out: &mut Vec<Boundary<f64>>) {
        out.clear();
        if span.is_empty() {
            return;
        }
        let frame = self.volume.frame();
        let line = Line::new(frame.ray(ray), frame.most(), !self.volume.is_shadow());
        // how often the end, then the start is lit: once or not at all, but for boundaries there that rounding exchanges
        let mut lit = i32::from(self.volume.is_shadow());
        self.descend(&line, &mut |distance, crossing| {
            if distance > span.end {
                lit += sign(crossing);
            } else if distance > span.start {
                out.push(Boundary { distance, crossing });
            }
        });
        close(span.end, lit, out);
        lit = out.iter().map(|boundary| sign(boundary.crossing)).sum();
        close(span.start, lit.clamp(0, 1) - lit, out);
    }

    /// Visits all crossings of a line.
    fn descend(&self, line: &Line, visit: &mut impl FnMut(f64, Crossing)) {
        let mut stack = vec![(self.levels.len() - 1, 0)];
        while let Some((level, index)) = stack.pop() {
            let Some(block) = self.levels[level].get(index) else { continue };
            if !line.cuts(block) {
                continue;
            }
            if level > 0 {
                let end = (FAN * (index + 1)).min(self.levels[level - 1].len());
                stack.extend((FAN * index..end).map(|index| (level - 1, index)));
                continue;
            }
            let triangles = self.volume.triangles();
            let end = (FAN * (index + 1)).min(triangles.len());
            for triangle in &triangles[FAN * index..end] {
                let corners = triangle.map(|index| &self.points[index as usize]);
                if let Some((distance, crossing)) = line.crossing(corners) {
                    visit(distance, crossing);
                }
            }
        }
    }
}

/// Adds boundaries at one place whose signs sum to `count`.
fn close(distance: f64, count: i32, out: &mut Vec<Boundary<f64>>) {
    let crossing = if count > 0 { Crossing::LeavesLight } else { Crossing::EntersLight };
    out.extend(std::iter::repeat_n(Boundary { distance, crossing }, count.unsigned_abs() as usize));
}

/// +1 leaving light, −1 entering it.
pub(crate) fn sign(crossing: Crossing) -> i32 {
    match crossing {
        Crossing::LeavesLight => 1,
        Crossing::EntersLight => -1,
    }
}
