//! Volumes are closed, oriented and conforming, whatever the map and the tessellation.

#![expect(clippy::unwrap_used, reason = "helpers of tests, which clippy does not take for tests")]

mod common;

use common::{CRITERIA, KINDS, RELIEFS, Random, Relief, adaptive, map};
use lightvolume::{Criterion, LightVolume, LightVolumeError, Options, Tessellation, VertexKind};
use proptest::prelude::*;
use shadowmap::{DepthMap, Outside, ProjectionKind};
use std::collections::HashMap;

fn build(map: &DepthMap, options: &Options) -> LightVolume {
    LightVolume::build(map, options).unwrap()
}

/// Every tessellation that a map can have.
fn all_options(kind: ProjectionKind, threshold: f32) -> Vec<Options> {
    let mut options = vec![Options::default()];
    options.extend(CRITERIA.map(|criterion| adaptive(criterion, threshold)));
    if kind != ProjectionKind::Cube {
        options.push(Options::new(Tessellation::Delaunay { bound: threshold }));
    }
    options
}

#[test]
fn every_kind_size_and_relief_is_valid() {
    let sizes = [1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 16, 17, 31, 32, 33];
    let mut checked = 0;
    for kind in KINDS {
        for (i, &columns) in sizes.iter().enumerate() {
            // on cubes the rows do not count
            let rows = if kind == ProjectionKind::Cube { &sizes[..1] } else { &sizes[..12] };
            for &rows in rows {
                for relief in RELIEFS {
                    let map = map(kind, (columns, rows), relief, &mut Random::new(i as u64));
                    for options in all_options(kind, 0.3) {
                        let volume = build(&map, &options);
                        volume.validate().unwrap_or_else(|defect| {
                            panic!("{kind:?} {columns} x {rows} {relief:?} {options:?}: {defect}")
                        });
                        checked += 1;
                    }
                }
            }
        }
    }
    assert!(checked > 8000, "{checked}");
}

