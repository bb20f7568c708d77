//! Log-log plots as SVG: time against error, error against samples.
//!
//! Drawn with plotters, which measures no text in SVG; so the legend stands in its own column at the right, one series
//! below the other, where the length of a label cannot collide with anything. Series differ in colour (Okabe and Ito's, which
//! colour-blind readers tell apart) and in the shape of their markers, so that a plot survives a grey printer.

use std::error::Error;
use std::fmt::Write;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::bars::wrap;
use super::escape::Escaped;
use super::number;
use super::table::{Column, Table};
use super::ticks::{Ticks, decades};
use crate::failure::{Failure, Outcome};

/// A log-log plot.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Plot {
    /// File name in the experiment's folder, ending in `.svg`.
    pub file: String,
    /// Heading.
    pub title: String,
    /// What the plot shows, for those who cannot see it and as its caption.
    pub caption: String,
    /// Quantity and unit along x.
    pub x: Axis,
    /// Quantity and unit along y.
    pub y: Axis,
    /// The curves.
    pub series: Vec<Series>,
}

/// An axis of a [`Plot`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Axis {
    /// Quantity, such as "time of the fog".
    pub label: String,
    /// Unit, such as "ms"; empty for a number.
    pub unit: String,
}

impl Axis {
    /// An axis with its unit.
    pub(crate) fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into() }
    }

    fn text(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }
}

/// A curve of a [`Plot`].
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Series {
    /// Name in the legend.
    pub label: String,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
    /// Whether a line joins the points, in their order.
    pub joined: bool,
}

// A drawing is twice as large as it is shown, since plotters rounds to whole units.
const WIDTH: i32 = 1720;
const LEAST_HEIGHT: i32 = 1000;
/// Part of the width that the legend takes.
const LEGEND: i32 = 460;
/// Letters that fit into a line of the legend.
const LEGEND_LETTERS: usize = 25;
const FONT: i32 = 34;
const LINE: i32 = 40;
const TOP: i32 = 100;
/// Half the width of a marker.
const MARK: i32 = 10;

/// Okabe and Ito's palette without yellow, which white paper swallows, and with black last.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const INK: RGBColor = RGBColor(34, 34, 34);
const GRID: RGBColor = RGBColor(216, 216, 216);
const FAINT_GRID: RGBColor = RGBColor(240, 240, 240);

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

impl Plot {
    /// Points that a logarithmic axis cannot show: zero, negative or not finite.
    pub(crate) fn left_out(&self) -> usize {
        self.series.iter().flat_map(|series| &series.points).filter(|point| !drawable(point)).count()
    }

    /// The plot's numbers, for those who want to read them off.
    pub(crate) fn table(&self) -> Table {
        let columns =
            vec![Column::left("series"), Column::right(self.x.text()), Column::right(self.y.text())];
        let mut table = Table::new(format!("Numbers of: {}", self.title), columns);
        for series in &self.series {
            for (x, y) in &series.points {
                table.push(vec![series.label.clone(), number::figure(*x), number::figure(*y)]);
            }
        }
        table
    }

    /// Where each curve begins and ends, in words.
    pub(super) fn described(&self) -> String {
        let at = |(x, y): (f64, f64)| format!("({}, {})", number::figure(x), number::figure(y));
        let mut text = format!("Logarithmic axes: {} across, {} upwards.", self.x.text(), self.y.text());
        for series in &self.series {
            let points: Vec<(f64, f64)> =
                series.points.iter().filter(|point| drawable(point)).copied().collect();
            let _ = match points[..] {
                [] => write!(text, " {}: no point.", series.label),
                [only] => write!(text, " {}: {}.", series.label, at(only)),
                [first, .., last] => write!(text, " {}: from {} to {}.", series.label, at(first), at(last)),
            };
        }
        text
    }

    /// A standalone SVG document on white, with its title for screen readers.
    pub(crate) fn svg(&self) -> Outcome<String> {
        let legend: Vec<Vec<String>> =
            self.series.iter().map(|series| wrap(&series.label, LEGEND_LETTERS)).collect();
        let lines: usize = legend.iter().map(Vec::len).sum();
        let height = LEAST_HEIGHT.max(TOP + LINE * (lines + legend.len()) as i32);

        let mut drawn = String::new();
        self.draw(&mut drawn, height, &legend)
            .map_err(|error| Failure::program(format_args!("plot {}: {error}", self.file)))?;
        // plotters knows neither a role nor a title, and shows a drawing as large as it was drawn
        let body = drawn.split_once('>').map_or("", |(_, body)| body).trim_start();
        let label = format!("{}. {} {}", self.title, self.caption, self.described());
        Ok(format!(
            "<svg role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{}\" height=\"{}\" \
             xmlns=\"http://www.w3.org/2000/svg\">\n<title>{}</title>\n{body}",
            Escaped(&label),
            WIDTH / 2,
            height / 2,
            Escaped(&self.title),
        ))
    }

