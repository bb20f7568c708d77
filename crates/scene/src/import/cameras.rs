//! Cameras.

use super::error::{ImportError, place};
use super::nodes::Node;
use super::notes::Notes;
use crate::Camera;
use glam::DVec3;
use gltf::camera::Projection;

/// What `camera` sees from `node`; none if it is orthographic.
pub(super) fn perspective(
    node: &Node<'_>,
    camera: &gltf::Camera<'_>,
    notes: &mut Notes,
) -> Result<Option<Camera>, ImportError> {
    let place = place("camera", camera.index(), camera.name());
    let Projection::Perspective(perspective) = camera.projection() else {
        notes.add("orthographic cameras are skipped", &place);
        return Ok(None);
    };
    let fov_y = perspective.yfov();
    if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
        return Err(ImportError::at(place, format!("yfov must lie between 0 and pi, got {fov_y}")));
    }
    let frame = Frame::of(node)?;
    Ok(Some(Camera {
        name: node.item.name().or(camera.name()).map(str::to_owned),
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
            return Err(ImportError::at(node.place(), "its position is out of the range of 32-bit numbers"));
        }
        let forward = -axes.z_axis.normalize();
        // first to unit length: an axis of 1e200 has no squared length
        let across = |axis: DVec3| axis.normalize().reject_from_normalized(forward).normalize();
        Ok(Self { position, forward, right: across(axes.x_axis), up: across(axes.y_axis) })
    }
}
