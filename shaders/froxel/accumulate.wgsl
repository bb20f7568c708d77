// Radiance and density summed up from the eye to the end of each slice, column by column: scattered light is integrated over
// a slice with the extinction in it, which conserves energy in slices of any depth (Hillaire 2015).
//
// Twin: crates/froxel-grid/src/accumulate.rs.

#import froxel
#import froxel_which

// whether the channels are attenuated alike
override ACHROMATIC: bool = true;

@group(2) @binding(1) var lit_volume: texture_3d<f32>;
// W/(m^2 sr) in rgb, the integral of the density in alpha (m)
@group(2) @binding(2) var accumulated: texture_storage_3d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let froxel_view = froxel_views.views[which.view];
    if any(id.xy >= froxel_view.tiles) {
        return;
    }
    let reach = reach_of(froxel_view, id.xy);
    var sum = vec4f();
    var lit = 0u;
    // slices in front of the surfaces; a count of the column's own, since lavapipe would compile a uniform's anew
    let slices = select(0u, froxels.slices, reach > 0.0);
    for (var k = 0u; k < slices; k++) {
        let slice = froxels.starts[k];
        if slice.x >= reach {
            break;
        }
        let value = textureLoad(lit_volume, vec3u(id.xy, k), 0);
        let depth = slice.y - slice.x;
        let path = value.a * depth;
        var seen = vec3f(exp(-froxels.sigma_t.x * sum.a) * phi(froxels.sigma_t.x * path));
        if !ACHROMATIC {
            let y = froxels.sigma_t * path;
            seen = exp(-froxels.sigma_t * sum.a) * vec3f(phi(y.x), phi(y.y), phi(y.z));
        }
        sum += vec4f(seen * value.rgb, value.a) * depth;
        textureStore(accumulated, vec3u(id.xy, k), sum);
        lit++;
    }
    atomicAdd(&counts[FROXELS], lit);
}