    fn draw(&self, svg: &mut String, height: i32, legend: &[Vec<String>]) -> Drawn {
        let canvas =
            SVGBackend::with_string(svg, (WIDTH.unsigned_abs(), height.unsigned_abs())).into_drawing_area();
        canvas.fill(&WHITE)?;
        let (plot_area, _) = canvas.split_horizontally(WIDTH - LEGEND);

        let (x, y) = (self.ticks(|point| point.0), self.ticks(|point| point.1));
        let mut chart = ChartBuilder::on(&plot_area)
            .caption(&self.title, font(FONT + 6))
            .margin(24)
            .x_label_area_size(100)
            .y_label_area_size(150)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .bold_line_style(GRID.stroke_width(2))
            .light_line_style(FAINT_GRID.stroke_width(2))
            .axis_style(INK.stroke_width(2))
            .label_style(font(FONT))
            .axis_desc_style(font(FONT))
            .x_desc(self.x.text())
            .y_desc(self.y.text())
            .draw()?;

        let mut legend_y = TOP;
        for (index, (series, label)) in self.series.iter().zip(legend).enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let points: Vec<(f64, f64)> =
                series.points.iter().filter(|point| drawable(point)).copied().collect();
            let points = points.iter().map(|(x, y)| chart.backend_coord(&(x.log10(), y.log10())));
            let points: Vec<(i32, i32)> = points.collect();
            let legend_x = WIDTH - LEGEND + 40;
            if series.joined {
                canvas.draw(&PathElement::new(points.clone(), colour.stroke_width(4)))?;
                let ends = [(legend_x - 30, legend_y), (legend_x + 30, legend_y)];
                canvas.draw(&PathElement::new(ends, colour.stroke_width(4)))?;
            }
            for point in points.into_iter().chain([(legend_x, legend_y)]) {
                draw_marker(&canvas, point, index, colour)?;
            }
            for line in label {
                let beside = font(FONT).pos(Pos::new(HPos::Left, VPos::Center));
                canvas.draw(&Text::new(line.clone(), (legend_x + 44, legend_y), beside))?;
                legend_y += LINE;
            }
            legend_y += LINE / 3;
        }
        canvas.present()?;
        Ok(())
    }

    fn ticks(&self, pick: fn(&(f64, f64)) -> f64) -> Ticks {
        decades(
            self.series.iter().flat_map(|series| &series.points).filter(|point| drawable(point)).map(pick),
        )
    }
}

fn drawable((x, y): &(f64, f64)) -> bool {
    x.is_normal() && y.is_normal() && *x > 0.0 && *y > 0.0
}

fn font(size: i32) -> TextStyle<'static> {
    ("sans-serif", size).into_text_style(&(1, 1)).color(&INK)
}

/// One of six shapes; with seven colours no two of the first 42 series look the same.
fn draw_marker(canvas: &Canvas<'_>, (x, y): (i32, i32), shape: usize, colour: RGBColor) -> Drawn {
    let polygon = |corners: &[(i32, i32)]| {
        let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        canvas.draw(&Polygon::new(corners, colour.filled()))
    };
    let stroke = |from: (i32, i32), to: (i32, i32)| {
        let ends = [(x + from.0, y + from.1), (x + to.0, y + to.1)];
        canvas.draw(&PathElement::new(ends, colour.stroke_width(6)))
    };
    // pointed shapes are drawn larger, so that all look equally large
    let (m, l) = (MARK, MARK * 4 / 3);
    match shape % 6 {
        0 => canvas.draw(&Circle::new((x, y), m, colour.filled()))?,
        1 => polygon(&[(-m, -m), (m, -m), (m, m), (-m, m)])?,
        2 => polygon(&[(0, -l), (l, m), (-l, m)])?,
        3 => polygon(&[(0, -l), (l, 0), (0, l), (-l, 0)])?,
        4 => {
            stroke((-m, -m), (m, m))?;
            stroke((-m, m), (m, -m))?;
        }
        _ => {
            stroke((-l, 0), (l, 0))?;
            stroke((0, -l), (0, l))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Plot {
        Plot {
            file: "a.svg".into(),
            title: "Time & error".into(),
            caption: "Less is better <in both>.".into(),
            x: Axis::new("time", "ms"),
            y: Axis::new("shadow error", ""),
            series: vec![
                Series { label: "hybrid".into(), points: vec![(1.0, 0.1), (10.0, 0.01)], joined: true },
                Series { label: "exact".into(), points: vec![(100.0, 0.0), (f64::NAN, 1.0)], joined: true },
            ],
        }
    }

    #[test]
    fn svg_has_its_words_and_is_well_formed() {
        let svg = sample().svg().unwrap();
        assert!(svg.contains("<title>Time &amp; error</title>"), "{svg}");
        assert!(
            svg.contains("role=\"img\" aria-label=\"Time &amp; error. Less is better &lt;in both&gt;. Logarithmic axes: time (ms) across"),
            "{svg}"
        );
        assert!(svg.contains("hybrid: from (1.00, 0.100) to (10.0, 0.0100). exact: no point."), "{svg}");
        for word in ["time (ms)", "shadow error", "hybrid", "exact"] {
            assert!(svg.contains(word), "{word} is missing: {svg}");
        }
        assert_eq!(svg.matches("<svg").count(), 1);
        assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
        assert!(svg.trim_end().ends_with("</svg>"), "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn what_cannot_be_drawn_is_counted_and_listed() {
        assert_eq!(sample().left_out(), 2);
        assert_eq!(sample().table().rows.len(), 4);
    }

    #[test]
    fn empty_flat_and_crowded_plots_are_drawn() {
        let mut plot = Plot::default();
        assert!(plot.svg().unwrap().contains("</svg>"));
        let series =
            |i: usize| Series { label: format!("series {i}"), points: vec![(2.0, 2.0)], joined: false };
        plot.series = (0..50).map(series).collect();
        let svg = plot.svg().unwrap();
        assert!(svg.contains("series 49"), "{svg}");
    }

    #[test]
    fn labels_break_between_words() {
        assert_eq!(
            wrap("hybrid march, 50 samples, quarter resolution", LEGEND_LETTERS),
            ["hybrid march, 50 samples,", "quarter resolution"]
        );
        assert_eq!(wrap("", LEGEND_LETTERS), [""]);
    }
}
