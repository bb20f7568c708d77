//! `repro --keep`: tables for the repository, which say nothing of the machine's folders.

use airlight_tests::cli::{Desk, all_right};
use airlight_tests::glb::Glb;
use serde_json::Value;

#[test]
fn tables_are_kept_without_the_machines_folders() {
    let desk = Desk::default();
    // a scenes folder of one's own, whose name must not get into the tables
    std::fs::create_dir(desk.path("private")).unwrap();
    desk.write("private/sphere_20k.glb", Glb::triangle().bytes());
    let kept = desk.path("out/kept");
    let words = "repro error-budget --preset smoke --backend cpu --out out/r --scenes";
    let mut words: Vec<String> = words.split(' ').map(str::to_owned).collect();
    words.extend([desk.path("private").display().to_string(), "--keep".into(), kept.display().to_string()]);
    let ended = desk.run_words(&words);
    assert_eq!(ended.code, 0, "{}", ended.stderr);

    let index: Value = serde_json::from_slice(&std::fs::read(kept.join("index.json")).unwrap()).unwrap();
    let [entry] = &index.as_array().unwrap()[..] else { panic!("one experiment ran: {index}") };
    assert_eq!(entry["command"], "cargo xtask repro error-budget --preset smoke --backend cpu --scenes DIR");
    assert!(entry["adapter"]["name"].is_string() && entry["git"].is_string(), "{entry}");
    let folder = kept.join(entry["folder"].as_str().unwrap());
    let texts =
        [kept.join("index.json"), kept.join("README.md"), folder.join("data.json"), folder.join("table.txt")]
            .map(|path| std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())));
    let data: Value = serde_json::from_str(&texts[2]).unwrap();
    let whole: Value =
        serde_json::from_slice(&std::fs::read(desk.path("out/r/error-budget/data.json")).unwrap()).unwrap();
    for key in ["adapter", "command", "git", "rows", "checks", "notes"] {
        assert!(!data[key].is_null() && data[key] == whole[key], "{key} differs from that of the run");
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2, "tables alone are kept");
    let home = desk.path("").display().to_string();
    for text in &texts {
        for place in [home.trim_end_matches('/'), "private", env!("CARGO_MANIFEST_DIR")] {
            assert!(!text.contains(place), "{place} is in:\n{text}");
        }
    }
}

#[test]
fn what_cannot_be_kept_is_refused_before_anything_runs() {
    let desk = Desk::default();
    desk.write("file", "");
    std::fs::create_dir_all(desk.path("full/adapter/experiment")).unwrap();
    desk.write("full/adapter/experiment/data.json", "{}");
    let repro = "repro airlight-accuracy --preset smoke --out r";
    all_right([
        desk.misrefused(&format!("{repro} --keep file/kept"), "--keep file/kept"),
        desk.misrefused(&format!("{repro} --keep full"), "data.json"),
    ]);
}
