//! The froxels of one view in one frame: where they sample, and what they need.

use glam::Vec3;

use crate::needs::{Needs, Scout};
use crate::reach::reach;
use crate::strongest::Strongest;
use crate::{Counts, Frame, FroxelView, Froxels, Slices, View, parallel};

/// What all views of a frame have in common.
#[derive(Debug)]
pub(crate) struct Setup<'a> {
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) froxels: &'a Froxels,
    pub(crate) slices: &'a Slices,
    /// Where in their slices froxels sample, in (0, 1).
    pub(crate) jitter: f32,
    /// Counts frames, for what alternates.
    pub(crate) index: u32,
    pub(crate) scout: Scout<'a>,
    pub(crate) strongest: Strongest<'a>,
}

impl Setup<'_> {
    /// The sample point of a cell of `side` × `side` froxels; 1 for a froxel itself. Units: m.
    pub(crate) fn point(&self, layout: &FroxelView, [column, row, k]: [u32; 3], side: u32) -> Vec3 {
        layout.eye + self.slices.distance(k, self.jitter) * layout.direction(column, row, side)
    }

    /// Whether a light arrives at a point; a shadow ray.
    pub(crate) fn traces(&self, point: Vec3, light: usize) -> bool {
        let light = scene::LightId(light);
        self.frame.occluders.is_none_or(|occluders| occluders.visibility.visibility(point, light) >= 0.5)
    }
}

/// The froxels of a view; column fastest, then row, then slice.
#[derive(Debug)]
pub(crate) struct Volume {
    pub(crate) layout: FroxelView,
    /// By tile; units: m.
    pub(crate) reach: Vec<f32>,
    /// By froxel; nothing where it is not in front.
    pub(crate) needs: Vec<Needs>,
}

impl Volume {
    pub(crate) fn new(setup: &Setup<'_>, view: &View<'_>) -> (Self, Counts) {
        let layout = FroxelView::new(view.camera, view.size, setup.froxels.tile);
        let reach = reach(view, &layout, setup.froxels.range);
        let (columns, rows) = layout.tiles();
        let slices = setup.slices.count();
        let mut volume = Self { layout, reach, needs: Vec::new() };
        let mut needs = vec![Needs::default(); columns as usize * rows as usize * slices as usize];
        let counts = parallel::rows(&mut needs, columns as usize, |index, row| {
            let (k, y) = (index as u32 / rows, index as u32 % rows);
            let mut counts = Counts::default();
            for (x, needs) in (0..columns).zip(row) {
                if volume.in_front(setup.slices, [x, y, k]) {
                    counts.froxels += 1;
                    *needs = setup.scout.needs(setup.point(&volume.layout, [x, y, k], 1));
                }
            }
            counts
        });
        volume.needs = needs;
        (volume, counts)
    }

    /// Columns, rows and slices.
    pub(crate) fn dims(&self) -> [u32; 3] {
        let (columns, rows) = self.layout.tiles();
        [columns, rows, (self.needs.len() / self.reach.len().max(1)) as u32]
    }

    /// Whether anything is seen through a froxel, or in it.
    pub(crate) fn in_front(&self, slices: &Slices, [column, row, k]: [u32; 3]) -> bool {
        let columns = self.layout.tiles().0;
        slices.starts[k as usize] < self.reach[row as usize * columns as usize + column as usize]
    }

    /// What a froxel needs.
    pub(crate) fn needs_of(&self, [column, row, k]: [u32; 3]) -> Needs {
        let (columns, rows) = self.layout.tiles();
        self.needs[column as usize + columns as usize * (row as usize + rows as usize * k as usize)]
    }
}
