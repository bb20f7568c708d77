//! The wide hierarchy of a scene in buffers, for shadow rays in any pass.
//!
//! Twin of the structs in `shaders/shared/bvh.wgsl`.

use bytemuck::{Pod, Zeroable};
use scene::{Triangle, WideBvh, WideNode};

use crate::PrepareError;
use crate::checked::{check_size, filled_buffer, prepared};

mod probe;

pub use probe::{OcclusionProbe, ShadowRay, Traced};

/// The operation, in errors.
const UPLOAD: &str = "upload of the hierarchy";

/// [`WideNode`] as the shader reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuNode {
    origin: [f32; 3],
    exponents: u32,
    first_child: u32,
    first_triangle: u32,
    contents: [u32; 2],
    min_x: [u32; 2],
    max_x: [u32; 2],
    min_y: [u32; 2],
    max_y: [u32; 2],
    min_z: [u32; 2],
    max_z: [u32; 2],
}

impl From<&WideNode> for GpuNode {
    fn from(node: &WideNode) -> Self {
        let words = |[a, b, c, d, e, f, g, h]: [u8; 8]| {
            [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
        };
        let [x, y, z] = node.exponents;
        let ([min_x, min_y, min_z], [max_x, max_y, max_z]) = (node.min.map(words), node.max.map(words));
        Self {
            origin: node.origin,
            exponents: u32::from_le_bytes([x, y, z, node.inner]),
            first_child: node.first_child,
            first_triangle: node.first_triangle,
            contents: words(node.contents),
            min_x,
            max_x,
            min_y,
            max_y,
            min_z,
            max_z,
        }
    }
}

/// A triangle as the shader reads it: a corner and the edges from it; units: m.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuTriangle {
    corner: [f32; 3],
    _pad0: f32,
    edge1: [f32; 3],
    _pad1: f32,
    edge2: [f32; 3],
    _pad2: f32,
}

impl From<&Triangle> for GpuTriangle {
    fn from(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.corners;
        let [corner, edge1, edge2] = [a, b - a, c - a].map(|v| v.to_array());
        Self { corner, _pad0: 0.0, edge1, _pad1: 0.0, edge2, _pad2: 0.0 }
    }
}

/// A scene's hierarchy on a device.
///
/// A pass that wants shadow rays imports `bvh`, declares `bvh_nodes` and `bvh_triangles` as read-only storage, and binds
/// [`GpuBvh::nodes`] and [`GpuBvh::triangles`] to them.
#[derive(Debug, Clone)]
pub struct GpuBvh {
    nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    triangle_count: u64,
}

impl GpuBvh {
    /// Copies the hierarchy to the device.
    ///
    /// # Errors
    /// [`PrepareError::TooLarge`] if nodes (80 bytes each) or triangles (48 bytes each) exceed the device's limits: 2.8
    /// million triangles at the default 128 MiB. [`PrepareError::Device`] if the device has no memory for them or is lost.
    pub fn upload(device: &wgpu::Device, bvh: &WideBvh) -> Result<Self, PrepareError> {
        let sizes = [
            ("the buffer of the hierarchy's nodes", size_of::<GpuNode>() * bvh.nodes().len()),
            ("the buffer of the hierarchy's triangles", size_of::<GpuTriangle>() * bvh.triangles().len()),
        ];
        for (what, bytes) in sizes {
            check_size(device, what, bytes as u64)?;
        }
        let mut nodes: Vec<GpuNode> = bvh.nodes().iter().map(GpuNode::from).collect();
        let mut triangles: Vec<GpuTriangle> = bvh.triangles().iter().map(GpuTriangle::from).collect();
        if nodes.is_empty() {
            // a binding has to hold something: a node without children, which no ray gets past
            nodes.push(GpuNode::zeroed());
            triangles.push(GpuTriangle::zeroed());
        }
        let storage = |label, contents| filled_buffer(device, label, contents, wgpu::BufferUsages::STORAGE);
        prepared(device, UPLOAD, || Self {
            nodes: storage("bvh nodes", bytemuck::cast_slice(&nodes)),
            triangles: storage("bvh triangles", bytemuck::cast_slice(&triangles)),
            triangle_count: bvh.triangles().len() as u64,
        })
    }

    /// What a pass binds to `bvh_nodes`.
    pub fn nodes(&self) -> &wgpu::Buffer {
        &self.nodes
    }

    /// What a pass binds to `bvh_triangles`.
    pub fn triangles(&self) -> &wgpu::Buffer {
        &self.triangles
    }

    /// Triangles of the scene.
    pub fn triangle_count(&self) -> u64 {
        self.triangle_count
    }

    /// Memory on the device; units: bytes.
    pub fn bytes(&self) -> u64 {
        self.nodes.size() + self.triangles.size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader;
    use std::mem::offset_of;

    /// The module of a pass that imports the hierarchy.
    fn module() -> naga::Module {
        naga::front::wgsl::parse_str(&shader::assemble("probe/occlusion").unwrap()).unwrap()
    }

    /// Offsets of a struct's fields in the shader, and its stride in an array.
    fn layout(module: &naga::Module, name: &str) -> (Vec<(String, usize)>, usize) {
        let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is a struct") };
        let field = |m: &naga::StructMember| (m.name.clone().unwrap(), m.offset as usize);
        (members.iter().map(field).collect(), *span as usize)
    }

    macro_rules! fields {
        ($ty:ty: $($field:ident),*) => { vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),*] };
    }

    #[test]
    fn the_shader_reads_what_rust_writes() {
        let module = module();
        let node = fields!(GpuNode: origin, exponents, first_child, first_triangle, contents, min_x, max_x, min_y, max_y, min_z, max_z);
        assert_eq!(layout(&module, "BvhNode"), (node, size_of::<GpuNode>()));
        let triangle = fields!(GpuTriangle: corner, _pad0, edge1, _pad1, edge2, _pad2);
        assert_eq!(layout(&module, "BvhTriangle"), (triangle, size_of::<GpuTriangle>()));
    }

    #[test]
    fn the_shader_has_the_constants_of_the_hierarchy() {
        let module = module();
        let value = |name: &str| {
            let (_, constant) =
                module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name)).unwrap();
            let naga::Expression::Literal(literal) = module.global_expressions[constant.init] else {
                panic!("{name} is a number")
            };
            literal
        };
        assert_eq!(value("BVH_STACK"), naga::Literal::U32(WideBvh::STACK as u32));
        assert_eq!(value("BVH_GROWTH"), naga::Literal::F32(WideBvh::GROWTH));
    }

    #[test]
    fn bytes_keep_their_order() {
        let node = WideNode {
            exponents: [1, 2, 3],
            inner: 4,
            min: [[1, 2, 3, 4, 5, 6, 7, 8], [0; 8], [9; 8]],
            ..WideNode::default()
        };
        let packed = GpuNode::from(&node);
        assert_eq!(packed.exponents, 0x04030201);
        assert_eq!(packed.min_x, [0x04030201, 0x08070605]);
        assert_eq!((packed.min_y, packed.min_z, packed.max_z), ([0; 2], [0x09090909; 2], [0; 2]));
    }
}
