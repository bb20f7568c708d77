// Answers for an array of rays whether a triangle blocks them: for tests, and to measure rays per second.
//
// In: the hierarchy (GpuBvh), rays (Ray, 32 bytes each). Out: 1 for a blocked ray, 0 for a free one.
// Twin: crates/gpu-backend/src/bvh/probe.rs.

#import bvh

struct Ray {
    origin: vec3f,    // units: m
    far: f32,         // end of the ray in lengths of the direction, finite
    direction: vec3f, // units: m
    _pad0: f32,
}

@group(0) @binding(0) var<storage, read> bvh_nodes: array<BvhNode>;
@group(0) @binding(1) var<storage, read> bvh_triangles: array<BvhTriangle>;
@group(0) @binding(2) var<storage, read> rays: array<Ray>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&rays) {
        return;
    }
    let ray = rays[id.x];
    results[id.x] = u32(occluded(ray.origin, ray.direction, ray.far));
}
