//! `report.html`: one page over all experiments that needs no other file and no network.
//!
//! Tables and plots scroll sideways inside their own frames, so that the page itself fits a phone; headings, landmarks,
//! captions and alternative texts are there for those who do not look at it; verdicts are words.

use std::fmt::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;

use super::data::Adapter;
use super::escape::Escaped;
use super::rows;
use super::section::{PanelKind, PictureRow, Section};
use super::table::{Column, Table};
use crate::failure::Outcome;
use crate::image_file::{ERROR_SCALE_ENDS, scale_colour};
use crate::output_file;

/// What holds for the whole run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct RunInfo {
    /// `smoke`, `quick`, `standard` or `paper`.
    pub preset: String,
    /// What it ran on.
    pub adapter: Adapter,
    /// Revision of the source tree.
    pub git: String,
    /// When it ran.
    pub date: Option<String>,
    /// Command line that repeats it.
    pub command: String,
    /// What a reader must know to judge the figures.
    pub notes: Vec<String>,
}

/// Writes the report over `sections`, in their order.
pub(crate) fn write_report(path: &Path, sections: &[Section], run: &RunInfo) -> Outcome {
    output_file::write_bytes(path, render(sections, run)?.as_bytes())
}

// Writing to a string cannot fail, so the results of `write!` are dropped here.
fn render(sections: &[Section], run: &RunInfo) -> Outcome<String> {
    let mut page = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    let _ = writeln!(
        page,
        "<title>airlight: reproduction report</title>\n<style>\n{}</style>\n</head>\n<body>",
        include_str!("report.css")
    );
    page.push_str("<a class=\"skip\" href=\"#summary\">Skip to the summary</a>\n");
    page.push_str("<header>\n<h1>Volumetric shadows, reproduced</h1>\n");
    let _ = writeln!(page, "<p>{}</p>\n</header>", Escaped(&overview(sections)));
    contents(&mut page, sections);
    page.push_str("<main>\n");
    summary(&mut page, sections, run);
    for section in sections {
        experiment(&mut page, section)?;
    }
    page.push_str("</main>\n</body>\n</html>\n");
    Ok(page)
}

fn overview(sections: &[Section]) -> String {
    let checks = || sections.iter().flat_map(|section| &section.experiment.checks);
    let holding = checks().filter(|check| check.holds).count();
    let experiments = match sections.len() {
        1 => "One experiment".to_owned(),
        many => format!("{many} experiments"),
    };
    format!(
        "{experiments}; {holding} of {} claims hold. Every time stands beside its error.",
        checks().count()
    )
}

fn contents(page: &mut String, sections: &[Section]) {
    page.push_str("<nav aria-labelledby=\"contents\">\n<h2 id=\"contents\">Contents</h2>\n<ol>\n");
    page.push_str("<li><a href=\"#summary\">Summary</a></li>\n");
    for section in sections {
        let _ = writeln!(
            page,
            "<li><a href=\"#{}\">{}</a> <span class=\"quiet\">{}</span></li>",
            anchor(section),
            Escaped(section.heading()),
            Escaped(&section.verdict())
        );
    }
    page.push_str("</ol>\n</nav>\n");
}

fn summary(page: &mut String, sections: &[Section], run: &RunInfo) {
    page.push_str("<section aria-labelledby=\"summary\">\n<h2 id=\"summary\">Summary</h2>\n");
    facts(
        page,
        &[
            ("Adapter", &adapter(&run.adapter)),
            ("Preset", &run.preset),
            ("Revision", &run.git),
            ("Date", run.date.as_deref().unwrap_or_default()),
        ],
    );
    command(page, &run.command);
    notes(page, &run.notes);

    let columns = ["experiment", "title", "reproduces", "claims"].map(Column::left);
    let mut ran = Table::new("What ran", columns.into());
    for section in sections {
        let data = &section.experiment;
        ran.push(vec![data.id.clone(), section.heading().to_owned(), data.source.clone(), section.verdict()]);
    }
    ran.html(page);

    let checks = sections.iter().map(|section| &section.experiment);
    let mut checks =
        checks.flat_map(|data| data.checks.iter().map(|check| (Some(data.id.as_str()), check))).peekable();
    if checks.peek().is_some() {
        rows::checks("Claims of the papers, tested", checks).html(page);
    }
    page.push_str("</section>\n");
}

