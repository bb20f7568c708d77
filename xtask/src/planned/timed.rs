//! What a candidate takes on a GPU: frames of it, drawn before one is chosen.

use gpu_backend::GpuContext;

use super::Pilot;
use super::candidates::Candidate;
use crate::airlight::Stage;
use crate::airlight_gpu::GpuFrame;
use crate::failure::Outcome;

/// Frames beside the first, in which pipelines are made.
const FRAMES: u32 = 3;

/// Time of a frame of the full size, as if its light had moved; units: ms. Fails if the GPU cannot hold it.
pub(super) fn time(gpu: &GpuContext, pilot: &mut Pilot<'_>, candidate: &Candidate) -> Outcome<f64> {
    let options = candidate.options.of(candidate.technique);
    let (setup, bvh) = (pilot.setup(), pilot.bvh());
    let (rays, maps) = pilot.full_size(candidate.technique, &options)?;
    let stage = Stage { setup, bvh, options: &options, rays, maps, further: &[], tick: &|_| () };
    let mut frame = GpuFrame::new(gpu, &stage, candidate.technique)?;
    frame.render(true)?;
    let mut least = f64::INFINITY;
    for _ in 0..FRAMES {
        least = least.min(frame.render(true)?.ms);
    }
    Ok(least)
}
