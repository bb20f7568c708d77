//! A light volume's tessellation as a picture: the edges of its triangles over the map.

use lightvolume::{LightVolume, VertexKind};
use shadowmap::DepthMap;

use crate::image_file::Image8;

/// A square of the map's first face, magnified.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cutout {
    /// Upper left texel.
    pub(super) first: [u32; 2],
    /// Texels a side.
    pub(super) texels: u32,
    /// Pixels a texel and side.
    pub(super) zoom: u32,
}

/// Brightness of the farthest and of the nearest depth.
const GREY: [f32; 2] = [40.0, 235.0];

const EDGE: [u8; 3] = [200, 60, 20];

/// The edges of the surface's triangles over the map's depths, near ones bright.
pub(super) fn tessellation(map: &DepthMap, volume: &LightVolume, cutout: Cutout) -> Image8 {
    let mut picture = depths(map, cutout);
    for corners in surface(volume) {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            line(&mut picture, place(corners[from], cutout), place(corners[to], cutout));
        }
    }
    picture
}

/// The cut-out of so many texels with the most triangles among those side by side on the map.
pub(super) fn busiest(map: &DepthMap, volume: &LightVolume, texels: u32, zoom: u32) -> Cutout {
    let columns = map.size().0.div_ceil(texels).max(1);
    let mut counts = vec![0u32; (columns * map.size().1.div_ceil(texels).max(1)) as usize];
    for corners in surface(volume) {
        let [x, y] = corners[0].map(|at| at as u32 / texels);
        if let Some(count) = counts.get_mut((y * columns + x) as usize) {
            *count += 1;
        }
    }
    let most =
        counts.iter().enumerate().max_by_key(|(_, count)| **count).map_or(0, |(index, _)| index as u32);
    Cutout { first: [most % columns * texels, most / columns * texels], texels, zoom }
}

/// Columns and rows of the corners of the surface's triangles on the first face.
fn surface(volume: &LightVolume) -> impl Iterator<Item = [[i64; 2]; 3]> + '_ {
    let vertices = volume.vertices();
    volume.triangles().iter().take(volume.surface_count()).filter_map(move |triangle| {
        let corners = triangle.map(|index| vertices[index as usize]);
        let drawn = corners.iter().all(|v| v.face == 0 && v.kind == VertexKind::Surface);
        drawn.then(|| corners.map(|v| [v.x as i64, v.y as i64]))
    })
}

/// The pixel of a texel's centre.
fn place(texel: [i64; 2], cutout: Cutout) -> [i64; 2] {
    let zoom = i64::from(cutout.zoom);
    [0, 1].map(|axis| (texel[axis] - i64::from(cutout.first[axis])) * zoom + zoom / 2)
}

fn depths(map: &DepthMap, cutout: Cutout) -> Image8 {
    let [least, most] = map
        .face(0)
        .iter()
        .filter(|depth| depth.is_finite())
        .fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], depth| {
            [least.min(*depth), most.max(*depth)]
        });
    let shade = |x: u32, y: u32| {
        let inside = x < map.size().0 && y < map.size().1;
        let depth = if inside { map.depth(0, x, y) } else { f32::INFINITY };
        let near = ((most - depth) / (most - least)).clamp(0.0, 1.0);
        let near = if near.is_nan() { 0.0 } else { near };
        [(GREY[0] + (GREY[1] - GREY[0]) * near) as u8; 3]
    };
    let side = cutout.texels * cutout.zoom;
    let texel = |at: u32, axis: usize| cutout.first[axis] + at / cutout.zoom;
    let pixels = (0..side * side).map(|pixel| shade(texel(pixel % side, 0), texel(pixel / side, 1)));
    Image8 { width: side, height: side, pixels: pixels.collect() }
}

/// A line one pixel wide, of which only what is in the picture is drawn.                              (Bresenham 1965)
fn line(picture: &mut Image8, from: [i64; 2], to: [i64; 2]) {
    let size = [i64::from(picture.width), i64::from(picture.height)];
    let outside = |axis: usize| from[axis].max(to[axis]) < 0 || from[axis].min(to[axis]) >= size[axis];
    if outside(0) || outside(1) {
        return;
    }
    let length = [(to[0] - from[0]).abs(), -(to[1] - from[1]).abs()];
    let step = [(to[0] - from[0]).signum(), (to[1] - from[1]).signum()];
    let (mut at, mut error) = (from, length[0] + length[1]);
    loop {
        if (0..size[0]).contains(&at[0]) && (0..size[1]).contains(&at[1]) {
            picture.pixels[(at[1] * size[0] + at[0]) as usize] = EDGE;
        }
        if at == to {
            return;
        }
        let twice = 2 * error;
        if twice >= length[1] {
            (error, at[0]) = (error + length[1], at[0] + step[0]);
        }
        if twice <= length[0] {
            (error, at[1]) = (error + length[0], at[1] + step[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};
    use lightvolume::{Options, Tessellation};
    use shadowmap::Projection;

    fn blank(side: u32) -> Image8 {
        Image8 { width: side, height: side, pixels: vec![[0; 3]; (side * side) as usize] }
    }

    fn drawn(picture: &Image8) -> Vec<usize> {
        (0..picture.pixels.len()).filter(|pixel| picture.pixels[*pixel] == EDGE).collect()
    }

    #[test]
    fn lines_reach_both_ends_and_stay_inside() {
        let mut picture = blank(4);
        line(&mut picture, [0, 0], [3, 3]);
        assert_eq!(drawn(&picture), [0, 5, 10, 15]);
        let mut picture = blank(4);
        line(&mut picture, [3, 1], [-5, 1]);
        line(&mut picture, [9, 9], [7, 2]);
        assert_eq!(drawn(&picture), [4, 5, 6, 7]);
    }

    #[test]
    fn a_cell_is_two_triangles() {
        let projection = Projection::perspective(DVec3::ZERO, DVec3::Z, DVec3::X, DVec2::ONE);
        let map = DepthMap::new(projection.unwrap(), (2, 2), vec![1.0, 1.0, 2.0, 2.0]).unwrap();
        let volume = LightVolume::build(&map, &Options::new(Tessellation::Static)).unwrap();
        let whole = Cutout { first: [0, 0], texels: 2, zoom: 4 };
        assert_eq!(busiest(&map, &volume, 2, 4), whole);
        let picture = tessellation(&map, &volume, whole);
        // four sides and a diagonal between the centres of four texels, 4 pixels apart: 16 pixels around, 3 across
        assert_eq!(drawn(&picture).len(), 19);
        assert!(picture.pixels[0][0] > picture.pixels[7 * 8][0], "the near half is brighter");
    }
}
