// Airlight of one light by a march that casts a shadow ray at every step (march.wgsl). In and out: see bindings.wgsl and
// bindings_bvh.wgsl.

#import bindings
#import bindings_bvh
#import march

// What looks: a view ray, along the world's axes.
struct Sight {
    direction: vec3f,
}

fn sight_of(ray: ViewRay) -> Sight {
    return Sight(to_world(ray.direction));
}

// A shadow ray from the point at distance x.
fn visibility_at(sight: Sight, x: f32) -> f32 {
    let point = x * sight.direction;
    let origin = point + light.eye;
    if LIGHT == DIRECTIONAL {
        return select(1.0, 0.0, occluded(origin, light.world, ENDLESS));
    }
    return select(1.0, 0.0, occluded(origin, light.world - point, 1.0));
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) index: u32) {
    let pixel = pixel_of(tile.xy, index);
    if any(pixel >= view.size) {
        return;
    }
    var sum = vec4f(march(pixel), 0.0);
    if light.adds == 1u {
        sum += textureLoad(before, pixel, 0);
    }
    textureStore(scattered, pixel, sum);
}
