//! Bytes as cameras, lights, media and meshes, all of them through public constructors.
//!
//! A case is tame or wild. Tame numbers are those of scenes, lamps and fog, from nothing to a kilometre and a
//! megawatt: what is accepted of them must give finite pictures. Wild ones are any `f32`: what is accepted of those may
//! overflow, and must not panic.

use std::sync::Arc;

use arbitrary::{Result, Unstructured};
use glam::{DVec2, DVec3, Vec3};
use media_math::{Lobe, PhaseFunction};
use scene::{
    Aabb, AirlightModel, Camera, Density, DensityGrid, DirectionalLight, Light, LightTexture, Material,
    Medium, Mesh, PointLight, RgbMedium, Scene, SpotLight, TextureFilter,
};
use shadowmap::{
    Bias, DepthEncoding, DepthMap, DepthOrder, Filter, MapSurface, Outside, Projection, ProjectionKind,
};

/// `f32`s at the borders of what there is.
const WILD: [f32; 12] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -0.0,
    1e15,
    -1e15,
    1e30,
    1e-30,
];

/// Bytes that are being taken for values.
#[derive(Debug)]
pub struct Case<'a> {
    bytes: Unstructured<'a>,
    /// Whether any `f32` may come.
    pub wild: bool,
}

impl<'a> Case<'a> {
    /// A case from its bytes; where those end, all is zeros.
    ///
    /// # Errors
    /// None that is known: an error ends the case.
    pub fn new(bytes: &'a [u8]) -> Result<Self> {
        let mut bytes = Unstructured::new(bytes);
        let wild = bytes.arbitrary()?;
        Ok(Self { bytes, wild })
    }

    /// A number between two others, its limits and 0 more often than the rest, or a wild one.
    pub(crate) fn number(&mut self, low: f32, high: f32) -> Result<f32> {
        let share: u16 = self.bytes.arbitrary()?;
        Ok(match share {
            0..0x400 => low,
            0x400..0x800 => high,
            0x800..0xc00 => 0.0_f32.clamp(low, high),
            0xc00..0x1400 if self.wild => *self.bytes.choose(&WILD)?,
            0x1400..0x1800 if self.wild => f32::from_bits(self.bytes.arbitrary()?),
            share => low + (high - low) * f32::from(share) / 65535.0,
        })
    }

    /// A number of any order of magnitude between two positive ones, or 0.
    pub(crate) fn magnitude(&mut self, low: f32, high: f32) -> Result<f32> {
        let exponent = self.number(low.log10(), high.log10())?;
        Ok(if self.flag()? { 10_f32.powf(exponent) } else { 0.0 })
    }

    pub(crate) fn flag(&mut self) -> Result<bool> {
        self.bytes.arbitrary()
    }

    pub(crate) fn count(&mut self, low: u32, high: u32) -> Result<u32> {
        self.bytes.int_in_range(low..=high)
    }

    pub(crate) fn one_of<T: Copy>(&mut self, values: &[T]) -> Result<T> {
        self.bytes.choose(values).copied()
    }

    /// Coordinates that often coincide.
    pub(crate) fn point(&mut self) -> Result<Vec3> {
        let coarse = self.flag()?;
        let mut at = || -> Result<f32> {
            let value = self.number(-3.0, 3.0)?;
            Ok(if coarse { value.round() } else { value })
        };
        Ok(Vec3::new(at()?, at()?, at()?))
    }

    fn colour(&mut self, low: f32, high: f32) -> Result<[f32; 3]> {
        let grey = self.magnitude(low, high)?;
        if self.flag()? {
            Ok([grey; 3])
        } else {
            Ok([grey, self.magnitude(low, high)?, self.magnitude(low, high)?])
        }
    }

    /// A box, now and then without an inside.
    pub(crate) fn bounds(&mut self) -> Result<Aabb> {
        let (a, b) = (self.point()?, self.point()?);
        Ok(Aabb::around([a, b]))
    }

