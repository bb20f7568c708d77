//! A few pixels of every technique, from parameters that bytes have chosen.

use arbitrary::Result;
use froxel_grid::{
    FroxelFog, Froxels, GridMemory, GridReads, MaskWidth, Near, Shadowing, SharedGrid, Temporal, Update,
};
use glam::DVec3;
use ground_truth::{Reference, Settings};
use hybrid_march::{
    Adjacency, BruteForce, FaceBounds, Hybrid, LightMips, LowResolution, Occluders, Placement, ShadowVolume,
    bounding_box, cluster, near_viewer,
};
use lightvolume::{Anchor, Criterion, LightVolume, LightVolumes, Options, SignedAirlight, Tessellation};
use media_math::{AngleTable, Foot, FrameTable};
use scene::{
    Aabb, AirlightModel, Bvh, BvhVisibility, Camera, DRay, Interval, Light, LightId, LitIntervals, Medium,
    Scene, Visibility,
};
use shadowmap::{
    DepthMap, ExactShadowMap, MapTraversal, MapVisibility, SurfaceVisibility, VarianceMap,
    VarianceVisibility, draw_maps_for,
};

use super::Case;

/// Camera, lights, medium and triangles from `bytes`, seen through one technique: every value is finite, or is refused
/// with a typed error. A case that runs out of sense ends early.
pub fn render(bytes: &[u8]) {
    // an error of `arbitrary` is only the end of the case
    let _ = run(bytes);
}

/// What all techniques are given.
struct Show {
    scene: Scene,
    bvh: Bvh,
    camera: Camera,
    lights: Vec<Light>,
    medium: Medium,
    model: AirlightModel,
    size: (u32, u32),
    max_distance: f64,
}

fn run(bytes: &[u8]) -> Result<()> {
    let mut case = Case::new(bytes)?;
    let technique = case.count(0, 8)?;
    if technique == 8 {
        return hosts_map(&mut case);
    }
    let (Some(scene), Some(camera), Some(medium)) = (case.scene()?, case.camera()?, case.medium()?) else {
        return Ok(());
    };
    let Ok(bvh) = Bvh::build(&scene) else { return Ok(()) };
    let show = Show {
        scene,
        bvh,
        camera,
        lights: case.lights(if technique == 6 { 10 } else { 3 })?,
        medium,
        model: case.model()?,
        size: case.size()?,
        max_distance: case.end()?,
    };
    match technique {
        0 => exact(&mut case, &show),
        1 => exact_shadow_map(&mut case, &show),
        2 | 3 => brute_force(&mut case, &show),
        4 => hybrid(&mut case, &show),
        5 => light_volume(&mut case, &show),
        6 => froxels(&mut case, &show),
        _ => tables(&mut case, &show),
    }
}

impl Show {
    /// Every view ray with where it ends.
    fn rays(&self) -> impl Iterator<Item = ((u32, u32), DRay, f64)> {
        let pixels = (0..self.size.1).flat_map(|y| (0..self.size.0).map(move |x| (x, y)));
        pixels.map(|(x, y)| {
            let ray = self.camera.pixel_ray(x, y, self.size);
            let end = self.bvh.closest_hit(&ray, f64::INFINITY).map_or(self.max_distance, |hit| hit.distance);
            ((x, y), ray, end)
        })
    }

    fn maps(
        &self,
        case: &mut Case<'_>,
        surface: shadowmap::MapSurface,
    ) -> Result<Option<Vec<Option<DepthMap>>>> {
        let side = case.count(0, 9)?;
        Ok(draw_maps_for(&self.lights, &self.scene, side, surface).ok())
    }

    fn occluders<'a>(&self, visibility: &'a dyn Visibility) -> Option<Occluders<'a>> {
        let bounds = self.bvh.bounds();
        (!bounds.is_empty()).then_some(Occluders { visibility, bounds })
    }
}

fn exact(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let settings = Settings {
        airlight_only: case.flag()?,
        shadows_in_medium: case.flag()?,
        max_distance: show.max_distance,
        model: show.model,
    };
    let Show { scene, bvh, medium, lights, .. } = show;
    let Ok(reference) = Reference::new(&scene.materials, bvh, medium, lights, settings) else {
        return Ok(());
    };
    for (_, ray, _) in show.rays() {
        case.check("exact", reference.radiance(&ray));
    }
    Ok(())
}

fn exact_shadow_map(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let (surface, bias) = (case.surface()?, case.bias()?);
    let Some(maps) = show.maps(case, surface)? else { return Ok(()) };
    let Ok(shadows) = ExactShadowMap::new(&maps, &show.lights, surface, bias) else { return Ok(()) };
    let Show { scene, bvh, medium, lights, .. } = show;
    let settings = Settings { max_distance: show.max_distance, model: show.model, ..Settings::default() };
    let Ok(reference) = Reference::new(&scene.materials, bvh, medium, lights, settings) else {
        return Ok(());
    };
    let reference = reference.with_shadows(&shadows);
    for (_, ray, end) in show.rays() {
        case.check("exact-shadow-map", reference.airlight(&ray, end));
    }
    Ok(())
}

