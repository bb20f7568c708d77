//! `repro`: every table and figure, and one report over all of them.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::experiments::{ALL, Context, Preset, References, cpu, revision};
use crate::failure::{Failure, Outcome};
use crate::gpu;
use crate::render::Backend;
use crate::report::{Kept, RunInfo, Section, write_report};
use crate::setups::Setups;

/// Environment variable that names the scenes folder.
pub(crate) const SCENES: &str = "AIRLIGHT_SCENES";

/// Reproduce the papers' tables and figures.
#[derive(Debug, Args)]
pub(crate) struct ReproArgs {
    /// Experiments to run; all of them by default.
    #[arg(value_name = "ID")]
    ids: Vec<String>,
    /// List the experiments.
    #[arg(long)]
    list: bool,
    /// How much to compute.
    #[arg(long, value_enum, default_value = "quick")]
    preset: Preset,
    /// Where to compute it.
    #[arg(long, value_enum, default_value_t)]
    backend: Backend,
    /// Part of the name of the GPU adapter to use.
    #[arg(long)]
    adapter: Option<String>,
    /// Folder with the scenes' meshes; AIRLIGHT_SCENES does the same.
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
    /// Where tables, pictures and the report go.
    #[arg(long, value_name = "DIR", default_value = "target/repro")]
    out: PathBuf,
    /// Folder in which the tables are kept, too, by adapter and with an index.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Exit with 1 if a claim does not hold.
    #[arg(long)]
    strict: bool,
}

/// The scenes folder that the environment names; an empty name is none.
pub(crate) fn scenes_folder() -> Option<PathBuf> {
    std::env::var_os(SCENES).filter(|name| !name.is_empty()).map(PathBuf::from)
}

pub(crate) fn run(args: &ReproArgs) -> Outcome {
    if args.list {
        let list: String = ALL.iter().map(|entry| format!("{:<20}{}\n", entry.id, entry.about)).collect();
        crate::print(&list);
        return Ok(());
    }
    if let Some(unknown) = args.ids.iter().find(|id| ALL.iter().all(|entry| entry.id != **id)) {
        let known: Vec<&str> = ALL.iter().map(|entry| entry.id).collect();
        return Err(Failure::input(format!(
            "{unknown}: no such experiment in this version; known: {}",
            known.join(", ")
        )));
    }
    let setups = match (&args.scenes, scenes_folder()) {
        (Some(folder), _) => Setups::load(Some(("--scenes", folder)))?,
        (None, Some(folder)) => Setups::load(Some((SCENES, &folder)))?,
        (None, None) => Setups::load(None)?,
    };
    let mut flags = format!(" --preset {}", args.preset.name());
    match args.backend {
        Backend::Auto => {}
        Backend::Gpu => flags += " --backend gpu",
        Backend::Cpu => flags += " --backend cpu",
    }
    if let Some(adapter) = &args.adapter {
        flags += &format!(" --adapter {adapter:?}");
    }
    if setups.has_folder() {
        // the reader's folder is elsewhere
        flags += " --scenes DIR";
    }
    let gpu = match args.backend {
        // one that is named has to be there, as for `render`
        Backend::Cpu => args.adapter.as_deref().map(|name| gpu::open(Some(name))).transpose()?.and(None),
        Backend::Auto | Backend::Gpu => gpu::open(args.adapter.as_deref())?,
    };
    if gpu.is_none() && args.backend == Backend::Gpu {
        return Err(Failure::input("--backend gpu: there is no GPU adapter"));
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|e| Failure::input(format!("--out {}: cannot be made: {e}", args.out.display())))?;
    let kept = args.keep.as_deref().map(Kept::open).transpose()?;
    let references = References::of_this_build();
    let context =
        Context { gpu, preset: args.preset, setups, adapter: cpu(), git: revision(), references, flags };
    let mut sections: Vec<Section> = Vec::new();
    for entry in ALL.iter().filter(|entry| args.ids.is_empty() || args.ids.iter().any(|id| id == entry.id)) {
        tracing::info!("{}: {}", entry.id, entry.about);
        let begun = Instant::now();
        let section = (entry.run)(&context)?;
        tracing::info!("{}: took {:.1} s", entry.id, begun.elapsed().as_secs_f64());
        section.write(&args.out)?;
        crate::print(&format!("{}\n", section.text()));
        sections.push(section);
    }
    let report = args.out.join("report.html");
    let info = RunInfo {
        preset: args.preset.name().into(),
        adapter: context.adapter.clone(),
        git: context.git.clone(),
        date: None,
        command: format!(
            "cargo xtask repro{}{}",
            args.ids.iter().map(|id| format!(" {id}")).collect::<String>(),
            context.flags
        ),
        notes: vec!["Each experiment names the adapter that it was measured on.".into()],
    };
    write_report(&report, &sections, &info)?;
    tracing::info!("report: {}", report.display());
    if let Some(kept) = kept {
        kept.add(&sections)?;
    }
    let failed = sections.iter().flat_map(|s| &s.experiment.checks).filter(|check| !check.holds).count();
    if args.strict && failed > 0 {
        return Err(Failure::program(format!("--strict: {failed} claims do not hold")));
    }
    Ok(())
}
