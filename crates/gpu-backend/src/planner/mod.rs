//! What a frame needs, chosen from what is known of it: plain values in, a technique and its reason out.
//!
//! A scene pays for what it has. A light that nothing shadows is one closed-form evaluation a pixel; what varies in space
//! is marched, or lit in froxels that all views share; and where several techniques give the same picture, the one of
//! least predicted cost that meets the target error is taken. Costs are counts of operations ([`Operation`]) times what
//! one takes on a device ([`Costs`]); errors are those that a technique usually has ([`usual_error`]), unless somebody
//! measures them on the scene and hands them to [`choose_by`].
//!
//! Nothing here touches a GPU. A host that has its own maps asks for one technique a frame:
//!
//! ```
//! use gpu_backend::planner::{Costs, Facts, LightFacts, LightKind, MapFacts, MediumFacts, ShadowFacts, choose};
//!
//! let map = MapFacts { side: 1024, changed: true };
//! let lamp = LightFacts { kind: LightKind::Spot, textured: false, shadows: ShadowFacts::Map(map) };
//! let facts = Facts {
//!     lights: &[lamp],
//!     medium: MediumFacts::default(),
//!     views: 1,
//!     pixels: 1280 * 720,
//!     triangles: 100_000,
//!     diagonal: 20.0,
//!     casts_rays: false,
//!     target_error: 0.01,
//! };
//! let choice = choose(&facts, None, &Costs::SOFTWARE);
//! assert!(choice.predicted_error <= 0.01);
//! println!("{:?}: {}", choice.technique, choice.reasons[0]);
//! ```

mod candidates;
mod choice;
mod costs;
mod facts;
mod usual_error;

pub use candidates::{Candidate, candidates};
pub use choice::{Choice, choose, choose_by, reason};
pub use costs::{Costs, Operation};
pub use facts::{Facts, LightFacts, LightKind, MapFacts, MediumFacts, ShadowFacts};
pub use usual_error::usual_error;
