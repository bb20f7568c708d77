//! What a technique cannot take, said instead of drawn wrongly.

use thiserror::Error;

/// A technique was asked for a feature that it does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{technique} cannot take {feature}; use {instead}")]
pub struct Refusal {
    /// The technique that refuses.
    pub technique: &'static str,
    /// What it was asked for.
    pub feature: &'static str,
    /// What does it instead.
    pub instead: &'static str,
}
