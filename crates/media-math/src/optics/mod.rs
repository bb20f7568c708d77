//! The optics, one quantity a file.

pub(crate) mod airlight;
pub(crate) mod airlight_table;
pub(crate) mod boundary;
pub(crate) mod closed_form;
pub(crate) mod composite;
pub(crate) mod directional;
pub(crate) mod equiangular;
mod exponential_integral;
pub mod foot;
pub(crate) mod medium;
pub(crate) mod phase;
pub(crate) mod special;
