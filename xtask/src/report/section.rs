//! One experiment's share of the output: its folder and its part of the report.

use std::fs;
use std::path::Path;

use super::bars::Bars;
use super::data::{Attachment, Check, Experiment};
use super::plot::Plot;
use super::table::Table;
use super::{costs, number, rows};
use crate::failure::{Failure, Outcome};
use crate::image_file::Image8;
use crate::metrics::Metrics;
use crate::{image_file, output_file};

/// One experiment with everything that is shown of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Section {
    /// What it found.
    pub experiment: Experiment,
    /// Its own tables, such as the paper's with ours beside it. Measurements, equal error and claims need none: they
    /// are shown for every experiment.
    pub tables: Vec<Table>,
    /// Its plots.
    pub plots: Vec<Plot>,
    /// Its bars; those of stage times and of memory need none: they are drawn for every experiment.
    pub bars: Vec<Bars>,
    /// Its pictures.
    pub pictures: Vec<PictureRow>,
}

/// Pictures that belong side by side.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PictureRow {
    /// What they show together.
    pub caption: String,
    /// The pictures.
    pub panels: Vec<Panel>,
}

/// One picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panel {
    /// File name in the experiment's folder, ending in `.png`.
    pub file: String,
    /// Short heading.
    pub title: String,
    /// What the picture shows, for those who cannot see it.
    pub alt: String,
    /// Width and height; units: pixels.
    pub size: (u32, u32),
    /// The PNG file's bytes.
    pub png: Vec<u8>,
    /// What is printed with it.
    pub kind: PanelKind,
}

/// What is printed with a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PanelKind {
    /// Its title alone: a reference, or a picture that nobody timed.
    Plain,
    /// Time and error.
    Measured(Cost),
    /// The scale of the error maps.
    ErrorMap,
}

/// What a picture cost and how far it is off: never one without the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cost {
    /// Time of the fog, ms.
    pub ms: f64,
    /// ‖a − b‖₂ / ‖b‖₂.
    pub rel_rmse: f64,
    /// ‖a − b‖₂ / ‖u − b‖₂, where shadows matter.
    pub shadow_err: Option<f64>,
    /// Mean FLIP.
    pub flip: f64,
}

impl Cost {
    /// A time in ms with the figures of the comparison it was measured with.
    pub(crate) fn new(ms: f64, metrics: &Metrics) -> Self {
        Self { ms, rel_rmse: metrics.rel_rmse, shadow_err: metrics.shadow_err, flip: metrics.flip }
    }

    /// The figures with their names, the time first.
    pub(super) fn figures(&self) -> impl Iterator<Item = String> {
        let shadow = self.shadow_err.map(|share| format!("shadow error {}", number::error(share)));
        let rmse = format!("relative RMSE {}", number::error(self.rel_rmse));
        let flip = format!("FLIP {}", number::figure(self.flip));
        [Some(number::time(self.ms)), shadow, Some(rmse), Some(flip)].into_iter().flatten()
    }
}

/// Claims by verdict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Tally {
    pub(super) hold: usize,
    pub(super) fail: usize,
    pub(super) not_measured: usize,
}

impl Tally {
    pub(super) fn of(checks: &[Check]) -> Self {
        let mut tally = Self::default();
        for check in checks {
            *match check.verdict() {
                "holds" => &mut tally.hold,
                "not measured" => &mut tally.not_measured,
                _ => &mut tally.fail,
            } += 1;
        }
        tally
    }

    pub(super) fn all(self) -> usize {
        self.hold + self.fail + self.not_measured
    }
}

impl std::ops::Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            hold: self.hold + other.hold,
            fail: self.fail + other.fail,
            not_measured: self.not_measured + other.not_measured,
        }
    }
}

impl Panel {
    /// A picture with what is printed with it.
    pub(crate) fn new(
        file: impl Into<String>,
        title: impl Into<String>,
        alt: impl Into<String>,
        picture: &Image8,
        kind: PanelKind,
    ) -> Outcome<Self> {
        let png = image_file::encode_png(picture)?;
        let size = (picture.width, picture.height);
        Ok(Self { file: file.into(), title: title.into(), alt: alt.into(), size, png, kind })
    }
}

impl Section {
    /// Heading: the experiment's title, or its id.
    pub(super) fn heading(&self) -> &str {
        self.experiment.title.as_ref().unwrap_or(&self.experiment.id)
    }

    /// How many claims there are to test of each verdict.
    pub(super) fn tally(&self) -> Tally {
        Tally::of(&self.experiment.checks)
    }

    /// "2 of 3 claims hold".
    pub(super) fn verdict(&self) -> String {
        let tally = self.tally();
        match (tally.all(), tally.hold, tally.not_measured) {
            (0, ..) => "no claim to test".to_owned(),
            (1, 1, _) => "its claim holds".to_owned(),
            (1, _, 1) => "its claim was not measured".to_owned(),
            (1, ..) => "its claim does not hold".to_owned(),
            (all, hold, _) => format!("{hold} of {all} claims hold"),
        }
    }

