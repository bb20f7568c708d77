//! The GPU that commands run on, where there is one.

use gpu_backend::GpuContext;

use crate::failure::{Failure, Outcome};

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
