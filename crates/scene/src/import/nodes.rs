//! The node hierarchy: which nodes the scene holds, and where each of them stands in the world.

use super::document::{Document, List};
use super::error::ImportError;
use super::json::Item;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A node of the scene.
#[derive(Debug, Clone)]
pub(super) struct Node<'a> {
    /// The node in the document.
    pub(super) item: Item<'a>,
    /// From the node's space to the world's.
    pub(super) world_from_node: DAffine3,
}

/// The nodes of `scene`, or all of the document without one; each parent before its children.
///
/// No recursion: the hierarchy may be as deep as the file is long.
pub(super) fn collect<'a>(
    document: &Document<'a>,
    scene: Option<&Item<'a>>,
) -> Result<Vec<Node<'a>>, ImportError> {
    let hierarchy = Hierarchy::new(document)?;
    let roots = match scene {
        Some(scene) => hierarchy.scene_roots(document, scene)?,
        None => hierarchy.roots().collect(),
    };
    let mut nodes = Vec::new();
    // popped from the end, so that nodes come out in the order of the file
    let mut pending: Vec<_> = roots.into_iter().rev().map(|root| (root, DAffine3::IDENTITY)).collect();
    while let Some((index, world_from_parent)) = pending.pop() {
        let item = hierarchy.items[index].clone();
        let world_from_node = world_from_parent * local_transform(&item)?;
        if !is_invertible(&world_from_node) {
            return Err(
                item.error("its transform, with those of its parents, is not finite or not invertible")
            );
        }
        pending.extend(hierarchy.children[index].iter().rev().map(|&child| (child, world_from_node)));
        nodes.push(Node { item, world_from_node });
    }
    Ok(nodes)
}

struct Hierarchy<'a> {
    items: Vec<Item<'a>>,
    children: Vec<Vec<usize>>,
    parents: Vec<Option<usize>>,
}

impl<'a> Hierarchy<'a> {
    /// Checks that the nodes are a set of trees.
    fn new(document: &Document<'a>) -> Result<Self, ImportError> {
        let items: Vec<_> = document.all(List::Nodes).collect();
        let mut parents = vec![None; items.len()];
        let mut children = vec![Vec::new(); items.len()];
        for (index, item) in items.iter().enumerate() {
            let Some(list) = item.get("children")? else { continue };
            for reference in list.elements()? {
                let (child, _) = document.refer(List::Nodes, &reference)?;
                if let Some(parent) = parents[child].replace(index) {
                    let (child, parent) = (items[child].place(), items[parent].place());
                    return Err(reference.error(format!("{child} is already a child of {parent}")));
                }
                children[index].push(child);
            }
        }
        let hierarchy = Self { items, children, parents };
        hierarchy.refuse_cycles()?;
        Ok(hierarchy)
    }

    fn roots(&self) -> impl Iterator<Item = usize> {
        self.parents.iter().enumerate().filter(|(_, parent)| parent.is_none()).map(|(index, _)| index)
    }

    /// With at most one parent a node, what cannot be reached from a root is a cycle or hangs on one.
    fn refuse_cycles(&self) -> Result<(), ImportError> {
        let mut reached = vec![false; self.items.len()];
        let mut pending: Vec<_> = self.roots().collect();
        while let Some(index) = pending.pop() {
            reached[index] = true;
            pending.extend(&self.children[index]);
        }
        match reached.iter().position(|&reached| !reached) {
            Some(index) => Err(self.items[index].error("is its own ancestor, or hangs on such a node")),
            None => Ok(()),
        }
    }

    fn scene_roots(&self, document: &Document<'a>, scene: &Item<'a>) -> Result<Vec<usize>, ImportError> {
        let Some(list) = scene.get("nodes")? else { return Ok(Vec::new()) };
        let mut roots = Vec::new();
        let mut taken = vec![false; self.items.len()];
        for reference in list.elements()? {
            let (root, item) = document.refer(List::Nodes, &reference)?;
            if let Some(parent) = self.parents[root] {
                let (node, parent) = (item.place(), self.items[parent].place());
                return Err(reference.error(format!("{node} is not a root, but a child of {parent}")));
            }
            if std::mem::replace(&mut taken[root], true) {
                return Err(reference.error(format!("{} is listed twice", item.place())));
            }
            roots.push(root);
        }
        Ok(roots)
    }
}

/// The node's own transform, from `matrix` or from `translation`, `rotation` and `scale`.
fn local_transform(node: &Item<'_>) -> Result<DAffine3, ImportError> {
    if let Some(item) = node.get("matrix")? {
        let m: [f64; 16] = item.tuple(Item::number)?;
        // writers round; anything more is a projection
        if [m[3], m[7], m[11], m[15] - 1.0].iter().any(|entry| entry.abs() > 1e-5) {
            return Err(item.error("its last row must be 0, 0, 0, 1"));
        }
        let column = |at: usize| DVec3::new(m[at], m[at + 1], m[at + 2]);
        return Ok(DAffine3::from_cols(column(0), column(4), column(8), column(12)));
    }
    let vector = |key: &str, default: DVec3| {
        node.get(key)?.map_or(Ok(default), |item| item.tuple(Item::number).map(DVec3::from_array))
    };
    let rotation = match node.get("rotation")? {
        Some(item) => {
            let q = DQuat::from_array(item.tuple(Item::number)?);
            let length = q.length();
            if !(length.is_normal()) {
                return Err(item.error("must be a unit quaternion, got one of no length"));
            }
            // written with the digits of an f32 or fewer
            q / length
        }
        None => DQuat::IDENTITY,
    };
    let (translation, scale) = (vector("translation", DVec3::ZERO)?, vector("scale", DVec3::ONE)?);
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

/// Whether the transform is finite and keeps all three dimensions.
fn is_invertible(transform: &DAffine3) -> bool {
    let columns = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis];
    let units = columns.map(|column| column / column.length());
    // the volume spanned by unit vectors: 1e-14 is what rounding leaves of 0, whatever the scale
    transform.is_finite() && DMat3::from_cols(units[0], units[1], units[2]).determinant().abs() > 1e-14
}

