//! What `repro` leaves behind: for every experiment a folder with text, data, pictures and plots, and one report over
//! all of them.
//!
//! An experiment builds a [`Section`]; [`Section::write`] makes its folder, [`write_report`] the page. Times and
//! errors appear together or not at all: in tables by [`rows::measurements`], beside pictures because [`Cost`] has no
//! way to hold one without the other.

mod escape;
mod html;
mod number;
mod plot;
mod section;
mod ticks;

pub(crate) mod data;
pub(crate) mod rows;
pub(crate) mod table;

pub(crate) use html::{RunInfo, write_report};
pub(crate) use number::{MISSING, bytes, count, error, figure, ratio, time};
pub(crate) use plot::{Axis, Plot, Series};
pub(crate) use section::{Cost, Panel, PanelKind, PictureRow, Section};
