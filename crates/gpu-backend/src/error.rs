//! What can go wrong between the program and the GPU.

use thiserror::Error;

/// A failure of the GPU path; the text says what to do about it where something can be done.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter, or none whose name holds the wanted part.
    #[error("no GPU adapter{}; found: {}", wanted.as_ref().map(|name| format!(" whose name holds \"{name}\"")).unwrap_or_default(), if found.is_empty() { "none".to_owned() } else { found.join(", ") })]
    NoAdapter {
        /// Part of a name that was asked for.
        wanted: Option<String>,
        /// Names of the adapters that there are.
        found: Vec<String>,
    },
    /// The adapter refused to make a device.
    #[error("adapter {adapter} made no device: {reason}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// Its words.
        reason: String,
    },
    /// A shader imports a file that does not exist, or itself.
    #[error("shader {file}: {reason}")]
    Shader {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A buffer is larger than the device allows.
    #[error("{what} needs {bytes} bytes, more than the {limit} of this device")]
    TooLarge {
        /// What the buffer holds.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// wgpu's validation, or the driver, refused an operation.
    #[error("{pass}: {reason}")]
    Pass {
        /// Name of the pass.
        pass: &'static str,
        /// wgpu's words.
        reason: String,
    },
}
