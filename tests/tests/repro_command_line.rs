//! `repro` on the command line: what it refuses, and the files and fields of its report.

use airlight_tests::cli::{Desk, NO_ADAPTER, all_right, json_of, keys};
use serde_json::json;

#[test]
fn repro_refuses_what_it_does_not_know() {
    let desk = Desk::default();
    desk.write("file", "not a folder");
    all_right([
        desk.misrefused("repro nonsense --out out/r", "nonsense"),
        desk.misrefused("repro airlight-accuracy nonsense --out out/r", "nonsense"),
        desk.misrefused("repro airlight-accuracy --scenes absent --out out/r", "absent"),
        desk.misrefused("repro airlight-accuracy --scenes file --out out/r", "file"),
        desk.misrefused("repro airlight-accuracy --preset smoke --out file/r", "file/r"),
        desk.misrefused(&format!("repro airlight-accuracy --adapter {NO_ADAPTER} --out out/r"), "--adapter"),
    ]);
}

#[test]
fn repro_writes_its_report() {
    let desk = Desk::default();
    let list = desk.done("repro --list").stdout;
    assert!(list.lines().any(|line| line.starts_with("airlight-accuracy ")), "{list}");
    assert!(list.lines().all(|line| line.split_whitespace().count() > 1), "every id has a line: {list}");

    let ended = desk.done("repro airlight-accuracy --preset smoke --out out/r");
    let folder = desk.path("out/r");
    let table = std::fs::read_to_string(folder.join("airlight-accuracy/table.txt")).unwrap();
    assert!(!table.trim().is_empty() && ended.stdout.contains(table.trim()), "the table is on stdout too");
    let report = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(report.contains("airlight-accuracy") && report.contains("<svg"), "a report has plots");
    for reference in ["src=\"http", "href=\"http", "<script src", "url(http"] {
        assert!(!report.contains(reference), "the report is not self-contained: {reference}");
    }
    let data = json_of(&std::fs::read_to_string(folder.join("airlight-accuracy/data.json")).unwrap());
    for key in ["id", "source", "preset", "adapter", "git", "rows", "equal_error", "checks"] {
        assert!(data.get(key).is_some(), "{key} is missing: {:?}", keys(&data));
    }
    assert_eq!((&data["id"], &data["preset"]), (&json!("airlight-accuracy"), &json!("smoke")));
    for key in ["name", "backend", "kind"] {
        assert!(data["adapter"][key].is_string(), "adapter.{key}: {}", data["adapter"]);
    }
    let rows = data["rows"].as_array().map_or(&[][..], Vec::as_slice);
    assert!(rows.len() > 10, "{} rows", rows.len());
    for row in rows {
        for key in ROW_KEYS {
            assert!(row.get(key).is_some(), "{key} is missing from a row: {:?}", keys(row));
        }
    }
    let checks = data["checks"].as_array().map_or(&[][..], Vec::as_slice);
    assert!(!checks.is_empty(), "no claim was checked");
    for check in checks {
        for key in ["claim", "paper", "measured", "bar", "holds"] {
            assert!(check.get(key).is_some(), "{key} is missing: {check}");
        }
        assert_eq!(check["holds"], true, "{check}");
    }
}

/// What a row of `data.json` holds, null where it was not measured.
const ROW_KEYS: [&str; 21] = [
    "scene",
    "triangles",
    "technique",
    "params",
    "viewers",
    "ms_scatter",
    "ms_frame",
    "ms_min",
    "ms_max",
    "frames",
    "stages",
    "rel_rmse",
    "shadow_err",
    "nmae",
    "p99",
    "flip",
    "rays",
    "samples",
    "fragments",
    "mesh_triangles",
    "memory_bytes",
];
