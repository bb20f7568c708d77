//! A frame of froxels from its stages, and what is kept from one frame to the next.

use glam::{UVec3, Vec3};
use scene::{Aabb, AirlightModel, Light, Medium};

use crate::accumulate::accumulate;
use crate::apply::apply;
use crate::grid::Grid;
use crate::history::History;
use crate::light_up::light_up;
use crate::lighting::Lighting;
use crate::near::NearMasks;
use crate::needs::Scout;
use crate::strongest::Strongest;
use crate::volume::{Setup, Volume};
use crate::{Counts, Frame, FroxelError, Froxels, Lit, Mask, MaskWidth, Rendered, Slices, Temporal};

/// Fog in froxels, for any number of views: the reference, or with the shared shadow grid.
#[derive(Debug)]
pub struct FroxelFog {
    froxels: Froxels,
    slices: Slices,
    grid: Option<Grid>,
    near: Vec<NearMasks>,
    views: Vec<History>,
    /// What the history was lit by.
    lit_by: Option<LitBy>,
    /// Frames since all was forgotten.
    index: u32,
}

/// What must stay the same for a history to be true.
#[derive(Debug, PartialEq)]
struct LitBy {
    lights: Vec<Light>,
    medium: Medium,
    model: AirlightModel,
    casters: Option<Aabb>,
    views: usize,
}

impl LitBy {
    fn is(&self, frame: &Frame<'_>) -> bool {
        self.lights == frame.lights
            && self.medium == *frame.medium
            && self.model == frame.model
            && self.casters == frame.casters()
            && self.views == frame.views.len()
    }
}

impl FroxelFog {
    /// Fog without a history.
    ///
    /// # Errors
    /// [`FroxelError::Setting`] names a setting that makes no sense.
    pub fn new(froxels: Froxels) -> Result<Self, FroxelError> {
        froxels.check()?;
        Ok(Self {
            froxels,
            slices: Slices::new(&froxels),
            grid: None,
            near: Vec::new(),
            views: Vec::new(),
            lit_by: None,
            index: 0,
        })
    }

    /// Forgets the history and the grid: for a cut of the cameras, or of the scene.
    pub fn forget(&mut self) {
        self.grid = None;
        self.views.clear();
        self.lit_by = None;
        self.index = 0;
    }

    /// Renders the next frame.
    ///
    /// The grid goes on from the frame before, and so do views of the same index and size where there is
    /// [`Temporal`].
    ///
    /// # Errors
    /// [`FroxelError`] for too many lights, a view whose sizes do not match, or voxels too small for the casters'
    /// box.
    pub fn render(&mut self, frame: &Frame<'_>) -> Result<Rendered, FroxelError> {
        frame.check()?;
        let bits = self.froxels.grid().map_or(MaskWidth::of(frame.lights.len()), |grid| grid.lights).bits();
        let setup = Setup {
            frame,
            froxels: &self.froxels,
            slices: &self.slices,
            jitter: self.froxels.temporal.map_or(0.5, |_| Temporal::jitter(self.index)),
            index: self.index,
            scout: Scout::new(frame),
            strongest: Strongest::new(frame.lights, bits),
        };
        let mut grid = match (self.froxels.grid(), frame.casters()) {
            (Some(_), Some(casters)) if self.grid.as_ref().is_some_and(|grid| grid.covers(&casters)) => {
                self.grid.take()
            }
            (Some(settings), Some(casters)) => Some(Grid::new(&self.froxels, settings, &casters)?),
            _ => None,
        };

        let mut counts = Counts::default();
        let mut volumes = Vec::with_capacity(frame.views.len());
        self.near.clear();
        for view in frame.views {
            let (volume, froxels) = Volume::new(&setup, view);
            let (near, rays) = NearMasks::trace(&setup, &volume);
            counts += froxels + rays;
            volumes.push(volume);
            self.near.push(near);
        }
        if let Some(grid) = &mut grid {
            counts += grid.update(&setup, &volumes);
        }

        let lighting = Lighting::new(frame.medium, frame.lights, frame.model);
        let mut lit = Vec::with_capacity(volumes.len());
        for (volume, near) in volumes.iter().zip(&self.near) {
            let (values, froxels) = light_up(&setup, &lighting, volume, near, grid.as_ref());
            counts += froxels;
            lit.push(values);
        }
        self.grid = grid;
        self.keep(frame, &volumes, lit);

        let views = frame.views.iter().zip(&volumes).zip(&self.views);
        let airlight = views.map(|((view, volume), history)| {
            let ends = accumulate(volume, &history.lit, &self.slices, lighting.sigma_t());
            apply(view, &volume.layout, &self.slices, &ends)
        });
        let airlight: Vec<Vec<Vec3>> = airlight.collect();
        self.index = self.index.wrapping_add(1);
        Ok(Rendered { airlight, counts })
    }

    /// Blends the history into lit froxels, and makes them the next one.
    fn keep(&mut self, frame: &Frame<'_>, volumes: &[Volume], lit: Vec<Vec<Lit>>) {
        let mut old = std::mem::take(&mut self.views).into_iter();
        let most = self.froxels.temporal.map_or(1, |temporal| temporal.frames);
        if let Some(temporal) = self.froxels.temporal
            && !self.lit_by.as_ref().is_some_and(|lit_by| lit_by.is(frame))
        {
            if !temporal.keeps_changed {
                old = Vec::new().into_iter();
            }
            self.lit_by = Some(LitBy {
                lights: frame.lights.to_vec(),
                medium: frame.medium.clone(),
                model: frame.model,
                casters: frame.casters(),
                views: frame.views.len(),
            });
        }
        for (volume, mut lit) in volumes.iter().zip(lit) {
            let before = old.next().filter(|history| most > 1 && history.layout.size == volume.layout.size);
            let frames = before.as_ref().map_or(1, |history| (history.frames + 1).min(most));
            if let Some(history) = before {
                history.blend(&self.slices, volume, 1.0 / frames as f32, &mut lit);
            }
            self.views.push(History { layout: volume.layout, lit, frames });
        }
    }

    /// Froxels of a view as the last frame left them; column fastest, then row, then slice. Empty for a view that was
    /// not there.
    pub fn lit(&self, view: usize) -> &[Lit] {
        self.views.get(view).map_or(&[], |view| &view.lit)
    }

    /// Masks of a view's own cells in the last frame, those of its shadow frustum or all of the reference; column
    /// fastest, then row, then slice. Empty for a view that was not there.
    pub fn near_masks(&self, view: usize) -> &[Mask] {
        self.near.get(view).map_or(&[], |near| &near.masks)
    }

    /// The mask of a voxel of the grid (`level` 0) or of the finer one (1), and what of it the last frame traced;
    /// `None` where nothing is kept.
    pub fn voxel(&self, level: usize, voxel: UVec3) -> Option<Mask> {
        let store = &self.grid.as_ref()?.store;
        let lattice = store.lattices.get(level)?;
        if voxel.cmplt(lattice.dims).all() { store.mask((level, voxel)) } else { None }
    }

    /// Lattices of the grid: itself, and the finer one. Empty without a grid.
    pub fn lattices(&self) -> &[crate::Lattice] {
        self.grid.as_ref().map_or(&[], |grid| &grid.store.lattices)
    }
}