    /// The tables that say what came out: claims, the experiment's own, equal error.
    pub(super) fn result_tables(&self) -> Vec<Table> {
        let Experiment { checks, equal_error, .. } = &self.experiment;
        let mut tables = Vec::new();
        if !checks.is_empty() {
            tables.push(rows::checks("Claims", checks.iter()));
        }
        tables.extend(self.tables.iter().cloned());
        if !equal_error.is_empty() {
            tables.push(rows::equal_error(equal_error));
        }
        tables
    }

    /// What the frames' times are made of and how much memory they hold, as tables and as bars.
    pub(super) fn costs(&self) -> Vec<(Table, Bars)> {
        let rows = &self.experiment.rows;
        [costs::stages(rows), costs::memory(rows)].into_iter().flatten().collect()
    }

    /// Every measurement, unless there is none.
    pub(super) fn measurements(&self) -> Option<Table> {
        let rows = &self.experiment.rows;
        (!rows.is_empty()).then(|| rows::measurements("Every measurement", rows))
    }

    /// The text of `table.txt`, which `repro` also prints.
    pub(crate) fn text(&self) -> String {
        let Experiment { id, source, preset, adapter, git, command, notes, .. } = &self.experiment;
        let mut text = format!("{}\n", self.heading());
        let mut fact = |name: &str, value: &str| {
            if !value.is_empty() {
                text += &format!("{name:<10}{value}\n");
            }
        };
        fact("id", id);
        fact("source", source);
        fact("preset", preset);
        fact("adapter", &adapter.text());
        fact("revision", git);
        fact("command", command.as_deref().unwrap_or_default());
        let costs = self.costs().into_iter().map(|(table, _)| table);
        for table in self.result_tables().into_iter().chain(costs).chain(self.measurements()) {
            text += &format!("\n{}", table.text());
        }
        for row in &self.pictures {
            text += &format!("\n{}\n", row.caption);
            for panel in &row.panels {
                let cost = match &panel.kind {
                    PanelKind::Measured(cost) => {
                        format!(": {}", cost.figures().collect::<Vec<_>>().join(", "))
                    }
                    PanelKind::Plain | PanelKind::ErrorMap => String::new(),
                };
                text += &format!("  {}  {}{cost}\n", panel.file, panel.title);
            }
        }
        if !notes.is_empty() {
            text += "\nNotes\n";
            text.extend(notes.iter().map(|note| format!("- {note}\n")));
        }
        text
    }

    /// Writes `<id>/table.txt`, `<id>/data.json`, the pictures and the plots under `out`.
    pub(crate) fn write(&self, out: &Path) -> Outcome {
        let folder = out.join(&self.experiment.id);
        fs::create_dir_all(&folder)
            .map_err(|error| Failure::input(format_args!("{}: cannot be made: {error}", folder.display())))?;
        for panel in self.panels() {
            output_file::write_bytes(&folder.join(&panel.file), &panel.png)?;
        }
        for plot in &self.plots {
            output_file::write_bytes(&folder.join(&plot.file), plot.svg()?.as_bytes())?;
        }
        for bars in self.all_bars() {
            output_file::write_bytes(&folder.join(&bars.file), bars.svg().as_bytes())?;
        }
        let json = self.with_attachments().json()?;
        output_file::write_bytes(&folder.join("data.json"), &json)?;
        output_file::write_bytes(&folder.join("table.txt"), self.text().as_bytes())
    }

    /// The experiment's own bars, stage times and memory.
    fn all_bars(&self) -> Vec<Bars> {
        let costs = self.costs().into_iter().map(|(_, bars)| bars);
        self.bars.iter().cloned().chain(costs).collect()
    }

    fn panels(&self) -> impl Iterator<Item = &Panel> {
        self.pictures.iter().flat_map(|row| &row.panels)
    }

    /// The experiment with its files listed.
    fn with_attachments(&self) -> Experiment {
        let mut experiment = self.experiment.clone();
        experiment.pictures.extend(self.panels().map(|panel| Attachment {
            file: panel.file.clone(),
            caption: panel.title.clone(),
            alt: panel.alt.clone(),
        }));
        experiment.plots.extend(self.plots.iter().map(|plot| Attachment {
            file: plot.file.clone(),
            caption: plot.title.clone(),
            alt: plot.caption.clone(),
        }));
        experiment.plots.extend(self.all_bars().into_iter().map(|bars| Attachment {
            alt: format!("{} {}", bars.caption, bars.described()),
            file: bars.file,
            caption: bars.title,
        }));
        experiment
    }
}
