//! `report.html`: one page over all experiments that needs no other file and no network.
//!
//! The summary comes first, then the contents, which stand at its side where there is room, then every claim, then the
//! experiments. Tables and plots scroll sideways inside their own frames, so that the page itself fits a phone; headings,
//! landmarks, captions and alternative texts are there for those who do not look at it; verdicts are words.

use std::fmt::Write;
use std::path::Path;

use super::data::Adapter;
use super::escape::Escaped;
use super::part::part;
use super::section::Section;
use super::summary::{all_claims, overview, summary};
use crate::failure::Outcome;
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
    page.push_str("<meta name=\"color-scheme\" content=\"light dark\">\n");
    let _ = writeln!(
        page,
        "<title>airlight: reproduction report</title>\n<style>\n{}</style>\n</head>\n<body>",
        include_str!("report.css")
    );
    page.push_str("<a class=\"skip\" href=\"#summary\">Skip to the summary</a>\n");
    page.push_str("<a class=\"skip\" href=\"#contents\">Skip to the contents</a>\n");
    page.push_str("<header>\n<h1>Volumetric shadows, reproduced</h1>\n");
    let _ = writeln!(page, "<p>{}</p>\n</header>", Escaped(&overview(sections)));
    page.push_str("<main>\n");
    summary(&mut page, sections, run);
    contents(&mut page, sections);
    all_claims(&mut page, sections);
    for section in sections {
        part(&mut page, section)?;
    }
    page.push_str("</main>\n</body>\n</html>\n");
    Ok(page)
}

fn contents(page: &mut String, sections: &[Section]) {
    page.push_str("<nav aria-labelledby=\"contents\">\n<h2 id=\"contents\">Contents</h2>\n<ol>\n");
    page.push_str("<li><a href=\"#summary\">Summary</a></li>\n");
    if sections.iter().any(|section| section.tally().all() > 0) {
        page.push_str("<li><a href=\"#claims\">Claims, tested</a></li>\n");
    }
    for section in sections {
        let _ = writeln!(
            page,
            "<li><a href=\"#{}\">{}</a> <span class=\"quiet\">{}; {}</span></li>",
            anchor(section),
            Escaped(section.heading()),
            Escaped(&section.experiment.id),
            Escaped(&section.verdict())
        );
    }
    page.push_str("</ol>\n</nav>\n");
}

/// Names and values, without those that have none.
pub(super) fn facts(page: &mut String, facts: &[(&str, &str)]) {
    page.push_str("<dl>\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(page, "<div><dt>{}</dt><dd>{}</dd></div>", Escaped(name), Escaped(value));
    }
    page.push_str("</dl>\n");
}

pub(super) fn command(page: &mut String, command: &str) {
    if !command.is_empty() {
        let _ = writeln!(page, "<p class=\"redo\">To repeat it: <code>{}</code></p>", Escaped(command));
    }
}

pub(super) fn notes(page: &mut String, notes: &[String]) {
    if notes.is_empty() {
        return;
    }
    page.push_str("<ul class=\"notes\">\n");
    for note in notes {
        let _ = writeln!(page, "<li>{}</li>", Escaped(note));
    }
    page.push_str("</ul>\n");
}

/// Name of an experiment's place in the page; the prefix keeps it apart from the page's own.
pub(super) fn anchor(section: &Section) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '-' };
    format!("experiment-{}", section.experiment.id.chars().map(plain).collect::<String>())
}

#[cfg(test)]
#[path = "sample.rs"]
mod tests;
