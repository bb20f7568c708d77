// The visibility that a march asks for, by shadow rays through a hierarchy (bvh.wgsl).

#import bindings_bvh
#import light

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
