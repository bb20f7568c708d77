//! What the fuzz targets of `fuzz/` do with their bytes; the tests replay their seeds through the same functions.

mod gltf;
mod parameters;
mod techniques;

pub use gltf::gltf;
pub use parameters::Case;
pub use techniques::render;
