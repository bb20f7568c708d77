//! The first part of the report: what ran, what it comes to, what does not hold; then every claim.

use std::fmt::Write;

use super::escape::Escaped;
use super::headline;
use super::html::{RunInfo, anchor, command, facts, notes};
use super::rows;
use super::section::{Section, Tally};

/// All claims of all experiments.
fn tally(sections: &[Section]) -> Tally {
    sections.iter().map(Section::tally).fold(Tally::default(), |a, b| a + b)
}

/// The report in one sentence.
pub(super) fn overview(sections: &[Section]) -> String {
    let tally = tally(sections);
    let experiments = match sections.len() {
        1 => "One experiment".to_owned(),
        many => format!("{many} experiments"),
    };
    let unmeasured = match tally.not_measured {
        0 => String::new(),
        some => format!(", {some} not measured"),
    };
    format!(
        "{experiments}. {} of {} claims hold, {} {} not{unmeasured}. Every time stands beside its error.",
        tally.hold,
        tally.all(),
        tally.fail,
        if tally.fail == 1 { "does" } else { "do" }
    )
}

// Writing to a string cannot fail, so the results of `write!` are dropped here.
pub(super) fn summary(page: &mut String, sections: &[Section], run: &RunInfo) {
    page.push_str("<section aria-labelledby=\"summary\">\n<h2 id=\"summary\">Summary</h2>\n");
    let tally = tally(sections);
    page.push_str("<dl class=\"tally\">\n");
    for (name, count, look) in [
        ("claims hold", tally.hold, "holds"),
        ("do not hold", tally.fail, "fails"),
        ("not measured", tally.not_measured, "quiet"),
        ("experiments", sections.len(), ""),
    ] {
        let look = if count == 0 { "quiet" } else { look };
        let _ = writeln!(page, "<div class=\"{look}\"><dt>{name}</dt><dd>{count}</dd></div>");
    }
    page.push_str("</dl>\n");
    facts(
        page,
        &[
            ("Measured on", &adapters(sections, run)),
            ("Preset", &run.preset),
            ("Revision", &run.git),
            ("Date", run.date.as_deref().unwrap_or_default()),
        ],
    );
    command(page, &run.command);
    notes(page, &run.notes);

    if let Some(table) = headline::gains(sections) {
        page.push_str("<h3>What is gained</h3>\n");
        table.html(page);
    }
    if !sections.is_empty() {
        page.push_str("<h3>How the claims fare</h3>\n");
        headline::by_paper(sections).html(page);
    }
    let failing = claims(sections).filter(|(check, _)| !check.holds);
    if tally.all() > tally.hold {
        page.push_str("<h3>What does not hold</h3>\n");
        rows::claims("Claims that do not hold or were not measured", failing).html(page);
    }
    page.push_str("</section>\n");
}

/// Every claim, by paper.
pub(super) fn all_claims(page: &mut String, sections: &[Section]) {
    if tally(sections).all() == 0 {
        return;
    }
    page.push_str("<section aria-labelledby=\"claims\">\n<h2 id=\"claims\">Claims, tested</h2>\n");
    for paper in headline::papers(sections) {
        let here = || sections.iter().filter(|s| headline::paper(&s.experiment.source) == paper);
        let tally = here().map(Section::tally).fold(Tally::default(), |a, b| a + b);
        if tally.all() == 0 {
            continue;
        }
        let _ = writeln!(page, "<h3>{}</h3>", Escaped(paper));
        let title = format!("{} of {} claims hold", tally.hold, tally.all());
        rows::claims(&title, here().flat_map(claims_of)).html(page);
    }
    page.push_str("</section>\n");
}

type Claim<'a> = (&'a super::data::Check, Option<(&'a str, String)>);

fn claims(sections: &[Section]) -> impl Iterator<Item = Claim<'_>> {
    sections.iter().flat_map(claims_of)
}

/// The claims of an experiment, each with its id and its place in the page.
fn claims_of(section: &Section) -> impl Iterator<Item = Claim<'_>> {
    let id = section.experiment.id.as_str();
    section.experiment.checks.iter().map(move |check| (check, Some((id, anchor(section)))))
}

/// Where the experiments ran, and how many on each where there are several.
fn adapters(sections: &[Section], run: &RunInfo) -> String {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for section in sections {
        let text = section.experiment.adapter.text();
        match counts.iter_mut().find(|(known, _)| *known == text) {
            Some((_, count)) => *count += 1,
            None => counts.push((text, 1)),
        }
    }
    match &counts[..] {
        [] => run.adapter.text(),
        [(only, _)] => only.clone(),
        several => {
            let each = several.iter().map(|(text, count)| {
                format!("{text}: {count} {}", if *count == 1 { "experiment" } else { "experiments" })
            });
            each.collect::<Vec<_>>().join("; ")
        }
    }
}
