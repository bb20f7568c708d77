//! Bars side by side: what a frame's time is made of, what an error is made of, how much memory is held.
//!
//! Drawn from zero on a linear axis, since only there lengths can be added up. Every bar ends in its number. Parts carry
//! numbers that the legend explains, so that colour is not needed to tell them apart.

use std::fmt::Write;

use super::escape::Escaped;
use super::number;
use super::table::{Column, Table};

/// Horizontal bars.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Bars {
    /// File name in the experiment's folder, ending in `.svg`.
    pub file: String,
    /// Heading.
    pub title: String,
    /// What the bars show, for those who cannot see them and as their caption.
    pub caption: String,
    /// What their length means.
    pub quantity: Quantity,
    /// From the top.
    pub bars: Vec<Bar>,
}

/// One bar, or a heading where it has no parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Bar {
    /// What it is for.
    pub label: String,
    /// Names and lengths from left to right.
    pub parts: Vec<(String, f64)>,
}

/// What the length of a bar means.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Units: ms.
    #[default]
    Time,
    /// A relative error.
    Error,
    /// Units: bytes.
    Memory,
}

impl Quantity {
    fn text(self, value: f64) -> String {
        match self {
            Self::Time => number::time(value),
            Self::Error => number::error(value),
            Self::Memory => number::bytes(value as u64),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Error => "error",
            Self::Memory => "memory",
        }
    }
}

impl Bar {
    /// A bar of a single part.
    pub(crate) fn plain(label: impl Into<String>, length: f64) -> Self {
        Self { label: label.into(), parts: vec![(String::new(), length)] }
    }

    fn total(&self) -> f64 {
        self.parts.iter().map(|(_, length)| drawn(*length)).sum()
    }
}

/// What is drawn of a length: nothing of one that is negative or no number.
fn drawn(length: f64) -> f64 {
    if length.is_finite() { length.max(0.0) } else { 0.0 }
}

const WIDTH: f64 = 860.0;
/// Where bars begin, right of their labels.
const LEFT: f64 = 310.0;
/// Room for the number behind the longest bar.
const NUMBER: f64 = 90.0;
const TOP: f64 = 46.0;
const LINE: f64 = 17.0;
const THICK: f64 = 20.0;
/// Letters that fit into a line beside a bar.
const LABEL_LETTERS: usize = 42;
/// Letters of the legend are about so wide.
const LETTER: f64 = 7.4;

/// Fills and the ink on them: Okabe and Ito's colours, light and dark in turns, so that neighbours differ in grey too.
const FILLS: [(&str, &str); 8] = [
    ("#0072b2", "#fff"),
    ("#e69f00", "#000"),
    ("#00664a", "#fff"),
    ("#8fcaf0", "#000"),
    ("#a33f00", "#fff"),
    ("#e3a9c6", "#000"),
    ("#333333", "#fff"),
    ("#bdbdbd", "#000"),
];

