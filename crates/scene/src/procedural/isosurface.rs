//! The surface where a function is zero, by naive surface nets: one vertex in each cell that the surface crosses,
//! one quadrangle for each grid edge that it crosses.

use super::builder::MeshBuilder;
use glam::Vec3;

/// Samples of a function on a cubic grid, x fastest; inside is where they are negative.
struct Samples {
    n: usize,
    values: Vec<f32>,
}

impl Samples {
    /// Index distance to the next sample along each axis.
    fn step(&self) -> [usize; 3] {
        [1, self.n, self.n * self.n]
    }

    /// Index of corner `c` of the cell whose first corner has index `cell`; bit a of `c` is the offset along axis a.
    fn corner(&self, cell: usize, c: usize) -> usize {
        let [x, y, z] = self.step();
        cell + (c & 1) * x + (c >> 1 & 1) * y + (c >> 2 & 1) * z
    }

    fn inside(&self, i: usize) -> bool {
        self.values[i] < 0.0
    }

    /// Which corners of a cell are inside, one bit each.
    fn mask(&self, cell: usize) -> u8 {
        (0..8).fold(0, |mask, c| mask | u8::from(self.inside(self.corner(cell, c))) << c)
    }

    /// First corners of the cells that the surface crosses.
    fn crossed(&self) -> Vec<usize> {
        let last = self.n - 1;
        let rows = (0..last).flat_map(|z| (0..last).map(move |y| (y, z)));
        rows.flat_map(|(y, z)| {
            let row = self.n * (y + self.n * z);
            row..row + last
        })
        .filter(|&cell| !matches!(self.mask(cell), 0 | 0xFF))
        .collect()
    }

    /// Moves single samples outside until the surface crosses every cell in one piece.
    ///
    /// Where two inside corners face each other across a face or a cell, two sheets would share an edge or a vertex.
    /// Such samples are next to the surface already, and since they only ever go outside, this ends.
    fn untangle(&mut self) {
        let mut work = self.crossed();
        while let Some(cell) = work.pop() {
            let mask = self.mask(cell);
            let Some(pair) = opposed_corners(mask) else { continue };
            let [a, b] = pair.map(|c| self.corner(cell, c));
            let nearest = if self.values[a] > self.values[b] { a } else { b };
            self.values[nearest] = -self.values[nearest];
            // all cells around the sample have changed
            let [x, y, z] = self.step();
            work.extend((0..8).map(|c| nearest - (c & 1) * x - (c >> 1 & 1) * y - (c >> 2 & 1) * z));
        }
    }
}

/// Two inside corners of a cell, one of which must go so that both the inside and the outside hang together.
fn opposed_corners(mask: u8) -> Option<[usize; 2]> {
    let inside = |c: usize| mask >> c & 1 == 1;
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for base in [0, 1 << axis] {
            for [a, b, c, d] in
                [[base, base | u | v, base | u, base | v], [base | u, base | v, base, base | u | v]]
            {
                if inside(a) && inside(b) && !inside(c) && !inside(d) {
                    return Some([a, b]);
                }
            }
        }
    }
    for a in 0..4 {
        let b = 7 - a;
        // alone inside, or alone outside, where any other corner will do
        if mask == 1 << a | 1 << b {
            return Some([a, b]);
        }
        if mask == !(1 << a | 1 << b) {
            return Some([a ^ 1, a ^ 2]);
        }
    }
    None
}

/// The surface around the points where `value` (of grid coordinates) is negative, in grid coordinates of `n`³
/// samples: closed, a manifold. Values at the two outermost layers of the grid must be positive.
pub(super) fn surface_nets(n: usize, value: impl Fn([usize; 3]) -> f32) -> MeshBuilder {
    let mut values = Vec::with_capacity(n * n * n);
    for z in 0..n {
        for y in 0..n {
            values.extend((0..n).map(|x| value([x, y, z])));
        }
    }
    let mut samples = Samples { n, values };
    samples.untangle();

    let crossed = samples.crossed();
    let mut b = MeshBuilder::default();
    let mut vertices = vec![u32::MAX; samples.values.len()];
    for &cell in &crossed {
        // the mean of the points where the surface crosses the cell's edges
        let (mut sum, mut crossings) = (Vec3::ZERO, 0.0);
        for axis in 0..3 {
            for c in (0..8).filter(|c| c >> axis & 1 == 0) {
                let [v, w] = [c, c | 1 << axis].map(|c| samples.values[samples.corner(cell, c)]);
                if (v < 0.0) != (w < 0.0) {
                    let mut p = Vec3::from_array([0, 1, 2].map(|a| (c >> a & 1) as f32));
                    p[axis] = v / (v - w);
                    sum += p;
                    crossings += 1.0;
                }
            }
        }
        let first = [cell % n, cell / n % n, cell / (n * n)].map(|x| x as f32);
        vertices[cell] = b.vertex(Vec3::from_array(first) + sum / crossings);
    }

    let step = samples.step();
    for &cell in &crossed {
        for w in 0..3 {
            let (u, v) = (step[(w + 1) % 3], step[(w + 2) % 3]);
            if samples.inside(cell) == samples.inside(cell + step[w]) {
                continue;
            }
            // the four cells around the edge, counter-clockwise seen from its far end
            let [c, d, e, f] = [cell - u - v, cell - v, cell, cell - u].map(|i| vertices[i]);
            if samples.inside(cell) {
                b.triangles.extend([[c, d, e], [c, e, f]]);
            } else {
                b.triangles.extend([[c, e, d], [c, f, e]]);
            }
        }
    }
    b
}

