//! `billeter-table1`: Billeter, Sintorn and Assarsson's Table 1, static against adaptive tessellation of growing maps.
//!
//! All divisions of a map's surface take turns. The static ones are exact but for rounding; what the others add to
//! their error is the difference from the static picture, as a share of what shadows change.

use super::billeter_bench::{Division, SCENES, fastest, linear, lit};
use super::measure::{Arena, Measured};
use super::shown::{self, clock_note, display_scale};
use super::{Context, Preset, experiment, gpu_or_cpu};
use crate::failure::Outcome;
use crate::metrics;
use crate::report::data::Row;
use crate::report::{PictureRow, Section};
use crate::setups::LightKind;

mod checks;
mod tables;

/// What an adaptive tessellation may add to the error.
const ADDED: f64 = 1e-3;

/// Largest map whose Delaunay triangles are made.
const MOST_DELAUNAY: u32 = 1024;

/// Thresholds are shares of the scene's diagonal, the coarsest first.
struct Plan {
    side: u32,
    maps: &'static [u32],
    distance: &'static [f32],
    laplacian: &'static [f32],
    delaunay: &'static [f32],
    scenes: usize,
}

fn plan(context: &Context) -> Plan {
    let all = Plan {
        side: 512,
        maps: &[512, 1024, 2048, 4096],
        distance: &[3e-2, 1e-2, 6e-3, 3e-3, 1e-3],
        laplacian: &[1e-2, 3e-3, 1e-3],
        delaunay: &[1e-2, 3e-3, 1e-3],
        scenes: 2,
    };
    let few = Plan {
        distance: &[3e-2, 1e-2, 6e-3, 3e-3],
        laplacian: &[1e-2, 3e-3],
        delaunay: &[1e-2, 3e-3],
        ..all
    };
    let least =
        Plan { side: 64, maps: &[128], distance: &[1e-2, 3e-3], laplacian: &[3e-3], scenes: 1, ..few };
    let plan = match context.preset {
        Preset::Smoke => Plan { maps: &[256], ..least },
        Preset::Quick => Plan { side: 256, maps: &[1024], ..few },
        Preset::Standard => few,
        Preset::Paper => Plan { side: 1024, ..all },
    };
    // what the CPU builds, it builds for every frame
    if context.gpu.is_some() { plan } else { Plan { scenes: plan.scenes, ..least } }
}

/// A division of a map's surface, measured.
struct Volume {
    division: Division,
    measured: Measured,
    /// Difference from the static picture, as a share of what shadows change.
    added: f64,
}

/// A scene with a map.
struct Case {
    id: &'static str,
    title: String,
    map: u32,
    triangles: u64,
    volumes: Vec<Volume>,
}

impl Case {
    fn of(&self, belongs: impl Fn(Division) -> bool) -> impl Iterator<Item = &Volume> {
        self.volumes.iter().filter(move |volume| belongs(volume.division))
    }

    /// The faster way to draw all cells.
    fn fixed(&self) -> Option<&Measured> {
        fastest(self.of(Division::is_static).map(|volume| &volume.measured))
    }

    /// The coarsest of a kind that adds little enough.
    fn coarsest(&self, belongs: impl Fn(Division) -> bool) -> Option<&Volume> {
        self.of(belongs).find(|volume| volume.added <= ADDED)
    }

    /// The coarsest quadtree of each criterion that adds little enough.
    fn candidates(&self) -> impl Iterator<Item = &Volume> {
        let distance = self.coarsest(|division| matches!(division, Division::Distance(_)));
        distance.into_iter().chain(self.coarsest(|division| matches!(division, Division::Laplacian(_))))
    }

    /// The faster of these.
    fn adaptive(&self) -> Option<&Volume> {
        self.candidates().min_by(|a, b| a.measured.ms().total_cmp(&b.measured.ms()))
    }

    /// Triangles of a volume as a share of those of all cells.
    fn share(&self, volume: &Volume) -> Option<f64> {
        Some(volume.measured.mesh_triangles? as f64 / self.fixed()?.mesh_triangles? as f64)
    }
}

pub(super) fn run(context: &Context) -> Outcome<Section> {
    let plan = plan(context);
    let mut found = experiment(
        context,
        "billeter-table1",
        "Static against adaptive tessellation of the light volume",
        "Billeter, Sintorn & Assarsson 2010, Table 1",
    );
    found.adapter = gpu_or_cpu(context);
    let mut section = Section::default();
    let mut cases = Vec::new();
    for id in SCENES.iter().take(plan.scenes) {
        let Some((title, setup)) = lit(context, id, LightKind::Spot)? else { continue };
        let first = plan.maps.first().copied().unwrap_or(128);
        let mut arena = Arena::new(&context.references, title, setup, linear(plan.side, first))?;
        for &map in plan.maps {
            cases.push(measure(context, &plan, id, &mut arena, map)?);
        }
        section.pictures.extend(pictures(&arena, &cases)?);
    }
    // a software adapter's stamps of what makes a quadtree are not those of its work
    let stamped = context.gpu.as_ref().is_some_and(crate::gpu::is_hardware);
    for case in &cases {
        found.rows.extend(case.volumes.iter().map(|volume| row(case, volume, stamped)));
    }
    section.tables = vec![tables::table(&cases, stamped), tables::summary(&cases)];
    found.checks = checks::checks(&cases);
    found.notes = notes(context, &plan);
    section.experiment = found;
    Ok(section)
}

