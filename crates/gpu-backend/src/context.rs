//! A device of one's own, without a window.

use crate::capabilities::{optional_features, required_features, required_limits};
use crate::{Capabilities, ContextError, Pipelines};

/// A headless device with its queue and what is known of its adapter.
#[derive(Debug)]
pub struct GpuContext {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver, backend and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    /// Pipelines that fogs of the device share if they are made with them, by
    /// [`FogDescriptor::pipelines`](crate::FogDescriptor::pipelines).
    pub pipelines: Pipelines,
}

/// How much a headless device is made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeviceFeatures {
    /// WebGPU's default limits and no optional feature: what runs everywhere.
    Core,
    /// WebGPU's default limits, or the adapter's own where those are larger, and every optional feature that is of use.
    #[default]
    Everything,
}

impl GpuContext {
    /// Opens an adapter with everything of use that it has: one whose name holds `adapter`, whatever the case, or the
    /// first that there is, hardware before software.
    ///
    /// # Errors
    /// [`ContextError::NoAdapter`] names the adapters that were found; [`ContextError::NoDevice`] says why one refused.
    pub fn headless(adapter: Option<&str>) -> Result<Self, ContextError> {
        Self::open(adapter, DeviceFeatures::Everything)
    }

    /// As [`GpuContext::headless`], with as much as `features` says.
    ///
    /// # Errors
    /// As [`GpuContext::headless`].
    pub fn open(adapter: Option<&str>, features: DeviceFeatures) -> Result<Self, ContextError> {
        pollster::block_on(Self::open_async(adapter, features))
    }

    async fn open_async(wanted: Option<&str>, features: DeviceFeatures) -> Result<Self, ContextError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let mut adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
        // stable: the driver's order otherwise
        adapters.sort_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
        let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
        let matches =
            |name: &String| wanted.is_none_or(|part| name.to_lowercase().contains(&part.to_lowercase()));
        let Some(adapter) = names.iter().position(matches).map(|index| &adapters[index]) else {
            return Err(ContextError::NoAdapter { wanted: wanted.map(str::to_owned), found: names });
        };
        let info = adapter.get_info();
        let (required_features, required_limits) = match features {
            DeviceFeatures::Core => (required_features(), required_limits()),
            DeviceFeatures::Everything => {
                (required_features() | (optional_features() & adapter.features()), adapter.limits())
            }
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("airlight"),
            required_features,
            required_limits,
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|e| ContextError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        let pipelines = Pipelines::new(&device);
        Ok(Self { device, queue, info, pipelines })
    }

    /// Which paths the device gets.
    pub fn capabilities(&self) -> Capabilities {
        Capabilities::of(&self.device)
    }
}

/// What kind of adapter it is, in words.
pub fn software_or_hardware(info: &wgpu::AdapterInfo) -> &'static str {
    match info.device_type {
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Other => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_that_is_not_there_is_named() {
        let error = GpuContext::headless(Some("no such adapter")).unwrap_err();
        assert!(error.to_string().contains("no such adapter"), "{error}");
    }
}
