//! What the grid experiments share: settings of froxels that take turns.

use std::collections::BTreeMap;

use froxel_grid::{Counts, Froxels, GridMemory, Near, SharedGrid, Update};
use gpu_backend::GpuContext;

use super::grid_stand::{Stand, pictures};
use super::measure::{WARM_FRAMES, in_turns};
use crate::failure::Outcome;
use crate::froxels::{Engine, Eye};
use crate::image_file::Image;
use crate::median::median;
use crate::metrics::{self, Metrics};
use crate::report::data::Row;

/// Frames before those that are timed: the first compiles, the second fills the other half of a grid that takes turns.
const COLD_FRAMES: usize = 2;

/// Frames over which counts are averaged, which differ from turn to turn.
const COUNTED_FRAMES: usize = 2;

/// Room for so many bricks: 4 million voxels.
pub(super) const MOST_BRICKS: u32 = 8192;

/// Froxels by the name that their rows have.
#[derive(Debug, Clone)]
pub(super) struct Contender {
    pub(super) name: String,
    pub(super) froxels: Froxels,
    /// Whether anything casts a shadow.
    pub(super) casts: bool,
}

impl Contender {
    /// A contender with shadows.
    pub(super) fn new(name: impl Into<String>, froxels: Froxels) -> Self {
        Self { name: name.into(), froxels, casts: true }
    }

    /// Whether its frames differ, since voxels take turns.
    fn takes_turns(&self) -> bool {
        let update = self.froxels.grid().map(|grid| grid.update);
        matches!(update, Some(Update::InFrustums { alternate: true } | Update::Marked { alternate: true }))
    }

    /// Side of its voxels; units: m.
    pub(super) fn voxel_size(&self) -> Option<f32> {
        self.froxels.grid().map(|grid| grid.voxel_size)
    }
}

/// Who takes part in most experiments, with froxels of one layout.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cast(pub(super) Froxels);

impl Cast {
    /// A shadow ray for every froxel and light.
    pub(super) fn reference(self) -> Contender {
        Contender::new("froxels", self.0)
    }

    /// The paper's scheme.
    pub(super) fn paper(self, voxel: f32) -> Contender {
        Contender::new(format!("paper's grid, {voxel} m"), self.0.with_grid(SharedGrid::paper(voxel)))
    }

    /// The same frustums, and only what froxels read.
    pub(super) fn marked(self, voxel: f32) -> Contender {
        Contender::new(format!("marked grid, {voxel} m"), self.0.with_grid(SharedGrid::marked(voxel)))
    }

    /// The same in bricks.
    pub(super) fn bricks(self, voxel: f32) -> Contender {
        let memory = GridMemory::Bricks { most: MOST_BRICKS };
        let grid = SharedGrid { memory, ..SharedGrid::marked(voxel) };
        Contender::new(format!("marked grid in bricks, {voxel} m"), self.0.with_grid(grid))
    }

    /// The marked grid with something else next to the viewer.
    pub(super) fn near(self, name: &str, voxel: f32, near: Near) -> Contender {
        let memory = match near {
            Near::FineGrid { .. } => GridMemory::Bricks { most: 4 * MOST_BRICKS },
            _ => GridMemory::Dense,
        };
        Contender::new(name, self.0.with_grid(SharedGrid { near, memory, ..SharedGrid::marked(voxel) }))
    }
}

/// What a contender did for some viewers.
pub(super) struct Found {
    pub(super) contender: Contender,
    pub(super) viewers: usize,
    /// Sorted; units: ms.
    pub(super) times: Vec<f64>,
    passes: BTreeMap<String, Vec<f64>>,
    /// Of a frame, the mean of two.
    pub(super) counts: Counts,
    /// Memory of a frame; units: bytes.
    pub(super) bytes: u64,
    /// The first viewer's airlight.
    pub(super) image: Image,
    /// Against the reference's pictures, those of the reference against exact ones; the mean over viewers.
    pub(super) errors: Option<Metrics>,
}

impl Found {
    /// Median; units: ms.
    pub(super) fn ms(&self) -> f64 {
        median(&self.times).unwrap_or(f64::NAN)
    }

    /// All shadow rays of a frame.
    pub(super) fn rays(&self) -> f64 {
        self.counts.rays() as f64
    }

    /// Median time of each kind of pass; none where they do not make up half of the frame, as the time stamps of some software
    /// adapters do.
    pub(super) fn stages(&self) -> BTreeMap<String, f64> {
        let medians = self.passes.iter().filter_map(|(name, times)| Some((name.clone(), median(times)?)));
        let stages: BTreeMap<String, f64> = medians.collect();
        if stages.values().sum::<f64>() >= 0.5 * self.ms() { stages } else { BTreeMap::new() }
    }

