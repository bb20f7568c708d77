//! What an experiment found, in the form of its `data.json`.
//!
//! Optional figures are `null` where they were not measured; a figure without a value (infinite, not a number) is
//! `null` too. Optional texts and lists are left out when empty.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::failure::{Failure, Outcome};
use crate::metrics::Metrics;

/// One experiment: everything that `data.json` holds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Experiment {
    /// Name on the command line and of the output folder.
    pub id: String,
    /// Heading in the report; the id stands in when it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// What it reproduces, such as "Wyman & Ramsey 2008, Table 1".
    pub source: String,
    /// `smoke`, `quick`, `standard` or `paper`.
    pub preset: String,
    /// What it ran on.
    pub adapter: Adapter,
    /// Revision of the source tree.
    pub git: String,
    /// Command line that repeats it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Every measurement.
    pub rows: Vec<Row>,
    /// Times interpolated to equal error.
    pub equal_error: Vec<EqualError>,
    /// The paper's claims, tested.
    pub checks: Vec<Check>,
    /// What a reader must know to judge the figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Pictures beside this file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<Attachment>,
    /// Plots beside this file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<Attachment>,
}

impl Experiment {
    /// The text of `data.json`.
    pub(crate) fn json(&self) -> Outcome<Vec<u8>> {
        let mut json = serde_json::to_vec_pretty(self)
            .map_err(|error| Failure::program(format_args!("data.json of {}: {error}", self.id)))?;
        json.push(b'\n');
        Ok(json)
    }
}

/// What the measurements ran on.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Adapter {
    /// Name of the GPU or CPU.
    pub name: String,
    /// `vulkan`, `cpu`, …
    pub backend: String,
    /// `discrete GPU`, `software`, …
    pub kind: String,
}

/// One measurement: a technique with its parameters on a scene.
///
/// Times are in ms. Errors are against `exact`, or against the froxel reference in the grid experiments.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Scene and set-up.
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: Option<u64>,
    /// Technique and variant.
    pub technique: String,
    /// Parameters of the technique.
    pub params: Map<String, Value>,
    /// Views rendered.
    pub viewers: u32,
    /// All that the technique adds to a frame without fog, its preparation included; median.
    pub ms_scatter: Option<f64>,
    /// The whole frame; median.
    pub ms_frame: Option<f64>,
    /// Least `ms_scatter` seen.
    pub ms_min: Option<f64>,
    /// Greatest `ms_scatter` seen.
    pub ms_max: Option<f64>,
    /// Warm frames measured.
    pub frames: Option<u32>,
    /// Time of each stage.
    pub stages: BTreeMap<String, f64>,
    /// ‖a − b‖₂ / ‖b‖₂.
    pub rel_rmse: Option<f64>,
    /// ‖a − b‖₂ / ‖u − b‖₂.
    pub shadow_err: Option<f64>,
    /// mean |a − b| / mean b.
    pub nmae: Option<f64>,
    /// 99th percentile of |a − b| / mean b.
    pub p99: Option<f64>,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// `shadow_err` against the exact picture of the same shadow map.
    pub shadow_err_map: Option<f64>,
    /// Which meaning of the map `shadow_err_map` refers to: `step` or `linear`.
    pub map_surface: Option<String>,
    /// Shadow rays traced.
    pub rays: Option<u64>,
    /// Samples along view rays.
    pub samples: Option<u64>,
    /// Fragments shaded.
    pub fragments: Option<u64>,
    /// Triangles of the light volume or of the shadow volumes.
    pub mesh_triangles: Option<u64>,
    /// Memory that the technique holds.
    pub memory_bytes: Option<u64>,
    /// What the paper measured, such as `{"fps": 96}`.
    pub paper: Option<Map<String, Value>>,
}

impl Adapter {
    /// Its name, with what it is in parentheses.
    pub(crate) fn text(&self) -> String {
        let details = [&self.backend, &self.kind].into_iter().filter(|text| !text.is_empty());
        let details = details.map(String::as_str).collect::<Vec<_>>().join(", ");
        if details.is_empty() { self.name.clone() } else { format!("{} ({details})", self.name) }
    }
}

impl Row {
    /// A row of one viewer, with nothing measured yet.
    pub(crate) fn new(scene: impl Into<String>, technique: impl Into<String>) -> Self {
        Self { scene: scene.into(), technique: technique.into(), viewers: 1, ..Self::default() }
    }

    /// Takes over the figures of a comparison.
    pub(crate) fn set_errors(&mut self, metrics: &Metrics) {
        self.rel_rmse = Some(metrics.rel_rmse);
        self.shadow_err = metrics.shadow_err;
        self.nmae = Some(metrics.nmae);
        self.p99 = Some(metrics.p99);
        self.flip = Some(metrics.flip);
    }
}

