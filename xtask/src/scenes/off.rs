//! The Object File Format (.off) as text: counts, vertices, polygons.

use glam::Vec3;
use scene::Scene;

use super::read::plain;

/// Reads polygons as fans of triangles; normals and colours, which the first word or more numbers tell of, are left out.
pub(super) fn read(bytes: &[u8]) -> Result<Scene, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is not text: binary .off files are not read")?;
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let mut lines = lines.filter(|line| !line.is_empty());
    let head = lines.next().ok_or("is empty")?;
    // the counts may stand behind the word
    let rest = ["OFF", "COFF", "NOFF", "CNOFF"]
        .iter()
        .find_map(|word| {
            head.strip_prefix(word).filter(|rest| rest.is_empty() || rest.starts_with(char::is_whitespace))
        })
        .ok_or_else(|| format!("starts with {head:?}, not with OFF"))?;
    let counts = if rest.trim().is_empty() { lines.next().ok_or("has no counts")? } else { rest };
    let counts = numbers::<usize>(counts)?;
    let [vertices, faces, ..] = counts[..] else { return Err("has no counts of vertices and faces".into()) };
    if vertices.saturating_add(faces) > bytes.len() {
        return Err(format!("{vertices} vertices and {faces} faces in {} bytes", bytes.len()));
    }
    let mut positions = Vec::with_capacity(vertices);
    for index in 0..vertices {
        let line = lines.next().ok_or_else(|| format!("ends before vertex {index}"))?;
        let [x, y, z, ..] = numbers::<f32>(line)?[..] else {
            return Err(format!("vertex {index} has fewer than three coordinates"));
        };
        positions.push(Vec3::new(x, y, z));
    }
    let mut triangles = Vec::with_capacity(faces);
    for index in 0..faces {
        let line = lines.next().ok_or_else(|| format!("ends before face {index}"))?;
        let mut words = line.split_whitespace();
        let count = words.next().and_then(|word| word.parse::<usize>().ok());
        let corners: Vec<u32> = words.map_while(|word| word.parse().ok()).collect();
        // a colour may follow
        let corners = count.and_then(|count| corners.get(..count));
        let corners =
            corners.ok_or_else(|| format!("face {index} does not have the corners that it counts"))?;
        let pairs = corners.get(1..).unwrap_or_default().windows(2);
        triangles.extend(pairs.map(|pair| [corners[0], pair[0], pair[1]]));
    }
    plain(positions, triangles)
}

fn numbers<T: std::str::FromStr>(line: &str) -> Result<Vec<T>, String> {
    let words = line.split_whitespace();
    words.map(|word| word.parse().map_err(|_| format!("{word:?} is not a number"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_triangles() {
        let vertices = "0 0 0\n1 0 0\n1 1 0 # a corner\n\n0 1 0\n";
        let plain = read(format!("OFF\n# by hand\n4 1 0\n{vertices}4 0 1 2 3\n").as_bytes()).unwrap();
        assert_eq!(plain.meshes[0].triangles(), [[0, 1, 2], [0, 2, 3]]);
        let colored = format!("OFF 4 2 4\n{vertices}3 0 1 2 255 0 0\n3 0 2 3 0.5 0.5 0.5 1\n");
        assert_eq!(read(colored.as_bytes()).unwrap(), plain);
    }

    #[test]
    fn nonsense_is_refused() {
        for (text, word) in [
            ("", "empty"),
            ("OFFER\n1 1 0\n", "OFFER"),
            ("OFF\n", "counts"),
            ("OFF\n3\n", "counts"),
            ("OFF\n1 x 0\n", "\"x\""),
            ("OFF\n99999999999 1 0\n", "bytes"),
            ("OFF\n2 1 0\n0 0 0\n", "vertex 1"),
            ("OFF\n1 1 0\n0 0\n3 0 0 0\n", "vertex 0"),
            ("OFF\n1 1 0\n0 0 0\n", "face 0"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0\n", "face 0"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "1"),
            ("OFF\n1 1 0\n0 0 nan\n3 0 0 0\n", ""),
        ] {
            let said = read(text.as_bytes()).unwrap_err();
            assert!(said.contains(word), "{text:?}: {said}");
        }
        assert!(read(b"OFF BINARY\n\xff\xfe").is_err());
    }
}