fn experiment(page: &mut String, section: &Section) -> Outcome {
    let (data, anchor) = (&section.experiment, anchor(section));
    let _ = writeln!(
        page,
        "<section aria-labelledby=\"{anchor}\">\n<h2 id=\"{anchor}\">{}</h2>",
        Escaped(section.heading())
    );
    facts(
        page,
        &[
            ("Experiment", &data.id),
            ("Reproduces", &data.source),
            ("Preset", &data.preset),
            ("Adapter", &adapter(&data.adapter)),
        ],
    );
    command(page, data.command.as_deref().unwrap_or_default());
    notes(page, &data.notes);

    let tables = section.result_tables();
    if !tables.is_empty() {
        page.push_str("<h3>Results</h3>\n");
        tables.iter().for_each(|table| table.html(page));
    }
    if !section.plots.is_empty() {
        page.push_str("<h3>Plots</h3>\n");
    }
    for plot in &section.plots {
        let _ = writeln!(
            page,
            "<figure>\n<div class=\"scroll plot\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">\n{}</div>\n<figcaption>{}",
            Escaped(&plot.title),
            plot.svg()?,
            Escaped(&plot.caption)
        );
        match plot.left_out() {
            0 => {}
            1 => page.push_str(" One point at zero or without a value is not drawn."),
            many => {
                let _ = write!(page, " {many} points at zero or without a value are not drawn.");
            }
        }
        page.push_str("</figcaption>\n</figure>\n<details>\n<summary>Numbers of this plot</summary>\n");
        plot.table().html(page);
        page.push_str("</details>\n");
    }
    if !section.pictures.is_empty() {
        page.push_str("<h3>Pictures</h3>\n");
        section.pictures.iter().for_each(|row| pictures(page, row));
    }
    if let Some(table) = section.measurements() {
        page.push_str("<h3>Measurements</h3>\n");
        table.html(page);
    }
    page.push_str("</section>\n");
    Ok(())
}

fn pictures(page: &mut String, row: &PictureRow) {
    page.push_str("<figure>\n<div class=\"panels\">\n");
    for panel in &row.panels {
        let _ = writeln!(
            page,
            "<figure>\n<img src=\"data:image/png;base64,{}\" alt=\"{}\">\n<figcaption><strong>{}</strong>",
            BASE64.encode(&panel.png),
            Escaped(&panel.alt),
            Escaped(&panel.title)
        );
        match &panel.kind {
            PanelKind::Plain => {}
            PanelKind::Measured(cost) => {
                // each figure in one piece, breaks between them
                let figures = cost.figures().map(|figure| format!("<span>{}</span>", Escaped(&figure)));
                let _ =
                    write!(page, "<span class=\"cost\">{}</span>", figures.collect::<Vec<_>>().join(", "));
            }
            PanelKind::ErrorMap => error_scale(page),
        }
        page.push_str("</figcaption>\n</figure>\n");
    }
    let _ = writeln!(page, "</div>\n<figcaption>{}</figcaption>\n</figure>", Escaped(&row.caption));
}

/// The colours of the error maps, with the ends of their scale.
fn error_scale(page: &mut String) {
    const STOPS: u8 = 16;
    let stops = (0..=STOPS).map(|stop| {
        let [r, g, b] = scale_colour(f32::from(stop) / f32::from(STOPS));
        format!("#{r:02x}{g:02x}{b:02x}")
    });
    let stops = stops.collect::<Vec<_>>().join(",");
    let [low, high] = ERROR_SCALE_ENDS;
    let _ = write!(
        page,
        "<span class=\"scale\"><span>{low}</span><span class=\"ramp\" style=\"background:linear-gradient(to right,{stops})\">\
         </span><span>{high}</span></span><span class=\"quiet\">error over the mean of the reference, logarithmic</span>"
    );
}

/// Names and values, without those that have none.
fn facts(page: &mut String, facts: &[(&str, &str)]) {
    page.push_str("<dl>\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(page, "<div><dt>{}</dt><dd>{}</dd></div>", Escaped(name), Escaped(value));
    }
    page.push_str("</dl>\n");
}

fn command(page: &mut String, command: &str) {
    if !command.is_empty() {
        let _ = writeln!(page, "<p class=\"redo\">To repeat it: <code>{}</code></p>", Escaped(command));
    }
}

fn notes(page: &mut String, notes: &[String]) {
    if notes.is_empty() {
        return;
    }
    page.push_str("<ul class=\"notes\">\n");
    for note in notes {
        let _ = writeln!(page, "<li>{}</li>", Escaped(note));
    }
    page.push_str("</ul>\n");
}

fn adapter(adapter: &Adapter) -> String {
    let details = [&adapter.backend, &adapter.kind].into_iter().filter(|text| !text.is_empty());
    let details = details.map(String::as_str).collect::<Vec<_>>().join(", ");
    if details.is_empty() { adapter.name.clone() } else { format!("{} ({details})", adapter.name) }
}

/// Name of an experiment's place in the page; the prefix keeps it apart from the page's own.
fn anchor(section: &Section) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '-' };
    format!("experiment-{}", section.experiment.id.chars().map(plain).collect::<String>())
}

#[cfg(test)]
#[path = "sample.rs"]
mod tests;
