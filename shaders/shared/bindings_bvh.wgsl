// The hierarchy that shadow rays go through: group 2. Layout in Rust: crates/gpu-backend/src/fog/layout.rs.

#import bvh

@group(2) @binding(0) var<storage, read> bvh_nodes: array<BvhNode>;
@group(2) @binding(1) var<storage, read> bvh_triangles: array<BvhTriangle>;
