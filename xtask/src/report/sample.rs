//! A report over invented data, for looking at and for the rules that every report keeps.

use super::super::bars::{Bar, Bars, Quantity};
use super::super::data::{Bound, Check, EqualError, Experiment, Row};
use super::super::plot::{Axis, Plot, Series};
use super::super::section::{Cost, Panel, PanelKind, PictureRow};
use super::super::table::{Column, Table};
use super::*;
use crate::image_file::{Image, error_picture, to_srgb8};
use crate::metrics::Metrics;

fn halo(wobble: f32) -> Image {
    let pixel = |i: u32| {
        let (x, y) = ((i % 96) as f32 / 96.0 - 0.4, (i / 96) as f32 / 96.0 - 0.5);
        let light = (0.03 / (0.01 + x * x + y * y)) * (1.0 + wobble * (40.0 * x).sin() * y);
        let shaft = if (3.0 * x - y).sin() > 0.3 { 0.4 } else { 1.0 };
        [light * shaft, 0.9 * light * shaft, 0.7 * light * shaft]
    };
    Image { width: 96, height: 96, pixels: (0..96 * 96).map(pixel).collect() }
}

fn experiment_data(id: &str) -> Experiment {
    let mut rows = Vec::new();
    for (scene, triangles, slow) in [("sphere", 1280, 1.0), ("columned hall <windows>", 262_267, 3.2)] {
        for (technique, samples, ms, err) in [
            ("brute force", 150, 11.2, 0.031),
            ("hybrid", 50, 3.41, 0.0124),
            ("light volume", 0, 0.734, 2.5e-5),
        ] {
            let mut row = Row::new(scene, technique);
            row.triangles = Some(triangles);
            if samples > 0 {
                row.params.insert("samples".into(), samples.into());
            }
            (row.ms_scatter, row.ms_min, row.ms_max) =
                (Some(ms * slow), Some(ms * slow * 0.9), Some(ms * slow * 1.3));
            row.ms_frame = Some(ms * slow + 0.8);
            (row.shadow_err, row.rel_rmse, row.p99) = (Some(err), Some(err / 9.0), Some(err / 2.0));
            (row.flip, row.shadow_err_map) = (Some(0.6 * err), Some(err / 3.0));
            row.map_surface = Some("step".into());
            row.samples = Some(512 * 512 * samples);
            row.memory_bytes = Some(4 << 22);
            if samples > 0 {
                row.stages = [("faces".into(), 0.2 * ms * slow), ("march".into(), 0.8 * ms * slow)].into();
            }
            rows.push(row);
        }
    }
    rows.push(Row { ms_scatter: Some(77.7), ..Row::new("sphere", "untested") });
    let mut slower =
        Check::new("faster on a hall with windows, too", "Table 1", Some(1.3), Bound::AtLeast, 2.4);
    slower.note = Some("Measured on a software adapter.".into());
    Experiment {
        id: id.into(),
        title: Some("Hybrid against brute-force marching".into()),
        source: "Wyman & Ramsey 2008, Table 1".into(),
        preset: "quick".into(),
        adapter: Adapter { name: "llvmpipe".into(), backend: "vulkan".into(), kind: "software".into() },
        git: "0123abc".into(),
        command: Some(format!("cargo xtask repro {id} --preset quick")),
        rows,
        equal_error: vec![EqualError {
            scene: "sphere".into(),
            metric: "shadow_err".into(),
            target: 0.02,
            ms: [("brute force".into(), Some(20.1)), ("hybrid".into(), Some(2.4)), ("froxel".into(), None)]
                .into(),
            speedup_over_brute_force: [("brute force".into(), Some(1.0)), ("hybrid".into(), Some(8.4))]
                .into(),
        }],
        checks: vec![
            Check::new(
                "hybrid at 50 samples is 2.4 to 7.1 times as fast as brute force at 150",
                "Table 1",
                Some(3.28),
                Bound::AtLeast,
                2.4,
            ),
            slower,
            Check::new("needs a textured spotlight", "Table 1", None, Bound::AtLeast, 1.8),
        ],
        notes: vec!["Pictures are 128 pixels wide instead of 1024 & have \"one\" light.".into()],
        ..Experiment::default()
    }
}

