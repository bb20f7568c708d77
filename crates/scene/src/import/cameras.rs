//! Cameras.

use super::error::ImportError;
use super::json::Item;
use super::nodes::Node;
use super::notes::Notes;
use crate::Camera;
use glam::DVec3;

/// What `camera`, one of the document's cameras, sees from `node`; none if it is orthographic.
pub(super) fn perspective(
    node: &Node<'_>,
    camera: &Item<'_>,
    notes: &mut Notes,
) -> Result<Option<Camera>, ImportError> {
    let kind = camera.need("type")?;
    match kind.text()? {
        "perspective" => {}
        "orthographic" => {
            notes.add("orthographic cameras are skipped", camera.place());
            return Ok(None);
        }
        other => {
            let other = super::error::quoted(other);
            return Err(kind.error(format!("must be \"perspective\" or \"orthographic\", got {other}")));
        }
    }
    let yfov = camera.need("perspective")?.need("yfov")?;
    let fov_y = yfov.single()? as f32;
    if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
        return Err(yfov.error(format!("must lie between 0 and pi, got {fov_y}")));
    }
    let name = match node.item.get("name")? {
        Some(name) => Some(name),
        None => camera.get("name")?,
    };
    let frame = Frame::of(node)?;
    Ok(Some(Camera {
        name: name.map(|name| name.text().map(str::to_owned)).transpose()?,
        position: frame.position.as_vec3(),
        // forward and up are kept in a mirrored node, and the picture is not mirrored
        right: frame.forward.cross(frame.up).as_vec3(),
        up: frame.up.as_vec3(),
        forward: frame.forward.as_vec3(),
        fov_y,
    }))
}

/// Where a camera or a light stands and how it is turned; what scales or shears its node does not reach it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    /// Origin; units: m.
    pub(super) position: DVec3,
    /// Unit vector along −Z.
    pub(super) forward: DVec3,
    /// Unit vector along +X, at right angles to `forward`.
    pub(super) right: DVec3,
    /// Unit vector along +Y, at right angles to `forward`.
    pub(super) up: DVec3,
}

impl Frame {
    /// The frame of a node.
    pub(super) fn of(node: &Node<'_>) -> Result<Self, ImportError> {
        let world_from_node = &node.world_from_node;
        let axes = world_from_node.matrix3;
        let position = world_from_node.translation;
        if !position.as_vec3().is_finite() {
            return Err(node.item.error("its position is out of the range of 32-bit numbers"));
        }
        let forward = -axes.z_axis.normalize();
        // first to unit length: an axis of 1e200 has no squared length
        let across = |axis: DVec3| axis.normalize().reject_from_normalized(forward).normalize();
        Ok(Self { position, forward, right: across(axes.x_axis), up: across(axes.y_axis) })
    }
}