    /// Its line among the measurements.
    pub(super) fn row(&self, stand: &Stand) -> Row {
        let Counts { near_rays, grid_rays, froxels, voxels, bricks, missed, dropped, not_finite } =
            self.counts;
        let mut row = Row::new(&stand.title, &self.contender.name);
        row.triangles = Some(stand.triangles());
        row.viewers = self.viewers as u32;
        if !self.times.is_empty() {
            (row.ms_scatter, row.ms_frame) = (Some(self.ms()), Some(self.ms()));
            (row.ms_min, row.ms_max) = (self.times.first().copied(), self.times.last().copied());
            row.frames = Some(self.times.len() as u32);
            row.stages = self.stages();
            if let Some(errors) = &self.errors {
                row.set_errors(errors);
            }
        }
        row.rays = Some(self.counts.rays());
        row.memory_bytes = Some(self.bytes);
        let mut param = |name: &str, value: serde_json::Value| _ = row.params.insert(name.into(), value);
        if let Some(voxel) = self.contender.voxel_size() {
            param("voxel_size", voxel.into());
            param("rays_near", near_rays.into());
            param("rays_grid", grid_rays.into());
            param("voxels", voxels.into());
        }
        param("froxels", froxels.into());
        for (name, count) in
            [("bricks", bricks), ("missed", missed), ("dropped", dropped), ("not_finite", not_finite)]
        {
            if count > 0 {
                param(name, count.into());
            }
        }
        row
    }
}

/// Contenders, each ready to render; the first is the reference.
pub(super) struct Bench<'g> {
    all: Vec<(Contender, Engine<'g>)>,
}

impl<'g> Bench<'g> {
    /// On the GPU where there is one, else on the CPU.
    pub(super) fn new(gpu: Option<&'g GpuContext>, contenders: Vec<Contender>) -> Outcome<Self> {
        let ready = |contender: Contender| {
            let engine = Engine::new(gpu, contender.froxels)?;
            Ok((contender, engine))
        };
        Ok(Self { all: contenders.into_iter().map(ready).collect::<Outcome<_>>()? })
    }

    /// Frames of the first `count` viewers in turns, after some that warm up.
    pub(super) fn measure(&mut self, stand: &Stand, count: usize) -> Outcome<Vec<Found>> {
        self.frames(stand, count, true)
    }

    /// The same without times: one frame of each, two of grids that take turns.
    pub(super) fn count(&mut self, stand: &Stand, count: usize) -> Outcome<Vec<Found>> {
        self.frames(stand, count, false)
    }

    fn frames(&mut self, stand: &Stand, count: usize, timed: bool) -> Outcome<Vec<Found>> {
        let eyes = stand.eyes(count);
        let mut turns = Vec::new();
        for (contender, engine) in &mut self.all {
            engine.forget();
            let mut turn = Turn { contender, engine, counts: Vec::new(), passes: BTreeMap::new() };
            let cold = if timed || turn.contender.takes_turns() { COLD_FRAMES } else { 0 };
            for _ in 0..cold {
                turn.frame(stand, &eyes)?;
            }
            turns.push(turn);
        }
        // what warmed up is no part of the medians
        turns.iter_mut().for_each(|turn| turn.passes.clear());
        let times = if timed {
            in_turns(&mut turns, |turn| turn.frame(stand, &eyes))?
        } else {
            for turn in &mut turns {
                let frames = 1 + usize::from(turn.contender.takes_turns());
                (0..frames).try_for_each(|_| turn.frame(stand, &eyes).map(drop))?;
            }
            vec![Vec::new(); turns.len()]
        };
        let mut reference = Vec::new();
        let mut all = Vec::new();
        for (turn, times) in turns.into_iter().zip(times) {
            let Turn { contender, engine, counts, mut passes } = turn;
            let images = pictures(engine, count, stand.size)?;
            let errors = if all.is_empty() {
                let errors = against(&images, &stand.exact, &stand.open)?;
                reference.clone_from(&images);
                errors
            } else {
                against(&images, &reference, &stand.open)?
            };
            passes.values_mut().for_each(|times| times.sort_by(f64::total_cmp));
            let (width, height) = stand.size;
            let image = images.into_iter().next().unwrap_or(Image { width, height, pixels: Vec::new() });
            let counts = mean_counts(&counts);
            let contender = contender.clone();
            let bytes = engine.bytes();
            all.push(Found { contender, viewers: count, times, passes, counts, bytes, image, errors });
        }
        Ok(all)
    }
}

