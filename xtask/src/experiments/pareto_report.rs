//! How `pareto` is told: frontiers, the fastest way to each error, what the planner chose, and the claims.

use std::collections::BTreeMap;

use hybrid_march::Sampling;

use super::equal_error::interpolate;
use super::measure::Measured;
use super::pareto::Case;
use super::pareto_picks::{Metric, Pick, TARGETS};
use super::pareto_settings::family;
use super::shown::slug;
use crate::median::median;
use crate::report::data::{Bound, Check, EqualError};
use crate::report::table::{Column, Table};
use crate::report::{self, Axis, Plot, Series};
use crate::technique::Technique;

/// How many times the fastest setting's time a choice may take, and on how many of its cases it is to stay below.
const NEAR: f64 = 1.25;
const OFTEN: f64 = 0.9;

/// How many times less than the march a picture of equal error on the map is to take.
const SPEEDUPS: [(f64, f64); 2] = [(0.01, 5.0), (0.002, 15.0)];

impl Case {
    /// Errors of all settings, of those that have any.
    fn errors(&self, metric: Metric) -> impl Iterator<Item = (&Measured, f64)> {
        self.results.iter().filter_map(move |found| Some((found, metric.error(found, self.map)?)))
    }

    /// The fastest setting within a target.
    fn fastest(&self, metric: Metric, target: f64) -> Option<&Measured> {
        let within = self.errors(metric).filter(|(_, error)| *error <= target);
        within.min_by(|a, b| a.0.ms().total_cmp(&b.0.ms())).map(|(found, _)| found)
    }

    /// Settings that nothing beats in both time and error, from the fastest on.
    pub(super) fn frontier(&self, metric: Metric) -> Vec<(&Measured, f64)> {
        let mut all: Vec<(&Measured, f64)> = self.errors(metric).collect();
        all.sort_by(|a, b| a.0.ms().total_cmp(&b.0.ms()));
        let mut least = f64::INFINITY;
        all.retain(|(_, error)| {
            let better = *error < least;
            least = least.min(*error);
            better
        });
        all
    }

    /// Time that the march needs for an error, at every pixel.
    fn march(&self, metric: Metric, target: f64) -> Option<f64> {
        let is_plain = |found: &Measured| {
            family(&found.setting) == "brute-force" && found.setting.options.sampling == Sampling::Pixels
        };
        let marches = self.errors(metric).filter(|(found, _)| is_plain(found));
        let mut points: Vec<(u32, f64, f64)> =
            marches.map(|(found, error)| (found.samples(), found.ms(), error)).collect();
        points.sort_by_key(|point| point.0);
        interpolate(points.into_iter().map(|(_, ms, error)| (ms, error)), target)
    }

    /// The planner's choice for a target, by a pilot.
    fn pick(&self, metric: Metric, target: f64) -> Option<(&Pick, &Measured)> {
        self.pick_by(metric, target, true)
    }

    fn pick_by(&self, metric: Metric, target: f64, pilot: bool) -> Option<(&Pick, &Measured)> {
        let mut picks = self.picks.iter();
        let is_it = |pick: &&Pick| {
            let same = pick.metric == metric && pick.target.total_cmp(&target).is_eq();
            same && pick.pilot_ms.is_some() == pilot
        };
        let pick = picks.find(is_it)?;
        Some((pick, &self.results[pick.setting]))
    }

    /// Time of the choice over that of the fastest setting; `None` where the choice is not within the target.
    fn over_fastest(&self, metric: Metric, target: f64, pilot: bool) -> Option<f64> {
        let (_, chosen) = self.pick_by(metric, target, pilot)?;
        let within = metric.error(chosen, self.map)? <= target;
        let fastest = self.fastest(metric, target).filter(|_| within)?;
        Some(chosen.ms() / fastest.ms())
    }
}

