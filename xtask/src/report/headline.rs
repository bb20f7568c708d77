//! What a whole run comes to: claims by paper, and what each technique gains at equal error.

use std::collections::BTreeMap;

use super::data::Adapter;
use super::number;
use super::section::{Section, Tally};
use super::table::{Column, Table};

/// What times are compared with, and itself no result.
const BASELINE: &str = "brute-force";

/// The paper that an experiment reproduces: its source up to the year.
pub(super) fn paper(source: &str) -> &str {
    let is_year = |at: &usize| {
        let digits = source.as_bytes().get(*at..at + 4).unwrap_or_default();
        digits.len() == 4 && digits.iter().all(u8::is_ascii_digit)
    };
    (0..source.len()).find(is_year).map_or(source, |at| &source[..at + 4])
}

/// The papers in the order of their experiments.
pub(super) fn papers(sections: &[Section]) -> Vec<&str> {
    let mut papers = Vec::new();
    for section in sections {
        let paper = paper(&section.experiment.source);
        if !papers.contains(&paper) {
            papers.push(paper);
        }
    }
    papers
}

/// How many claims of each paper hold.
pub(super) fn by_paper(sections: &[Section]) -> Table {
    let mut columns = vec![Column::left("source")];
    columns.extend(["experiments", "claims", "hold", "do not hold", "not measured"].map(Column::right));
    let mut table = Table::new("Claims by source", columns);
    let mut line = |name: &str, of: Vec<&Section>| {
        let tally = of.iter().map(|section| section.tally()).fold(Tally::default(), |a, b| a + b);
        let mut cells = vec![name.to_owned()];
        let counts = [of.len(), tally.all(), tally.hold, tally.fail, tally.not_measured];
        cells.extend(counts.map(|count| count.to_string()));
        table.push(cells);
    };
    let papers = papers(sections);
    for name in &papers {
        line(name, sections.iter().filter(|s| paper(&s.experiment.source) == *name).collect());
    }
    if papers.len() > 1 {
        line("all", sections.iter().collect());
    }
    table
}

/// What was found of one technique at equal error.
#[derive(Debug, Default)]
struct Gains {
    targets: usize,
    /// Error targets, reached or not.
    errors: Vec<f64>,
    speedups: Vec<f64>,
}

/// How many times faster than the march each technique reaches the same error; `None` where nothing was compared so.
pub(super) fn gains(sections: &[Section]) -> Option<Table> {
    let mut all: BTreeMap<(&Adapter, &str), Gains> = BTreeMap::new();
    for section in sections {
        for entry in &section.experiment.equal_error {
            for technique in entry.ms.keys().filter(|technique| *technique != BASELINE) {
                let gains = all.entry((&section.experiment.adapter, technique)).or_default();
                gains.targets += 1;
                gains.errors.push(entry.target);
                gains.speedups.extend(entry.speedup_over_brute_force.get(technique).copied().flatten());
            }
        }
    }
    all.retain(|_, gains| !gains.speedups.is_empty());
    if all.is_empty() {
        return None;
    }
    let adapters = all.keys().any(|(adapter, _)| Some(adapter) != all.keys().next().map(|(first, _)| first));
    let columns = vec![
        Column::left("technique"),
        Column::right("less time than a march, median"),
        Column::right("least"),
        Column::right("most"),
        Column::right("at errors of"),
        Column::right("compared"),
        Column::left("adapter"),
    ];
    let mut table = Table::new("Gain at equal error over the brute-force march", columns);
    for ((adapter, technique), mut gains) in all {
        gains.speedups.sort_by(f64::total_cmp);
        gains.errors.sort_by(f64::total_cmp);
        let n = gains.speedups.len();
        let median = 0.5 * (gains.speedups[(n - 1) / 2] + gains.speedups[n / 2]);
        let ends = |of: &[f64]| (of.first().copied(), of.last().copied());
        let ((least, most), (low, high)) = (ends(&gains.speedups), ends(&gains.errors));
        let errors = if low == high {
            number::error(low)
        } else {
            format!("{} to {}", number::error(low), number::error(high))
        };
        table.push(vec![
            technique.to_owned(),
            number::ratio(median),
            number::ratio(least),
            number::ratio(most),
            errors,
            format!("{n} of {}", gains.targets),
            if adapters { adapter.text() } else { String::new() },
        ]);
    }
    table.note = Some("Ratios of times in one run, over all scenes and error targets of all experiments. Compared: where both the technique and the march reach the target. Below 1 the march is faster.".into());
    Some(table.without_empty_columns())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::data::{EqualError, Experiment};

    #[test]
    fn a_paper_ends_with_its_year() {
        let known = [
            ("Wyman & Ramsey 2008, Table 1", "Wyman & Ramsey 2008"),
            ("Billeter, Sintorn & Assarsson 2010, Figure 6", "Billeter, Sintorn & Assarsson 2010"),
            ("no year § at all", "no year § at all"),
            ("", ""),
        ];
        for (source, name) in known {
            assert_eq!(paper(source), name);
        }
    }

    #[test]
    fn gains_are_medians_with_their_ends() {
        let entry = |target, hybrid: Option<f64>| EqualError {
            target,
            ms: [("hybrid".into(), hybrid.map(|gain| 10.0 / gain)), (BASELINE.into(), Some(10.0))].into(),
            speedup_over_brute_force: [("hybrid".into(), hybrid), (BASELINE.into(), Some(1.0))].into(),
            ..EqualError::default()
        };
        let equal_error = vec![entry(0.01, Some(2.0)), entry(0.001, Some(8.0)), entry(0.0001, None)];
        let section =
            Section { experiment: Experiment { equal_error, ..Experiment::default() }, ..Section::default() };
        let table = gains(&[section]).unwrap();
        assert_eq!(table.rows, [["hybrid", "5.00 ×", "2.00 ×", "8.00 ×", "1.00e-4 to 1.00 %", "2 of 3"]]);
        assert!(gains(&[Section::default()]).is_none());
    }
}
