//! How large an estimated error may be: the budget of squared errors, shared out level by level.

use super::prediction::Prediction;

/// Bins of a histogram: by quarters of a power of two, from this power of the target on.
const BINS: usize = 56;
const BINS_PER_OCTAVE: f64 = 4.0;
const FIRST_OCTAVE: f64 = -10.0;

/// Pixels along a side of the groups that a histogram takes or leaves, at the stride of its level.
const GROUP: u32 = 8;

/// Groups of which a histogram takes all.
const FEW_GROUPS: u32 = 512;

/// A step of [`Adaptive`](crate::Adaptive): from every so many pixels to half of that.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AdaptiveLevel {
    /// Distance of the pixels that are known; units: pixels.
    pub stride: u32,
    /// Share of what is left of the budget that the level may use; the last one may use all. Errors of early ones are
    /// inherited.
    pub share: f64,
    /// Share of its pixels that may be left to be traced: where there are more, all of them are. What is left then is not to
    /// be trusted, and saves little, since rays beside edges cost more than a mean one.
    pub most_traced: f64,
    /// One group of 8 × 8 known pixels in so many is in the histogram: in row y those at 3 y modulo that many, and
    /// every so many further.
    pub survey: u32,
}

impl AdaptiveLevel {
    pub(super) fn new(stride: u32, size: (u32, u32)) -> Self {
        let groups = |length: u32| length.div_ceil(stride).div_ceil(GROUP);
        let share = match stride {
            2 => 1.0,
            4 => 0.35,
            8 => 0.2,
            _ => 0.1,
        };
        let most_traced = if stride == 2 { 0.45 } else { 0.6 };
        Self { stride, share, most_traced, survey: (groups(size.0) * groups(size.1) / FEW_GROUPS).max(1) }
    }

    /// Whether a known pixel's group is in the histogram; by its column and row among those.
    fn surveys(&self, cell: [u32; 2]) -> bool {
        let [x, y] = cell.map(|place| place / GROUP);
        x % self.survey == 3 * y % self.survey
    }
}

/// What is left of the squares of estimated errors that may add up.
#[derive(Debug)]
pub(super) struct Budget {
    /// Target error; units: W/(m²·sr).
    unit: f64,
    /// Units: squares of the target error, times pixels.
    left: f64,
    /// The largest estimate, in units of the target.
    most: f64,
}

impl Budget {
    pub(super) fn new(unit: f64, left: f64, most: f64) -> Self {
        Self { unit, left, most }
    }

    /// The largest estimate at which predictions of a level are taken, in W/(m²·sr), from a histogram of them; below every
    /// estimate where all of the level is to be traced.
    pub(super) fn tolerance<'p>(
        &mut self,
        level: &AdaptiveLevel,
        predictions: impl IntoIterator<Item = &'p Prediction>,
    ) -> f64 {
        // the last counts what is too large for any bin
        let mut counts = [0_u64; BINS + 1];
        for prediction in predictions.into_iter().filter(|prediction| level.surveys(prediction.cell)) {
            counts[bin(prediction.estimate / self.unit)] += u64::from(level.survey);
        }
        // an error is inherited by all pixels that are predicted from this one
        let pixels = f64::from(level.stride / 2).powi(2);
        let share = level.share * self.left;
        let (mut spent, mut taken, mut end) = (0.0, 0.0, BINS as f64);
        for (bin, &count) in counts.iter().take(BINS).enumerate() {
            let squares = count as f64 * pixels * estimate_at(bin as f64 + 0.5).powi(2);
            if spent + squares > share {
                let part = (share - spent) / squares;
                end = bin as f64 + part;
                taken += part * count as f64;
                spent = share;
                break;
            }
            spent += squares;
            taken += count as f64;
        }
        let all = counts.iter().sum::<u64>() as f64;
        if all - taken > level.most_traced * all {
            return f64::NEG_INFINITY;
        }
        self.left -= spent;
        self.unit * estimate_at(end).min(self.most)
    }
}

/// The bin of an estimate, in units of the target; the one after the last for those too large.
fn bin(estimate: f64) -> usize {
    // not a number where nothing is lit: as good as 0
    let at = (estimate.max(0.0).log2() - FIRST_OCTAVE) * BINS_PER_OCTAVE;
    at.clamp(0.0, BINS as f64) as usize
}

/// The estimate at a place among the bins, in units of the target.
fn estimate_at(bin: f64) -> f64 {
    (bin / BINS_PER_OCTAVE + FIRST_OCTAVE).exp2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptive::prediction::Prediction;

    fn predictions(estimates: &[f64]) -> Vec<Prediction> {
        estimates.iter().map(|&estimate| Prediction::of_estimate(estimate)).collect()
    }

    #[test]
    fn what_is_taken_stays_within_the_budget() {
        let level = AdaptiveLevel::new(2, (64, 64));
        let estimates: Vec<f64> = (0..900).map(|i| 2.0 * f64::from(i % 100) / 100.0).collect();
        for mean in [0.01, 0.1, 0.3, 0.8] {
            let mut budget = Budget::new(1.0, mean * 900.0, 4.0);
            let tolerance = budget.tolerance(&level, &predictions(&estimates));
            let taken = estimates.iter().filter(|estimate| **estimate <= tolerance);
            let squares: f64 = taken.map(|estimate| estimate * estimate).sum();
            // what is estimated at 1.1 and less, 55 of 100, takes 0.22
            assert_eq!(tolerance < 0.0, mean < 0.22, "{mean}: {tolerance}");
            if tolerance >= 0.0 {
                // bins are a fifth wide
                assert!(squares < 1.2 * mean * 900.0 && squares > 0.6 * mean * 900.0, "{mean}: {squares}");
                assert!(budget.left.abs() < 1e-9, "{}", budget.left);
            }
        }
    }

    #[test]
    fn nothing_is_taken_where_most_is_left() {
        let level = AdaptiveLevel::new(4, (64, 64));
        let some = |unknown: usize| {
            let estimates = [vec![0.001; 100 - unknown], vec![f64::INFINITY; unknown]].concat();
            Budget::new(1.0, 1.0, 4.0).tolerance(&level, &predictions(&estimates))
        };
        assert!(some(59) == 4.0 && some(61) < 0.0);
        // where nothing is lit nothing errs
        assert_eq!(Budget::new(0.0, 1.0, 4.0).tolerance(&level, &predictions(&[0.0; 9])), 0.0);
    }

    #[test]
    fn a_survey_takes_its_share_of_all_columns_and_rows() {
        let level = AdaptiveLevel::new(2, (1024, 1024));
        assert_eq!(level.survey, 8);
        let in_row = |y: u32| (0..64_u32).filter(|x| level.surveys([8 * x, 8 * y])).count();
        let in_column = |x: u32| (0..64_u32).filter(|y| level.surveys([8 * x, 8 * y])).count();
        assert!((0..64_u32).all(|i| in_row(i) == 8 && in_column(i) == 8));
        assert_eq!(AdaptiveLevel::new(2, (256, 256)).survey, 1);
    }
}
