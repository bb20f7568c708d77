//! Stereolithography files, as text or binary, read by the crate `stl_io`.

use std::io::Cursor;

use glam::Vec3;
use scene::Scene;

use super::read::plain;

/// Bytes before the triangles of a binary file: 80 of any kind, and how many triangles there are.
const HEADER: usize = 84;

/// Bytes of each triangle there.
const TRIANGLE: usize = 50;

/// Reads triangles, joined where corners have equal bits.
pub(super) fn read(bytes: &[u8]) -> Result<Scene, String> {
    let mut bytes = bytes.to_vec();
    // `stl_io` takes for text what starts as text does, and so do some binary files
    if is_binary(&bytes) {
        bytes[0] = 0;
    }
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let index = |index: usize| u32::try_from(index).map_err(|_| "too many vertices".to_owned());
    let triangles = mesh.faces.iter().map(|face| {
        let [a, b, c] = face.vertices;
        Ok([index(a)?, index(b)?, index(c)?])
    });
    let triangles = triangles.collect::<Result<_, String>>()?;
    plain(mesh.vertices.iter().map(|vertex| Vec3::from(vertex.0)).collect(), triangles)
}

/// Whether the file is as long as the count in it says.
fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| bytes.len() as u64 == HEADER as u64 + u64::from(count) * TRIANGLE as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_are_read() {
        let corner = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0";
        let text =
            format!("solid a\nfacet normal 0 0 1\nouter loop\n{corner}\nendloop\nendfacet\nendsolid a\n");
        let scene = read(text.as_bytes()).unwrap();
        assert_eq!(scene.triangle_count(), 1);
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(read(&binary(b"made by", &[triangle])).unwrap(), scene);
        // a binary file that says what text starts with
        assert_eq!(read(&binary(b"solid a", &[triangle])).unwrap(), scene);
    }

    #[test]
    fn nonsense_is_refused() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, f32::NAN]];
        assert!(read(&binary(b"", &[triangle])).is_err());
        let whole = binary(b"", &[[[0.0; 3]; 3]]);
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "cut at {end}");
        }
        for text in ["solid a", "solid a\nfacet\n", "solid a\nfacet normal 0 0 x\n"] {
            assert!(read(text.as_bytes()).is_err(), "{text}");
        }
    }
}
