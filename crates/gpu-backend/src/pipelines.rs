//! Pipelines that are compiled once, whatever number of fogs they serve.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::CreateError;

/// Compiled pipelines of a device, made when something first needs them and kept for all that is given the same.
///
/// A fog compiles for the lights, media and techniques that it meets, which takes a driver tens of milliseconds a pipeline.
/// Fogs that take the same [`FogDescriptor::pipelines`](crate::FogDescriptor::pipelines) compile each once for all of them.
/// Copies share what is kept; it goes with the last of them.
#[derive(Debug, Clone)]
pub struct Pipelines {
    device: wgpu::Device,
    kept: Arc<Mutex<Kept>>,
}

/// By all that tells a pipeline from others on the same device.
#[derive(Debug, Default)]
struct Kept {
    compute: HashMap<String, wgpu::ComputePipeline>,
    drawing: HashMap<String, wgpu::RenderPipeline>,
}

impl Pipelines {
    /// None yet.
    pub fn new(device: &wgpu::Device) -> Self {
        Self { device: device.clone(), kept: Arc::default() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.with(|kept| kept.compute.len() + kept.drawing.len())
    }

    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The compute pipeline of this name, made if there is none.
    pub(crate) fn compute(
        &self,
        name: String,
        make: impl FnOnce() -> Result<wgpu::ComputePipeline, CreateError>,
    ) -> Result<wgpu::ComputePipeline, CreateError> {
        if let Some(pipeline) = self.with(|kept| kept.compute.get(&name).cloned()) {
            return Ok(pipeline);
        }
        // others may compile meanwhile; of two that are the same one is kept
        let made = make()?;
        Ok(self.with(|kept| kept.compute.entry(name).or_insert(made).clone()))
    }

    /// The render pipeline of this name, made if there is none.
    pub(crate) fn drawing(
        &self,
        name: String,
        make: impl FnOnce() -> Result<wgpu::RenderPipeline, CreateError>,
    ) -> Result<wgpu::RenderPipeline, CreateError> {
        if let Some(pipeline) = self.with(|kept| kept.drawing.get(&name).cloned()) {
            return Ok(pipeline);
        }
        let made = make()?;
        Ok(self.with(|kept| kept.drawing.entry(name).or_insert(made).clone()))
    }

    fn with<T>(&self, act: impl FnOnce(&mut Kept) -> T) -> T {
        // whoever panicked left the maps whole
        act(&mut self.kept.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
