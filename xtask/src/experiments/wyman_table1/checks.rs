//! The paper's claims, tested.

use super::super::measure::Measured;
use super::{BRUTE, Case, LOW, POINT, TEXTURED, Way, tables};
use crate::median::median;
use crate::report;
use crate::report::data::{Bound, Check};

pub(super) fn checks(cases: &[Case]) -> Vec<Check> {
    let mut checks = equal_samples(cases);
    checks.extend(equal_error(cases));
    checks.extend(low_resolution(cases));
    checks
}

/// A figure of each case with its name, the greatest last.
fn sorted(of: impl Iterator<Item = (String, Option<f64>)>) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = of.filter_map(|(name, value)| Some((name, value?))).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

/// Every figure, for a note.
fn list(all: &[(String, f64)]) -> String {
    let each: Vec<String> =
        all.iter().map(|(name, value)| format!("{name} {}", report::figure(*value))).collect();
    each.join("; ")
}

fn with_note(check: Check, note: String) -> Check {
    Check { note: (!note.is_empty()).then_some(note), ..check }
}

/// Hybrid 50 against brute force 150.
fn equal_samples(cases: &[Case]) -> Vec<Check> {
    let mut checks = Vec::new();
    for (way, textured) in
        [(Way::Bisected, false), (Way::Paper, false), (Way::Bisected, true), (Way::Paper, true)]
    {
        let errors = |case: &Case| Some(case.hybrid(way, 1)?.map_error() / case.brute(BRUTE, 1)?.map_error());
        let own = cases.iter().filter(|case| case.textured() == textured);
        let all = sorted(own.map(|case| (case.title(), errors(case))));
        let hybrid = if textured { "stained-glass spot, hybrid 3 × 50" } else { "hybrid 50" };
        checks.push(with_note(
            Check::new(
                format!(
                    "{hybrid} ({}) against brute force 150: shadow_err_map not larger, worst ratio",
                    way.name()
                ),
                "\"rendered roughly without sampling artifacts\" at 50 and at 150 samples (Table 1)",
                all.last().map(|(_, ratio)| *ratio),
                Bound::AtMost,
                1.0,
            ),
            list(&all),
        ));
    }
    for case in cases {
        let brute = case.brute(BRUTE, 1);
        let faster = |way| Case::ratio(brute, case.hybrid(way, 1));
        let paper = case.wyman.as_ref().filter(|_| case.light == POINT);
        let paper = paper.map(|wyman| wyman.hybrid_full / wyman.brute_full);
        let check = Check::new(
            format!(
                "{}: hybrid {} ({}) takes times less time than brute force 150",
                case.title(),
                if case.textured() { "3 × 50" } else { "50" },
                Way::Bisected.name()
            ),
            match paper {
                Some(ratio) => format!("{} in Table 1 (whole frames)", report::ratio(ratio)),
                None if case.textured() => {
                    "the same number of steps; Table 1 has no brute force there".into()
                }
                None => "2.4 to 7.1 times in Table 1, for point lights".into(),
            },
            faster(Way::Bisected),
            Bound::AtLeast,
            1.0,
        );
        let note = format!(
            "the paper's way: {}; {}",
            report::ratio(faster(Way::Paper)),
            shares(case.hybrid(Way::Bisected, 1))
        );
        checks.push(with_note(check, note));
    }
    checks
}

/// Where a setting's time goes.
fn shares(result: Option<&Measured>) -> String {
    let Some(result) = result else { return String::new() };
    let stages = result.stages();
    if stages.is_empty() {
        return "the device's time stamps do not name its stages".into();
    }
    let sum: f64 = stages.values().sum();
    let shares: Vec<String> =
        stages.iter().map(|(name, ms)| format!("{name} {:.0} %", 100.0 * ms / sum)).collect();
    format!("its time: {}", shares.join(", "))
}

