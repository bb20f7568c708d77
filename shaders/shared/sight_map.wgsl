// The visibility that a march asks for, by lookups in the light's map (shadow_map.wgsl).

#import shadow_map

// What looks up: the ray's coordinates on the map.
alias Sight = MapPath;

fn sight_of(ray: ViewRay) -> Sight {
    return map_path(ray);
}

fn visibility_at(sight: Sight, x: f32) -> f32 {
    return map_visibility(sight, x);
}
