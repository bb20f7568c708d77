//! The GPU that commands run on, where there is one.

use gpu_backend::{GpuContext, software_or_hardware};

use crate::failure::{Failure, Outcome};
use crate::report::data::Adapter;

/// Opens the adapter whose name holds `wanted`, or the first that there is; none is no error unless one was named.
pub(crate) fn open(wanted: Option<&str>) -> Outcome<Option<GpuContext>> {
    match (GpuContext::headless(wanted), wanted) {
        (Ok(gpu), _) => Ok(Some(gpu)),
        (Err(error), Some(name)) => Err(Failure::input(format!("--adapter {name}: {error}"))),
        (Err(error), None) => {
            tracing::debug!("{error}");
            Ok(None)
        }
    }
}

/// What results say of the GPU that they come from.
pub(crate) fn describe(gpu: &GpuContext) -> Adapter {
    Adapter {
        name: gpu.info.name.clone(),
        backend: gpu.info.backend.to_string(),
        kind: software_or_hardware(&gpu.info).to_owned(),
    }
}

/// Whether the adapter is no software on the CPU: then its time stamps are those of its work.
pub(crate) fn is_hardware(gpu: &GpuContext) -> bool {
    gpu.info.device_type != gpu_backend::wgpu::DeviceType::Cpu
}