/// For each scene the fastest way to each error, beside what the planner chose.
pub(super) fn ways(metric: Metric, cases: &[Case]) -> Table {
    let title = match metric {
        Metric::Geometry => "The fastest way to an error against the geometry",
        Metric::Map => "The fastest way to an error against the map",
    };
    let mut table = Table::new(
        title,
        vec![
            Column::left("scene"),
            Column::right("target"),
            Column::left("fastest"),
            Column::right("time"),
            Column::right("error"),
            Column::left("the planner's choice"),
            Column::right("time"),
            Column::right("error"),
            Column::right("over the fastest"),
            Column::right("predicted"),
            Column::right("pilot"),
            Column::right("march"),
            Column::right("faster than the march by"),
        ],
    );
    for (case, target) in cases.iter().flat_map(|case| TARGETS.map(|target| (case, target))) {
        let fastest = case.fastest(metric, target);
        let error = |found: Option<&Measured>| found.and_then(|found| metric.error(found, case.map));
        let pick = case.pick(metric, target);
        let chosen = pick.map(|(_, chosen)| chosen);
        let ms = |found: Option<&Measured>| report::time(found.map(Measured::ms));
        let name = |found: Option<&Measured>| {
            found.map_or(report::MISSING.to_owned(), |found| found.setting.name.clone())
        };
        let march = case.march(metric, target);
        table.push(vec![
            case.title.clone(),
            report::error(target),
            name(fastest),
            ms(fastest),
            report::error(error(fastest)),
            name(chosen),
            ms(chosen),
            report::error(error(chosen)),
            report::ratio(case.over_fastest(metric, target, true)),
            report::time(pick.and_then(|(pick, _)| pick.predicted_ms)),
            report::time(pick.and_then(|(pick, _)| pick.pilot_ms)),
            report::time(march),
            report::ratio(march.zip(chosen).map(|(march, chosen)| march / chosen.ms())),
        ]);
    }
    table.note = Some(match metric {
        Metric::Geometry => "The map's side is the planner's to choose. A dash where a choice is not within its target, or the march does not get there. Predictions are for a software adapter with two free cores.".into(),
        Metric::Map => "The map is given. Dashes as above.".into(),
    });
    table
}

/// Times at equal error: the fastest setting of each technique, and what the planner chose.
pub(super) fn equal_errors(metrics: &[Metric], case: &Case) -> Vec<EqualError> {
    let mut all = Vec::new();
    for (metric, target) in metrics.iter().flat_map(|metric| TARGETS.map(|target| (*metric, target))) {
        let mut ms: BTreeMap<String, Option<f64>> = BTreeMap::new();
        for (found, error) in case.errors(metric) {
            let slot = ms.entry(family(&found.setting)).or_default();
            if error <= target && slot.is_none_or(|least| found.ms() < least) {
                *slot = Some(found.ms());
            }
        }
        let march = case.march(metric, target);
        ms.insert("brute-force".into(), march);
        let chosen = case.over_fastest(metric, target, true).and(case.pick(metric, target));
        ms.insert("planner".into(), chosen.map(|(_, chosen)| chosen.ms()));
        let faster = |ms: &Option<f64>| Some(march? / (*ms)?);
        let speedups = ms.iter().filter(|(name, _)| *name != "brute-force");
        all.push(EqualError {
            scene: case.title.clone(),
            metric: metric.name().into(),
            target,
            speedup_over_brute_force: speedups.map(|(name, ms)| (name.clone(), faster(ms))).collect(),
            ms,
        });
    }
    all
}

/// The claims.
pub(super) fn checks(cases: &[Case]) -> Vec<Check> {
    let mut checks = Vec::new();
    for (metric, pilot) in [(Metric::Geometry, true), (Metric::Map, true), (Metric::Map, false)] {
        let pairs = cases.iter().flat_map(|case| TARGETS.map(|target| (case, target)));
        // where nothing that was measured is within a target there is nothing to be near to
        let ratios: Vec<Option<f64>> = pairs
            .filter(|(case, target)| case.fastest(metric, *target).is_some())
            .map(|(case, target)| case.over_fastest(metric, target, pilot))
            .collect();
        let near = ratios.iter().flatten().filter(|ratio| **ratio <= NEAR).count();
        let missed = ratios.iter().filter(|ratio| ratio.is_none()).count();
        let share = (!ratios.is_empty()).then(|| near as f64 / ratios.len() as f64);
        let mut check = Check::new(
            format!(
                "{}{}: share of (scene, target) pairs where the planner's choice is within the target and takes at most {NEAR} times the fastest measured setting's time",
                metric.name(),
                if pilot { "" } else { ", without a pilot" }
            ),
            "the planner",
            share,
            Bound::AtLeast,
            OFTEN,
        );
        check.note =
            Some(format!("{near} of {}; {missed} choices are not within their target", ratios.len()));
        checks.push(check);
    }
    checks.extend(speedup_checks(cases));
    checks
}

