// The estimate up to which a level's share of the budget reaches. One thread. In and out: see sampling.wgsl.
// Twin: `Budget::tolerance` in crates/hybrid-march/src/adaptive/budget.rs.

#import sampling

// The estimate at a place among the bins; units: target errors.
fn estimate_at(bin: f32) -> f32 {
    return exp2(bin / BINS_PER_OCTAVE + FIRST_OCTAVE);
}

@compute @workgroup_size(1)
fn main() {
    // an error is inherited by all pixels that are predicted from this one
    let half = f32(level.stride / 2u);
    let pixels = f32(level.survey) * half * half;
    let share = level.share * sampling.left;
    var spent = 0.0;
    var taken = 0.0;
    var all = f32(atomicExchange(&sampling.counts[BINS], 0u));
    var end = f32(BINS);
    for (var bin = 0u; bin < BINS; bin++) {
        let count = f32(atomicExchange(&sampling.counts[bin], 0u));
        let middle = estimate_at(f32(bin) + 0.5);
        let squares = count * pixels * middle * middle;
        all += count;
        if end == f32(BINS) {
            let part = select(1.0, (share - spent) / squares, spent + squares > share);
            spent += part * squares;
            taken += part * count;
            end = select(end, f32(bin) + part, part < 1.0);
        }
    }
    if all - taken > level.most_traced * all {
        sampling.error = -1.0;
        return;
    }
    sampling.left -= spent;
    sampling.error = sampling.unit * min(estimate_at(end), level.most);
}