fn brute_force(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let samples = case.count(0, 9)?;
    let (surface, bias, filter) = (case.surface()?, case.bias()?, case.filter()?);
    let asked = case.count(0, 3)?;
    let maps = if asked == 0 { None } else { show.maps(case, surface)? }.unwrap_or_default();
    let moments: Vec<Option<VarianceMap>> = if asked == 3 {
        let (far, bleed, radius) = (case.magnitude(0.1, 100.0)?, case.number(0.0, 0.9)?, case.count(0, 3)?);
        let moments =
            |map: &DepthMap| VarianceMap::new(map, far)?.blurred(radius)?.with_bleed_reduction(bleed);
        maps.iter().map(|map| map.as_ref().and_then(|map| moments(map).ok())).collect()
    } else {
        Vec::new()
    };
    let by_rays = BvhVisibility::new(&show.bvh, &show.lights);
    let by_map = MapVisibility::new(&maps, filter, bias);
    let by_surface = SurfaceVisibility::new(&maps, surface, bias);
    let by_moments = VarianceVisibility::new(&moments);
    let visibility: &dyn Visibility = match asked {
        0 => &by_rays,
        1 => &by_map,
        2 => &by_surface,
        _ => &by_moments,
    };
    let march = BruteForce {
        medium: &show.medium,
        lights: &show.lights,
        occluders: show.occluders(visibility),
        samples,
        model: show.model,
    };
    for (_, ray, end) in show.rays() {
        case.check("brute-force", march.airlight(&ray, end).airlight.as_dvec3());
    }
    Ok(())
}

fn hybrid(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let corners: Vec<_> = show.scene.meshes.iter().flat_map(|mesh| mesh.corners()).collect();
    let casters = match case.count(0, 3)? {
        0 => cluster(&corners, case.count(0, 4)?),
        1 => near_viewer(&corners, show.camera.position, case.number(0.0, 5.0)?),
        2 => bounding_box(&show.bvh.bounds()),
        _ => corners,
    };
    let Ok(mesh) = Adjacency::new(casters) else { return Ok(()) };
    let volumes: Vec<_> = show.lights.iter().map(|light| ShadowVolume::new(&mesh, light)).collect();
    let (scale, margin) = (case.count(0, 3)?, f64::from(case.magnitude(1e-3, 1.0)?));
    let bounds: Vec<_> = volumes
        .iter()
        .map(|volume| FaceBounds::draw_with_margin(volume, &show.camera, show.size, scale, margin))
        .collect();
    let visibility = BvhVisibility::new(&show.bvh, &show.lights);
    let occluders = show.occluders(&visibility);
    let (samples, refine) = (case.count(0, 9)?, case.count(0, 9)?);
    let Ok(mut march) = Hybrid::new(&show.medium, &show.lights, occluders, samples, refine, show.model)
    else {
        return Ok(());
    };
    let blur = case.number(0.0, 3.0)?;
    let mips: Vec<_> = show
        .lights
        .iter()
        .map(|light| match light {
            Light::Spot(spot) => spot.texture.as_ref().map(|picture| LightMips::new(picture, blur)),
            _ => None,
        })
        .collect();
    (march.lit_samples, march.partial) = (case.count(0, 9)?, case.flag()?);
    march.placement = case.one_of(&[Placement::EqualAngle, Placement::EqualDistance])?;
    march.mips = if case.flag()? { &mips } else { &[] };
    let by_pixel = case.flag()?;
    let pixel = |(x, y): (u32, u32), ray: &DRay, end: f64| {
        let span = Interval::new(0.0, end);
        let faces: Vec<_> = volumes
            .iter()
            .zip(&bounds)
            .map(|(volume, bounds)| if by_pixel { volume.faces(ray, span) } else { bounds.at(x, y) })
            .collect();
        march.airlight(ray, end, &faces).airlight
    };
    let full: Vec<_> = show.rays().map(|(at, ray, end)| pixel(at, &ray, end)).collect();
    full.iter().for_each(|value| case.check("hybrid", value.as_dvec3()));
    let Ok(low) = LowResolution::new(show.size, scale) else { return Ok(()) };
    let ends: Vec<f32> = show.rays().map(|(_, _, end)| end as f32).collect();
    let Ok(low_ends) = low.ends(&show.camera, &ends) else { return Ok(()) };
    let columns = low.low_size().0;
    let layers = low_ends.each_ref().map(|ends| {
        let block = |(end, i): (&f32, u32)| {
            let at = (i % columns, i / columns);
            pixel(at, &low.low_ray(&show.camera, at.0, at.1), f64::from(*end))
        };
        ends.iter().zip(0..).map(block).collect::<Vec<_>>()
    });
    let low_ends = [&low_ends[0][..], &low_ends[1][..]];
    if let Ok(picture) = low.upsample(&show.camera, &ends, low_ends, [&layers[0], &layers[1]]) {
        picture.iter().for_each(|value| case.check("hybrid, upsampled", value.as_dvec3()));
    }
    let _ = low.edges(&show.camera, &ends, low_ends);
    Ok(())
}

