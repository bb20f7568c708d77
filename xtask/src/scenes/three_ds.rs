//! 3D Studio files (.3ds): chunks within chunks, of which meshes and their materials are read.
//!
//! No kept crate reads them. A chunk is a number of two bytes, its length in four with these six, and its contents;
//! what is not needed is passed over by its length. Vertices are in the scene's place already: the matrix of an object
//! says only where its axes were.

use std::collections::{BTreeMap, HashMap};

use glam::Vec3;
use scene::{Material, Mesh, Scene};

/// Numbers of the chunks that are read.
mod chunk {
    pub(super) const MAIN: u16 = 0x4d4d;
    pub(super) const EDITOR: u16 = 0x3d3d;
    pub(super) const OBJECT: u16 = 0x4000;
    pub(super) const MESH: u16 = 0x4100;
    pub(super) const VERTICES: u16 = 0x4110;
    pub(super) const FACES: u16 = 0x4120;
    pub(super) const FACES_OF_MATERIAL: u16 = 0x4130;
    pub(super) const MATERIAL: u16 = 0xafff;
    pub(super) const MATERIAL_NAME: u16 = 0xa000;
    pub(super) const DIFFUSE: u16 = 0xa020;
    pub(super) const COLOR_F32: u16 = 0x0010;
    pub(super) const COLOR_U8: u16 = 0x0011;
}

/// Reads triangles by material, as they stand in the file: there Z is up.
pub(super) fn read(bytes: &[u8]) -> Result<Scene, String> {
    let (mut materials, mut objects) = (Vec::new(), Vec::new());
    let mut file = Bytes(bytes);
    let (id, mut main) = file.chunk()?;
    if id != chunk::MAIN {
        return Err("is no 3D Studio file: it does not start with the chunk 4d4d".into());
    }
    while let Some((id, mut editor)) = main.next_chunk()? {
        if id != chunk::EDITOR {
            continue;
        }
        while let Some((id, mut contents)) = editor.next_chunk()? {
            match id {
                chunk::MATERIAL => materials.push(material(contents)?),
                chunk::OBJECT => {
                    let name = contents.text()?;
                    while let Some((id, mesh)) = contents.next_chunk()? {
                        // cameras and lights are objects too
                        if id == chunk::MESH {
                            objects
                                .push(Object::read(mesh).map_err(|what| format!("object {name:?}: {what}"))?);
                        }
                    }
                }
                _ => {}
            }
        }
    }
    let mut scene = Scene::default();
    let by_name: HashMap<String, usize> =
        materials.iter().enumerate().map(|(index, material)| (material.name.clone(), index)).collect();
    let white = materials.len();
    scene.materials = materials;
    scene.materials.push(Material { name: String::new(), base_color: [1.0; 3] });
    for object in objects {
        object.add(&mut scene, &by_name, white)?;
    }
    Ok(scene)
}

/// Triangles of one object, and which of them are of which material.
#[derive(Default)]
struct Object {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    groups: Vec<(String, Vec<u16>)>,
}

impl Object {
    fn read(mut mesh: Bytes<'_>) -> Result<Self, String> {
        let mut object = Self::default();
        while let Some((id, mut contents)) = mesh.next_chunk()? {
            match id {
                chunk::VERTICES => {
                    for _ in 0..contents.u16()? {
                        object.positions.push(Vec3::new(contents.f32()?, contents.f32()?, contents.f32()?));
                    }
                }
                chunk::FACES => {
                    for _ in 0..contents.u16()? {
                        let corners = [contents.u16()?, contents.u16()?, contents.u16()?];
                        contents.u16()?; // which edges are drawn
                        object.triangles.push(corners.map(u32::from));
                    }
                    while let Some((id, mut group)) = contents.next_chunk()? {
                        if id == chunk::FACES_OF_MATERIAL {
                            let name = group.text()?;
                            let count = group.u16()?;
                            let faces = (0..count).map(|_| group.u16()).collect::<Result<_, _>>()?;
                            object.groups.push((name, faces));
                        }
                    }
                }
                _ => {}
            }
        }
        Ok(object)
    }

    /// A mesh for each material that it has; the faces that no group names are white.
    fn add(self, scene: &mut Scene, materials: &HashMap<String, usize>, white: usize) -> Result<(), String> {
        let mut of = vec![white; self.triangles.len()];
        for (name, faces) in &self.groups {
            let material = materials.get(name).copied().unwrap_or(white);
            for face in faces {
                *of.get_mut(usize::from(*face))
                    .ok_or_else(|| format!("face {face} of material {name:?} is not there"))? = material;
            }
        }
        let mut by_material: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
        for (corners, material) in self.triangles.iter().zip(of) {
            if let Some(corner) = corners.iter().find(|corner| **corner as usize >= self.positions.len()) {
                return Err(format!("vertex {corner} is not there"));
            }
            by_material.entry(material).or_default().push(*corners);
        }
        for (material, mut triangles) in by_material {
            let (mut kept, mut positions) = (HashMap::new(), Vec::new());
            for corner in triangles.as_flattened_mut() {
                *corner = *kept.entry(*corner).or_insert_with(|| {
                    positions.push(self.positions[*corner as usize]);
                    positions.len() as u32 - 1
                });
            }
            scene.meshes.push(Mesh::new(positions, triangles, material).map_err(|e| e.to_string())?);
        }
        Ok(())
    }
}

