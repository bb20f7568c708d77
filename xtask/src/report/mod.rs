//! What `repro` leaves behind: for every experiment a folder with text, data, pictures and plots, and one report over
//! all of them.
//!
//! An experiment builds a [`Section`]; [`Section::write`] makes its folder, [`write_report`] the page. Times and
//! errors appear together or not at all: in tables by [`rows::measurements`], beside pictures because [`Cost`] has no
//! way to hold one without the other.

mod bars;
mod costs;
mod escape;
mod headline;
mod html;
mod kept;
mod number;
mod part;
mod plot;
mod section;
mod summary;
mod ticks;

pub(crate) mod data;
pub(crate) mod rows;
pub(crate) mod table;

pub(crate) use bars::{Bar, Bars, Quantity};
pub(crate) use html::{RunInfo, write_report};
pub(crate) use kept::Kept;
pub(crate) use number::{MISSING, bytes, count, error, figure, ratio, time};
pub(crate) use plot::{Axis, Plot, Series};
pub(crate) use section::{Cost, Panel, PanelKind, PictureRow, Section};
