//! A stained-glass window, as the picture of a textured spot: Voronoi panes of a few colours between lines of lead.

use std::f32::consts::PI;

use scene::{LightTexture, TextureFilter};

/// Texels along a side.
const SIDE: u32 = 128;

/// Panes along a side; each has one seed somewhere in its cell.
const CELLS: i32 = 9;

/// Half the width of the lead between two panes, in cells.
const LEAD: f32 = 0.07;

/// Transmittances of the glasses.
const GLASSES: [[f32; 3]; 7] = [
    [0.85, 0.08, 0.05],
    [0.06, 0.14, 0.80],
    [0.95, 0.70, 0.10],
    [0.08, 0.55, 0.15],
    [0.55, 0.10, 0.60],
    [0.90, 0.90, 0.80],
    [0.10, 0.60, 0.75],
];

/// The window: the same picture at every call.
pub(crate) fn stained_glass() -> LightTexture {
    let texels = (0..SIDE * SIDE).map(|texel| {
        let at = |index: u32| (index as f32 + 0.5) / SIDE as f32 * CELLS as f32;
        texel_at(at(texel % SIDE), at(texel / SIDE))
    });
    LightTexture { width: SIDE, height: SIDE, texels: texels.collect(), filter: TextureFilter::Linear }
}

/// Light that passes at a place in cells.
fn texel_at(x: f32, y: f32) -> [f32; 3] {
    let (column, row) = (x.floor() as i32, y.floor() as i32);
    let mut near: Vec<(f32, i32, i32)> = (-2..=2)
        .flat_map(|dy| (-2..=2).map(move |dx| (column + dx, row + dy)))
        .map(|(column, row)| {
            let (sx, sy) = seed(column, row);
            ((x - sx).hypot(y - sy), column, row)
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(first, column, row), (second, ..), ..] = near[..] else { return [0.0; 3] };
    // the distance of two panes' border is close to half of the difference
    let border = 0.5 * (second - first);
    let open = ((border - LEAD) / 0.05).clamp(0.0, 1.0);
    let glass = GLASSES[noise(column, row, 3) as usize % GLASSES.len()];
    glass.map(|share| share * open)
}

/// Where a cell's seed lies.
fn seed(column: i32, row: i32) -> (f32, f32) {
    let share = |salt| (noise(column, row, salt) % 1024) as f32 / 1024.0;
    let (angle, radius) = (2.0 * PI * share(1), 0.42 * share(2).sqrt());
    (column as f32 + 0.5 + radius * angle.cos(), row as f32 + 0.5 + radius * angle.sin())
}

/// A fixed number for a cell.
fn noise(column: i32, row: i32, salt: u32) -> u32 {
    let mut bits = (column as u32)
        .wrapping_mul(0x9E37_79B1)
        .wrapping_add((row as u32).wrapping_mul(0x85EB_CA77))
        .wrapping_add(salt.wrapping_mul(0xC2B2_AE3D));
    for _ in 0..2 {
        bits ^= bits >> 15;
        bits = bits.wrapping_mul(0x2C1B_3C6D);
    }
    bits ^ (bits >> 13)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_panes_and_lead() {
        let window = stained_glass();
        assert_eq!(window.texels.len(), (window.width * window.height) as usize);
        assert!(window.texels.iter().flatten().all(|share| (0.0..=1.0).contains(share)));
        let share = |counts: fn(&&[f32; 3]) -> bool| {
            window.texels.iter().filter(counts).count() as f32 / window.texels.len() as f32
        };
        let lead = share(|texel| **texel == [0.0; 3]);
        assert!((0.05..0.5).contains(&lead), "{lead}");
        for glass in GLASSES {
            assert!(window.texels.contains(&glass), "{glass:?}");
        }
        assert_eq!(window, stained_glass());
    }
}
