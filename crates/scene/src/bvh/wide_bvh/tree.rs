//! From boxes to a compressed wide tree of bounded depth, by obvhs.
//!
//! obvhs joins neighbouring boxes two by two. Where many boxes are equal it makes chains instead, as deep as there are
//! boxes, and recurses along them. Such trees are replaced by one that halves the number of boxes at every step.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer};
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// Deepest binary tree that is converted: the conversion recurses.
const DEEPEST_BINARY: usize = 256;

/// Most triangles of a leaf; the format has room for three.
const TRIANGLES_PER_LEAF: u32 = 3;

/// A tree over `boxes` with at most `most_levels` levels, or ⌈log₂⌉ of their number if that is more; `boxes` has one at
/// least.
pub(super) fn build(boxes: &[Aabb], most_levels: usize) -> CwBvh {
    let params = BvhBuildParams::medium_build();
    let indices = (0..boxes.len() as u32).collect();
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        indices,
        params.sort_precision,
        params.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut tree, params.reinsertion_batch_ratio, None);
    if !is_deeper(&tree, DEEPEST_BINARY) {
        let wide = bvh2_to_cwbvh(&tree, TRIANGLES_PER_LEAF, true, false);
        if levels(&wide) <= most_levels {
            return wide;
        }
    }
    bvh2_to_cwbvh(&halved(boxes), TRIANGLES_PER_LEAF, true, false)
}

/// Levels of the tree; every child comes behind its parent in the list.
pub(super) fn levels(tree: &CwBvh) -> usize {
    let mut levels = vec![1; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        let (first, below) = (node.child_base_idx as usize, levels[i] + 1);
        levels.iter_mut().skip(first).take(node.imask.count_ones() as usize).for_each(|level| *level = below);
    }
    levels.into_iter().max().unwrap_or(0)
}

/// Whether the binary tree has more than `most` levels.
fn is_deeper(tree: &Bvh2, most: usize) -> bool {
    let mut open = vec![(0, 1)];
    while let Some((index, level)) = open.pop() {
        if level > most {
            return true;
        }
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            let child = node.first_index as usize;
            open.extend([(child, level + 1), (child + 1, level + 1)]);
        }
    }
    false
}

/// The binary tree that halves the boxes along the longest axis, one box a leaf.
fn halved(boxes: &[Aabb]) -> Bvh2 {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut open = vec![(0, 0..boxes.len())];
    while let Some((index, range)) = open.pop() {
        let part = &mut order[range.clone()];
        let around = part.iter().fold(Aabb::empty(), |a, &i| a.union(&boxes[i as usize].aabb()));
        if part.len() == 1 {
            nodes[index] = Bvh2Node::new(around, 1, range.start as u32);
            continue;
        }
        let axis = longest(around.diagonal());
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| {
            let at = |i: u32| boxes[i as usize].center()[axis];
            at(a).total_cmp(&at(b))
        });
        let child = nodes.len();
        nodes[index] = Bvh2Node::new(around, 0, child as u32);
        nodes.resize(child + 2, Bvh2Node::default());
        let middle = range.start + middle;
        open.extend([(child, range.start..middle), (child + 1, middle..range.end)]);
    }
    Bvh2 { nodes, primitive_indices: order, ..Bvh2::default() }
}

fn longest(size: Vec3A) -> usize {
    (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_boxes_make_no_chain() {
        let unit = Aabb::new(Vec3A::ZERO, Vec3A::ONE);
        let point = Aabb::new(Vec3A::ONE, Vec3A::ONE);
        for same in [unit, point] {
            for count in [1, 2, 5, 1000, 3000] {
                let tree = build(&vec![same; count], 33);
                assert!(levels(&tree) <= 13, "{count}: {} levels", levels(&tree));
                let mut seen = tree.primitive_indices.clone();
                seen.sort_unstable();
                assert!(seen.into_iter().eq(0..count as u32), "{count}: not every box is there once");
            }
        }
    }
}
