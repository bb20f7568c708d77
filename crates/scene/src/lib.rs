//! What a view with fog is made of: rays, cameras, lights, media, meshes; and where it comes from.
//!
//! The vocabulary needs no feature and no file. On top of it, each behind a feature:
//!
//! | feature | gives |
//! | --- | --- |
//! | `gltf` | [`import`]: glTF 2.0 (`.glb`, `.gltf`) with cameras, lights, media and light textures |
//! | `bvh` | [`Bvh`]: hierarchy over the triangles; nearest hit, shadow rays, and the triangles near a plane region; [`WideBvh`], the form for GPUs |
//! | `procedural` | [`procedural`]: generated scenes of the papers' triangle counts |
//!
//! ```
//! use glam::Vec3;
//! use scene::{Bvh, Camera, Interval, Medium, procedural};
//!
//! // a ball of 1 m on the ground, seen from 4 m
//! let ball = procedural::generate("sphere")?;
//! let camera = Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::Y, Vec3::Y, 45_f32.to_radians())?;
//! let ray = camera.pixel_ray(256, 256, (512, 512));
//! let bvh = Bvh::build(&ball)?;
//! let hit = bvh.closest_hit(&ray, f64::INFINITY).ok_or("the ball is in the middle")?;
//! assert!((hit.distance - 3.0).abs() < 1e-3);
//!
//! // what is left of its light when it arrives through haze of 2 % a metre
//! let haze = Medium::homogeneous([0.015; 3], [0.005; 3])?;
//! let path = haze.optical_path(&ray, Interval::new(0.0, hit.distance));
//! let transmittance = (-f64::from(haze.coefficients.sigma_t()[0]) * path).exp();
//! assert!((transmittance - 0.9418).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! Metres; right-handed, Y up, cameras look along −Z of their node. Point and spot lights by radiant intensity
//! (W/sr), directional lights by irradiance (W/m²); results are radiance (W/(m²·sr)), linear RGB. `distance` is
//! Euclidean metres along a ray. Image row 0 is at the top, pixel and texel centres lie at +0.5. Vertices, lights and
//! media are `f32`; the exact reference promotes the very same values to `f64`.
//!
//! # Shadows are two questions
//!
//! [`Visibility`] asks how much of a light arrives at a point, [`LitIntervals`] which pieces of a view ray a light
//! reaches. Every technique answers one of the two, and adds a form of the airlight integral.

mod aabb;
#[cfg(feature = "bvh")]
mod bvh;
mod camera;
mod cone;
mod error;
#[cfg(feature = "gltf")]
pub mod import;
mod light;
mod medium;
mod medium_path;
mod mesh;
#[cfg(feature = "procedural")]
pub mod procedural;
mod ray;
mod refusal;
mod scene;
mod visibility;

pub use aabb::Aabb;
#[cfg(feature = "bvh")]
pub use bvh::{Bvh, BvhVisibility, Hit, PlaneRegion, Triangle, WideBvh, WideNode};
pub use camera::Camera;
pub use error::SceneError;
pub use light::{
    DirectionalLight, Light, LightId, LightTexture, PointLight, SpotCone, SpotLight, TextureFilter,
};
pub use medium::{AirlightModel, Density, DensityGrid, Medium, RgbMedium};
pub use mesh::Mesh;
pub use ray::{DRay, Interval, Ray};
pub use refusal::Refusal;
pub use scene::{Material, Scene};
pub use visibility::{LitIntervals, Unoccluded, Visibility};