#[test]
fn larger_maps_are_valid() {
    for kind in KINDS {
        for size in [(64, 64), (128, 128), (100, 37)] {
            for relief in RELIEFS {
                let map = map(kind, size, relief, &mut Random::new(7));
                for options in all_options(kind, 0.05) {
                    let volume = build(&map, &options);
                    volume.validate().unwrap_or_else(|defect| {
                        panic!("{kind:?} {size:?} {relief:?} {options:?}: {defect}")
                    });
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_threshold_is_valid(
        kind in 0..3_usize, columns in 1..80_u32, rows in 1..80_u32, relief in 0..6_usize, seed in any::<u64>(),
        log_threshold in -5.0..3.0_f32,
    ) {
        let map = map(KINDS[kind], (columns, rows), RELIEFS[relief], &mut Random::new(seed));
        for options in all_options(KINDS[kind], 10_f32.powf(log_threshold)) {
            let volume = build(&map, &options);
            prop_assert!(volume.validate().is_ok(), "{:?} {:?}", options, volume.validate());
            let statically = build(&map, &Options::default());
            prop_assert!(volume.surface_count() <= statically.surface_count());
        }
    }

    #[test]
    fn edge_neighbours_differ_by_at_most_one_level(
        kind in 0..3_usize, columns in 2..90_u32, rows in 2..90_u32, relief in 3..5_usize, seed in any::<u64>(),
        log_threshold in -3.0..1.0_f32, criterion in 0..2_usize,
    ) {
        let map = map(KINDS[kind], (columns, rows), RELIEFS[relief], &mut Random::new(seed));
        let volume = build(&map, &adaptive(CRITERIA[criterion], 10_f32.powf(log_threshold)));
        let (columns, rows) = map.size();
        // level of the leaf over every cell
        let mut levels = HashMap::new();
        for leaf in volume.leaves() {
            let side = 1 << leaf.level;
            for y in (leaf.y * side..(leaf.y + 1) * side).take_while(|&y| y < rows - 1) {
                for x in (leaf.x * side..(leaf.x + 1) * side).take_while(|&x| x < columns - 1) {
                    prop_assert!(levels.insert((leaf.face, x, y), leaf.level).is_none(), "cell twice");
                }
            }
        }
        let faces = map.projection().faces().len();
        prop_assert_eq!(levels.len(), faces * ((columns - 1) * (rows - 1)) as usize);
        for (&(face, x, y), &level) in &levels {
            for neighbour in [(face, x + 1, y), (face, x, y + 1)] {
                if let Some(&other) = levels.get(&neighbour) {
                    prop_assert!(level.abs_diff(other) <= 1, "{} beside {} at {:?}", level, other, (face, x, y));
                }
            }
        }
    }
}

#[test]
fn counts_by_hand() {
    let random = &mut Random::new(3);
    let volume = |kind, size, options: &Options, random: &mut Random| {
        build(&map(kind, size, Relief::Ramp, random), options)
    };
    // 4 × 2 cells, 12 border edges, the light
    let spot = volume(ProjectionKind::Perspective, (5, 3), &Options::default(), random);
    assert_eq!((spot.triangles().len(), spot.surface_count(), spot.vertices().len()), (16 + 12, 16, 16));
    assert!(!spot.is_shadow() && spot.leaves().is_empty());
    // a skirt of two triangles and a cap of one for each border edge
    let sun = volume(ProjectionKind::Orthographic, (5, 3), &Options::default(), random);
    assert_eq!((sun.triangles().len(), sun.vertices().len()), (16 + 3 * 12, 15 + 12 + 1));
    assert!(sun.is_shadow());
    // six faces of 3 × 3 cells, twelve strips of three cells, eight corners
    let cube = volume(ProjectionKind::Cube, (4, 4), &Options::default(), random);
    assert_eq!((cube.triangles().len(), cube.vertices().len()), (6 * 18 + 12 * 6 + 8, 96));
    // one texel a face: an octahedron
    let octahedron = volume(ProjectionKind::Cube, (1, 1), &Options::default(), random);
    assert_eq!((octahedron.triangles().len(), octahedron.vertices().len()), (8, 6));
    // nothing between the nodes of a row
    for kind in [ProjectionKind::Perspective, ProjectionKind::Orthographic] {
        let nothing = volume(kind, (9, 1), &Options::default(), random);
        assert!(nothing.triangles().is_empty() && nothing.vertices().is_empty());
    }
    assert_eq!(spot.bytes(), 16 * 20 + 28 * 12);
}

#[test]
fn a_plane_is_one_quad_and_threshold_0_keeps_every_node_that_matters() {
    let flat = map(ProjectionKind::Perspective, (65, 65), Relief::Constant, &mut Random::new(1));
    for criterion in CRITERIA {
        let volume = build(&flat, &adaptive(criterion, 0.0));
        assert_eq!((volume.leaves().len(), volume.surface_count()), (1, 2));
        assert_eq!((volume.leaves()[0].level, volume.leaves()[0].configuration), (6, 0));
    }
    let rough = map(ProjectionKind::Perspective, (33, 33), Relief::Noise, &mut Random::new(1));
    assert_eq!(build(&rough, &adaptive(Criterion::Distance, 0.0)).surface_count(), 2 * 32 * 32);
}

#[test]
fn positions_are_those_of_the_map() {
    for kind in KINDS {
        let map = map(kind, (6, 6), Relief::Spots, &mut Random::new(5));
        let volume = build(&map, &Options::default());
        assert_eq!(volume.positions().len(), volume.vertices().len());
        for (vertex, position) in volume.vertices().iter().zip(volume.positions()) {
            let at = position.truncate() / position.w;
            match vertex.kind {
                VertexKind::Surface => {
                    let expected = map.vertex(usize::from(vertex.face), vertex.x as u32, vertex.y as u32);
                    assert!((at - expected).length() < 1e-12, "{kind:?} {vertex:?}");
                }
                VertexKind::Apex => assert_eq!(at, map.projection().faces()[0].origin),
                VertexKind::Far => assert_eq!((vertex.depth, vertex.height), (volume.far(), -volume.far())),
            }
        }
    }
}

#[test]
fn nonsense_is_refused() {
    let spot = map(ProjectionKind::Perspective, (4, 4), Relief::Ramp, &mut Random::new(1));
    let sun = map(ProjectionKind::Orthographic, (4, 4), Relief::Ramp, &mut Random::new(1));
    let cube = map(ProjectionKind::Cube, (4, 4), Relief::Ramp, &mut Random::new(1));
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        for tessellation in [
            Tessellation::Adaptive { criterion: Criterion::Distance, threshold: bad },
            Tessellation::Delaunay { bound: bad },
        ] {
            let error = LightVolume::build(&spot, &Options::new(tessellation)).unwrap_err();
            assert!(matches!(error, LightVolumeError::Threshold { .. }), "{error}");
        }
        let far = Options { far: Some(bad), ..Options::default() };
        assert!(matches!(LightVolume::build(&sun, &far), Err(LightVolumeError::Far { .. })));
    }
    let delaunay = Options::new(Tessellation::Delaunay { bound: 0.1 });
    assert_eq!(LightVolume::build(&cube, &delaunay).unwrap_err(), LightVolumeError::Cube);
    let error = LightVolume::build(&spot.with_outside(Outside::Lit), &Options::default()).unwrap_err();
    assert_eq!(error.to_string(), "a light volume of a perspective map needs an outside that is dark");
    let error = LightVolume::build(&sun.with_outside(Outside::Dark), &Options::default()).unwrap_err();
    assert!(matches!(error, LightVolumeError::Outside { .. }));
}

/// By count: Euler's characteristic and the pairing of edges, which is what `validate` does.
#[test]
#[ignore = "two gigabytes and ten seconds"]
fn a_map_of_4096_squared_is_valid() {
    let time = std::time::Instant::now();
    let map = map(ProjectionKind::Perspective, (4096, 4096), Relief::Spots, &mut Random::new(1));
    println!("map: {:?}", time.elapsed());
    for options in
        [Options::default(), adaptive(Criterion::Laplacian, 0.01), adaptive(Criterion::Distance, 0.01)]
    {
        let time = std::time::Instant::now();
        let volume = build(&map, &options);
        let built = time.elapsed();
        volume.validate().unwrap();
        println!(
            "{options:?}: {} triangles, {} leaves, {} MB, built in {built:?}, checked in {:?}",
            volume.triangles().len(),
            volume.leaves().len(),
            volume.bytes() >> 20,
            time.elapsed() - built
        );
    }
}
