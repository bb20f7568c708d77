//! The tables that every experiment has: measurements, equal error, claims.
//!
//! No time without its error, no error without its time. [`measurements`] keeps that rule for all experiments: times and
//! errors stand side by side, and a row that has only one of the two shows neither.

use serde_json::Value;

use super::data::{Bound, Check, EqualError, Row};
use super::number;
use super::table::{Column, Table};

/// All rows with their times, errors and counts; columns that nothing fills are left out.
pub(crate) fn measurements(title: &str, rows: &[Row]) -> Table {
    let columns = vec![
        Column::left("scene"),
        Column::left("technique"),
        Column::left("parameters"),
        Column::right("viewers"),
        Column::right("time of the fog"),
        Column::right("shadow error"),
        Column::right("relative RMSE"),
        Column::right("99 % below"),
        Column::right("FLIP"),
        Column::right("map error"),
        Column::right("least to most"),
        Column::right("whole frame"),
        Column::right("rays"),
        Column::right("samples"),
        Column::right("fragments"),
        Column::right("mesh triangles"),
        Column::right("memory"),
        Column::left("paper"),
    ];
    let mut table = Table::new(title, columns);
    let mut withheld = 0;
    for row in rows {
        let complete = is_complete(row);
        withheld += usize::from(!complete && (has_time(row) || has_error(row)));
        let shown = |text: String| if complete { text } else { number::MISSING.to_owned() };
        let spread = match (row.ms_min, row.ms_max) {
            (Some(least), Some(most)) => format!("{} to {}", number::time(least), number::time(most)),
            _ => number::MISSING.to_owned(),
        };
        table.push(vec![
            row.scene.clone(),
            row.technique.clone(),
            pairs(row.params.iter()),
            row.viewers.to_string(),
            shown(number::time(row.ms_scatter)),
            shown(number::error(row.shadow_err)),
            shown(number::error(row.rel_rmse)),
            shown(number::error(row.p99)),
            shown(number::figure(row.flip)),
            shown(map_error(row)),
            shown(spread),
            shown(number::time(row.ms_frame)),
            number::count(row.rays),
            number::count(row.samples),
            number::count(row.fragments),
            number::count(row.mesh_triangles),
            number::bytes(row.memory_bytes),
            row.paper.as_ref().map_or_else(String::new, |paper| pairs(paper.iter())),
        ]);
    }
    if rows.iter().all(|row| row.viewers <= 1) {
        // one viewer is the rule and not worth a column
        table.rows.iter_mut().for_each(|row| row[3].clear());
    }
    if withheld > 0 {
        table.note = Some(format!(
            "{withheld} of {} rows lack either the time or the error; the other is withheld.",
            rows.len()
        ));
    }
    table.without_empty_columns()
}

/// Whether a row has both a time and an error.
fn is_complete(row: &Row) -> bool {
    has_time(row) && has_error(row)
}

fn has_time(row: &Row) -> bool {
    [row.ms_scatter, row.ms_frame].into_iter().flatten().any(|ms| ms.is_finite())
}

/// Only errors that the table shows count.
fn has_error(row: &Row) -> bool {
    let shown = [row.shadow_err, row.rel_rmse, row.p99, row.flip, row.shadow_err_map];
    shown.into_iter().flatten().any(|error| !error.is_nan())
}

/// The error against the map's own exact picture, with the meaning of the map.
fn map_error(row: &Row) -> String {
    match (row.shadow_err_map, &row.map_surface) {
        (Some(share), Some(surface)) => format!("{} ({surface})", number::error(share)),
        (share, _) => number::error(share),
    }
}

/// `name value, name value`; texts without their quotes.
pub(super) fn pairs<'a>(entries: impl Iterator<Item = (&'a String, &'a Value)>) -> String {
    let pair = |(name, value): (&String, &Value)| match value {
        Value::Bool(true) => name.clone(),
        Value::String(text) => format!("{name} {text}"),
        Value::Number(number) if number.is_f64() => format!("{name} {}", number::figure(number.as_f64())),
        value => format!("{name} {value}"),
    };
    entries.map(pair).collect::<Vec<_>>().join(", ")
}

/// Times at equal error, one line for every scene, target and technique.
pub(crate) fn equal_error(entries: &[EqualError]) -> Table {
    let columns = vec![
        Column::left("scene"),
        Column::left("technique"),
        Column::right("time"),
        Column::right("target error"),
        Column::left("of"),
        Column::right("speed-up over brute force"),
    ];
    let mut table = Table::new("Time at equal error", columns);
    table.note = Some(
        "The time at which a technique reaches the target, interpolated between its settings. One without an error, such \
         as exact, reaches every target in the same time."
            .into(),
    );
    for entry in entries {
        for (technique, ms) in &entry.ms {
            let speedup = entry.speedup_over_brute_force.get(technique).copied().flatten();
            table.push(vec![
                entry.scene.clone(),
                technique.clone(),
                ms.map_or_else(|| "does not get there".to_owned(), number::time),
                number::error(entry.target),
                entry.metric.clone(),
                number::ratio(speedup),
            ]);
        }
    }
    table
}

