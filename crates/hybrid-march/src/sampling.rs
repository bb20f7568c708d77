//! For which view rays of a picture airlight is computed.

use crate::Adaptive;

/// For which view rays of a picture airlight is computed; the others take it from their neighbours.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Sampling {
    /// For every pixel.
    #[default]
    Pixels,
    /// For blocks of pixels, in two layers that a filter spreads over the pixels by their depth (Wyman and Ramsey 2008,
    /// section 3.3); see [`LowResolution`](crate::LowResolution).
    Blocks {
        /// Pixels along the side of a block; 1 to 64.
        scale: u32,
        /// Whether pixels within two pixels of a depth edge are computed anew. Sharper edges for about a quarter of the time
        /// of a full picture on a software adapter, which cannot leave out the others for free.
        anew_at_edges: bool,
    },
    /// For pixels around which airlight changes by more than an error that is accepted.
    Adaptive(Adaptive),
}

impl Sampling {
    /// Pixels along the side of a block.
    pub fn scale(&self) -> u32 {
        match self {
            Self::Blocks { scale, .. } => *scale,
            _ => 1,
        }
    }

    /// Blocks of pixels, or every pixel at a scale of 1.
    pub fn blocks(scale: u32) -> Self {
        if scale == 1 { Self::Pixels } else { Self::Blocks { scale, anew_at_edges: false } }
    }

    /// The adaptive sampling, if it is one.
    pub fn adaptive(&self) -> Option<&Adaptive> {
        match self {
            Self::Adaptive(adaptive) => Some(adaptive),
            _ => None,
        }
    }
}
