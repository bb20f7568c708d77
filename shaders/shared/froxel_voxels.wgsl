// Voxels of the world and where their masks are: dense, or in bricks of 8 x 8 x 8 found by a key.
//
// Masks are in two buffers, since one binding has room for 128 MiB alone.

#import froxel

// whether voxels are in bricks
override BRICKS: bool = false;
// whether froxels read only every other layer in z
override ALTERNATES: bool = false;
// whether eight voxels are read
override TRILINEAR: bool = false;

@group(1) @binding(0) var<storage, read_write> masks0: array<atomic<u32>>;
@group(1) @binding(1) var<storage, read_write> masks1: array<atomic<u32>>;
// the key of the brick in each place, or a one for each block of dense voxels that something marks, 0 where there is none;
// behind those the places or blocks of all, in no order
@group(1) @binding(2) var<storage, read_write> keys: array<atomic<u32>>;

// words of the first buffer: 128 MiB
const FIRST_WORDS: u32 = 33554432u;
const NOWHERE: u32 = 0xffffffffu;
// places that are tried for a brick
const MOST_PROBES: u32 = 64u;

fn load_word(word: u32) -> u32 {
    if word < FIRST_WORDS {
        return atomicLoad(&masks0[word]);
    }
    return atomicLoad(&masks1[word - FIRST_WORDS]);
}

fn store_word(word: u32, value: u32) {
    if word < FIRST_WORDS {
        atomicStore(&masks0[word], value);
    } else {
        atomicStore(&masks1[word - FIRST_WORDS], value);
    }
}

fn or_word(word: u32, bits: u32) {
    if word < FIRST_WORDS {
        atomicOr(&masks0[word], bits);
    } else {
        atomicOr(&masks1[word - FIRST_WORDS], bits);
    }
}

fn level_dims(fine: bool) -> vec3u {
    return select(froxels.dims, froxels.dims * froxels.ratio, fine);
}

fn level_size(fine: bool) -> f32 {
    return select(froxels.voxel_size, froxels.voxel_size / f32(froxels.ratio), fine);
}

fn voxel_center(voxel: vec3u, fine: bool) -> vec3f {
    return froxels.grid_min + (vec3f(voxel) + 0.5) * level_size(fine);
}

// The layer that is read in place of a voxel's.
fn alternate(voxel: vec3u, fine: bool) -> vec3u {
    if !ALTERNATES {
        return voxel;
    }
    let z = (voxel.z & ~1u) | froxels.parity;
    return vec3u(voxel.xy, min(z, level_dims(fine).z - 1u));
}

// The voxel that a point lies in, or the next one to it.
fn voxel_at(point: vec3f, fine: bool) -> vec3u {
    let at = floor((point - froxels.grid_min) * (1.0 / level_size(fine)));
    return vec3u(clamp(at, vec3f(0.0), vec3f(level_dims(fine) - 1u)));
}

// The lowest of the eight voxels around a point, and the shares of the way to the others.
struct Around {
    low: vec3u,
    high: vec3u,
    share: vec3f,
}

fn voxels_around(point: vec3f, fine: bool) -> Around {
    let last = vec3f(level_dims(fine) - 1u);
    let at = clamp((point - froxels.grid_min) * (1.0 / level_size(fine)) - 0.5, vec3f(0.0), last);
    let low = floor(at);
    return Around(vec3u(low), vec3u(min(low + 1.0, last)), at - low);
}

// One of the eight, and its weight.
fn corner_voxel(around: Around, index: u32) -> vec3u {
    let upper = vec3<bool>((index & 1u) != 0u, (index & 2u) != 0u, (index & 4u) != 0u);
    return select(around.low, around.high, upper);
}

fn corner_weight(around: Around, index: u32) -> f32 {
    let upper = vec3<bool>((index & 1u) != 0u, (index & 2u) != 0u, (index & 4u) != 0u);
    let weights = select(1.0 - around.share, around.share, upper);
    return weights.x * weights.y * weights.z;
}

fn brick_key(voxel: vec3u, fine: bool) -> u32 {
    let brick = voxel >> vec3u(3u);
    return (u32(fine) << 30u) + ((brick.z << 20u) | (brick.y << 10u) | brick.x) + 1u;
}

// A hash that spreads neighbouring keys.
fn hash_of(key: u32) -> u32 {
    var h = key * 0x9e3779b1u;
    h ^= h >> 16u;
    h *= 0x85ebca6bu;
    h ^= h >> 13u;
    return h;
}

// Puts a block on the list of those that rays are traced for.
fn list_block(block: u32) {
    atomicStore(&keys[froxels.blocks + atomicAdd(&counts[BRICKS_USED], 1u)], block);
}

// The same for a block of dense voxels that may be there already.
fn note_block(voxel: vec3u) {
    let blocks = (froxels.dims + 7u) / 8u;
    let at = voxel >> vec3u(3u);
    let block = (at.z * blocks.y + at.y) * blocks.x + at.x;
    if atomicLoad(&keys[block]) == 0u && atomicExchange(&keys[block], 1u) == 0u {
        list_block(block);
    }
}

// The place of a brick, or NOWHERE.
fn find_brick(key: u32) -> u32 {
    let first = hash_of(key);
    for (var i = 0u; i < MOST_PROBES; i++) {
        let place = (first + i) & (froxels.bricks - 1u);
        let there = atomicLoad(&keys[place]);
        if there == key {
            return place;
        }
        if there == 0u {
            return NOWHERE;
        }
    }
    return NOWHERE;
}

// The same; the brick gets a place if it has none.
fn make_brick(key: u32) -> u32 {
    let first = hash_of(key);
    for (var i = 0u; i < MOST_PROBES; i++) {
        let place = (first + i) & (froxels.bricks - 1u);
        // a read before the exchange: nearly all voxels of a brick find it there
        var there = atomicLoad(&keys[place]);
        if there == 0u {
            let exchanged = atomicCompareExchangeWeak(&keys[place], 0u, key);
            if exchanged.exchanged {
                list_block(place);
                return place;
            }
            there = exchanged.old_value;
            if there == 0u {
                // it failed for no reason: this place once more
                i -= 1u;
                continue;
            }
        }
        if there == key {
            return place;
        }
    }
    return NOWHERE;
}

// Word of a voxel in the brick at a place.
fn brick_word(place: u32, voxel: vec3u) -> u32 {
    let inside = voxel & vec3u(7u);
    return (place * 512u + (inside.z * 8u + inside.y) * 8u) * LIGHT_BITS / 32u + ((inside.x * LIGHT_BITS) >> 5u);
}

fn dense_word(voxel: vec3u) -> u32 {
    let row = (froxels.dims.x * LIGHT_BITS + 31u) >> 5u;
    return (voxel.z * froxels.dims.y + voxel.y) * row + ((voxel.x * LIGHT_BITS) >> 5u);
}

fn voxel_shift(voxel: vec3u) -> u32 {
    return (voxel.x * LIGHT_BITS) & 31u;
}

const WHOLE_MASK: u32 = 0xffffffffu;

// The mask of a voxel; lit where its brick found no place, which `missed` then says for so many reads.
fn voxel_mask(voxel: vec3u, fine: bool, reads: u32, missed: ptr<function, u32>) -> u32 {
    var word = 0u;
    if BRICKS {
        let place = find_brick(brick_key(voxel, fine));
        if place == NOWHERE {
            *missed += reads;
            return WHOLE_MASK;
        }
        word = brick_word(place, voxel);
    } else {
        word = dense_word(voxel);
    }
    return (load_word(word) >> voxel_shift(voxel)) & (WHOLE_MASK >> (32u - LIGHT_BITS));
}