/// The claims with their verdicts.
pub(crate) fn checks<'a>(title: &str, checks: impl Iterator<Item = &'a Check>) -> Table {
    claims(title, checks.map(|check| (check, None)))
}

/// The claims with their verdicts, each with the id and the place in the page of its experiment where those are given.
pub(super) fn claims<'a>(
    title: &str,
    checks: impl Iterator<Item = (&'a Check, Option<(&'a str, String)>)>,
) -> Table {
    let columns = vec![
        Column::left("verdict"),
        Column::left("claim"),
        Column::right("measured"),
        Column::right("bar"),
        Column::left("in the paper"),
        Column::left("experiment"),
        Column::left("remark"),
    ];
    let mut table = Table::new(title, columns);
    let mut links = Vec::new();
    for (check, experiment) in checks {
        let bar = match (check.bar, check.bound) {
            (Some(bar), Some(Bound::AtLeast)) => format!("≥ {}", number::figure(bar)),
            (Some(bar), Some(Bound::AtMost)) => format!("≤ {}", number::figure(bar)),
            (bar, _) => number::figure(bar),
        };
        let (id, anchor) = experiment.unwrap_or_default();
        links.push(anchor);
        table.push(vec![
            check.verdict().to_owned(),
            check.claim.clone(),
            number::figure(check.measured),
            bar,
            check.paper.clone(),
            id.to_owned(),
            check.note.clone().unwrap_or_default(),
        ]);
    }
    (table.header, table.links) = (1, Some((5, links)));
    table.without_empty_columns()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(table: &Table, name: &str) -> Option<usize> {
        table.columns.iter().position(|column| column.name == name)
    }

    #[test]
    fn no_time_without_its_error_and_no_error_without_its_time() {
        let mut both = Row::new("sphere", "hybrid");
        (both.ms_scatter, both.ms_min, both.ms_max) = (Some(1.5), Some(1.0), Some(2.0));
        (both.shadow_err, both.rel_rmse) = (Some(0.01), Some(0.002));
        let time_only = Row { ms_scatter: Some(7.77), ms_frame: Some(8.88), ..Row::new("sphere", "froxel") };
        let error_only = Row { shadow_err: Some(0.0333), ..Row::new("sphere", "march") };
        let no_number = Row { ms_scatter: Some(7.77), rel_rmse: Some(f64::NAN), ..Row::new("sphere", "map") };
        let neither = Row { rays: Some(12), ..Row::new("sphere", "grid") };

        let table = measurements("All", &[both, time_only, error_only, no_number, neither]);
        let text = table.text();
        assert!(text.contains("1.50 ms") && text.contains("1.00 %"), "{text}");
        assert!(!text.contains("7.77") && !text.contains("8.88") && !text.contains("3.33"), "{text}");
        assert!(table.note.as_ref().unwrap().starts_with("3 of 5 rows"), "{text}");

        let (time, error) =
            (column(&table, "time of the fog").unwrap(), column(&table, "shadow error").unwrap());
        assert_eq!(error, time + 1, "the error stands beside the time");
        for row in &table.rows {
            assert_eq!(row[time] == number::MISSING, row[error] == number::MISSING, "{row:?}");
        }
    }

    #[test]
    fn parameters_read_as_words() {
        let mut row = Row::new("sphere", "hybrid");
        row.params.insert("samples".into(), 50.into());
        row.params.insert("tessellation".into(), "adaptive".into());
        row.params.insert("voxel".into(), 0.25.into());
        row.params.insert("jitter".into(), true.into());
        let text = measurements("All", &[row]).text();
        assert!(text.contains("jitter, samples 50, tessellation adaptive, voxel 0.250"), "{text}");
    }

    #[test]
    fn a_claim_that_fails_says_so() {
        let check = Check::new("three times as fast", "Table 1", Some(2.0), Bound::AtLeast, 3.0);
        let experiment = Some(("wyman-table1", "place".to_owned()));
        let text = claims("Claims", [(&check, experiment)].into_iter()).text();
        assert!(
            text.contains("does not hold") && text.contains("≥ 3.00") && text.contains("wyman-table1"),
            "{text}"
        );
        assert!(!checks("Claims", [&check].into_iter()).text().contains("experiment"));
    }

    #[test]
    fn equal_error_names_who_does_not_get_there() {
        let entry = EqualError {
            scene: "sphere".into(),
            metric: "shadow_err".into(),
            target: 0.01,
            ms: [("hybrid".into(), Some(2.0)), ("froxel".into(), None)].into(),
            speedup_over_brute_force: [("hybrid".into(), Some(3.5))].into(),
        };
        let text = equal_error(&[entry]).text();
        assert!(text.contains("does not get there") && text.contains("3.50 ×"), "{text}");
    }
}
