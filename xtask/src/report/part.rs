//! One experiment's part of the report.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;

use super::bars::Bars;
use super::escape::Escaped;
use super::html::{anchor, command, facts, notes};
use super::plot::Plot;
use super::section::{Panel, PanelKind, PictureRow, Section};
use super::table::Table;
use crate::failure::Outcome;
use crate::image_file::{ERROR_SCALE_ENDS, scale_colour};

/// Rows up to which the numbers of bars are shown without being asked for.
const FEW_ROWS: usize = 12;

/// Width up to which pictures are magnified in squares rather than blurred; units: pixels.
const SMALL: u32 = 256;

// Writing to a string cannot fail, so the results of `write!` are dropped here.
pub(super) fn part(page: &mut String, section: &Section) -> Outcome {
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
            ("Claims", &section.verdict()),
            ("Preset", &data.preset),
            ("Measured on", &data.adapter.text()),
        ],
    );
    command(page, data.command.as_deref().unwrap_or_default());
    notes(page, &data.notes);

    let tables = section.result_tables();
    if !tables.is_empty() {
        page.push_str("<h3>Results</h3>\n");
        tables.iter().for_each(|table| table.html(page));
    }
    if !section.plots.is_empty() || !section.bars.is_empty() {
        page.push_str("<h3>Plots</h3>\n");
    }
    for plot in &section.plots {
        figure(page, &plot.title, &plot.svg()?, &plot_caption(plot));
        numbers(page, &plot.table(), false);
    }
    for bars in &section.bars {
        drawn_bars(page, bars);
        numbers(page, &bars.table(), false);
    }
    if !section.pictures.is_empty() {
        page.push_str("<h3>Pictures</h3>\n");
        section.pictures.iter().for_each(|row| pictures(page, row));
    }
    let costs = section.costs();
    if !costs.is_empty() {
        page.push_str("<h3>Stages and memory</h3>\n");
    }
    for (table, bars) in &costs {
        drawn_bars(page, bars);
        numbers(page, table, table.rows.len() <= FEW_ROWS);
    }
    if let Some(table) = section.measurements() {
        page.push_str("<h3>Measurements</h3>\n");
        table.html(page);
    }
    page.push_str("<p class=\"up\"><a href=\"#contents\">Back to the contents</a></p>\n</section>\n");
    Ok(())
}

fn figure(page: &mut String, title: &str, svg: &str, caption: &str) {
    let _ = writeln!(
        page,
        "<figure>\n<div class=\"scroll plot\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">\n{svg}</div>\n\
         <figcaption>{}</figcaption>\n</figure>",
        Escaped(title),
        Escaped(caption)
    );
}

fn drawn_bars(page: &mut String, bars: &Bars) {
    figure(page, &bars.title, &bars.svg(), &bars.caption);
}

fn plot_caption(plot: &Plot) -> String {
    let left_out = match plot.left_out() {
        0 => String::new(),
        1 => " One point at zero or without a value is not drawn.".to_owned(),
        many => format!(" {many} points at zero or without a value are not drawn."),
    };
    format!("{}{left_out}", plot.caption)
}

/// A figure's numbers, at first hidden unless `open`.
fn numbers(page: &mut String, table: &Table, open: bool) {
    let open = if open { " open" } else { "" };
    let what = table.title.trim_start_matches("Numbers of: ");
    let _ = writeln!(page, "<details{open}>\n<summary>In numbers: {}</summary>", Escaped(what));
    table.html(page);
    page.push_str("</details>\n");
}

/// Pictures in pairs: each with its error map beside it, or with the next one that has none.
fn pictures(page: &mut String, row: &PictureRow) {
    page.push_str("<figure>\n<div class=\"panels\">\n");
    let mut rest = &row.panels[..];
    while let Some(first) = rest.first() {
        let together = match rest.get(1).map(|next| next.kind) {
            Some(PanelKind::ErrorMap) if first.kind != PanelKind::ErrorMap => 2,
            Some(PanelKind::Plain) if first.kind == PanelKind::Plain => 2,
            _ => 1,
        };
        let (pair, left) = rest.split_at(together);
        page.push_str("<div class=\"pair\">\n");
        pair.iter().for_each(|panel| picture(page, panel));
        page.push_str("</div>\n");
        rest = left;
    }
    let _ = writeln!(page, "</div>\n<figcaption>{}</figcaption>\n</figure>", Escaped(&row.caption));
}

fn picture(page: &mut String, panel: &Panel) {
    let (width, height) = panel.size;
    let small = if width <= SMALL { " class=\"small\"" } else { "" };
    let _ = writeln!(
        page,
        "<figure>\n<img{small} src=\"data:image/png;base64,{}\" width=\"{width}\" height=\"{height}\" alt=\"{}\">\n\
         <figcaption><strong>{}</strong>",
        BASE64.encode(&panel.png),
        Escaped(&panel.alt),
        Escaped(&panel.title)
    );
    match &panel.kind {
        PanelKind::Plain => {}
        PanelKind::Measured(cost) => {
            // each figure in one piece, breaks between them
            let figures = cost.figures().map(|figure| format!("<span>{}</span>", Escaped(&figure)));
            let _ = write!(page, "<span class=\"cost\">{}</span>", figures.collect::<Vec<_>>().join(", "));
        }
        PanelKind::ErrorMap => error_scale(page),
    }
    page.push_str("</figcaption>\n</figure>\n");
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
         </span><span>{high}</span></span><span class=\"quiet\">error over the mean of the reference, logarithmic; bright is far off</span>"
    );
}