/// The claims over the march.
pub(super) fn speedup_checks(cases: &[Case]) -> Vec<Check> {
    let of = |(target, bar): (f64, f64)| {
        let faster = |case: &Case| {
            let (_, chosen) = case.pick(Metric::Map, target)?;
            let within = Metric::Map.error(chosen, case.map)? <= target;
            within.then_some(case.march(Metric::Map, target)? / chosen.ms())
        };
        let mut all: Vec<f64> = cases.iter().filter_map(faster).collect();
        all.sort_by(f64::total_cmp);
        let mut check = Check::new(
            format!(
                "the planner's choice: times less time than the march at {} % shadow_err_map, median over scenes and lights",
                100.0 * target
            ),
            "the honest march on the same map",
            median(&all),
            Bound::AtLeast,
            bar,
        );
        if let (Some(least), Some(most)) = (all.first(), all.last()) {
            check.note = Some(format!("{least:.1} to {most:.1} on {} of {} set-ups", all.len(), cases.len()));
        }
        check
    };
    SPEEDUPS.into_iter().map(of).collect()
}

/// Time against error of all settings, by technique.
pub(super) fn plot(metric: Metric, case: &Case) -> Plot {
    let mut series: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    for (found, error) in case.errors(metric) {
        series.entry(family(&found.setting)).or_default().push((found.ms(), error));
    }
    let mut series: Vec<Series> =
        series.into_iter().map(|(label, points)| Series { label, points, joined: false }).collect();
    let points = case.frontier(metric).into_iter().map(|(found, error)| (found.ms(), error)).collect();
    series.push(Series { label: "frontier".into(), points, joined: true });
    let picks = TARGETS.iter().filter_map(|&target| {
        let (_, chosen) = case.pick(metric, target)?;
        Some((chosen.ms(), metric.error(chosen, case.map)?))
    });
    let label = "the planner's choices for 5, 1 and 0.2 %".to_owned();
    series.push(Series { label, points: picks.collect(), joined: false });
    let against = if metric == Metric::Map { "map" } else { "geometry" };
    Plot {
        file: format!("{}-{against}.svg", slug(&case.title)),
        title: format!("{}: error against the {against}", case.title),
        caption: format!(
            "Every technique and setting; the frontier is what nothing beats in both. Map {}² where it is given.",
            case.map
        ),
        x: Axis::new("time of the airlight", "ms"),
        y: Axis::new(format!("shadow error against the {against}"), ""),
        series,
    }
}

/// How far predictions were off, by technique: the median of measured over predicted time.
pub(super) fn predictions(cases: &[Case]) -> Table {
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for case in cases {
        for (measured, predicted) in case.results.iter().zip(&case.predicted) {
            if let Some(predicted) = predicted
                && measured.setting.technique != Technique::Exact
            {
                found.entry(family(&measured.setting)).or_default().push(measured.ms() / predicted);
            }
        }
    }
    let mut table = Table::new(
        "Measured over predicted time",
        vec![
            Column::left("technique"),
            Column::right("least"),
            Column::right("median"),
            Column::right("most"),
            Column::right("settings"),
        ],
    );
    for (name, mut ratios) in found {
        ratios.sort_by(f64::total_cmp);
        table.push(vec![
            name,
            report::ratio(ratios.first().copied()),
            report::ratio(median(&ratios)),
            report::ratio(ratios.last().copied()),
            report::count(ratios.len() as u64),
        ]);
    }
    table.note = Some("The costs of the planner are a software adapter's with two free cores; another device is as many times faster or slower for all, which one measured frame tells (Costs::scaled).".into());
    table
}