fn sample(id: &str) -> Section {
    let (exact, march) = (halo(0.0), halo(0.05));
    let metrics = Metrics {
        rel_rmse: 0.01,
        nmae: 0.02,
        p99: 0.1,
        max_abs: 1.0,
        flip: 0.012,
        nan: 0,
        shadow_err: Some(0.031),
    };
    let shown = |image: &Image| to_srgb8(image, 0.5);
    let panels = vec![
        Panel::new("exact.png", "Exact", "A halo with dark shafts", &shown(&exact), PanelKind::Plain)
            .unwrap(),
        Panel::new(
            "march.png",
            "Brute force, 150 samples",
            "The same with bands",
            &shown(&march),
            PanelKind::Measured(Cost::new(11.2, &metrics)),
        )
        .unwrap(),
        Panel::new(
            "march-error.png",
            "Its error",
            "Bands of error",
            &error_picture(&march, &exact).unwrap(),
            PanelKind::ErrorMap,
        )
        .unwrap(),
    ];
    let curve = |label: &str, ms: f64, err: f64, slope: f64| Series {
        label: label.into(),
        points: (0..6).map(|i| (ms * 2.0_f64.powi(i), err * 2.0_f64.powf(slope * f64::from(i)))).collect(),
        joined: true,
    };
    let mut series = vec![
        curve("brute force", 1.1, 0.3, -0.9),
        curve("hybrid", 0.9, 0.11, -1.2),
        curve("hybrid, quarter resolution, bilateral", 0.3, 0.12, -0.6),
        curve("froxel", 0.5, 0.4, -0.4),
        curve("shared grid", 0.7, 0.45, -0.3),
        Series { label: "light volume".into(), points: vec![(0.73, 0.002)], joined: true },
        Series { label: "exact".into(), points: vec![(900.0, 0.0)], joined: false },
    ];
    series[5].joined = false;
    let mut table = Table::new(
        "Frames per second, as Table 1 has them",
        vec![Column::left("scene"), Column::right("time"), Column::right("shadow error")],
    );
    table.push(vec!["sphere <1>".into(), "3.41 ms".into(), "1.24 %".into()]);
    Section {
        experiment: experiment_data(id),
        tables: vec![table],
        plots: vec![Plot {
            file: "pareto.svg".into(),
            title: "Time against error, sphere".into(),
            caption: "Down and to the left is better. One point for every number of samples.".into(),
            x: Axis::new("time of the fog", "ms"),
            y: Axis::new("shadow error", ""),
            series,
        }],
        bars: vec![Bars {
            file: "budget.svg".into(),
            title: "What the error is made of".into(),
            caption: "Each source by itself.".into(),
            quantity: Quantity::Error,
            bars: vec![Bar::plain("shadow map, 1024²", 0.02), Bar::plain("50 steps", 0.005)],
        }],
        pictures: vec![PictureRow { caption: "Sphere, optical depth 0.3, one point light.".into(), panels }],
    }
}

fn run_info() -> RunInfo {
    RunInfo {
        preset: "quick".into(),
        adapter: experiment_data("x").adapter,
        git: "0123abc".into(),
        date: Some("2026-01-02".into()),
        command: "cargo xtask repro --preset quick".into(),
        notes: vec!["Sizes are scaled down for this preset.".into()],
    }
}

/// The tags of a page in order, without their attributes; void elements left out.
fn tags(page: &str) -> Vec<String> {
    let tags = page
        .split('<')
        .skip(1)
        .filter_map(|rest| rest.split(['>', ' ', '\n', '/']).next().map(|name| (name, rest)));
    tags.filter(|(name, rest)| {
        let itself_closed = rest.split('>').next().is_some_and(|tag| tag.ends_with('/'));
        !itself_closed && !["!DOCTYPE", "meta", "img"].contains(name)
    })
    .map(
        |(name, rest)| {
            if name.is_empty() { format!("/{}", &rest[1..rest.find('>').unwrap()]) } else { name.to_owned() }
        },
    )
    .collect()
}

#[test]
fn every_tag_is_closed_in_order() {
    let page = render(&[sample("one"), sample("two")], &run_info()).unwrap();
    let mut open = Vec::new();
    for tag in tags(&page) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop().as_deref(), Some(name), "still open: {open:?}"),
            None => open.push(tag),
        }
    }
    assert_eq!(open, [""; 0]);
}

