// Shadow rays of the shared grid: a group of threads for each block of 8 x 8 x 8 voxels.
//
// Rays that are asked for are listed light by light, so that threads next to each other all have one to trace. What is
// asked for are the marks of froxels, which the answers take the place of, or every voxel in some view's frustum
// (Stojanovic et al. 2023, section 3.1.1).

#import froxel
#import froxel_voxels
#import bindings_bvh

// whether marks say what is traced
override MARKED: bool = true;

var<workgroup> asked: array<u32, 512>;
var<workgroup> lit: array<atomic<u32>, 512>;
var<workgroup> list: array<u32, 512>;
var<workgroup> list_length: atomic<u32>;
var<workgroup> list_end: u32;
var<workgroup> asked_bits: atomic<u32>;
var<workgroup> block_bits: u32;
var<workgroup> traced_voxels: atomic<u32>;
var<workgroup> block_count: u32;

// Whether a view has the point in its frustum.
fn is_seen(view: FroxelView, point: vec3f) -> bool {
    let from_eye = point - view.eye;
    let depth = dot(from_eye, view.forward);
    if !(depth > 0.0) {
        return false;
    }
    let tangent = vec2f(dot(from_eye, view.right), dot(from_eye, view.up)) / depth;
    let pixel = (tangent - view.offset) / view.scale;
    return all(pixel >= vec2f(0.0)) && all(pixel < vec2f(view.size)) && length(from_eye) <= froxels.range;
}

fn is_seen_by_any(point: vec3f) -> bool {
    for (var i = 0u; i < froxels.view_count; i++) {
        if is_seen(froxel_views.views[i], point) {
            return true;
        }
    }
    return false;
}

// Whether a view may have something of a sphere in its frustum.
fn may_see(view: FroxelView, center: vec3f, radius: f32) -> bool {
    let from_eye = center - view.eye;
    let p = vec3f(dot(from_eye, view.right), dot(from_eye, view.up), dot(from_eye, view.forward));
    // tangents of the picture's left and upper, right and lower edges
    let a = view.offset;
    let b = view.offset + view.scale * vec2f(view.size);
    let inside = vec4f(
        (p.x - a.x * p.z) / sqrt(1.0 + a.x * a.x), (a.y * p.z - p.y) / sqrt(1.0 + a.y * a.y),
        (b.x * p.z - p.x) / sqrt(1.0 + b.x * b.x), (p.y - b.y * p.z) / sqrt(1.0 + b.y * b.y),
    );
    return all(inside >= vec4f(-radius)) && p.z >= -radius && length(from_eye) <= froxels.range + radius;
}

