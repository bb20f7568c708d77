//! One experiment's share of the output: its folder and its part of the report.

use std::fs;
use std::path::Path;

use super::data::{Attachment, Experiment};
use super::plot::Plot;
use super::table::Table;
use super::{number, rows};
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
        Ok(Self { file: file.into(), title: title.into(), alt: alt.into(), png, kind })
    }
}

impl Section {
    /// Heading: the experiment's title, or its id.
    pub(super) fn heading(&self) -> &str {
        self.experiment.title.as_ref().unwrap_or(&self.experiment.id)
    }

    /// "2 of 3 claims hold".
    pub(super) fn verdict(&self) -> String {
        let checks = &self.experiment.checks;
        let holding = checks.iter().filter(|check| check.holds).count();
        match checks.len() {
            0 => "no claim to test".to_owned(),
            1 if holding == 1 => "its claim holds".to_owned(),
            1 => "its claim does not hold".to_owned(),
            all => format!("{holding} of {all} claims hold"),
        }
    }

    /// The tables that say what came out: claims, the experiment's own, equal error.
    pub(super) fn result_tables(&self) -> Vec<Table> {
        let Experiment { checks, equal_error, .. } = &self.experiment;
        let mut tables = Vec::new();
        if !checks.is_empty() {
            tables.push(rows::checks("Claims", checks.iter().map(|check| (None, check))));
        }
        tables.extend(self.tables.iter().cloned());
        if !equal_error.is_empty() {
            tables.push(rows::equal_error(equal_error));
        }
        tables
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
        fact("adapter", &format!("{} ({}, {})", adapter.name, adapter.backend, adapter.kind));
        fact("revision", git);
        fact("command", command.as_deref().unwrap_or_default());
        for table in self.result_tables().iter().chain(&self.measurements()) {
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
        let mut json = serde_json::to_vec_pretty(&self.with_attachments()).map_err(|error| {
            Failure::program(format_args!("data.json of {}: {error}", self.experiment.id))
        })?;
        json.push(b'\n');
        output_file::write_bytes(&folder.join("data.json"), &json)?;
        output_file::write_bytes(&folder.join("table.txt"), self.text().as_bytes())
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
        experiment
    }
}
