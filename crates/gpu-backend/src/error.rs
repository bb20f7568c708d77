//! What can go wrong between the program and the GPU: one enum a stage.

use scene::Refusal;
use thiserror::Error;

/// Why there is no device.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ContextError {
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
}

/// Why passes cannot be made on a device.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CreateError {
    /// A shader imports a file that does not exist, or itself.
    #[error("shader {file}: {reason}")]
    Shader {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The device was made with less than the passes need.
    #[error("the device's limit {name} is {got}, and {needed} is needed")]
    Limit {
        /// Name of the limit, as in `wgpu::Limits`.
        name: &'static str,
        /// What is needed; see [`required_limits`](crate::required_limits).
        needed: u64,
        /// What the device has.
        got: u64,
    },
    /// The target's format cannot be blended into.
    #[error("a picture of format {0:?} cannot be blended into on this device")]
    Format(wgpu::TextureFormat),
    /// What the fog was to share its pipelines with belongs to another device.
    #[error("the pipelines that were given belong to another device")]
    OtherDevice,
    /// wgpu's validation, or the driver, refused a pipeline.
    #[error("{pass}: {reason}")]
    Pipeline {
        /// Name of the pass.
        pass: String,
        /// wgpu's words.
        reason: String,
    },
}

/// Why a frame, or a map for it, cannot be prepared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// More lights than fit.
    #[error("{got} lights, and {most} fit")]
    TooManyLights {
        /// Lights of the frame.
        got: usize,
        /// [`MAX_LIGHTS`](crate::MAX_LIGHTS).
        most: usize,
    },
    /// A texture or buffer is larger than the device allows.
    #[error("{what} needs {needed}, more than the {limit} of this device ({unit})")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// What it needs.
        needed: u64,
        /// The device's limit.
        limit: u64,
        /// What both count.
        unit: &'static str,
    },
    /// A view without pixels.
    #[error("view {view} has no pixels")]
    EmptyView {
        /// Its index.
        view: usize,
    },
    /// One distance a pixel is needed.
    #[error("view {view} of {pixels} pixels has {got} distances")]
    Distances {
        /// Index of the view.
        view: usize,
        /// Its pixels.
        pixels: u64,
        /// Distances given.
        got: u64,
    },
    /// One triangle index a pixel is needed.
    #[error("a view of {pixels} pixels has {got} triangle indices")]
    Triangles {
        /// Pixels of the view.
        pixels: u64,
        /// Indices given.
        got: u64,
    },
    /// A distance, or a depth plane, that is none.
    #[error("view {view}: {name} is {value}; it must {valid}")]
    Value {
        /// Index of the view.
        view: usize,
        /// What is wrong.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        valid: &'static str,
    },
    /// A host's texture does not have the format, size or usage that the pass reads.
    #[error("{what} is {got}; it must be {wanted}")]
    Texture {
        /// Which texture.
        what: &'static str,
        /// What it is.
        got: String,
        /// What would do.
        wanted: String,
    },
    /// A map that was made for another kind of light.
    #[error("light {light}: {map} map cannot serve a {kind} light")]
    WrongMap {
        /// Index of the light.
        light: usize,
        /// What kind of map it was given.
        map: &'static str,
        /// What kind of light it is.
        kind: &'static str,
    },
    /// A variance lookup needs moments.
    #[error("light {light}: the map has no moments to look up; see ShadowMap::with_moments")]
    NoMoments {
        /// Index of the light.
        light: usize,
    },
    /// A light volume is to be drawn from triangles that are not there.
    #[error("light {light}: the map has no triangles of its size; see ShadowMap::with_mesh")]
    NoMesh {
        /// Index of the light.
        light: usize,
    },
    /// The hybrid march needs the light's shadow volume.
    #[error("light {light}: there is no shadow volume to march in; see Lamp::volume")]
    NoVolume {
        /// Index of the light.
        light: usize,
    },
    /// Blocks of no pixels, or of so many that they have nothing to do with each other.
    #[error("a scattering scale of {got}; it must be from 1 to {most}")]
    ScatteringScale {
        /// Pixels along the side of a block.
        got: u32,
        /// Most of them.
        most: u32,
    },
    /// Settings of adaptive sampling without meaning.
    #[error(transparent)]
    Sampling(#[from] hybrid_march::AdaptiveError),
    /// A mesh whose edges cannot be told.
    #[error("the casters: {0}")]
    Mesh(String),
    /// A map or projection without meaning.
    #[error(transparent)]
    Map(#[from] shadowmap::ShadowMapError),
    /// Settings of froxels without meaning, or what does not fit in them.
    #[error(transparent)]
    Froxels(#[from] froxel_grid::FroxelError),
    /// The technique cannot take what the frame asks for.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A pipeline that the frame needs cannot be made.
    #[error(transparent)]
    Create(#[from] CreateError),
    /// The device is lost or out of memory, or wgpu refused the work.
    #[error("{what}: {reason}")]
    Device {
        /// What was being prepared.
        what: &'static str,
        /// wgpu's words.
        reason: String,
    },
}

/// Why results cannot be read back.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The device is lost, or wgpu refused the work.
    #[error("{what}: {reason}")]
    Device {
        /// What was being read.
        what: &'static str,
        /// wgpu's words.
        reason: String,
    },
    /// Nothing was prepared that could be read.
    #[error("there is no {0} to read")]
    Nothing(&'static str),
}

/// Any failure of the GPU path; the text says what to do about it where something can be done.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No device.
    #[error(transparent)]
    Context(#[from] ContextError),
    /// No passes.
    #[error(transparent)]
    Create(#[from] CreateError),
    /// No frame.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// No result.
    #[error(transparent)]
    Read(#[from] ReadError),
}