// All rays of a block: a brick by its place, or a block of dense voxels by its number.
fn trace_block(block: u32, thread: u32) {
    var first = vec3u();
    var fine = false;
    if BRICKS {
        let code = atomicLoad(&keys[block]) - 1u;
        fine = (code >> 30u) != 0u;
        first = vec3u(code & 1023u, (code >> 10u) & 1023u, (code >> 20u) & 1023u) * 8u;
    } else {
        let blocks = (froxels.dims + 7u) / 8u;
        first = vec3u(block % blocks.x, (block / blocks.x) % blocks.y, block / (blocks.x * blocks.y)) * 8u;
    }
    if thread == 0u {
        atomicStore(&asked_bits, 0u);
        atomicStore(&traced_voxels, 0u);
    }
    workgroupBarrier();

    if !MARKED {
        // most blocks are in no frustum: a sphere around each says so before its voxels do
        let center = voxel_center(first, false) + 3.5 * froxels.voxel_size;
        var may_be_seen = false;
        for (var i = thread; i < froxels.view_count; i += 64u) {
            may_be_seen = may_be_seen || may_see(froxel_views.views[i], center, 7.0 * froxels.voxel_size);
        }
        atomicOr(&asked_bits, u32(may_be_seen));
        workgroupBarrier();
        if thread == 0u {
            block_bits = atomicLoad(&asked_bits);
            atomicStore(&asked_bits, 0u);
        }
        if workgroupUniformLoad(&block_bits) == 0u {
            return;
        }
    }

    // a thread has a row of eight voxels
    let dims = level_dims(fine);
    let row = first + vec3u(0u, thread & 7u, thread >> 3u);
    let row_is_there = all(row < dims);
    let lanes = 32u / LIGHT_BITS;
    let row_words = LIGHT_BITS / 4u;
    let mask = 0xffffffffu >> (32u - LIGHT_BITS);
    let every_bit = 0xffffffffu >> (32u - min(LIGHTS, LIGHT_BITS));
    let is_its_turn = (froxels.everything != 0u) | ((row.z & 1u) == froxels.parity);
    var first_word = 0u;
    if BRICKS {
        first_word = brick_word(block, row);
    } else {
        first_word = dense_word(row);
    }
    var here = 0u;
    var voxels = 0u;
    for (var x = 0u; x < 8u; x++) {
        let voxel = row + vec3u(x, 0u, 0u);
        var bits = 0u;
        if row_is_there && voxel.x < dims.x {
            if MARKED {
                bits = (load_word(first_word + x / lanes) >> ((x % lanes) * LIGHT_BITS)) & mask;
            } else if is_its_turn && LIGHTS > 0u {
                bits = select(0u, every_bit, is_seen_by_any(voxel_center(voxel, fine)));
            }
        }
        asked[thread * 8u + x] = bits;
        atomicStore(&lit[thread * 8u + x], 0u);
        here |= bits;
        voxels += u32(bits != 0u);
    }
    atomicOr(&asked_bits, here);
    atomicAdd(&traced_voxels, voxels);
    workgroupBarrier();
    if thread == 0u {
        block_bits = atomicLoad(&asked_bits);
    }
    var bits_left = workgroupUniformLoad(&block_bits);
    if bits_left == 0u {
        return;
    }

    var rays = 0u;
    while bits_left != 0u {
        let bit = firstTrailingBit(bits_left);
        bits_left &= bits_left - 1u;
        if thread == 0u {
            atomicStore(&list_length, 0u);
        }
        workgroupBarrier();
        for (var x = 0u; x < 8u; x++) {
            if ((asked[thread * 8u + x] >> bit) & 1u) != 0u {
                list[atomicAdd(&list_length, 1u)] = thread * 8u + x;
            }
        }
        workgroupBarrier();
        if thread == 0u {
            list_end = atomicLoad(&list_length);
        }
        let end = workgroupUniformLoad(&list_end);
        rays += end;
        for (var i = thread; i < end; i += 64u) {
            let at = list[i];
            let voxel = first + vec3u(at & 7u, (at >> 3u) & 7u, at >> 6u);
            let point = voxel_center(voxel, fine);
            let light = light_of(chosen_lights(point), bit);
            if !occluded(point, way_to(light_at(light), point), way_end(light_at(light))) {
                atomicOr(&lit[at], 1u << bit);
            }
        }
        workgroupBarrier();
    }

    if row_is_there {
        for (var w = 0u; w < row_words; w++) {
            if row.x + w * lanes >= dims.x {
                break;
            }
            var word = 0u;
            var kept = 0u;
            for (var lane = 0u; lane < lanes; lane++) {
                let at = thread * 8u + w * lanes + lane;
                word |= atomicLoad(&lit[at]) << (lane * LIGHT_BITS);
                kept |= select(mask << (lane * LIGHT_BITS), 0u, asked[at] != 0u);
            }
            if !MARKED {
                // what is not in sight, or not in turn, keeps what it has
                word |= load_word(first_word + w) & kept;
            }
            store_word(first_word + w, word);
        }
    }
    if thread == 0u {
        atomicAdd(&counts[GRID_RAYS], rays);
        atomicAdd(&counts[VOXELS], atomicLoad(&traced_voxels));
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    if !MARKED {
        let block = group.y * groups.x + group.x;
        if block < froxels.blocks {
            trace_block(block, thread);
        }
        return;
    }
    // how many blocks are marked is known here alone: as many groups as run at once take them in turns
    if thread == 0u {
        block_count = min(atomicLoad(&counts[BRICKS_USED]), froxels.blocks);
    }
    let count = workgroupUniformLoad(&block_count);
    for (var i = group.x; i < count; i += groups.x) {
        trace_block(atomicLoad(&keys[froxels.blocks + i]), thread);
        workgroupBarrier();
    }
}
