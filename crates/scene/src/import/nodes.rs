//! The node hierarchy: which nodes the scene holds, and where each of them stands in the world.

use super::error::{ImportError, place};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf::Document;
use gltf::scene::Transform;

/// A node of the scene.
#[derive(Debug, Clone)]
pub(super) struct Node<'a> {
    /// The node in the document.
    pub(super) item: gltf::Node<'a>,
    /// From the node's space to the world's.
    pub(super) world_from_node: DAffine3,
}

impl Node<'_> {
    /// What errors call it.
    pub(super) fn place(&self) -> String {
        place_of(&self.item)
    }
}

fn place_of(node: &gltf::Node<'_>) -> String {
    place("node", node.index(), node.name())
}

/// The nodes of `scene`, or all of the document without one; each parent before its children.
///
/// No recursion: the hierarchy may be as deep as the file is long.
pub(super) fn collect<'a>(
    document: &'a Document,
    scene: Option<&gltf::Scene<'a>>,
) -> Result<Vec<Node<'a>>, ImportError> {
    let parents = parents(document)?;
    let mut pending: Vec<_> = match scene {
        Some(scene) => scene_roots(scene, &parents)?,
        None => document.nodes().filter(|node| parents[node.index()].is_none()).collect(),
    }
    .into_iter()
    .map(|root| (root, DAffine3::IDENTITY))
    .collect();
    // popped from the end, so that nodes come out in the order of the file
    pending.reverse();
    let mut nodes = Vec::new();
    while let Some((item, world_from_parent)) = pending.pop() {
        let world_from_node = world_from_parent * local_transform(&item)?;
        if !is_invertible(&world_from_node) {
            let reason = "its transform, with those of its parents, is not finite or not invertible";
            return Err(ImportError::at(place_of(&item), reason));
        }
        let first = pending.len();
        pending.extend(item.children().map(|child| (child, world_from_node)));
        pending[first..].reverse();
        nodes.push(Node { item, world_from_node });
    }
    Ok(nodes)
}

/// The parent of each node, if it has one; the nodes must be a set of trees.
fn parents<'a>(document: &'a Document) -> Result<Vec<Option<gltf::Node<'a>>>, ImportError> {
    let mut parents = vec![None; document.nodes().len()];
    for node in document.nodes() {
        for child in node.children() {
            if let Some(other) = parents[child.index()].replace(node.clone()) {
                let reason = format!("{} is already a child of {}", place_of(&child), place_of(&other));
                return Err(ImportError::at(place_of(&node), reason));
            }
        }
    }
    // with at most one parent a node, what cannot be reached from a root is a cycle or hangs on one
    let mut reached = vec![false; parents.len()];
    let mut pending: Vec<_> = document.nodes().filter(|node| parents[node.index()].is_none()).collect();
    while let Some(node) = pending.pop() {
        reached[node.index()] = true;
        pending.extend(node.children());
    }
    match document.nodes().find(|node| !reached[node.index()]) {
        Some(node) => Err(ImportError::at(place_of(&node), "is its own ancestor, or hangs on such a node")),
        None => Ok(parents),
    }
}

fn scene_roots<'a>(
    scene: &gltf::Scene<'a>,
    parents: &[Option<gltf::Node<'a>>],
) -> Result<Vec<gltf::Node<'a>>, ImportError> {
    let error = |reason| Err(ImportError::at(place("scene", scene.index(), scene.name()), reason));
    let mut taken = vec![false; parents.len()];
    for root in scene.nodes() {
        if let Some(parent) = &parents[root.index()] {
            return error(format!("{} is not a root, but a child of {}", place_of(&root), place_of(parent)));
        }
        if std::mem::replace(&mut taken[root.index()], true) {
            return error(format!("{} is listed twice", place_of(&root)));
        }
    }
    Ok(scene.nodes().collect())
}

