// The target error in radiance: a share of what shadows take away on the lattice, as root mean square; and how large the
// squares of estimates may be together. One group of threads. In and out: see sampling.wgsl.

#import sampling

// Share of the unshadowed airlight that shadows count as at least: below are the roundings of 32-bit floats.
const LEAST_SHADOWS: f32 = 1e-3;

// sums of squares: of what shadows take away, and of all
var<workgroup> sums: array<vec2f, 256>;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) index: u32) {
    let size = lattice_size();
    let count = size.x * size.y;
    var sum = vec2f();
    for (var i = index; i < count; i += 256u) {
        let all = unshadowed[i].rgb;
        let taken = all - values[place_of(vec2u(i % size.x, i / size.x) * level.spacing)].rgb;
        sum += vec2f(dot(taken, taken), dot(all, all));
    }
    sums[index] = sum;
    for (var reach = 128u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if index < reach {
            sums[index] += sums[index + reach];
        }
    }
    if index == 0u {
        let mean = max(sums[0].x, LEAST_SHADOWS * LEAST_SHADOWS * sums[0].y) / f32(count);
        sampling.unit = level.target_error * sqrt(mean);
        sampling.left = level.budget * f32(view.size.x * view.size.y);
    }
    if index < BINS_AND_REST {
        atomicStore(&sampling.counts[index], 0u);
    }
}