#[cfg(test)]
mod tests {
    use super::super::notes::Notes;
    use super::*;
    use serde_json::Value;

    fn nodes(text: &str) -> Result<Vec<(String, DAffine3)>, String> {
        let json: Value =
            serde_json::from_str(&format!(r#"{{"asset": {{"version": "2.0"}}, {text}}}"#)).unwrap();
        let document = Document::new(&json, &mut Notes::default()).unwrap();
        let scene = document.follow(List::Scenes, document.root(), "scene").unwrap().map(|(_, scene)| scene);
        let collected = collect(&document, scene.as_ref()).map_err(|error| error.to_string())?;
        Ok(collected.into_iter().map(|node| (node.item.place().to_owned(), node.world_from_node)).collect())
    }

    #[test]
    fn transforms_compose_by_hand() {
        // a quarter turn about Z, twice as large, one to the right; below it, one up and half as large
        let got = nodes(
            r#""scene": 0, "scenes": [{"nodes": [1]}], "nodes": [
                {"name": "leaf", "matrix": [0.5,0,0,0, 0,0.5,0,0, 0,0,0.5,0, 0,1,0,1]},
                {"translation": [1, 0, 0], "rotation": [0, 0, 0.70710678, 0.70710678], "scale": [2, 2, 2], "children": [0]},
                {"name": "elsewhere"}]"#,
        )
        .unwrap();
        let names: Vec<_> = got.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["node 1", "node 0 \"leaf\""]);
        let leaf = got[1].1;
        assert!((leaf.transform_point3(DVec3::ZERO) - DVec3::new(-1.0, 0.0, 0.0)).length() < 1e-12);
        assert!((leaf.transform_point3(DVec3::X) - DVec3::new(-1.0, 1.0, 0.0)).length() < 1e-12);
        assert!((leaf.transform_point3(DVec3::Z) - DVec3::new(-1.0, 0.0, 1.0)).length() < 1e-12);
    }

    #[test]
    fn without_a_scene_all_roots_count() {
        let got = nodes(r#""nodes": [{"children": [2]}, {}, {}]"#).unwrap();
        let names: Vec<_> = got.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["node 0", "node 2", "node 1"]);
    }

    #[test]
    fn what_is_not_a_tree_is_refused() {
        let refused = |text: &str, why: &str| {
            let error = nodes(text).unwrap_err();
            assert!(error.contains(why), "{error}");
        };
        refused(r#""nodes": [{"children": [0]}]"#, "node 0: is its own ancestor");
        refused(r#""nodes": [{}, {"children": [2]}, {"children": [1]}]"#, "node 1: is its own ancestor");
        refused(
            r#""nodes": [{"children": [2]}, {"children": [2]}, {}]"#,
            "node 1 children[0]: node 2 is already a child of node 0",
        );
        refused(r#""nodes": [{"children": [3]}]"#, "node 0 children[0]: there is no node 3, the file has 1");
        refused(
            r#""scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"children": [1]}, {}]"#,
            "scene 0 nodes[1]: node 1 is not a root, but a child of node 0",
        );
        refused(r#""scene": 0, "scenes": [{"nodes": [0, 0]}], "nodes": [{}]"#, "listed twice");
        refused(r#""nodes": [{"children": [-1]}]"#, "whole number");
        // 2^32, which is 0 to a reader that keeps 32 bits
        refused(r#""nodes": [{}, {"children": [4294967296]}]"#, "there is no node 4294967296");
    }

    #[test]
    fn broken_transforms_are_refused() {
        let refused = |node: &str, why: &str| {
            let error = nodes(&format!(r#""nodes": [{node}]"#)).unwrap_err();
            assert!(error.starts_with("node 0") && error.contains(why), "{error}");
        };
        refused(r#"{"scale": [1, 0, 1]}"#, "not invertible");
        refused(r#"{"scale": [1, null, 1]}"#, "scale[1]: must be a number");
        refused(r#"{"scale": [1, 1]}"#, "array of 3");
        refused(r#"{"rotation": [0, 0, 0, 0]}"#, "quaternion");
        refused(r#"{"matrix": [1,0,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]}"#, "not invertible");
        refused(r#"{"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,1, 0,0,0,1]}"#, "last row");
        refused(r#"{"matrix": [1, 2, 3]}"#, "array of 16");
        let error =
            nodes(r#""nodes": [{"scale": [1e100, 1, 1], "children": [1]}, {"scale": [1e100, 1, 1]}]"#)
                .unwrap_err();
        assert!(error.starts_with("node 1: its transform"), "{error}");
        // small and flat, but with three dimensions
        assert!(nodes(r#""nodes": [{"scale": [1e-9, 1e9, 1], "rotation": [0.3, 0.2, 0.1, 0.9]}]"#).is_ok());
    }

    #[test]
    fn depth_is_no_matter() {
        let last = 200_000;
        let list: Vec<_> = (0..last).map(|i| format!(r#"{{"children": [{}]}}"#, i + 1)).collect();
        let got = nodes(&format!(r#""nodes": [{}, {{"translation": [0, 0, 1]}}]"#, list.join(", "))).unwrap();
        assert_eq!(got.len(), last + 1);
        assert_eq!(got[last].1.translation, DVec3::Z);
    }
}