/// The node's own transform.
///
/// In f64 from here on; the crate's `Transform::matrix` computes in f32.
fn local_transform(node: &gltf::Node<'_>) -> Result<DAffine3, ImportError> {
    match node.transform() {
        Transform::Matrix { matrix } => {
            let matrix: DMat4 = Mat4::from_cols_array_2d(&matrix).as_dmat4();
            // writers round; anything more is a projection
            if (matrix.row(3) - DVec3::ZERO.extend(1.0)).abs().max_element() > 1e-5 {
                return Err(ImportError::at(place_of(node), "the last row of its matrix must be 0, 0, 0, 1"));
            }
            Ok(DAffine3::from_mat4(matrix))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let rotation: DQuat = Quat::from_array(rotation).as_dquat();
            let length = rotation.length();
            if !length.is_normal() {
                let reason = format!("its rotation must be a unit quaternion, got one of length {length}");
                return Err(ImportError::at(place_of(node), reason));
            }
            let [translation, scale] = [translation, scale].map(|v| Vec3::from_array(v).as_dvec3());
            // written with the digits of an f32 or fewer, so the length is not quite 1
            Ok(DAffine3::from_scale_rotation_translation(scale, rotation / length, translation))
        }
    }
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
    use super::super::{document, notes::Notes};
    use super::*;

    fn nodes(text: &str) -> Result<Vec<(String, DAffine3)>, String> {
        let text = format!(r#"{{"asset": {{"version": "2.0"}}, {text}}}"#);
        let message = |error: ImportError| error.to_string();
        let document = document::parse(text.as_bytes(), &mut Notes::default()).map_err(message)?;
        let collected = collect(&document, document.default_scene().as_ref()).map_err(message)?;
        Ok(collected.into_iter().map(|node| (node.place(), node.world_from_node)).collect())
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
            "node 1: node 2 is already a child of node 0",
        );
        refused(r#""nodes": [{"children": [3]}]"#, "nodes[0].children[0]: Index out of bounds");
        refused(
            r#""scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"children": [1]}, {}]"#,
            "scene 0: node 1 is not a root, but a child of node 0",
        );
        refused(r#""scene": 0, "scenes": [{"nodes": [0, 0]}], "nodes": [{}]"#, "listed twice");
        refused(r#""nodes": [{"children": [-1]}]"#, "nodes[0].children[0]: invalid type: integer `-1`");
        // 2^32, which is 0 to a reader that keeps 32 bits
        refused(
            r#""nodes": [{}, {"children": [4294967296]}]"#,
            "nodes[1].children[0]: invalid type: floating point `4294967296.0`",
        );
    }

    #[test]
    fn broken_transforms_are_refused() {
        let refused = |node: &str, why: &str| {
            let error = nodes(&format!(r#""nodes": [{node}]"#)).unwrap_err();
            assert!(error.starts_with("node") && error.contains(why), "{error}");
        };
        refused(r#"{"scale": [1, 0, 1]}"#, "not invertible");
        refused(r#"{"scale": [1, null, 1]}"#, "nodes[0].scale[1]: invalid type: null, expected f32");
        refused(r#"{"scale": [1, 1]}"#, "nodes[0].scale: invalid length 2, expected an array of length 3");
        refused(r#"{"rotation": [0, 0, 0, 0]}"#, "quaternion");
        refused(r#"{"matrix": [1,0,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]}"#, "not invertible");
        refused(r#"{"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,1, 0,0,0,1]}"#, "last row");
        refused(
            r#"{"matrix": [1, 2, 3]}"#,
            "nodes[0].matrix: invalid length 3, expected an array of length 16",
        );
        // more than an f32 holds
        refused(r#"{"scale": [1e39, 1, 1]}"#, "not finite");
        let error = nodes(
            r#""nodes": [{"matrix": [0,1,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1], "children": [1]},
                {"scale": [1, 1, 1e-30], "children": [2]}, {"scale": [1, 1, 0]}]"#,
        )
        .unwrap_err();
        assert!(error.starts_with("node 2: its transform"), "{error}");
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
