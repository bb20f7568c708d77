//! Shadow rays through the wide hierarchy on the CPU; twin of `shaders/shared/bvh.wgsl`.

use glam::Vec3;

use super::{WideBvh, WideNode};
use crate::bvh::occlusion::{blocks, inverse};

/// A ray prepared for box tests.
struct Slabs {
    origin: Vec3,
    inverse: Vec3,
    far: f32,
}

impl Slabs {
    /// The children that the ray meets: bit 24 + *i* for child *i* that is a node, below the bits of its triangles.
    fn hits(&self, node: &WideNode) -> u32 {
        // per axis where the ray is at the grid's origin, one step of the grid, and the growth; in lengths of the
        // direction
        let axis = |k: usize| {
            let scale = f32::from_bits(u32::from(node.exponents[k]) << 23);
            let start = node.origin[k] - self.origin[k];
            let grow = WideBvh::GROWTH * (start.abs() + 255.0 * scale) * self.inverse[k].abs();
            (start * self.inverse[k], scale * self.inverse[k], grow)
        };
        let axes = [axis(0), axis(1), axis(2)];
        let mut hits = 0;
        for child in 0..8 {
            let (mut near, mut far) = (0.0_f32, self.far);
            for (k, (start, step, grow)) in axes.into_iter().enumerate() {
                let (a, b) = (f32::from(node.min[k][child]), f32::from(node.max[k][child]));
                let (a, b) = if step < 0.0 { (b, a) } else { (a, b) };
                near = near.max(a * step + (start - grow));
                far = far.min(b * step + (start + grow));
            }
            if near <= far {
                let contents = u32::from(node.contents[child]);
                hits |= (contents >> 5) << (contents & 31);
            }
        }
        hits
    }
}

