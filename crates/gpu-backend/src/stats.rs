//! What a frame did and what it cost.

/// What the last prepared frame consists of.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct FrameStats {
    /// Every pass in order, by name.
    pub passes: Vec<String>,
    /// Steps of marches over all pixels and lights, at most: a ray outside a light's reach takes none. Of a view that is
    /// sampled adaptively those of its first rays; how many more follow is found on the GPU
    /// ([`Fog::read_traced_rays`](crate::Fog::read_traced_rays)).
    pub samples: u64,
    /// Shadow rays of marches, at most: one a step.
    pub rays: u64,
    /// Triangles of the hierarchies that shadow rays go through, summed over lights.
    pub triangles: u64,
    /// Fragments that [`Fog::composite`](crate::Fog::composite) shades in all views.
    pub fragments: u64,
    /// Lights whose airlight is one closed-form evaluation a pixel.
    pub closed_forms: u32,
    /// Pyramids that the frame builds; those of lights that stand still are kept.
    pub pyramids_built: u32,
    /// Tessellations of light volumes that the frame makes; those of lights that stand still are kept.
    pub tessellations_built: u32,
    /// Silhouettes that the frame finds; those of lights that stand still are kept.
    pub silhouettes_found: u32,
    /// Maps that the frame reads.
    pub maps: u32,
    /// Memory of the views, the maps that are read and the light and density textures; units: bytes.
    pub bytes: u64,
}

/// Time of one pass on the GPU.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub name: String,
    /// Units: ms; `None` where the device has no timestamps or they came back empty.
    pub ms: Option<f64>,
}
