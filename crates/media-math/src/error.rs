//! What can be wrong with a medium, a phase function or a table.

use thiserror::Error;

/// A parameter of a medium or of a phase function that has no physical meaning.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MediumError {
    /// σ_s, σ_a or another coefficient is negative or not finite.
    #[error("{name} must be finite and at least 0 per metre, got {value}")]
    Coefficient {
        /// The coefficient's name.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// The asymmetry g of a Henyey-Greenstein lobe is outside (−1, 1).
    #[error("g must lie strictly between -1 and 1, got {value}")]
    Asymmetry {
        /// What was given.
        value: f64,
    },
    /// The weight of a lobe in a mixture is outside [0, 1], or the weights do not sum to 1.
    #[error("the weights of a phase mixture must lie in [0, 1] and sum to 1, got {value}")]
    Weight {
        /// The weight, or the sum.
        value: f64,
    },
    /// A mixture has no lobe, or more lobes than fit.
    #[error("a phase mixture needs 1 to {max} lobes, got {count}")]
    LobeCount {
        /// What was given.
        count: usize,
        /// The most that fit.
        max: usize,
    },
}

/// A table that cannot be built as asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// A number for which there is no table.
    #[error("a table needs {name} that is {needed}, got {value}")]
    Value {
        /// Which.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        needed: &'static str,
    },
    /// A side is too short to interpolate on, or absurdly long.
    #[error("a table needs between 2 and 16384 entries a side, got {size}")]
    Size {
        /// What was given.
        size: usize,
    },
}