impl Bars {
    /// Names of the parts in the order in which they first appear; the unnamed part of a plain bar is none.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.bars.iter().flat_map(|bar| &bar.parts) {
            if !name.is_empty() && !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
    }

    /// The lengths, for those who want to read them off.
    pub(crate) fn table(&self) -> Table {
        let names = self.names();
        let mut columns = vec![Column::left("bar")];
        columns.extend(names.iter().map(|name| Column::right(*name)));
        columns.push(Column::right(if names.is_empty() { self.quantity.name() } else { "together" }));
        let mut table = Table::new(format!("Numbers of: {}", self.title), columns);
        for bar in self.bars.iter().filter(|bar| !bar.parts.is_empty()) {
            let of = |name: &&str| bar.parts.iter().find(|(part, _)| part == name).map(|(_, length)| *length);
            let mut cells = vec![bar.label.clone()];
            cells.extend(
                names.iter().map(|name| {
                    of(name).map_or_else(|| number::MISSING.to_owned(), |v| self.quantity.text(v))
                }),
            );
            cells.push(self.quantity.text(bar.total()));
            table.push(cells);
        }
        table
    }

    /// The longest and the shortest bar in words.
    pub(super) fn described(&self) -> String {
        let bars = || self.bars.iter().filter(|bar| !bar.parts.is_empty());
        let longest = bars().max_by(|a, b| a.total().total_cmp(&b.total()));
        let shortest = bars().min_by(|a, b| a.total().total_cmp(&b.total()));
        let of = |bar: &Bar| format!("{} ({})", bar.label, self.quantity.text(bar.total()));
        match (longest, shortest) {
            (Some(longest), Some(shortest)) if longest != shortest => {
                format!("{} bars. Longest: {}. Shortest: {}.", bars().count(), of(longest), of(shortest))
            }
            (Some(only), _) => format!("One bar: {}.", of(only)),
            _ => "No bar.".to_owned(),
        }
    }

    /// A standalone SVG document on white, with its title for screen readers.
    // Writing to a string cannot fail, so the results of `write!` are dropped here.
    pub(crate) fn svg(&self) -> String {
        let names = self.names();
        let mut body = String::new();
        let _ = writeln!(
            body,
            "<text x=\"12\" y=\"26\" font-size=\"17\" font-weight=\"600\">{}</text>",
            Escaped(&self.title)
        );
        let mut y = if names.is_empty() { TOP } else { legend(&mut body, &names) };
        let most = self.bars.iter().map(Bar::total).fold(0.0, f64::max);
        let scale = if most > 0.0 { (WIDTH - LEFT - NUMBER) / most } else { 0.0 };
        for bar in &self.bars {
            y += self.bar(&mut body, bar, &names, y, scale);
        }
        let label = format!("{}. {} {}", self.title, self.caption, self.described());
        let height = y + 14.0;
        format!(
            "<svg role=\"img\" aria-label=\"{}\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"14\" fill=\"#222\" xmlns=\"http://www.w3.org/2000/svg\">\n\
             <title>{}</title>\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n{body}</svg>\n",
            Escaped(&label),
            Escaped(&self.title)
        )
    }

    /// Draws a bar at height `y` and returns the height that it takes.
    fn bar(&self, body: &mut String, bar: &Bar, names: &[&str], y: f64, scale: f64) -> f64 {
        if bar.parts.is_empty() {
            let _ = writeln!(
                body,
                "<text x=\"12\" y=\"{:.1}\" font-weight=\"600\">{}</text>",
                y + 22.0,
                Escaped(&bar.label)
            );
            return 32.0;
        }
        let lines = wrap(&bar.label, LABEL_LETTERS);
        let height = (lines.len() as f64 * LINE).max(THICK) + 8.0;
        let middle = y + height / 2.0;
        for (index, line) in lines.iter().enumerate() {
            let below = (index as f64 - (lines.len() - 1) as f64 / 2.0) * LINE;
            let _ = writeln!(
                body,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 10.0,
                middle + below + 5.0,
                Escaped(line)
            );
        }
        let mut x = LEFT;
        for (name, length) in &bar.parts {
            let width = drawn(*length) * scale;
            let number = names.iter().position(|known| known == name);
            let (fill, ink) = FILLS[number.unwrap_or(0) % FILLS.len()];
            let _ = writeln!(
                body,
                "<rect x=\"{x:.2}\" y=\"{:.1}\" width=\"{width:.2}\" height=\"{THICK}\" fill=\"{fill}\" stroke=\"#fff\"/>",
                middle - THICK / 2.0
            );
            if let Some(number) = number
                && width > 14.0
            {
                let _ = writeln!(
                    body,
                    "<text x=\"{:.2}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"12\" fill=\"{ink}\">{}</text>",
                    x + width / 2.0,
                    middle + 4.5,
                    number + 1
                );
            }
            x += width;
        }
        let _ = writeln!(
            body,
            "<line x1=\"{LEFT}\" x2=\"{LEFT}\" y1=\"{y:.1}\" y2=\"{:.1}\" stroke=\"#222\"/>\n\
             <text x=\"{:.2}\" y=\"{:.1}\">{}</text>",
            y + height,
            x + 7.0,
            middle + 5.0,
            Escaped(&self.quantity.text(bar.total()))
        );
        height
    }
}

