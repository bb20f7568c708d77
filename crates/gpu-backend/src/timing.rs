//! Times of a frame's passes by the device's own clock.
//!
//! Stamps are written with every encoded frame and mapped only when they are asked for: a host may encode several frames
//! before it submits one, and a buffer that is mapped by then could not be submitted.

use crate::checked::{prepared, read_buffer};
use crate::{PassTime, PrepareError, ReadError};

const WHAT: &str = "pass times";

/// Bytes of a stamp.
const STAMP: u64 = size_of::<u64>() as u64;

/// Stamps before and after each pass of a frame.
#[derive(Debug)]
pub(crate) struct PassTimer {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Passes that there are stamps for.
    capacity: u32,
    /// Names of the passes of the last encoded frame, until they are read.
    encoded: Vec<String>,
}

impl PassTimer {
    /// Most passes of a frame that can be timed.
    const MOST: u32 = wgpu::QUERY_SET_MAX_QUERIES / 2;

    /// A timer of `passes` passes: `old`, if it has stamps for them; `None` where the device has no clock, or nothing is
    /// to be timed.
    pub(crate) fn reserve(
        device: &wgpu::Device,
        old: Option<Self>,
        passes: usize,
    ) -> Result<Option<Self>, PrepareError> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        if let Some(mut old) = old.filter(|old| old.capacity as usize >= passes) {
            old.encoded.clear();
            return Ok(Some(old));
        }
        let capacity = u32::try_from(passes.next_power_of_two()).unwrap_or(Self::MOST).min(Self::MOST);
        if passes > capacity as usize {
            return Ok(None);
        }
        let size = 2 * STAMP * u64::from(capacity);
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let timer = prepared(device, WHAT, || Self {
            stamps: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(WHAT),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * capacity,
            }),
            resolved: buffer("pass stamps", Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            readback: buffer("pass times readback", Usage::MAP_READ | Usage::COPY_DST),
            capacity,
            encoded: Vec::new(),
        })?;
        Ok(Some(timer))
    }

    /// Where pass number `pass` of a frame leaves its stamps.
    pub(crate) fn writes(&self, pass: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        }
    }

    /// The same for a draw.
    pub(crate) fn draw_writes(&self, pass: u32) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        }
    }

    /// Encodes what makes the stamps of a frame's passes readable.
    pub(crate) fn resolve<'a>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        names: impl Iterator<Item = &'a str>,
    ) {
        self.encoded = names.map(str::to_owned).collect();
        let count = self.encoded.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&self.stamps, 0..2 * count, &self.resolved, 0);
            let bytes = 2 * STAMP * u64::from(count);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, bytes);
        }
    }

    /// Times of the last encoded frame, once it is submitted; empty if they were read before.
    pub(crate) fn read(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<Vec<PassTime>, ReadError> {
        let names = std::mem::take(&mut self.encoded);
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let stamps: Vec<[u64; 2]> =
            read_buffer(device, &self.readback, 2 * STAMP * names.len() as u64, WHAT)?;
        let period = f64::from(queue.get_timestamp_period()) * 1e-6;
        // a clock that stands still, or stamps that were not written, say nothing
        let time = |[before, after]: [u64; 2]| {
            (before > 0 && after > before).then(|| (after - before) as f64 * period)
        };
        Ok(names.into_iter().zip(stamps).map(|(name, stamps)| PassTime { name, ms: time(stamps) }).collect())
    }
}
