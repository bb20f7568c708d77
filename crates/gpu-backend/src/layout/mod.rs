//! What the shaders read, as Rust writes it: one struct a file, each with its WGSL twin.

mod light;
mod mesh;
mod view;
mod volume;

pub(crate) use light::{Basis, LightUniform};
pub(crate) use mesh::{GRID_TILE, MeshUniform, row_bits};
pub(crate) use view::{ENDLESS, ImagePlane, ViewUniform};
pub(crate) use volume::VolumeUniform;

#[cfg(test)]
pub(crate) mod tests {
    use crate::shader;

    /// Fields of a WGSL struct with their offsets, and its size.
    pub(crate) fn wgsl_struct(pass: &str, name: &str) -> (Vec<(String, u32)>, u32) {
        let module = naga::front::wgsl::parse_str(&shader::assemble(pass).unwrap()).unwrap();
        let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is a struct") };
        let offsets = members.iter().map(|m| (m.name.clone().unwrap(), m.offset)).collect();
        (offsets, *span)
    }

    /// The offsets of a Rust struct's fields, by name.
    macro_rules! offsets {
        ($ty:ty: $($field:ident),* $(,)?) => {
            vec![$((stringify!($field).to_owned(), std::mem::offset_of!($ty, $field) as u32)),*]
        };
    }
    pub(crate) use offsets;
}