/// The piece of a mesh with the most triangles; pieces hang together by shared vertices.
pub(super) fn largest_piece(b: &MeshBuilder) -> MeshBuilder {
    let mut parent: Vec<u32> = (0..b.positions.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for &[i, j, k] in &b.triangles {
        for other in [j, k] {
            let (a, c) = (root(&mut parent, i), root(&mut parent, other));
            parent[a as usize] = c;
        }
    }
    let mut sizes = vec![0_u32; parent.len()];
    let owners: Vec<u32> = b.triangles.iter().map(|t| root(&mut parent, t[0])).collect();
    for &owner in &owners {
        sizes[owner as usize] += 1;
    }
    let largest = (0..sizes.len()).max_by_key(|&i| sizes[i]).unwrap_or(0) as u32;

    let mut piece = MeshBuilder::default();
    let mut moved = vec![u32::MAX; b.positions.len()];
    for (t, _) in b.triangles.iter().zip(&owners).filter(|&(_, &owner)| owner == largest) {
        let t = t.map(|i| {
            if moved[i as usize] == u32::MAX {
                moved[i as usize] = piece.vertex(b.positions[i as usize]);
            }
            moved[i as usize]
        });
        piece.triangles.push(t);
    }
    piece
}

#[cfg(test)]
mod tests {
    use super::super::topology::survey;
    use super::*;

    fn ball(center: Vec3, radius: f32) -> impl Fn([usize; 3]) -> f32 {
        move |p| (Vec3::from_array(p.map(|x| x as f32)) - center).length() - radius
    }

    #[test]
    fn a_ball_is_a_ball() {
        let b = surface_nets(24, ball(Vec3::splat(11.5), 8.0));
        let s = survey(&b.positions, &b.triangles);
        assert!(s.is_closed_manifold() && s.genus() == 0, "{s:?}");
        assert!((s.volume / (4.0 / 3.0 * std::f64::consts::PI * 512.0) - 1.0).abs() < 0.02);
        assert!(b.positions.iter().all(|p| ((*p - Vec3::splat(11.5)).length() - 8.0).abs() < 0.2));
    }

    #[test]
    fn random_samples_give_a_manifold_too() {
        let mut rng = super::super::noise::Rng::new(5);
        let noise: Vec<f32> = (0..20_usize.pow(3)).map(|_| rng.range(-1.0, 1.0)).collect();
        let border = |p: [usize; 3]| p.iter().any(|&x| !(2..18).contains(&x));
        let b = surface_nets(20, |p| if border(p) { 1.0 } else { noise[p[0] + 20 * (p[1] + 20 * p[2])] });
        let s = survey(&b.positions, &b.triangles);
        assert!(b.triangles.len() > 1000 && s.bad_edges == 0 && s.pinched == 0, "{s:?}");
    }

    #[test]
    fn the_larger_of_two_balls_stays() {
        let (big, small) = (ball(Vec3::splat(8.0), 5.3), ball(Vec3::splat(20.0), 2.2));
        let two = surface_nets(26, |p| big(p).min(small(p)));
        let one = largest_piece(&two);
        assert_eq!(survey(&two.positions, &two.triangles).components, 2);
        let s = survey(&one.positions, &one.triangles);
        assert!(s.is_closed_manifold() && s.components == 1);
        assert!(
            one.positions.iter().all(|p| p.max_element() < 14.0) && one.triangles.len() < two.triangles.len()
        );
    }
}