/// Lookups and time at equal error.
fn equal_error(cases: &[Case]) -> Vec<Check> {
    let ratio = |way: Way, lookups: bool| {
        sorted(cases.iter().filter(|case| case.light == POINT).map(|case| {
            let target = case.common(0.002);
            let name = format!("{} at {}", case.title(), report::error(target));
            let needs = case.needs(None, target).zip(case.needs(Some(way), target));
            let ratio =
                needs.map(
                    |(brute, hybrid)| {
                        if lookups { brute.lookups / hybrid.lookups } else { brute.ms / hybrid.ms }
                    },
                );
            (name, ratio)
        }))
    };
    let middle = |all: &[(String, f64)]| median(&all.iter().map(|(_, ratio)| *ratio).collect::<Vec<_>>());
    let check = |claim: &str, lookups: bool, bar: f64| {
        let all = ratio(Way::Bisected, lookups);
        let unbisected = middle(&ratio(Way::Tiles, lookups));
        with_note(
            Check::new(
                format!("{claim}, median of {} set-ups", all.len()),
                "\"a significant speed improvement when comparing results of equivalent quality\" (Figure 5)",
                middle(&all),
                Bound::AtLeast,
                bar,
            ),
            format!("{}; the bounds alone, without bisection: {}", list(&all), report::ratio(unbisected)),
        )
    };
    vec![
        check(
            "at 0.2 % shadow_err_map, or the best that both reach: times fewer lookups per covered pixel than brute force",
            true,
            3.0,
        ),
        check("at the same error: times less time than brute force, bounds included", false, 1.5),
    ]
}

/// Quarter resolution against full.
fn low_resolution(cases: &[Case]) -> Vec<Check> {
    let mut checks = Vec::new();
    for (light, bar, paper) in [
        ("untextured lights", 4.0, "1.13 to 1.87 times in Table 1 (whole frames)"),
        (TEXTURED, 4.0, "1.8 to 4.0 times in Table 1 (whole frames)"),
    ] {
        let own = || cases.iter().filter(|case| case.textured() == (light == TEXTURED));
        let faster = |way| {
            sorted(own().map(|case| (case.title(), Case::ratio(case.hybrid(way, 1), case.hybrid(way, LOW)))))
        };
        let all = faster(Way::Bisected);
        let middle = |all: &[(String, f64)]| median(&all.iter().map(|(_, ratio)| *ratio).collect::<Vec<_>>());
        let at_low = own().find_map(|case| case.hybrid(Way::Bisected, LOW));
        checks.push(with_note(
            Check::new(
                format!("¼ resolution, {light}: times less time than full, median of {} set-ups", all.len()),
                paper,
                middle(&all),
                Bound::AtLeast,
                bar,
            ),
            format!(
                "{}; the paper's way: median {}; at ¼, first scene, {}",
                list(&all),
                report::ratio(middle(&faster(Way::Paper))),
                shares(at_low)
            ),
        ));
        let paper_fps = |case: &Case, scale| tables::fps(case, &case.hybrid(Way::Paper, scale)?.setting);
        let beside = sorted(own().map(|case| {
            let ratio = paper_fps(case, LOW).zip(paper_fps(case, 1)).map(|(low, full)| low / full);
            (case.title(), ratio)
        }));
        if let Some(check) = checks.last_mut()
            && let Some(note) = &mut check.note
        {
            *note += &format!("; in the paper: {}", list(&beside));
        }
    }
    let flips = sorted(cases.iter().map(|case| (case.title(), case.low.as_ref().map(|low| low.flip))));
    checks.push(with_note(
        Check::new(
            "¼ resolution: FLIP between it and full, worst",
            "\"only a modest drop in quality\"",
            flips.last().map(|(_, flip)| *flip),
            Bound::AtMost,
            0.02,
        ),
        list(&flips),
    ));
    let edges = sorted(
        cases.iter().map(|case| (case.title(), case.low.as_ref().map(|low| low.near_edges / low.elsewhere))),
    );
    checks.push(with_note(
        Check::new(
            "¼ resolution: error within two pixels of depth edges over the error elsewhere, worst",
            "\"some remaining jaggies and halo artifacts around depth discontinuities\" (Figure 8)",
            edges.last().map(|(_, ratio)| *ratio),
            Bound::AtMost,
            2.0,
        ),
        list(&edges),
    ));
    let anew = sorted(cases.iter().map(|case| (case.title(), case.low.as_ref().and_then(|low| low.anew))));
    let full = sorted(cases.iter().map(|case| {
        (case.title(), Case::ratio(case.hybrid(Way::Bisected, 1), case.find(&super::anew_name())))
    }));
    checks.push(with_note(
        Check::new(
            "the same where pixels at depth edges are computed anew, worst",
            "no such option",
            anew.last().map(|(_, ratio)| *ratio),
            Bound::AtMost,
            2.0,
        ),
        format!("{}; times less time than full: {}", list(&anew), list(&full)),
    ));
    checks
}
