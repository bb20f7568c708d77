//! What candidates take on a GPU: frames of them, drawn in turns before one is chosen.

use std::time::{Duration, Instant};

use gpu_backend::GpuContext;

use super::Pilot;
use super::candidates::Candidate;
use crate::airlight::Stage;
use crate::airlight_gpu::GpuFrame;
use crate::failure::Outcome;
use crate::median::median;
use crate::technique::{Options, Technique};

/// Rounds of a frame of each, after one in which pipelines are made.
const MOST_ROUNDS: usize = 9;

/// As many are drawn however long they take; the others only until [`LONG`] is over.
const LEAST_ROUNDS: usize = 3;
const LONG: Duration = Duration::from_secs(1);

/// Median time of a frame of the full size of each, as if its light had moved; units: ms. None for what the GPU cannot hold.
pub(super) fn times(
    gpu: &GpuContext,
    pilot: &mut Pilot<'_>,
    candidates: &[&Candidate],
) -> Outcome<Vec<Option<f64>>> {
    let all: Vec<(Technique, Options)> = candidates
        .iter()
        .map(|candidate| (candidate.technique, candidate.options.of(candidate.technique)))
        .collect();
    for (technique, options) in &all {
        pilot.make_ready(*technique, options)?;
    }
    let (setup, bvh, pilot) = (pilot.setup(), pilot.bvh(), &*pilot);
    let mut stages = Vec::new();
    for (technique, options) in &all {
        let (rays, maps) = pilot.full_size(*technique, options)?;
        stages.push(Stage { setup, bvh, options, rays, maps, further: &[], tick: &|_| () });
    }
    let mut frames: Vec<Option<(GpuFrame<'_>, Vec<f64>)>> = all
        .iter()
        .zip(&stages)
        .map(|((technique, _), stage)| {
            let mut frame = GpuFrame::new(gpu, stage, *technique).ok()?;
            frame.render(true).ok()?;
            Some((frame, Vec::new()))
        })
        .collect();
    let started = Instant::now();
    for round in 0..MOST_ROUNDS {
        if round >= LEAST_ROUNDS && started.elapsed() > LONG {
            break;
        }
        for one in &mut frames {
            let Some((frame, times)) = one else { continue };
            match frame.render(true) {
                Ok(found) => times.push(found.ms),
                Err(_) => *one = None,
            }
        }
    }
    let median_of = |(_, mut times): (GpuFrame<'_>, Vec<f64>)| {
        times.sort_by(f64::total_cmp);
        median(&times)
    };
    Ok(frames.into_iter().map(|one| one.and_then(median_of)).collect())
}
