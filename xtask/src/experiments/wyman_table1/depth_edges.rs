//! Where two pictures differ: at edges of the depth, or elsewhere.

use crate::image_file::Image;

/// Relative difference of neighbouring depths that is an edge.
const EDGE: f32 = 0.05;

/// How far from an edge a pixel counts as next to it; units: pixels.
const REACH: usize = 2;

/// Root mean square of the difference of `a` and `b` within [`REACH`] of an edge of `depths`, and of the rest.
pub(super) fn rms_at_edges(a: &Image, b: &Image, depths: &[f32]) -> (f64, f64) {
    let near = near_edges(a.width as usize, depths);
    let (mut sums, mut counts) = ([0.0; 2], [0_u64; 2]);
    for ((a, b), near) in a.pixels.iter().zip(&b.pixels).zip(near) {
        let class = usize::from(!near);
        for (a, b) in a.iter().zip(b) {
            sums[class] += f64::from(a - b).powi(2);
            counts[class] += 1;
        }
    }
    let rms = |class: usize| (sums[class] / counts[class].max(1) as f64).sqrt();
    (rms(0), rms(1))
}

fn near_edges(width: usize, depths: &[f32]) -> Vec<bool> {
    let height = depths.len() / width.max(1);
    let mut edges = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let own = depths[y * width + x];
            let neighbours = [(x + 1 < width).then_some((x + 1, y)), (y + 1 < height).then_some((x, y + 1))];
            for (nx, ny) in neighbours.into_iter().flatten() {
                if is_edge(own, depths[ny * width + nx]) {
                    edges.extend([(x, y), (nx, ny)]);
                }
            }
        }
    }
    let mut near = vec![false; depths.len()];
    for (x, y) in edges {
        // a pixel on an edge is the first of the two
        for ny in (y + 1).saturating_sub(REACH)..(y + REACH).min(height) {
            for nx in (x + 1).saturating_sub(REACH)..(x + REACH).min(width) {
                near[ny * width + nx] = true;
            }
        }
    }
    near
}

fn is_edge(a: f32, b: f32) -> bool {
    a.is_finite() != b.is_finite() || (a.is_finite() && (a - b).abs() > EDGE * a.min(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pixels_to_each_side() {
        let near = near_edges(8, &[1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
        assert_eq!(near, [false, false, true, true, true, true, false, false]);
        assert!(is_edge(1.0, f32::INFINITY) && !is_edge(f32::INFINITY, f32::INFINITY) && !is_edge(1.0, 1.04));
    }

    #[test]
    fn differences_go_where_they_are() {
        let image = |pixels| Image { width: 8, height: 1, pixels };
        let (a, mut b) = (image(vec![[0.0; 3]; 8]), image(vec![[0.0; 3]; 8]));
        b.pixels[3] = [1.0; 3];
        let (edges, rest) = rms_at_edges(&a, &b, &[1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
        assert_eq!((edges, rest), (0.5, 0.0));
    }
}