/// Times that the techniques need for the same error on one scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EqualError {
    /// Scene and set-up.
    pub scene: String,
    /// Which error: `shadow_err` or `shadow_err_map`.
    pub metric: String,
    /// Its value.
    pub target: f64,
    /// Time in ms by technique; `null` where a technique does not get there.
    pub ms: BTreeMap<String, Option<f64>>,
    /// Ratio of brute force's time to each technique's.
    pub speedup_over_brute_force: BTreeMap<String, Option<f64>>,
}

/// A claim of a paper, tested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Check {
    /// The claim, in words.
    pub claim: String,
    /// Where the paper makes it.
    pub paper: String,
    /// What was measured; `null` where it could not be.
    pub measured: Option<f64>,
    /// What the claim asks for.
    pub bar: Option<f64>,
    /// The side of the bar on which the claim holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<Bound>,
    /// Whether the claim holds. What could not be measured does not.
    pub holds: bool,
    /// What a reader must know to judge the verdict.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The side of the bar on which a claim holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Bound {
    /// measured ≥ bar.
    AtLeast,
    /// measured ≤ bar.
    AtMost,
}

impl Check {
    /// Tests a claim. `measured` that is absent or not a number holds nothing.
    pub(crate) fn new(
        claim: impl Into<String>,
        paper: impl Into<String>,
        measured: Option<f64>,
        bound: Bound,
        bar: f64,
    ) -> Self {
        let holds = measured.is_some_and(|measured| match bound {
            Bound::AtLeast => measured >= bar,
            Bound::AtMost => measured <= bar,
        });
        let (claim, paper) = (claim.into(), paper.into());
        Self { claim, paper, measured, bar: Some(bar), bound: Some(bound), holds, note: None }
    }

    /// The verdict in words.
    pub(crate) fn verdict(&self) -> &'static str {
        match (self.holds, self.measured) {
            (true, _) => "holds",
            (false, Some(_)) => "does not hold",
            (false, None) => "not measured",
        }
    }
}

/// A picture or plot in the experiment's folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Attachment {
    /// File name inside the experiment's folder.
    pub file: String,
    /// What it shows.
    pub caption: String,
    /// The same for those who cannot see it.
    pub alt: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(value: &Value) -> Vec<&str> {
        value.as_object().unwrap().keys().map(String::as_str).collect()
    }

    #[test]
    fn keys_are_the_contract() {
        let experiment = Experiment { rows: vec![Row::new("sphere", "hybrid")], ..Experiment::default() };
        let json = serde_json::to_value(&experiment).unwrap();
        assert_eq!(
            keys(&json),
            ["adapter", "checks", "equal_error", "git", "id", "preset", "rows", "source"]
        );
        assert_eq!(keys(&json["adapter"]), ["backend", "kind", "name"]);
        let row = &json["rows"][0];
        let mut expected = [
            "scene",
            "triangles",
            "technique",
            "params",
            "viewers",
            "ms_scatter",
            "ms_frame",
            "ms_min",
            "ms_max",
            "frames",
            "stages",
            "rel_rmse",
            "shadow_err",
            "nmae",
            "p99",
            "flip",
            "shadow_err_map",
            "map_surface",
            "rays",
            "samples",
            "fragments",
            "mesh_triangles",
            "memory_bytes",
            "paper",
        ];
        expected.sort_unstable();
        assert_eq!(keys(row), expected);
        assert!(row["paper"].is_null() && row["ms_scatter"].is_null(), "{row}");
        assert_eq!(row["viewers"], 1);
    }

    #[test]
    fn what_is_written_reads_back() {
        let mut row = Row::new("sphere", "hybrid");
        row.params.insert("samples".into(), 50.into());
        row.stages.insert("march".into(), 1.25);
        row.ms_scatter = Some(0.1 + 0.2);
        let check = Check::new("faster", "Table 1", Some(f64::INFINITY), Bound::AtLeast, 2.4);
        let mut experiment = Experiment { id: "x".into(), rows: vec![row], ..Experiment::default() };
        experiment.checks = vec![check];
        experiment.equal_error =
            vec![EqualError { ms: [("froxel".into(), None)].into(), ..Default::default() }];
        let json = serde_json::to_string(&experiment).unwrap();
        let read: Experiment = serde_json::from_str(&json).unwrap();
        // an infinite figure has no JSON form
        experiment.checks[0].measured = None;
        assert_eq!(read, experiment);
    }

    #[test]
    fn verdicts() {
        let verdict = |measured, bound| Check::new("", "", measured, bound, 2.0).verdict();
        assert_eq!(verdict(Some(2.0), Bound::AtLeast), "holds");
        assert_eq!(verdict(Some(1.9), Bound::AtLeast), "does not hold");
        assert_eq!(verdict(Some(1.9), Bound::AtMost), "holds");
        assert_eq!(verdict(Some(f64::NAN), Bound::AtMost), "does not hold");
        assert_eq!(verdict(None, Bound::AtMost), "not measured");
    }
}