#[test]
fn texts_are_escaped() {
    let page = render(&[sample("one")], &run_info()).unwrap();
    assert!(page.contains("columned hall &lt;windows&gt;") && !page.contains("<windows>"));
    assert!(page.contains("Wyman &amp; Ramsey") && page.contains("&quot;one&quot;"));
}

#[test]
fn the_page_stands_alone() {
    let page = render(&[sample("one")], &run_info()).unwrap();
    for loader in ["src=\"http", "href=\"http", "url(", "@import", "<link", "<script", "<iframe"] {
        assert!(!page.contains(loader), "{loader}");
    }
    let images: Vec<&str> =
        page.split("<img ").skip(1).map(|rest| &rest[..rest.find('>').unwrap()]).collect();
    assert_eq!(images.len(), 3);
    for image in images {
        assert!(
            image.contains("src=\"data:image/png;base64,") && image.contains(" alt=\""),
            "an image lacks its text"
        );
        assert!(!image.contains("alt=\"\""), "an empty alternative text hides the image");
    }
}

#[test]
fn headings_go_down_one_step_at_a_time_and_links_arrive() {
    let page = render(&[sample("one"), sample("two")], &run_info()).unwrap();
    let levels: Vec<usize> =
        tags(&page).iter().filter_map(|tag| tag.strip_prefix('h')?.parse().ok()).collect();
    assert_eq!(levels[0], 1);
    assert!(levels.windows(2).all(|pair| pair[1] <= pair[0] + 1 && pair[1] > 1), "{levels:?}");
    for link in page.split("href=\"#").skip(1).map(|rest| &rest[..rest.find('"').unwrap()]) {
        assert_eq!(page.matches(&format!(" id=\"{link}\"")).count(), 1, "{link}");
    }
}

#[test]
fn times_and_errors_stand_together() {
    let section = sample("one");
    let page = render(std::slice::from_ref(&section), &run_info()).unwrap();
    assert!(section.text().contains("11.2 ms, shadow error 3.10 %, relative RMSE 1.00 %, FLIP 0.0120"));
    assert!(page.contains("<span>11.2 ms</span>, <span>shadow error 3.10 %</span>"));
    // the row without an error keeps its time to itself
    assert!(!page.contains("77.7") && !section.text().contains("77.7"));
    for table in section.result_tables().iter().chain(&section.measurements()) {
        let has = |word: &str| table.columns.iter().any(|column| column.name.contains(word));
        assert_eq!(has("time"), has("error"), "{}", table.title);
    }
}

#[test]
fn verdicts_are_words() {
    let page = render(&[sample("one")], &run_info()).unwrap();
    for verdict in
        [">holds<", ">does not hold<", ">not measured<", "1 of 3 claims hold, 1 does not, 1 not measured"]
    {
        assert!(page.contains(verdict), "{verdict}");
    }
}

#[test]
fn nothing_to_report_is_a_page_too() {
    let page = render(&[], &RunInfo::default()).unwrap();
    assert!(page.contains("0 experiments"));
}

#[test]
fn a_folder_holds_what_the_contract_lists() {
    let out = tempfile::tempdir().unwrap();
    sample("one").write(out.path()).unwrap();
    write_report(&out.path().join("report.html"), &[sample("one")], &run_info()).unwrap();
    let read = |name: &str| std::fs::read_to_string(out.path().join(name)).unwrap();
    let data: Experiment = serde_json::from_str(&read("one/data.json")).unwrap();
    assert_eq!(data.rows, experiment_data("one").rows);
    let listed: Vec<&str> = data.pictures.iter().chain(&data.plots).map(|file| file.file.as_str()).collect();
    assert_eq!(
        listed,
        ["exact.png", "march.png", "march-error.png", "pareto.svg", "budget.svg", "stages.svg", "memory.svg"]
    );
    for file in listed {
        assert!(out.path().join("one").join(file).is_file(), "{file}");
    }
    let text = read("one/table.txt");
    assert!(text.contains("does not hold") && text.contains("cargo xtask repro one"), "{text}");
    assert!(read("report.html").starts_with("<!DOCTYPE html>"));
}
