//! What a frame's time is made of, and how much memory it holds: from the rows of any experiment.

use serde_json::Value;

use super::bars::{Bar, Bars, Quantity};
use super::data::Row;
use super::number;
use super::rows::pairs;
use super::table::{Column, Table};

/// Bars that a reader takes in at once; the table has all.
const MOST_BARS: usize = 24;

/// Time of each stage of the rows that know theirs; `None` where none does.
pub(super) fn stages(rows: &[Row]) -> Option<(Table, Bars)> {
    let rows: Vec<&Row> = rows.iter().filter(|row| !row.stages.is_empty()).collect();
    let mut names: Vec<&str> = Vec::new();
    for name in rows.iter().flat_map(|row| row.stages.keys()) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    if names.is_empty() {
        return None;
    }
    let mut columns = ["scene", "technique", "parameters", "viewers"].map(Column::left).to_vec();
    columns.extend(names.iter().map(|name| Column::right(*name)));
    columns.push(Column::right("together"));
    let mut table = Table::new("Time of each stage", columns);
    let many = rows.iter().any(|row| row.viewers > 1);
    for row in &rows {
        let mut cells = vec![row.scene.clone(), row.technique.clone(), told_apart(row, &rows)];
        cells.push(if many { row.viewers.to_string() } else { String::new() });
        cells.extend(names.iter().map(|name| number::time(row.stages.get(*name).copied())));
        cells.push(number::time(row.stages.values().sum::<f64>()));
        table.push(cells);
    }
    table.note = Some(
        "Medians, each of a stage by itself, so that together they need not be the median of whole frames."
            .into(),
    );
    let bar = |row: &Row| Bar {
        label: label(row, &rows),
        parts: names.iter().filter_map(|name| Some(((*name).to_owned(), *row.stages.get(*name)?))).collect(),
    };
    let bars = Bars {
        file: "stages.svg".into(),
        title: "Time of each stage".into(),
        caption: caption("Stages of a frame, one behind the other.", rows.len()),
        quantity: Quantity::Time,
        bars: by_scene(&rows, bar),
    };
    Some((table.without_empty_columns(), bars))
}

/// Memory of the rows that know theirs, the like only once; `None` where none does.
pub(super) fn memory(rows: &[Row]) -> Option<(Table, Bars)> {
    let mut seen: Vec<(String, u64)> = Vec::new();
    let with_memory: Vec<&Row> =
        rows.iter().filter(|row| row.memory_bytes.is_some_and(|bytes| bytes > 0)).collect();
    let distinct: Vec<&Row> = with_memory
        .iter()
        .copied()
        .filter(|row| {
            let key = (
                format!("{}\n{}", row.scene, label(row, &with_memory)),
                row.memory_bytes.unwrap_or_default(),
            );
            let new = !seen.contains(&key);
            seen.push(key);
            new
        })
        .collect();
    if distinct.is_empty() {
        return None;
    }
    let many = distinct.iter().any(|row| row.viewers > 1);
    let mut columns = ["scene", "technique", "parameters", "viewers"].map(Column::left).to_vec();
    columns.push(Column::right("memory"));
    let mut table = Table::new("Memory", columns);
    for row in &distinct {
        let viewers = if many { row.viewers.to_string() } else { String::new() };
        let bytes = number::bytes(row.memory_bytes);
        table.push(vec![
            row.scene.clone(),
            row.technique.clone(),
            told_apart(row, &distinct),
            viewers,
            bytes,
        ]);
    }
    let bytes = |row: &Row| row.memory_bytes.unwrap_or_default() as f64;
    let bars = Bars {
        file: "memory.svg".into(),
        title: "Memory".into(),
        caption: caption("What a technique holds beside the picture.", distinct.len()),
        quantity: Quantity::Memory,
        bars: by_scene(&distinct, |row| Bar::plain(label(row, &distinct), bytes(row))),
    };
    Some((table.without_empty_columns(), bars))
}

fn caption(text: &str, rows: usize) -> String {
    if rows > MOST_BARS { format!("{text} The first {MOST_BARS} of {rows} rows.") } else { text.to_owned() }
}

/// A bar for each of the first rows, under the names of their scenes.
fn by_scene(rows: &[&Row], bar: impl Fn(&Row) -> Bar) -> Vec<Bar> {
    let mut bars = Vec::new();
    let mut scene = None;
    for row in rows.iter().take(MOST_BARS) {
        if scene != Some(&row.scene) {
            scene = Some(&row.scene);
            bars.push(Bar { label: row.scene.clone(), parts: Vec::new() });
        }
        bars.push(bar(row));
    }
    bars
}

/// A row's technique with what tells it apart from the others of that name.
fn label(row: &Row, rows: &[&Row]) -> String {
    let mut label = row.technique.clone();
    if rows.iter().any(|other| other.viewers > 1) {
        label += &format!(", {} viewers", row.viewers);
    }
    match told_apart(row, rows) {
        params if params.is_empty() => label,
        params => format!("{label}, {params}"),
    }
}

/// The parameters in which a row differs from one that has its scene, technique and number of viewers, and the words
/// that only some of those have; measured figures among them are left out.
fn told_apart(row: &Row, rows: &[&Row]) -> String {
    let alike = |other: &&&Row| {
        (&other.scene, &other.technique, other.viewers) == (&row.scene, &row.technique, row.viewers)
    };
    let differs = |name: &String, value: &Value| {
        let from = |other: &&Row| other.params.get(name).map_or(!value.is_number(), |theirs| theirs != value);
        rows.iter().filter(alike).any(from)
    };
    let setting = |value: &Value| !value.is_f64();
    pairs(row.params.iter().filter(|(name, value)| setting(value) && differs(name, value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(technique: &str, map: u32, march: f64, bytes: u64) -> Row {
        let mut row = Row::new("sphere", technique);
        row.params.insert("map".into(), map.into());
        row.params.insert("steps_counted".into(), (march * 3.5).into());
        row.stages.insert("march".into(), march);
        row.memory_bytes = Some(bytes);
        row
    }

    #[test]
    fn stages_of_all_rows_stand_in_the_same_columns() {
        let mut other = row("hybrid", 256, 2.0, 1024);
        other.stages.insert("faces".into(), 1.0);
        let silent = Row { stages: Default::default(), ..row("froxels", 1, 9.0, 1) };
        let (table, bars) = stages(&[row("hybrid", 128, 4.0, 1024), other, silent]).unwrap();
        let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["scene", "technique", "parameters", "march", "faces", "together"]);
        assert_eq!(table.rows[1], ["sphere", "hybrid", "map 256", "2.00 ms", "1.00 ms", "3.00 ms"]);
        assert_eq!(table.rows.len(), 2);
        let labels: Vec<&str> = bars.bars.iter().map(|bar| bar.label.as_str()).collect();
        assert_eq!(labels, ["sphere", "hybrid, map 128", "hybrid, map 256"]);
        assert!(stages(&[Row::new("sphere", "march")]).is_none());
    }

    #[test]
    fn memory_is_listed_once() {
        let rows =
            [row("hybrid", 128, 1.0, 2048), row("hybrid", 128, 2.0, 2048), row("march", 64, 1.0, 4096)];
        let (table, bars) = memory(&rows).unwrap();
        assert_eq!(table.rows, [["sphere", "hybrid", "2.00 KiB"], ["sphere", "march", "4.00 KiB"]]);
        assert_eq!(bars.bars.len(), 3);
        assert!(memory(&[Row::new("sphere", "march")]).is_none());
    }
}
