//! The Stanford polygon format, as text or binary, read by the crate `ply-rs-bw`.

use glam::Vec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, Property, PropertyAccess, PropertyAccessResult};
use scene::Scene;

use super::read::plain;

struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Vec3::NAN)
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.0.x,
            "y" => &mut self.0.y,
            "z" => &mut self.0.z,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *place = value;
        PropertyAccessResult::Set
    }
}

struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        // both names are in use
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        let Some(indices) = value.to_u32_list() else { return PropertyAccessResult::UnsupportedType };
        self.0 = indices;
        PropertyAccessResult::Set
    }
}

/// Reads `vertex` and `face` elements, polygons as fans of triangles; strips are not read.
pub(super) fn read(bytes: &[u8]) -> Result<Scene, String> {
    let mut reader = Reader::new(bytes);
    let vertices = Parser::<Vertex>::new();
    let header = vertices.read_header(&mut reader).map_err(|e| e.to_string())?;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        // an element without properties takes no bytes, however many the header counts
        if element.count > bytes.len() {
            return Err(format!("{} elements {name:?} in {} bytes", element.count, bytes.len()));
        }
        match name.as_str() {
            "vertex" => {
                let read = vertices.read_payload_for_element(&mut reader, element, &header);
                positions.extend(read.map_err(|e| e.to_string())?.into_iter().map(|vertex| vertex.0));
            }
            "face" => {
                let read = Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header);
                for Face(polygon) in read.map_err(|e| e.to_string())? {
                    let pairs = polygon.get(1..).unwrap_or_default().windows(2);
                    triangles.extend(pairs.map(|pair| [polygon[0], pair[0], pair[1]]));
                }
            }
            _ => {
                let other = Parser::<DefaultElement>::new();
                other.read_payload_for_element(&mut reader, element, &header).map_err(|e| e.to_string())?;
            }
        }
    }
    plain(positions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
        property uchar red\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

    #[test]
    fn text_and_binary_are_read() {
        let text = format!(
            "ply\nformat ascii 1.0\n{HEADER}0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3\n3 0 1 2\n"
        );
        let scene = read(text.as_bytes()).unwrap();
        assert_eq!(scene.triangle_count(), 3);
        assert_eq!(scene.meshes[0].positions()[2], Vec3::new(1.0, 1.0, 0.0));

        let mut binary = format!("ply\nformat binary_big_endian 1.0\n{HEADER}").into_bytes();
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f32]] {
            binary.extend(x.to_be_bytes());
            binary.extend(f64::from(y).to_be_bytes());
            binary.extend([0, 0, 0, 0, 9]);
        }
        for polygon in [&[0, 1, 2, 3_i32][..], &[0, 1, 2]] {
            binary.push(polygon.len() as u8);
            binary.extend(polygon.iter().flat_map(|index| index.to_be_bytes()));
        }
        assert_eq!(read(&binary).unwrap(), scene);
        for end in 0..binary.len() {
            assert!(read(&binary[..end]).is_err(), "cut at {end}");
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let faces = |line: &str| {
            format!("ply\nformat ascii 1.0\n{HEADER}0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n3 0 1 2\n{line}\n")
        };
        assert!(read(faces("3 0 1 3").as_bytes()).is_ok());
        for line in ["3 0 1 4", "3 0 1 -1", "3 0 1", "-3 0 1 2", "300 0 1 2", "3 0 1 x", ""] {
            assert!(read(faces(line).as_bytes()).is_err(), "{line}");
        }
        let endless =
            "ply\nformat binary_little_endian 1.0\nelement nothing 18446744073709551615\nend_header\n";
        assert!(read(endless.as_bytes()).is_err());
        let no_z =
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n";
        assert!(read(no_z.as_bytes()).is_err());
    }
}