    /// Up to eight triangles, degenerate ones too.
    pub(crate) fn scene(&mut self) -> Result<Option<Scene>> {
        let count = self.count(0, 8)?;
        let mut positions = Vec::new();
        for _ in 0..count + 2 {
            positions.push(self.point()?);
        }
        let mut triangles = Vec::new();
        for _ in 0..count {
            // one index more than there is, where all else is wild
            let last = count + 1 + u32::from(self.wild);
            triangles.push([self.count(0, last)?, self.count(0, last)?, self.count(0, last)?]);
        }
        let Ok(mesh) = Mesh::new(positions, triangles, 0) else { return Ok(None) };
        Ok(Some(Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() }))
    }

    pub(crate) fn camera(&mut self) -> Result<Option<Camera>> {
        let (eye, target) = (self.point()?, self.point()?);
        let up = if self.flag()? { Vec3::Y } else { self.point()? };
        let fov = self.number(0.01, 3.1)?;
        Ok(Camera::look_at(eye, target, up, fov).ok())
    }

    pub(crate) fn light(&mut self) -> Result<Option<Light>> {
        let position = self.point()?;
        let power = Vec3::from(self.colour(1e-6, 1e6)?);
        Ok(match self.count(0, 3)? {
            0 => PointLight::new(position, power).ok().map(Light::Point),
            1 => DirectionalLight::new(position, power).ok().map(Light::Directional),
            kind => {
                let way = self.point()?;
                let outer = self.number(0.0, 1.57)?;
                let inner = self.number(0.0, 1.0)? * outer;
                let texture = if kind == 3 { self.texture()? } else { None };
                let spot = SpotLight::new(position, way, inner, outer, power).ok();
                spot.map(|spot| Light::Spot(SpotLight { texture, ..spot }))
            }
        })
    }

    pub(crate) fn lights(&mut self, most: u32) -> Result<Vec<Light>> {
        let mut lights = Vec::new();
        for _ in 0..self.count(0, most)? {
            lights.extend(self.light()?);
        }
        Ok(lights)
    }

    fn texture(&mut self) -> Result<Option<Arc<LightTexture>>> {
        let (width, height) = (self.count(0, 4)?, self.count(0, 4)?);
        let mut texels = Vec::new();
        for _ in 0..width * height {
            texels.push([self.number(0.0, 2.0)?, self.number(0.0, 2.0)?, self.number(0.0, 2.0)?]);
        }
        let filter = self.one_of(&[TextureFilter::Nearest, TextureFilter::Linear])?;
        Ok(LightTexture::new(width, height, texels, filter).ok().map(Arc::new))
    }

    fn phase(&mut self) -> Result<PhaseFunction<f32>> {
        let (g, share) = (self.number(-0.99, 0.99)?, self.number(0.0, 1.0)?);
        let phase = match self.count(0, 4)? {
            0 => Ok(PhaseFunction::ISOTROPIC),
            1 => PhaseFunction::henyey_greenstein(g),
            2 => PhaseFunction::rayleigh_mie(g, share),
            3 => PhaseFunction::single(Lobe::HoffmanPreethamMie { g }),
            _ => PhaseFunction::mixture(&[
                (share, Lobe::Isotropic),
                (1.0 - share, Lobe::HenyeyGreenstein { g }),
            ]),
        };
        Ok(phase.unwrap_or_default())
    }

    fn density(&mut self) -> Result<Option<Density>> {
        if self.flag()? {
            return Ok(Density::height(self.number(-3.0, 3.0)?, self.magnitude(1e-3, 1e3)?).ok());
        }
        let size = [self.count(0, 3)?, self.count(0, 3)?, self.count(0, 3)?];
        let bounds = self.bounds()?;
        let mut values = Vec::new();
        for _ in 0..size.iter().product() {
            values.push(self.number(0.0, 4.0)?);
        }
        Ok(DensityGrid::new(size, bounds, values).ok().map(Density::Grid))
    }

    pub(crate) fn medium(&mut self) -> Result<Option<Medium>> {
        let Ok(coefficients) = RgbMedium::new(self.colour(1e-8, 1e3)?, self.colour(1e-8, 1e3)?) else {
            return Ok(None);
        };
        let phase = self.phase()?;
        let bounds = if self.count(0, 3)? == 0 { Some(self.bounds()?) } else { None };
        let density = if self.count(0, 3)? == 0 { self.density()? } else { None };
        let glow = if self.count(0, 7)? == 0 { self.magnitude(1e-3, 1e3)? } else { 0.0 };
        let emission = if glow.is_finite() { [glow, 0.5 * glow, 0.0] } else { [0.0; 3] };
        Ok(Some(Medium { coefficients, phase, bounds, density, emission }))
    }

    pub(crate) fn model(&mut self) -> Result<AirlightModel> {
        self.one_of(&[AirlightModel::Sun, AirlightModel::Sun, AirlightModel::HoffmanPreetham])
    }

    pub(crate) fn bias(&mut self) -> Result<Bias> {
        let values = [self.number(0.0, 0.1)?, self.number(0.0, 2.0)?, self.number(0.0, 1.0)?];
        Ok(Bias::new(values[0], values[1], values[2]).unwrap_or(Bias::NONE))
    }

    pub(crate) fn filter(&mut self) -> Result<Filter> {
        let width = self.count(0, 40)?;
        Ok(Filter::pcf(width).unwrap_or(Filter::Nearest))
    }

    pub(crate) fn surface(&mut self) -> Result<MapSurface> {
        self.one_of(&[MapSurface::Step, MapSurface::Linear])
    }

    /// A projection by itself, of no light.
    pub(crate) fn projection(&mut self) -> Result<Option<Projection>> {
        let (at, way, right) = (self.point()?.as_dvec3(), self.point()?.as_dvec3(), self.point()?.as_dvec3());
        let half = DVec2::new(f64::from(self.magnitude(1e-3, 1e3)?), f64::from(self.magnitude(1e-3, 1e3)?));
        let projection = match self.count(0, 2)? {
            0 => Projection::perspective(at, way, right, half),
            1 => Projection::orthographic(at, way, right, half),
            _ => Projection::cube(at),
        };
        let near = self.magnitude(1e-5, 1.0)?;
        Ok(projection.and_then(|projection| projection.with_near(near)).ok())
    }

    /// A map that a host hands over.
    pub(crate) fn hosts_map(&mut self, projection: Projection) -> Result<Option<DepthMap>> {
        let size = (self.count(0, 5)?, self.count(0, 5)?);
        let size = if projection.kind() == ProjectionKind::Cube { (size.0, size.0) } else { size };
        let encoding = match self.count(0, 2)? {
            0 => DepthEncoding::Planar,
            1 => DepthEncoding::Distance,
            _ => DepthEncoding::Device {
                order: self.one_of(&[DepthOrder::Forward, DepthOrder::Reversed])?,
                near: self.magnitude(1e-3, 1.0)?,
                far: if self.flag()? { f32::INFINITY } else { self.magnitude(1.0, 1e3)? },
            },
        };
        let most = if matches!(encoding, DepthEncoding::Device { .. }) { 1.0 } else { 10.0 };
        let mut values = Vec::new();
        for _ in 0..projection.faces().len() as u32 * size.0 * size.1 {
            values.push(if self.count(0, 7)? == 0 { f32::INFINITY } else { self.number(0.0, most)? });
        }
        let outside = self.one_of(&[Outside::Lit, Outside::Dark])?;
        let map = DepthMap::from_host(projection, size, values, encoding).ok();
        Ok(if self.flag()? { map } else { map.map(|map| map.with_outside(outside)) })
    }

    /// A distance along a ray; units: m; may be infinite.
    pub(crate) fn end(&mut self) -> Result<f64> {
        Ok(if self.flag()? { f64::INFINITY } else { f64::from(self.magnitude(1e-3, 1e3)?) })
    }

    pub(crate) fn size(&mut self) -> Result<(u32, u32)> {
        Ok((self.count(1, 4)?, self.count(1, 4)?))
    }

    /// Fails for a value that a tame case must not lead to.
    pub(crate) fn check(&self, what: &str, value: DVec3) {
        assert!(self.wild || value.is_finite(), "{what}: {value}");
    }
}