fn divisions(context: &Context, plan: &Plan, id: &str, map: u32) -> Vec<Division> {
    let mut all = vec![Division::Indexed];
    // on the CPU both are the same triangles
    all.extend(context.gpu.is_some().then_some(Division::SixVertices));
    all.extend(plan.distance.iter().copied().map(Division::Distance));
    all.extend(plan.laplacian.iter().copied().map(Division::Laplacian));
    if map <= MOST_DELAUNAY && id == "sponza" {
        all.extend(plan.delaunay.iter().copied().map(Division::Delaunay));
    }
    all
}

fn measure(context: &Context, plan: &Plan, id: &'static str, arena: &mut Arena, map: u32) -> Outcome<Case> {
    tracing::info!("{}, map {map}²", arena.title);
    let divisions = divisions(context, plan, id, map);
    let options = linear(plan.side, map);
    let settings: Vec<_> = divisions.iter().map(|division| division.setting(arena, options)).collect();
    let measured = arena.measure(context.gpu.as_ref(), &settings)?;
    let reference = measured.first().map(|first| first.image.clone());
    let volumes = divisions.into_iter().zip(measured).map(|(division, measured)| {
        let whole = reference.as_ref().unwrap_or(&measured.image);
        let added = metrics::compare(&measured.image, whole, Some(&arena.unshadowed), None)?.shadow_err;
        Ok(Volume { division, measured, added: added.unwrap_or(f64::NAN) })
    });
    let volumes = volumes.collect::<Outcome<Vec<_>>>()?;
    Ok(Case { id, title: arena.title.clone(), map, triangles: arena.triangles(), volumes })
}

fn row(case: &Case, volume: &Volume, stamped: bool) -> Row {
    let mut row = volume.measured.row(&case.title, case.triangles);
    if !stamped {
        row.stages.clear();
    }
    row.params.insert("added_error".into(), volume.added.into());
    row.paper =
        tables::fps(case, volume.division).map(|fps| [("fps".to_owned(), fps.into())].into_iter().collect());
    row
}

/// The static volume and the chosen quadtree of the first map.
fn pictures(arena: &Arena, cases: &[Case]) -> Outcome<Option<PictureRow>> {
    let side = arena.map.maps.maps.iter().flatten().map(|map| map.size().0).next();
    let case = cases.iter().find(|case| case.title == arena.title && Some(case.map) == side);
    let Some(case) = case else { return Ok(None) };
    let exact = &arena.map.exact;
    let mut panels = Vec::new();
    for measured in case.fixed().into_iter().chain(case.adaptive().map(|volume| &volume.measured)) {
        let errors = (exact, measured.nearest_errors());
        panels.extend(shown::panels(&case.title, measured, errors, display_scale(exact, 95))?);
    }
    let caption = format!("{}, map {}², airlight only; errors on the map", case.title, case.map);
    Ok(Some(PictureRow { caption, panels }))
}

fn notes(context: &Context, plan: &Plan) -> Vec<String> {
    let mut notes = vec![
        format!("Pictures are {0}×{0}, airlight only, under a spot in the thin medium; the paper's are 1024×1024 with surfaces. Times are of the fog alone, the tessellation made anew in every frame unless the light stands still; view rays and maps are drawn once and given. The paper's frames have all of that in them.", plan.side),
        format!("Map errors are against the exact picture of the same map, linear between its texels. The added error is the difference from the picture of all cells, as a share of what shadows change; of each criterion the coarsest threshold counts that adds at most {ADDED}, and of the two criteria the faster. Thresholds are distances, as shares of the scene's diagonal."),
        format!("Delaunay triangles are made once on the CPU, up to maps of {MOST_DELAUNAY}², and that is in no time: they are for lights that stand still."),
        "All tessellations draw into sums of signed airlight; under a spot, whose terms are quadratures, the first crossings of a pixel are kept and sorted instead.".into(),
    ];
    if context.gpu.is_none() {
        notes.push("There is no GPU adapter: the smallest map is tessellated on the CPU, which draws nothing and meets the triangles with rays.".into());
    }
    if context.setups.has_stand_ins() {
        notes.push("Where models were not given, the columned hall stands in for sponza and a knot of as many triangles for Yeah Right, and the paper's figures are not theirs.".into());
    }
    notes.extend(clock_note(context));
    notes
}