impl WideBvh {
    /// Whether a triangle lies between `origin` and `origin + far·direction`; as [`Bvh::blocked`](crate::Bvh::blocked)
    /// answers it, and in the steps in which a GPU does.
    pub fn blocked(&self, origin: Vec3, direction: Vec3, far: f32) -> bool {
        if self.nodes.is_empty() || direction == Vec3::ZERO {
            return false;
        }
        let slabs = Slabs { origin, inverse: inverse(direction), far };
        let mut stack = [(0_u32, 0_u32); Self::STACK];
        let mut depth = 0;
        // index of the first child that is a node; the children to visit in the upper byte, all that are nodes in the
        // lower; at first the root alone
        let (mut first, mut group) = (0_u32, 1_u32 << 24);
        loop {
            let slot = (group >> 24).trailing_zeros();
            let before = group & ((1 << slot) - 1);
            let node = &self.nodes[(first + before.count_ones()) as usize];
            group ^= 1 << (24 + slot);
            if group >> 24 != 0 {
                stack[depth] = (first, group);
                depth += 1;
            }
            let hits = slabs.hits(node);
            let mut triangles = hits & 0x00ff_ffff;
            while triangles != 0 {
                let index = node.first_triangle + triangles.trailing_zeros();
                triangles &= triangles - 1;
                if blocks(&self.triangles[index as usize], origin, direction, far) {
                    return true;
                }
            }
            (first, group) = (node.first_child, hits & 0xff00_0000 | u32::from(node.inner));
            if group >> 24 == 0 {
                if depth == 0 {
                    return false;
                }
                depth -= 1;
                (first, group) = stack[depth];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bvh;
    use crate::bvh::tests::soup;

    /// Both trees answer alike for rays among the triangles of `scene`, but for `most_differ` of them.
    fn agree(scene: &crate::Scene, most_differ: usize) {
        let (binary, wide) = (Bvh::build(scene).unwrap(), WideBvh::build(scene).unwrap());
        assert!(wide.levels() <= WideBvh::MAX_LEVELS);
        let (low, size) = match scene.bounds() {
            bounds if bounds.is_empty() => (Vec3::ZERO, Vec3::ONE),
            bounds => (bounds.min, (bounds.max - bounds.min).max(Vec3::splat(0.1 * bounds.diagonal()))),
        };
        let mut differ = 0;
        for i in 0..4000 {
            let t = i as f32;
            let place = |a: f32, b: f32, c: f32| {
                low + size * Vec3::new((t * a).fract(), (t * b).fract(), (t * c).fract())
            };
            let (from, to) = (place(0.377, 0.611, 0.873), place(0.719, 0.237, 0.531));
            let mut direction = to - from;
            if i % 5 == 0 {
                direction[i / 5 % 3] = 0.0;
            }
            for far in [1.0, 1e15] {
                let (a, b) = (binary.blocked(from, direction, far), wide.blocked(from, direction, far));
                differ += usize::from(a != b);
            }
        }
        assert!(differ <= most_differ, "{differ} of 8000 differ");
    }

    #[test]
    fn answers_as_the_binary_tree() {
        for count in [0, 1, 2, 3, 7, 600] {
            agree(&soup(count, 0.15), 1);
        }
    }

    #[test]
    fn equal_and_degenerate_triangles() {
        let mut scene = soup(40, 0.3);
        let mesh = scene.meshes[0].clone();
        scene.meshes.resize(100, mesh);
        agree(&scene, 1);
        assert_eq!(WideBvh::build(&scene).unwrap().triangles().len(), 40);
        let points = vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, Vec3::ONE];
        let flat = vec![[0, 1, 2], [3, 3, 3], [0, 0, 3]];
        scene.meshes = vec![crate::Mesh::new(points, flat, 0).unwrap()];
        agree(&scene, 0);
        assert!(WideBvh::build(&scene).unwrap().nodes().is_empty());
    }

    #[test]
    fn a_direction_without_length_is_not_blocked() {
        let wide = WideBvh::build(&soup(600, 0.15)).unwrap();
        assert!(!wide.blocked(Vec3::splat(0.5), Vec3::ZERO, 1.0));
    }

    #[test]
    fn too_wide_a_scene_is_refused() {
        let corners = vec![Vec3::ZERO, Vec3::X, 1e12 * Vec3::Y];
        let mesh = crate::Mesh::new(corners, vec![[0, 1, 2]], 0).unwrap();
        let error = WideBvh::build(&crate::Scene { meshes: vec![mesh], ..Default::default() }).unwrap_err();
        assert!(error.to_string().contains("reaches 1000000000000 m"), "{error}");
    }

    #[test]
    fn grown_boxes_hold_their_triangles() {
        for (count, size) in [(600, 0.15), (5000, 0.001)] {
            for scale in [1e-6_f32, 1e-3, 1.0, 0.7e5] {
                let mut scene = soup(count, size);
                let mesh = &scene.meshes[0];
                let positions = mesh.positions().iter().map(|&p| scale * (p - 0.3)).collect();
                scene.meshes = vec![crate::Mesh::new(positions, mesh.triangles().to_vec(), 0).unwrap()];
                let wide = WideBvh::build(&scene).unwrap();
                assert_eq!(held(&wide, 0), count);
            }
        }
    }

    /// Number of triangles below a node, each of which has to lie in the box of the child that holds it.
    fn held(wide: &WideBvh, index: usize) -> usize {
        let node = &wide.nodes[index];
        let mut held = 0;
        let mut inner = node.first_child as usize;
        for child in 0..8 {
            let contents = node.contents[child];
            if contents == 0 {
                continue;
            }
            if node.inner & (1 << child) != 0 {
                assert_eq!(usize::from(contents), 0b0010_0000 + 24 + child);
                held += self::held(wide, inner);
                inner += 1;
                continue;
            }
            let first = (node.first_triangle + u32::from(contents & 31)) as usize;
            let count = (contents >> 5).count_ones() as usize;
            for corner in wide.triangles[first..first + count].iter().flat_map(|t| t.corners) {
                for axis in 0..3 {
                    let step = f64::from(f32::from_bits(u32::from(node.exponents[axis]) << 23));
                    let grow = f64::from(WideBvh::GROWTH) * 255.0 * step / 2.0;
                    let on_grid = (f64::from(corner[axis]) - f64::from(node.origin[axis])) / step;
                    let (low, high) = (f64::from(node.min[axis][child]), f64::from(node.max[axis][child]));
                    assert!(
                        on_grid >= low - grow / step && on_grid <= high + grow / step,
                        "{on_grid}: {low} to {high}"
                    );
                }
            }
            held += count;
        }
        held
    }
}
