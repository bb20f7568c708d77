//! The text of a document into the types of the crate `gltf`, after which every reference in it can be followed.

use super::error::{ImportError, one_line, quoted};
use super::notes::Notes;
use super::{mend, typed, validate};
use gltf::Document;
use gltf::json::{Asset, Root};
use serde::Deserialize;
use serde_json::Value;

/// Parses and checks a document; what it uses and is not read is noted.
pub(super) fn parse(text: &[u8], notes: &mut Notes) -> Result<Document, ImportError> {
    // serde_json stops at a nesting of 128, so that no text can exhaust the stack
    let mut json: Value = serde_json::from_slice(text).map_err(|error| ImportError::Json(one_line(error)))?;
    mend::values(&mut json);
    check_head(&json, notes)?;
    if mend::take_animations(&mut json) {
        notes.add("animations are ignored", "the document");
    }
    mend::scenes(&mut json);
    let mut root: Root = typed::read(json, "")?;
    mend::lights(&mut root);
    validate::validate(&root)?;
    Ok(Document::from_json_without_validation(root))
}

/// What is looked at before anything else: in another version, nothing else means the same.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
    #[serde(default)]
    extensions_used: Vec<String>,
}

fn check_head(json: &Value, notes: &mut Notes) -> Result<(), ImportError> {
    let head: Head = typed::read(json, "")?;
    let version = head.asset.version;
    if version.split('.').next() != Some("2") {
        return Err(ImportError::at(
            "asset.version",
            format!("only glTF 2 can be read, got {}", quoted(&version)),
        ));
    }
    if let Some(least) = head.asset.min_version.filter(|least| least != "2.0") {
        let reason = format!("only glTF 2.0 can be read, got {}", quoted(&least));
        return Err(ImportError::at("asset.minVersion", reason));
    }
    if let Some(name) = head.extensions_required.into_iter().find(|name| !is_known(name)) {
        return Err(ImportError::Extension(name));
    }
    for name in head.extensions_used {
        if name == "KHR_materials_pbrSpecularGlossiness" {
            notes.add("specular-glossiness colours are ignored", &quoted(&name));
        } else if !is_known(&name) {
            notes.add("this extension is ignored", &quoted(&name));
        }
    }
    Ok(())
}

/// Whether a file that uses this extension is read fully, or as fully as if the extension were not there.
fn is_known(extension: &str) -> bool {
    // surfaces are a base colour and nothing else, so what refines materials and textures does no harm
    let harmless = ["KHR_materials_", "EXT_materials_", "KHR_texture_", "EXT_texture_", "KHR_xmp"];
    extension == "KHR_lights_punctual" || harmless.iter().any(|prefix| extension.starts_with(prefix))
}