/// Draws numbered swatches with the names of the parts and returns where they end.
fn legend(body: &mut String, names: &[&str]) -> f64 {
    let (mut x, mut y) = (12.0, TOP);
    for (index, name) in names.iter().enumerate() {
        let wide = 34.0 + LETTER * name.chars().count() as f64;
        if x > 12.0 && x + wide > WIDTH {
            (x, y) = (12.0, y + 26.0);
        }
        let (fill, ink) = FILLS[index % FILLS.len()];
        let _ = writeln!(
            body,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"18\" height=\"18\" fill=\"{fill}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"12\" fill=\"{ink}\">{}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            y,
            x + 9.0,
            y + 13.5,
            index + 1,
            x + 24.0,
            y + 14.0,
            Escaped(name)
        );
        x += wide + 14.0;
    }
    y + 32.0
}

/// Breaks a text between words.
pub(super) fn wrap(text: &str, letters: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let fits = |line: &String| line.chars().count() + word.chars().count() < letters;
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if fits(line) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Bars {
        let bar = |label: &str, parts: &[(&str, f64)]| Bar {
            label: label.into(),
            parts: parts.iter().map(|(name, ms)| ((*name).into(), *ms)).collect(),
        };
        Bars {
            file: "stages.svg".into(),
            title: "Time & stages".into(),
            caption: "Median times <of frames>.".into(),
            quantity: Quantity::Time,
            bars: vec![
                bar("hall", &[]),
                bar("hybrid", &[("faces", 2.0), ("march", 6.0)]),
                bar("march", &[("march", 16.0), ("odd", f64::NAN)]),
            ],
        }
    }

    /// Widths of the bars' parts, without those of the legend and of the background.
    fn widths(svg: &str) -> Vec<f64> {
        let rects = svg.split("<rect x=\"").skip(1).filter(|rect| rect.contains("stroke="));
        rects
            .map(|rect| rect.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap())
            .collect()
    }

    #[test]
    fn lengths_are_in_proportion() {
        let svg = sample().svg();
        let widths = widths(&svg);
        assert_eq!(widths.len(), 4, "{svg}");
        assert!((widths[1] - 3.0 * widths[0]).abs() < 0.05 && (widths[2] - 8.0 * widths[0]).abs() < 0.05);
        assert_eq!(widths[3], 0.0, "what is no number has no length");
        assert!(
            !svg.contains("NaN") && svg.contains("Time &amp; stages") && svg.contains("&lt;of frames&gt;")
        );
        for word in ["hall", "hybrid", "8.00 ms", "16.0 ms", "faces"] {
            assert!(svg.contains(&format!(">{word}<")), "{word} is missing: {svg}");
        }
    }

    #[test]
    fn numbers_and_words_say_the_same() {
        let table = sample().table();
        assert_eq!(
            table.rows,
            [["hybrid", "2.00 ms", "6.00 ms", "–", "8.00 ms"], ["march", "–", "16.0 ms", "–", "16.0 ms"]]
        );
        assert_eq!(sample().described(), "2 bars. Longest: march (16.0 ms). Shortest: hybrid (8.00 ms).");
        assert_eq!(Bars::default().described(), "No bar.");
        assert!(Bars::default().svg().contains("</svg>"));
    }

    #[test]
    fn plain_bars_need_no_legend() {
        let bars = Bars {
            quantity: Quantity::Memory,
            bars: vec![Bar::plain("grid", 2048.0), Bar::plain("froxels", 1024.0)],
            ..Bars::default()
        };
        assert_eq!(bars.table().columns.len(), 2);
        let widths = widths(&bars.svg());
        assert!((widths[0] - 2.0 * widths[1]).abs() < 0.05 && bars.svg().contains("2.00 KiB"));
    }
}
