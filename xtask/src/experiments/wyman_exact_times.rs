//! How long the exact reference takes: the last rows of `wyman-table1`.

use ground_truth::ExactShadows;
use scene::{Bvh, Interval, LightId};

use super::{Context, Preset};
use crate::failure::{Failure, Outcome};
use crate::frame::{Picture, render};
use crate::report::data::{Bound, Check, Experiment};
use crate::report::table::{Column, Table};
use crate::report::{self, Section};
use crate::scene_args::{SceneArgs, Setup};
use crate::technique::{Options, Technique};

/// Side of the picture in which the exact reference is timed; units: pixels.
const EXACT_SIDE: u32 = 512;

/// How long the exact reference takes at 512², where that is asked of it.
pub(super) fn exact_times(context: &Context, found: &mut Experiment, section: &mut Section) -> Outcome {
    if context.preset == Preset::Smoke {
        return Ok(());
    }
    let mut table = Table::new(
        "The exact reference at 512²",
        vec![
            Column::left("scene"),
            Column::right("triangles"),
            Column::right("airlight (error 0)"),
            Column::right("airlight per pixel"),
            Column::right("view rays"),
            Column::right("triangles looked at, per pixel"),
        ],
    );
    let mut time = |name: &str, setup: &Setup| -> Outcome<f64> {
        let bvh = Bvh::build(&setup.scene).map_err(Failure::program)?;
        let picture = exact(setup, &bvh, &format!("{name}: exact at {EXACT_SIDE}²"))?;
        let pixels = f64::from(EXACT_SIDE).powi(2);
        table.push(vec![
            name.into(),
            report::count(setup.scene.triangle_count() as u64),
            report::time(picture.ms),
            report::time(picture.ms / pixels),
            report::time(picture.ms_view_rays),
            report::figure(candidates(setup, &bvh)),
        ]);
        Ok(picture.ms_frame())
    };
    let sphere = SceneArgs::default().resolve("procedural:sphere-plane")?;
    time("procedural:sphere-plane", &sphere)?;
    for source in context.setups.sources().iter().filter(|source| source.entry.id == "sponza") {
        let Some((_, depth)) = context.setups.media().next() else { continue };
        let ms = time(&source.title(), &source.setup(depth)?)?;
        found.checks.push(Check::new(
            format!("the exact reference on {} at 512² takes less than 60 s", source.title()),
            "predicted: 5 to 10 s on two cores",
            Some(ms / 1e3),
            Bound::AtMost,
            60.0,
        ));
    }
    table.note = Some("One frame each, hierarchy built before; a frame is airlight and view rays, since surfaces are black. For scale: an unbiased path tracer needs 40 to 80 minutes on such a machine for 1 % noise on the one-sphere scene.".into());
    section.tables.push(table);
    Ok(())
}

fn exact(setup: &Setup, bvh: &Bvh, label: &str) -> Outcome<Picture> {
    let options = Options { airlight_only: true, ..Options::new((EXACT_SIDE, EXACT_SIDE)) };
    render(setup, bvh, Technique::Exact, &options, None, label)
}

/// Mean number of triangles that the exact reference looks at for a pixel, over every sixteenth column and row.
fn candidates(setup: &Setup, bvh: &Bvh) -> f64 {
    let shadows = ExactShadows::new(bvh, &setup.lights);
    let (mut triangles, mut rays) = (0, 0);
    for y in (0..EXACT_SIDE).step_by(16) {
        for x in (0..EXACT_SIDE).step_by(16) {
            let ray = setup.camera.pixel_ray(x, y, (EXACT_SIDE, EXACT_SIDE));
            let end = bvh.closest_hit(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            for light in 0..setup.lights.len() {
                triangles += shadows.candidates(&ray, Interval::new(0.0, end), LightId(light));
            }
            rays += 1;
        }
    }
    triangles as f64 / f64::from(rays)
}
