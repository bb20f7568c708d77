//! Where a logarithmic axis begins, ends and carries its labels.
//!
//! plotters' own logarithmic axis does not let its ticks be chosen, so this is one over the exponent.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// A logarithmic axis; everything in decadic exponents.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    /// Ends of the axis.
    pub range: Range<f64>,
    /// Labelled ticks.
    pub major: Vec<f64>,
    /// Ticks between them.
    pub minor: Vec<f64>,
}

/// Labelled ticks that an axis has room for.
const MOST_LABELS: i32 = 8;

/// An axis for positive `values`, with a margin; from 0.1 to 10 for none.
pub(super) fn decades(values: impl Iterator<Item = f64>) -> Ticks {
    let exponents = values.map(f64::log10);
    let ends = exponents.fold(None, |ends: Option<(f64, f64)>, exponent| {
        let (low, high) = ends.unwrap_or((exponent, exponent));
        Some((low.min(exponent), high.max(exponent)))
    });
    let (low, high) = ends.unwrap_or((-1.0, 1.0));
    // at least a decade in all, lest a flat curve fill the plot with its noise
    let margin = (0.06 * (high - low)).max(0.5 * (1.0 - (high - low)));
    let range = low - margin..high + margin;

    let (first, last) = (range.start.floor() as i32, range.end.ceil() as i32);
    let at = |factors: &[f64]| -> Vec<f64> {
        let ticks =
            (first..=last).flat_map(|decade| factors.iter().map(move |f| f64::from(decade) + f.log10()));
        ticks.filter(|tick| range.contains(tick)).collect()
    };
    let few = range.end - range.start < 3.0;
    let (major, minor) = if few {
        (at(&[1.0, 2.0, 5.0]), at(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0]))
    } else {
        // every decade, or every second, third, … of many
        let every = ((last - first) / MOST_LABELS + 1).max(1);
        let labelled = |tick: &f64| (tick.round() as i32).rem_euclid(every) == 0;
        let (major, rest): (Vec<f64>, Vec<f64>) = at(&[1.0]).into_iter().partition(labelled);
        (major, if every == 1 { at(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]) } else { rest })
    };
    Ticks { range, major, minor }
}

impl Ticks {
    /// Text of the tick at 10^`exponent`.
    pub(super) fn label(&self, exponent: f64) -> String {
        // one way of writing for the whole axis
        if self.range.start > -3.5 && self.range.end < 4.5 {
            let value = 10_f64.powf(exponent);
            let decimals = (-exponent.floor()).max(0.0) as usize;
            return format!("{value:.decimals$}");
        }
        // the ticks are 1, 2 and 5 times a power of ten; the margin forgives the logarithm's rounding
        let power = (exponent + 1e-6).floor();
        let factor = 10_f64.powf(exponent - power).round();
        let raised: String = format!("{power:.0}").chars().map(superscript).collect();
        if factor == 1.0 { format!("10{raised}") } else { format!("{factor:.0}·10{raised}") }
    }
}

impl Ranged for Ticks {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, exponent: &f64, limit: (i32, i32)) -> i32 {
        let share = (exponent - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.minor.clone() } else { self.major.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Ticks {
    fn format_ext(&self, exponent: &f64) -> String {
        self.label(*exponent)
    }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64]) -> Vec<String> {
        let ticks = decades(values.iter().copied());
        ticks.major.iter().map(|tick| ticks.label(*tick)).collect()
    }

    #[test]
    fn few_decades_are_labelled_in_between() {
        assert_eq!(labels(&[0.1, 3.0]), ["0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(labels(&[2e-5, 4e-5]), ["10⁻⁵", "2·10⁻⁵", "5·10⁻⁵"]);
    }

    #[test]
    fn many_decades_are_labelled_sparsely() {
        assert_eq!(labels(&[1e-3, 1.0]), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(&[1e-12, 1e3]), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰", "10³"]);
    }

    #[test]
    fn every_value_lies_inside() {
        for values in [vec![], vec![1.0], vec![7.0, 7.0], vec![1e-300, 1e300], vec![3.0, 3.1]] {
            let ticks = decades(values.iter().copied());
            assert!(values.iter().all(|value| ticks.range.contains(&value.log10())), "{ticks:?}");
            assert!(ticks.range.end - ticks.range.start >= 0.999, "{ticks:?}");
            assert!((2..=10).contains(&ticks.major.len()), "{ticks:?}");
        }
    }
}