fn options(case: &mut Case<'_>) -> Result<Options> {
    let metres = case.magnitude(1e-4, 10.0)?;
    let tessellation = match case.count(0, 3)? {
        0 => Tessellation::Static,
        1 => Tessellation::Adaptive { criterion: Criterion::Distance, threshold: metres },
        2 => Tessellation::Adaptive { criterion: Criterion::Laplacian, threshold: metres },
        _ => Tessellation::Delaunay { bound: metres },
    };
    let far = if case.flag()? { None } else { Some(case.magnitude(1.0, 1e6)?) };
    Ok(Options { tessellation, far })
}

fn light_volume(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let Some(maps) = show.maps(case, shadowmap::MapSurface::Linear)? else { return Ok(()) };
    let options = options(case)?;
    let mut volumes = Vec::new();
    for map in &maps {
        let Some(map) = map else {
            volumes.push(None);
            continue;
        };
        let Ok(volume) = LightVolume::build(map, &options) else { return Ok(()) };
        assert!(case.wild || volume.validate().is_ok(), "{:?}", volume.validate());
        volumes.push(Some(volume));
    }
    let Ok(volumes) = LightVolumes::new(&volumes, &show.lights) else { return Ok(()) };
    let mut lit = Vec::new();
    for (_, ray, end) in show.rays() {
        for light in 0..show.lights.len() {
            volumes.lit_intervals(&ray, Interval::new(0.0, end), LightId(light), &mut lit);
            check_pieces(case, &lit);
        }
    }
    let anchor = case.one_of(&[Anchor::Near, Anchor::Far])?;
    if let Ok(signed) = SignedAirlight::<f32>::new(&show.medium, &volumes, anchor) {
        for (_, ray, end) in show.rays() {
            let [r, g, b] = signed.airlight(&ray, end).map(f64::from);
            case.check("light-volume, signed", DVec3::new(r, g, b));
        }
    }
    let settings = Settings { max_distance: show.max_distance, model: show.model, ..Settings::default() };
    let Show { scene, bvh, medium, lights, .. } = show;
    let Ok(reference) = Reference::new(&scene.materials, bvh, medium, lights, settings) else {
        return Ok(());
    };
    let reference = reference.with_shadows(&volumes);
    for (_, ray, end) in show.rays() {
        case.check("light-volume", reference.airlight(&ray, end));
    }
    Ok(())
}

/// Lit pieces are in order, and none is no number.
fn check_pieces(case: &Case<'_>, lit: &[Interval]) {
    let sound = lit.iter().all(|piece| piece.start <= piece.end)
        && lit.windows(2).all(|pair| pair[0].end <= pair[1].start);
    assert!(case.wild || sound, "{lit:?}");
}

fn settings_of_froxels(case: &mut Case<'_>) -> Result<Froxels> {
    let near = match case.count(0, 2)? {
        0 => Near::Grid,
        1 => Near::Frustum { side: case.count(0, 3)?, slices: case.count(0, 9)? },
        _ => Near::FineGrid { ratio: case.count(0, 4)?, slices: case.count(0, 9)? },
    };
    let alternate = case.flag()?;
    let grid = SharedGrid {
        voxel_size: case.magnitude(0.05, 10.0)?,
        near,
        update: if case.flag()? { Update::Marked { alternate } } else { Update::InFrustums { alternate } },
        memory: if case.flag()? {
            GridMemory::Dense
        } else {
            GridMemory::Bricks { most: case.count(0, 64)? }
        },
        reads: case.one_of(&[GridReads::Nearest, GridReads::Trilinear])?,
        lights: case.one_of(&[MaskWidth::Eight, MaskWidth::Sixteen, MaskWidth::ThirtyTwo])?,
    };
    Ok(Froxels {
        tile: case.count(0, 4)?,
        slices: case.count(0, 9)?,
        range: case.magnitude(0.1, 100.0)?,
        curve: case.number(0.0, 8.0)?,
        shadows: if case.flag()? { Shadowing::Traced } else { Shadowing::Shared(grid) },
        temporal: if case.flag()? {
            None
        } else {
            Some(Temporal { frames: case.count(0, 4)?, keeps_changed: case.flag()? })
        },
    })
}