/// A contender whose turn it is, and what its frames counted.
struct Turn<'a, 'g> {
    contender: &'a Contender,
    engine: &'a mut Engine<'g>,
    counts: Vec<Counts>,
    passes: BTreeMap<String, Vec<f64>>,
}

impl Turn<'_, '_> {
    /// Time of the next frame; units: ms.
    fn frame(&mut self, stand: &Stand, eyes: &[Eye<'_>]) -> Outcome<f64> {
        let time = self.engine.frame(&stand.world(self.contender.casts), eyes, stand.size)?;
        let mut sums: BTreeMap<String, f64> = BTreeMap::new();
        for pass in time.passes {
            if let Some(ms) = pass.ms {
                *sums.entry(kind_of_pass(&pass.name)).or_default() += ms;
            }
        }
        sums.into_iter().for_each(|(name, ms)| self.passes.entry(name).or_default().push(ms));
        self.counts.push(self.engine.counts()?);
        Ok(time.ms)
    }
}

/// Mean errors of the pictures that have a reference; `None` where none has.
fn against(images: &[Image], references: &[Image], open: &[Image]) -> Outcome<Option<Metrics>> {
    let each = images.iter().zip(references).zip(open);
    let each = each.map(|((image, reference), open)| metrics::compare(image, reference, Some(open), None));
    let each = each.collect::<Outcome<Vec<_>>>()?;
    if each.is_empty() {
        return Ok(None);
    }
    // where shadows change nothing, no error is a share of it
    let mean = |value: &dyn Fn(&Metrics) -> f64| {
        let values: Vec<f64> = each.iter().map(value).filter(|value| value.is_finite()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    Ok(Some(Metrics {
        rel_rmse: mean(&|m| m.rel_rmse),
        nmae: mean(&|m| m.nmae),
        p99: mean(&|m| m.p99),
        max_abs: each.iter().map(|m| m.max_abs).fold(0.0, f64::max),
        flip: mean(&|m| m.flip),
        nan: each.iter().map(|m| m.nan).sum(),
        shadow_err: Some(mean(&|m| m.shadow_err.unwrap_or(f64::NAN))),
    }))
}

/// Counts of a frame: the mean of the last ones.
fn mean_counts(counts: &[Counts]) -> Counts {
    let last = &counts[counts.len().saturating_sub(COUNTED_FRAMES)..];
    let sum: Counts = last.iter().copied().sum();
    let n = last.len().max(1) as u64;
    Counts {
        near_rays: sum.near_rays / n,
        grid_rays: sum.grid_rays / n,
        froxels: sum.froxels / n,
        voxels: sum.voxels / n,
        bricks: sum.bricks / n,
        missed: sum.missed / n,
        dropped: sum.dropped / n,
        not_finite: sum.not_finite / n,
    }
}

/// A pass's name without the view that it is for.
fn kind_of_pass(pass: &str) -> String {
    let name = pass.strip_prefix("froxels: ").unwrap_or(pass);
    name.split([',', ':', '('])
        .next()
        .unwrap_or(name)
        .trim_end_matches(|c: char| c.is_ascii_digit() || c == ' ')
        .to_owned()
}

/// The exponent of y in x: the slope of a line through the points in logarithms.
pub(super) fn exponent(points: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.into_iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let (sx, sy) = logs.iter().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
    let (mx, my) = (sx / n, sy / n);
    let sxx: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    let sxy: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    (logs.len() > 1 && sxx > 0.0).then(|| sxy / sxx)
}

/// Frames that a median stands on, as notes say it.
pub(super) fn frames_note() -> String {
    format!(
        "All contenders take turns in one process; times are medians of {WARM_FRAMES} frames after {COLD_FRAMES} that warm up, rays the mean of two frames."
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_powers() {
        let points = [1.0, 2.0, 8.0].map(|x: f64| (x, 5.0 * x.powf(0.7)));
        assert!((exponent(points).unwrap() - 0.7).abs() < 1e-12);
        assert_eq!(exponent([(1.0, 2.0)]), None);
        assert_eq!(exponent([(1.0, 2.0), (1.0, 3.0)]), None);
    }

    #[test]
    fn passes_lose_their_view() {
        assert_eq!(kind_of_pass("froxels: near shadows"), "near shadows");
        assert_eq!(kind_of_pass("froxels: march 12"), "march");
        assert_eq!(kind_of_pass("froxels: apply, view 3"), "apply");
    }

    #[test]
    fn counts_are_of_the_last_frames() {
        let of = |near_rays| Counts { near_rays, ..Counts::default() };
        assert_eq!(mean_counts(&[of(100), of(4), of(8)]).near_rays, 6);
        assert_eq!(mean_counts(&[]), Counts::default());
    }
}
