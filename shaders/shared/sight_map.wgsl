// The visibility that a march asks for, by lookups in the light's map (shadow_map.wgsl).

#import shadow_map

// What looks up: the ray's coordinates on the map.
fn sight_of(ray: ViewRay) -> MapPath {
    return map_path(ray);
}

fn visibility_at(sight: MapPath, x: f32) -> f32 {
    return map_visibility(sight, x);
}
