//! Tables, once described, as plain text and as HTML.

use std::fmt::Write;

use super::escape::Escaped;

/// A table of finished texts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Table {
    /// What the table shows.
    pub title: String,
    /// Its columns.
    pub columns: Vec<Column>,
    /// Rows of as many cells as there are columns; a missing cell is empty.
    pub rows: Vec<Vec<String>>,
    /// What a reader must know to judge the figures.
    pub note: Option<String>,
    /// The column that names its rows.
    pub(super) header: usize,
    /// A column whose cells lead to places in the page, and their names; text has no use for them.
    pub(super) links: Option<(usize, Vec<String>)>,
}

/// Letters up to which a text is not broken into lines.
const ONE_LINE: usize = 24;

/// Columns up to which a table fits an upright page.
const UPRIGHT: usize = 8;

/// A column's heading and the side its cells lean to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    /// Heading.
    pub name: String,
    /// Side.
    pub align: Align,
}

/// Side that cells lean to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

impl Column {
    /// A column of words.
    pub(crate) fn left(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Left }
    }

    /// A column of numbers.
    pub(crate) fn right(name: impl Into<String>) -> Self {
        Self { name: name.into(), align: Align::Right }
    }
}

impl Table {
    /// An empty table.
    pub(crate) fn new(title: impl Into<String>, columns: Vec<Column>) -> Self {
        Self { title: title.into(), columns, ..Self::default() }
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, row: Vec<String>) {
        self.rows.push(row);
    }

    /// Leaves out the columns in which no row says anything (nothing, or a dash).
    pub(crate) fn without_empty_columns(mut self) -> Self {
        let says = |cell: Option<&String>| {
            cell.is_some_and(|cell| !cell.is_empty() && cell != super::number::MISSING)
        };
        let keep: Vec<bool> =
            (0..self.columns.len()).map(|column| self.rows.iter().any(|row| says(row.get(column)))).collect();
        let kept = |column: &usize| keep.get(*column).copied().unwrap_or_default();
        let moved = |column: usize| (0..column).filter(kept).count();
        self.header = moved(self.header);
        self.links = self.links.filter(|(column, _)| kept(column)).map(|(column, to)| (moved(column), to));
        self.columns =
            self.columns.into_iter().enumerate().filter(|(i, _)| kept(i)).map(|(_, c)| c).collect();
        for row in &mut self.rows {
            *row = row.drain(..).enumerate().filter(|(i, _)| kept(i)).map(|(_, cell)| cell).collect();
        }
        self
    }

    /// The table as aligned text, ending in a line feed.
    pub(crate) fn text(&self) -> String {
        let headings: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let widths: Vec<usize> = headings
            .iter()
            .enumerate()
            .map(|(i, heading)| {
                self.rows.iter().map(|row| width(cell(row, i))).fold(width(heading), usize::max)
            })
            .collect();
        let line = |cells: &dyn Fn(usize) -> String| {
            let padded = self.columns.iter().zip(&widths).enumerate().map(|(i, (column, width))| {
                let cell = cells(i);
                let gap = " ".repeat(width.saturating_sub(self::width(&cell)));
                match column.align {
                    Align::Left => cell + &gap,
                    Align::Right => gap + &cell,
                }
            });
            padded.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        };

        let mut text = format!("{}\n", self.title);
        text += &line(&|i| headings[i].to_owned());
        text += &line(&|i| "─".repeat(widths[i]));
        for row in &self.rows {
            text += &line(&|i| cell(row, i).to_owned());
        }
        if let Some(note) = &self.note {
            text += &format!("{note}\n");
        }
        text
    }