fn froxels(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let froxels = settings_of_froxels(case)?;
    // wide enough that a grid over it is not all of the case's time
    if froxels
        .grid()
        .is_some_and(|grid| grid.lattice(&show.bvh.bounds()).is_ok_and(|lattice| lattice.count() > 1 << 20))
    {
        return Ok(());
    }
    let Ok(mut fog) = FroxelFog::new(froxels) else { return Ok(()) };
    let ends: Vec<f32> = show.rays().map(|(_, _, end)| end as f32).collect();
    let visibility = BvhVisibility::new(&show.bvh, &show.lights);
    let bounds: Aabb = show.bvh.bounds();
    let mut other = show.camera.clone();
    if let Some(camera) = case.camera()? {
        other = camera;
    }
    let view = |camera| froxel_grid::View { camera, size: show.size, ends: &ends };
    let views = [view(&show.camera), view(&other)];
    for frame in 0..2 {
        let frame = froxel_grid::Frame {
            views: &views[frame..],
            medium: &show.medium,
            lights: &show.lights,
            model: show.model,
            occluders: case.flag()?.then_some(froxel_grid::Occluders { visibility: &visibility, bounds }),
        };
        let Ok(rendered) = fog.render(&frame) else { return Ok(()) };
        for value in rendered.airlight.iter().flatten() {
            case.check("froxels", value.as_dvec3());
        }
    }
    Ok(())
}

/// The tables of the hybrid march, for the first point light.
fn tables(case: &mut Case<'_>, show: &Show) -> Result<()> {
    let (size, x_max) = (case.count(0, 9)? as usize, f64::from(case.magnitude(0.1, 100.0)?));
    let Some(Light::Point(light)) = show.lights.first() else { return Ok(()) };
    let medium = &show.medium.coefficients;
    let (sigma_s, sigma_t) = (f64::from(medium.sigma_s()[0]), f64::from(medium.sigma_t()[0]));
    let to_light = light.position.as_dvec3() - show.camera.position.as_dvec3();
    let distance = to_light.length();
    let intensity = f64::from(light.intensity.x);
    let printed = FrameTable::<f64>::new(size, sigma_s, sigma_t, distance, x_max);
    let angles = AngleTable::<f64>::new(size, sigma_s, sigma_t, distance);
    for (_, ray, end) in show.rays() {
        let (from, to) = (0.3 * end.min(x_max), end.min(x_max));
        if let Ok(table) = &printed {
            let cos_gamma = to_light.dot(ray.direction) / distance;
            // as printed, it diverges next to the light's direction: any value will do
            let _ = table.airlight(intensity, cos_gamma, from, to);
        }
        if let Ok(table) = &angles {
            let foot = Foot::new(to_light.to_array(), ray.direction.to_array());
            let value = table.airlight(intensity, &foot, from, end);
            assert!(case.wild || value.is_finite(), "angle table: {value}");
        }
    }
    Ok(())
}

/// A map of a host's depths by itself, asked in every way that there is.
fn hosts_map(case: &mut Case<'_>) -> Result<()> {
    let Some(projection) = case.projection()? else { return Ok(()) };
    let Some(map) = case.hosts_map(projection)? else { return Ok(()) };
    let (filter, bias, far) = (case.filter()?, case.bias()?, case.magnitude(0.1, 100.0)?);
    let (from, to) = (case.point()?.as_dvec3(), case.point()?.as_dvec3());
    let span = Interval::new(0.0, case.end()?);
    let direction = (to - from).normalize_or_zero();
    if let Ok(volume) = LightVolume::build(&map, &options(case)?) {
        assert!(case.wild || volume.validate().is_ok(), "{:?}", volume.validate());
    }
    let moments = VarianceMap::new(&map, far).ok();
    for point in [from, to] {
        let visibility = map.visibility(point, filter, bias);
        assert!((0.0..=1.0).contains(&visibility), "{visibility}");
        let visibility = map.surface_visibility(point, direction, filter, bias);
        assert!((0.0..=1.0).contains(&visibility), "{visibility}");
        let visibility = moments.as_ref().map_or(1.0, |moments| moments.visibility(point));
        assert!(case.wild || (0.0..=1.0).contains(&visibility), "{visibility}");
    }
    if direction == DVec3::ZERO {
        return Ok(());
    }
    let ray = DRay { origin: from, direction };
    let traversal = MapTraversal::new(&map, case.surface()?, bias);
    let mut lit = Vec::new();
    traversal.lit(&ray, span, &mut lit);
    check_pieces(case, &lit);
    traversal.lit_flat(&ray, span, &mut lit);
    check_pieces(case, &lit);
    Ok(())
}