fn material(mut contents: Bytes<'_>) -> Result<Material, String> {
    // white until it says otherwise
    let mut material = Material { name: String::new(), base_color: [1.0; 3] };
    while let Some((id, mut part)) = contents.next_chunk()? {
        match id {
            chunk::MATERIAL_NAME => material.name = part.text()?,
            chunk::DIFFUSE => {
                if let Some((id, mut color)) = part.next_chunk()? {
                    material.base_color = match id {
                        chunk::COLOR_F32 => [color.f32()?, color.f32()?, color.f32()?],
                        chunk::COLOR_U8 => {
                            [color.u8()?, color.u8()?, color.u8()?].map(|c| f32::from(c) / 255.0)
                        }
                        _ => material.base_color,
                    };
                }
            }
            _ => {}
        }
    }
    if material.base_color.iter().any(|c| c.is_nan()) {
        return Err(format!("the colour of material {:?} is not a number", material.name));
    }
    material.base_color = material.base_color.map(|c| c.clamp(0.0, 1.0));
    Ok(material)
}

/// What is left of the contents of a chunk.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("ends within a chunk")?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let taken = self.take(N)?;
        taken.try_into().map_err(|_| "ends within a chunk".into())
    }

    fn u8(&mut self) -> Result<u8, String> {
        Ok(self.array::<1>()?[0])
    }

    fn u16(&mut self) -> Result<u16, String> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn f32(&mut self) -> Result<f32, String> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    /// A name, which ends with a zero.
    fn text(&mut self) -> Result<String, String> {
        let end = self.0.iter().position(|byte| *byte == 0).ok_or("a name has no end")?;
        let text = String::from_utf8_lossy(self.take(end)?).into_owned();
        self.take(1)?;
        Ok(text)
    }

    fn chunk(&mut self) -> Result<(u16, Self), String> {
        let id = self.u16()?;
        let length = u32::from_le_bytes(self.array()?) as usize;
        let contents =
            length.checked_sub(6).ok_or_else(|| format!("chunk {id:04x} is {length} bytes long"))?;
        Ok((id, Self(self.take(contents)?)))
    }

    fn next_chunk(&mut self) -> Result<Option<(u16, Self)>, String> {
        if self.0.is_empty() { Ok(None) } else { self.chunk().map(Some) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxed(id: u16, contents: &[u8]) -> Vec<u8> {
        let length = contents.len() as u32 + 6;
        [&id.to_le_bytes()[..], &length.to_le_bytes(), contents].concat()
    }

    fn words(values: &[u16]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    fn vertices(positions: &[[f32; 3]]) -> Vec<u8> {
        let mut bytes = words(&[positions.len() as u16]);
        bytes.extend(positions.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
        boxed(chunk::VERTICES, &bytes)
    }

    /// Two triangles, of which a group has `face`, and something that nobody knows.
    fn file(positions: &[[f32; 3]], face: u16) -> Vec<u8> {
        let color = boxed(chunk::COLOR_U8, &[255, 0, 51]);
        let red = [boxed(chunk::MATERIAL_NAME, b"red\0"), boxed(chunk::DIFFUSE, &color)].concat();
        let group = boxed(chunk::FACES_OF_MATERIAL, &[&b"red\0"[..], &words(&[1, face])].concat());
        let faces = boxed(chunk::FACES, &[words(&[2, 0, 1, 2, 7, 0, 2, 3, 7]), group].concat());
        let mesh = boxed(chunk::MESH, &[boxed(0x4160, &[0; 48]), vertices(positions), faces].concat());
        let object = boxed(chunk::OBJECT, &[&b"wall\0"[..], &mesh].concat());
        let editor =
            boxed(chunk::EDITOR, &[boxed(chunk::MATERIAL, &red), boxed(0x1234, b"any"), object].concat());
        boxed(chunk::MAIN, &[boxed(2, &3_u32.to_le_bytes()), editor].concat())
    }

    const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 0.0, 2.0]];

    #[test]
    fn meshes_are_read_by_material() {
        let scene = read(&file(&SQUARE, 1)).unwrap();
        assert_eq!(scene.materials[0], Material { name: "red".into(), base_color: [1.0, 0.0, 0.2] });
        let found: Vec<_> =
            scene.meshes.iter().map(|mesh| (mesh.material, mesh.corners().next().unwrap())).collect();
        let [a, b, c, d] = SQUARE.map(Vec3::from);
        assert_eq!(found, [(0, [a, c, d]), (1, [a, b, c])]);
    }

    #[test]
    fn nonsense_is_refused() {
        let whole = file(&SQUARE, 1);
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "cut at {end}");
        }
        assert!(read(&file(&SQUARE[..3], 1)).unwrap_err().contains("vertex 3"));
        assert!(read(&file(&SQUARE, 2)).unwrap_err().contains("face 2"));
        let mut off = SQUARE;
        off[1][1] = f32::NAN;
        assert!(read(&file(&off, 0)).is_err());
        assert!(read(&boxed(chunk::EDITOR, &[])).unwrap_err().contains("4d4d"));
    }

    /// Whatever a byte is, there is an answer and no panic.
    #[test]
    fn any_byte_may_be_wrong() {
        let whole = file(&SQUARE, 1);
        for (place, value) in
            (0..whole.len()).flat_map(|place| [0, 1, 5, 0x7f, 0xff].map(|value| (place, value)))
        {
            let mut bytes = whole.clone();
            bytes[place] = value;
            let _ = read(&bytes);
        }
    }
}