    /// The table in Markdown, ending in a line feed.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let plain = |text: &str| text.replace('|', "\\|").replace('\n', " ");
        let mut text = format!("{}\n\n", self.title);
        text += &line(self.columns.iter().map(|column| plain(&column.name)).collect());
        let rules = self.columns.iter().map(|column| match column.align {
            Align::Left => "---".to_owned(),
            Align::Right => "--:".to_owned(),
        });
        text += &line(rules.collect());
        for row in &self.rows {
            text += &line((0..self.columns.len()).map(|i| plain(cell(row, i))).collect());
        }
        text.extend(self.note.iter().map(|note| format!("\n{note}\n")));
        text
    }

    /// The table as HTML, in a frame that scrolls sideways where the page is narrow and that a keyboard can reach.
    pub(super) fn html(&self, page: &mut String) {
        let title = Escaped(&self.title);
        let wide = if self.columns.len() > UPRIGHT { " wide" } else { "" };
        // writing to a string cannot fail
        let _ = writeln!(
            page,
            "<div class=\"scroll{wide}\" role=\"region\" tabindex=\"0\" aria-label=\"{title}\">\n<table>\n\
             <caption><span>{title}</span></caption>"
        );
        page.push_str("<thead><tr>");
        for column in &self.columns {
            let _ = write!(page, "<th scope=\"col\"{}>{}</th>", class(column.align), Escaped(&column.name));
        }
        page.push_str("</tr></thead>\n<tbody>\n");
        for (index, row) in self.rows.iter().enumerate() {
            page.push_str("<tr>");
            for (i, column) in self.columns.iter().enumerate() {
                let cell = cell(row, i);
                let (open, close) = if i == self.header { ("th scope=\"row\"", "th") } else { ("td", "td") };
                // the words of a verdict carry it; the look only helps the eye to find those that fail
                let look = match cell {
                    "holds" => " class=\"holds\"",
                    "does not hold" | "not measured" => " class=\"fails\"",
                    text if column.align == Align::Left && text.chars().count() > ONE_LINE => {
                        " class=\"words\""
                    }
                    _ => class(column.align),
                };
                let link =
                    self.links.as_ref().filter(|(linked, _)| *linked == i).and_then(|(_, to)| to.get(index));
                let _ = match link {
                    Some(to) => write!(
                        page,
                        "<{open}{look}><a href=\"#{}\">{}</a></{close}>",
                        Escaped(to),
                        Escaped(cell)
                    ),
                    None => write!(page, "<{open}{look}>{}</{close}>", Escaped(cell)),
                };
            }
            page.push_str("</tr>\n");
        }
        page.push_str("</tbody>\n</table>\n</div>\n");
        if let Some(note) = &self.note {
            let _ = writeln!(page, "<p class=\"note\">{}</p>", Escaped(note));
        }
    }
}

fn class(align: Align) -> &'static str {
    match align {
        Align::Left => "",
        Align::Right => " class=\"number\"",
    }
}

fn cell(row: &[String], column: usize) -> &str {
    row.get(column).map_or("", String::as_str)
}

/// Columns that a text takes in a terminal; none of our texts has wide or combining characters.
fn width(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table =
            Table::new("Times", vec![Column::left("scene"), Column::right("time"), Column::right("n")]);
        table.push(vec!["sphere".into(), "7.89 µs".into(), "–".into()]);
        table.push(vec!["a<b".into(), "12.3 ms".into()]);
        table.note = Some("One frame.".into());
        table
    }

    #[test]
    fn text_is_aligned() {
        let expected = "Times\n\
            scene      time  n\n\
            ──────  ───────  ─\n\
            sphere  7.89 µs  –\n\
            a<b     12.3 ms\n\
            One frame.\n";
        assert_eq!(sample().text(), expected);
    }

    #[test]
    fn markdown_has_a_cell_for_each_column() {
        let mut table = sample();
        table.rows[1][0] = "a|b".into();
        let expected = "Times\n\n| scene | time | n |\n| --- | --: | --: |\n| sphere | 7.89 µs | – |\n\
            | a\\|b | 12.3 ms |  |\n\nOne frame.\n";
        assert_eq!(table.markdown(), expected);
    }

    #[test]
    fn html_is_escaped_and_complete() {
        let mut html = String::new();
        sample().html(&mut html);
        assert!(html.contains("<th scope=\"row\">a&lt;b</th>"), "{html}");
        assert_eq!(html.matches("<td").count(), 4, "short rows are filled up: {html}");
        assert!(html.contains("<caption><span>Times</span></caption>"), "{html}");
    }

    #[test]
    fn rows_are_named_and_linked_where_they_are_told() {
        let mut table = sample();
        table.columns.insert(0, Column::left("silent"));
        table.rows.iter_mut().for_each(|row| row.insert(0, String::new()));
        (table.header, table.links) = (2, Some((2, vec!["there".into(), "elsewhere".into()])));
        let mut html = String::new();
        table.without_empty_columns().html(&mut html);
        assert!(html.contains("<td>sphere</td>"), "{html}");
        assert!(
            html.contains("<th scope=\"row\" class=\"number\"><a href=\"#there\">7.89 µs</a></th>"),
            "{html}"
        );
    }

    #[test]
    fn silent_columns_go() {
        let table = sample().without_empty_columns();
        assert_eq!(table.columns.len(), 2);
        assert_eq!(table.rows[0], ["sphere", "7.89 µs"]);
    }
}
