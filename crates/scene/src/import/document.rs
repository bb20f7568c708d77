//! The document: its lists of objects, references between them, and what it asks of its reader.

use super::error::{ImportError, quoted};
use super::json::Item;
use super::notes::Notes;
use serde_json::Value;

/// The lists of objects that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum List {
    Accessors,
    BufferViews,
    Buffers,
    Cameras,
    Images,
    Lights,
    Materials,
    Meshes,
    Nodes,
    Scenes,
}

/// Where each list stands, and what errors call one of its objects; in the order of [`List`].
const LISTS: [(&[&str], &str); 10] = [
    (&["accessors"], "accessor"),
    (&["bufferViews"], "buffer view"),
    (&["buffers"], "buffer"),
    (&["cameras"], "camera"),
    (&["images"], "image"),
    (&["extensions", "KHR_lights_punctual", "lights"], "light"),
    (&["materials"], "material"),
    (&["meshes"], "mesh"),
    (&["nodes"], "node"),
    (&["scenes"], "scene"),
];

/// A glTF 2.0 document.
#[derive(Debug)]
pub(super) struct Document<'a> {
    root: Item<'a>,
    lists: [&'a [Value]; LISTS.len()],
}

impl<'a> Document<'a> {
    /// Looks at version, required extensions and lists.
    pub(super) fn new(json: &'a Value, notes: &mut Notes) -> Result<Self, ImportError> {
        let root = Item::document(json);
        check_version(&root)?;
        check_extensions(&root, notes)?;
        let mut lists: [&[Value]; LISTS.len()] = [&[]; LISTS.len()];
        for (list, (path, _)) in lists.iter_mut().zip(LISTS) {
            if let Some(item) = root.path(path)? {
                *list = item.array()?;
            }
        }
        if root.get("animations")?.is_some() {
            notes.add("animations are ignored", "the document");
        }
        Ok(Self { root, lists })
    }

    /// The document itself.
    pub(super) fn root(&self) -> &Item<'a> {
        &self.root
    }

    /// Number of objects in a list.
    pub(super) fn len(&self, list: List) -> usize {
        self.lists[list as usize].len()
    }

    /// All objects of a list.
    pub(super) fn all(&self, list: List) -> impl Iterator<Item = Item<'a>> {
        let word = LISTS[list as usize].1;
        self.lists[list as usize]
            .iter()
            .enumerate()
            .map(move |(index, value)| Item::object(value, word, index))
    }

    /// The object that `reference` means, with its index.
    pub(super) fn refer(&self, list: List, reference: &Item<'_>) -> Result<(usize, Item<'a>), ImportError> {
        let wanted = reference.whole()?;
        let (objects, word) = (self.lists[list as usize], LISTS[list as usize].1);
        usize::try_from(wanted)
            .ok()
            .and_then(|index| Some((index, Item::object(objects.get(index)?, word, index))))
            .ok_or_else(|| {
                reference.error(format!("there is no {word} {wanted}, the file has {}", objects.len()))
            })
    }

    /// The object that the field `key` of `item` means, if there is such a field.
    pub(super) fn follow(
        &self,
        list: List,
        item: &Item<'_>,
        key: &str,
    ) -> Result<Option<(usize, Item<'a>)>, ImportError> {
        item.get(key)?.map(|reference| self.refer(list, &reference)).transpose()
    }
}

fn check_version(root: &Item<'_>) -> Result<(), ImportError> {
    let asset = root.need("asset")?;
    let version = asset.need("version")?;
    let text = version.text()?;
    if text.split('.').next() != Some("2") {
        return Err(version.error(format!("only glTF 2 can be read, got {}", quoted(text))));
    }
    if let Some(least) = asset.get("minVersion")?
        && least.text()? != "2.0"
    {
        return Err(least.error(format!("only glTF 2.0 can be read, got {}", quoted(least.text()?))));
    }
    Ok(())
}

/// Whether a file that uses this extension is read fully, or as fully as if the extension were not there.
fn is_known(extension: &str) -> bool {
    // surfaces are a base colour and nothing else, so what refines materials and textures does no harm
    let harmless = ["KHR_materials_", "EXT_materials_", "KHR_texture_", "EXT_texture_", "KHR_xmp"];
    extension == "KHR_lights_punctual" || harmless.iter().any(|prefix| extension.starts_with(prefix))
}

fn check_extensions(root: &Item<'_>, notes: &mut Notes) -> Result<(), ImportError> {
    if let Some(required) = root.get("extensionsRequired")? {
        for name in required.elements()? {
            if !is_known(name.text()?) {
                return Err(ImportError::Extension(name.text()?.into()));
            }
        }
    }
    if let Some(used) = root.get("extensionsUsed")? {
        for name in used.elements()? {
            if !is_known(name.text()?) {
                notes.add("this extension is ignored", &quoted(name.text()?));
            }
        }
    }
    Ok(())
}
