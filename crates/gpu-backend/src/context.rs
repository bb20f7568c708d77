//! A device of one's own, without a window.

use crate::GpuError;

/// A headless device with its queue and what is known of its adapter.
#[derive(Debug)]
pub struct GpuContext {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver, backend and kind of the adapter.
    pub info: wgpu::AdapterInfo,
}

impl GpuContext {
    /// Opens an adapter: one whose name holds `adapter`, whatever the case, or the first that there is, hardware
    /// before software.
    ///
    /// The device is made with WebGPU's default limits and no optional feature.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] names the adapters that were found; [`GpuError::NoDevice`] says why one refused.
    pub fn headless(adapter: Option<&str>) -> Result<Self, GpuError> {
        pollster::block_on(Self::open(adapter))
    }

    async fn open(wanted: Option<&str>) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let mut adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
        // stable: the driver's order otherwise
        adapters.sort_by_key(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu);
        let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
        let matches =
            |name: &String| wanted.is_none_or(|part| name.to_lowercase().contains(&part.to_lowercase()));
        let Some(adapter) = names.iter().position(matches).map(|index| &adapters[index]) else {
            return Err(GpuError::NoAdapter { wanted: wanted.map(str::to_owned), found: names });
        };
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor { label: Some("airlight"), ..Default::default() };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|e| GpuError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        Ok(Self { device, queue, info })
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
