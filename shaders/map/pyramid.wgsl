// Least and greatest height of blocks of a map's cells: four levels of the pyramid in one dispatch.
//
// In: the map's heights (r32float), or the level below the finest one written here (rg32float). Out: blocks of 1, 4, 16
// and 64 cells a side of the input; a workgroup makes one of the last. Cells beyond the map are empty ranges, which
// nothing reads; blocks beyond an output are not stored. Twin: crates/shadowmap/src/pyramid.rs.

@group(0) @binding(0) var heights: texture_2d_array<f32>;
@group(0) @binding(1) var level_0: texture_storage_2d_array<rg32float, write>;
@group(0) @binding(2) var level_2: texture_storage_2d_array<rg32float, write>;
@group(0) @binding(3) var level_4: texture_storage_2d_array<rg32float, write>;
@group(0) @binding(4) var level_6: texture_storage_2d_array<rg32float, write>;
@group(0) @binding(5) var<uniform> size: vec2u; // cells of the input

// whether the input is a map whose cells lie between four texel centres
override LINEAR: bool = false;
// whether the input holds ranges
override COARSE: bool = false;

const SIDE: u32 = 16u; // threads along a side; each makes a block of 4
const EMPTY: vec2f = vec2f(3.4e38, -3.4e38);

var<workgroup> ranges: array<vec2f, 256>;

fn joined(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(min(a.x, b.x), max(a.y, b.y));
}

fn height(texel: vec2u, face: u32) -> f32 {
    return textureLoad(heights, texel, face, 0).r;
}

fn cell_range(cell: vec2u, face: u32) -> vec2f {
    if COARSE {
        return textureLoad(heights, cell, face, 0).rg;
    }
    let own = height(cell, face);
    if !LINEAR {
        return vec2f(own, own);
    }
    let right = height(cell + vec2u(1u, 0u), face);
    let below = height(cell + vec2u(0u, 1u), face);
    let last = height(cell + vec2u(1u, 1u), face);
    return vec2f(min(min(own, right), min(below, last)), max(max(own, right), max(below, last)));
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let face = group.z;
    let block = group.xy * SIDE + local.xy;
    var range = EMPTY;
    for (var j = 0u; j < 4u; j++) {
        for (var i = 0u; i < 4u; i++) {
            let cell = block * 4u + vec2u(i, j);
            if all(cell < size) {
                let own = cell_range(cell, face);
                range = joined(range, own);
                if !COARSE {
                    textureStore(level_0, cell, face, vec4f(own, 0.0, 0.0));
                }
            }
        }
    }
    textureStore(level_2, block, face, vec4f(range, 0.0, 0.0));
    ranges[index] = range;
    workgroupBarrier();
    if all((local.xy & vec2u(3u)) == vec2u(0u)) {
        range = EMPTY;
        for (var j = 0u; j < 4u; j++) {
            for (var i = 0u; i < 4u; i++) {
                range = joined(range, ranges[index + j * SIDE + i]);
            }
        }
        textureStore(level_4, block / 4u, face, vec4f(range, 0.0, 0.0));
    }
    workgroupBarrier();
    if all((local.xy & vec2u(3u)) == vec2u(0u)) {
        ranges[index] = range;
    }
    workgroupBarrier();
    if index == 0u {
        for (var k = 1u; k < 16u; k++) {
            range = joined(range, ranges[(k / 4u) * 4u * SIDE + (k % 4u) * 4u]);
        }
        textureStore(level_6, group.xy, face, vec4f(range, 0.0, 0.0));
    }
}
