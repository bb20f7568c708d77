//! The experiments of `repro`, one a file.

use std::process::Command;

use gpu_backend::GpuContext;

pub(crate) use references::References;

use crate::failure::Outcome;
use crate::gpu;
use crate::report::Section;
use crate::report::data::{Adapter, Experiment};
use crate::setups::Setups;

mod airlight_accuracy;
mod billeter_bench;
mod billeter_fig1;
mod billeter_fig6;
mod billeter_fig7;
mod billeter_fig8;
mod billeter_mesh;
mod billeter_seams;
mod billeter_table1;
mod counts;
mod equal_error;
mod error_budget;
mod grid_ablation;
mod grid_bench;
mod grid_convergence;
mod grid_memory;
mod grid_overlap;
mod grid_quality;
mod grid_rays;
mod grid_scale;
mod grid_scenes;
mod grid_stages;
mod grid_stand;
mod grid_table;
mod grid_temporal;
mod grid_town;
mod hard_case_list;
mod hard_case_range;
mod hard_case_ways;
mod hard_cases;
mod map_traversal;
mod measure;
mod pareto;
mod pareto_picks;
mod pareto_report;
mod pareto_settings;
mod references;
mod shadow_rays;
mod shown;
mod wyman_bench;
mod wyman_boundary;
mod wyman_exact_times;
mod wyman_fig1;
mod wyman_fig4;
mod wyman_fig5;
mod wyman_fig6;
mod wyman_fig7;
mod wyman_fig7_options;
mod wyman_fig8;
mod wyman_placements;
mod wyman_table1;

/// How much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub(crate) enum Preset {
    /// All experiments in under two minutes, for tests.
    Smoke,
    /// All experiments in about ten minutes, sizes scaled down.
    Quick,
    /// Pictures of 512² where the experiment is not about others, all scenes.
    Standard,
    /// The paper's resolution and sample counts.
    Paper,
}

impl Preset {
    /// The flag's value.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Quick => "quick",
            Self::Standard => "standard",
            Self::Paper => "paper",
        }
    }
}

/// What every experiment needs to know of the run.
#[derive(Debug)]
pub(crate) struct Context {
    pub(crate) preset: Preset,
    pub(crate) setups: Setups,
    pub(crate) adapter: Adapter,
    /// The GPU, where there is one.
    pub(crate) gpu: Option<GpuContext>,
    pub(crate) git: String,
    /// Exact pictures of earlier runs.
    pub(crate) references: References,
    /// Flags that repeat this run, after the experiment's name.
    pub(crate) flags: String,
}

impl Context {
    /// Side of a picture that is marched many times, on a GPU of hardware `side`: elsewhere the default preset would take
    /// much longer than it says.
    fn marched_side(&self, side: u32) -> u32 {
        let software = !self.gpu.as_ref().is_some_and(gpu::is_hardware);
        if software && self.preset == Preset::Quick { side / 2 } else { side }
    }
}

/// An experiment: its name, what it is in one line, and what runs it.
pub(crate) struct Entry {
    pub(crate) id: &'static str,
    pub(crate) about: &'static str,
    pub(crate) run: fn(&Context) -> Outcome<Section>,
}

/// All experiments of this version, in the order in which they run.
pub(crate) const ALL: &[Entry] = &[
    Entry {
        id: "airlight-accuracy",
        about: "speed against error of every airlight form, by category of case",
        run: airlight_accuracy::run,
    },
    Entry {
        id: "hard-cases",
        about: "numerical stability: every technique on the scenes on which techniques fail first",
        run: hard_cases::run,
    },
    Entry {
        id: "error-budget",
        about: "what the error of each technique is made of: visibility, tessellation, integration, upsampling, precision",
        run: error_budget::run,
    },
    Entry {
        id: "map-traversal",
        about: "exact traversal of a shadow map against the honest march on the same map, on the GPU",
        run: map_traversal::run,
    },
    Entry {
        id: "shadow-rays",
        about: "shadow rays a second on the GPU and on the CPU, and how often they disagree",
        run: shadow_rays::run,
    },
    Entry {
        id: "wyman-fig4",
        about: "Wyman & Ramsey 2008, Figure 4: where the steps of a march lie, and what neighbours share of its error",
        run: wyman_fig4::run,
    },
    Entry {
        id: "wyman-fig5",
        about: "Wyman & Ramsey 2008, Figure 5: marching at equal samples, equal cost and equal quality",
        run: wyman_fig5::run,
    },
    Entry {
        id: "wyman-fig6",
        about: "Wyman & Ramsey 2008, Figure 6: error and time against samples per ray under a textured spot",
        run: wyman_fig6::run,
    },
    Entry {
        id: "wyman-fig7",
        about: "Wyman & Ramsey 2008, Figure 7: scenes of several depth complexities, options for complex ones",
        run: wyman_fig7::run,
    },
    Entry {
        id: "wyman-fig8",
        about: "Wyman & Ramsey 2008, Figure 8: the hybrid against ground truth",
        run: wyman_fig8::run,
    },
    Entry {
        id: "wyman-fig1",
        about: "Wyman & Ramsey 2008, Figure 1: pictures by the hybrid, surfaces included",
        run: wyman_fig1::run,
    },
    Entry {
        id: "wyman-table1",
        about: "Wyman & Ramsey 2008, Table 1: brute force against the hybrid, at equal samples and at equal error",
        run: wyman_table1::run,
    },
    Entry {
        id: "billeter-fig1",
        about: "Billeter, Sintorn & Assarsson 2010, Figure 1: a cathedral with two lights, surfaces included",
        run: billeter_fig1::run,
    },
    Entry {
        id: "billeter-fig6",
        about: "Billeter, Sintorn & Assarsson 2010, Figure 6: a point light with cube maps of three sizes",
        run: billeter_fig6::run,
    },
    Entry {
        id: "billeter-fig7",
        about: "Billeter, Sintorn & Assarsson 2010, Figure 7: the light volume against marches of 150 and 400 samples",
        run: billeter_fig7::run,
    },
    Entry {
        id: "billeter-fig8",
        about: "Billeter, Sintorn & Assarsson 2010, Figure 8: the tessellated light volume, as drawn and from the light",
        run: billeter_fig8::run,
    },
    Entry {
        id: "billeter-table1",
        about: "Billeter, Sintorn & Assarsson 2010, Table 1: static against adaptive tessellation of growing maps",
        run: billeter_table1::run,
    },
    Entry {
        id: "grid-convergence",
        about: "froxels against the exact picture and the converged march as they shrink",
        run: grid_convergence::run,
    },
    Entry {
        id: "grid-fig6",
        about: "Stojanovic et al. 2023, Figure 6: error of the shared grid against the size of voxels",
        run: grid_quality::fig6,
    },
    Entry {
        id: "grid-fig7",
        about: "Stojanovic et al. 2023, Figure 7: light shafts by the size of voxels",
        run: grid_quality::fig7,
    },
    Entry {
        id: "grid-table1",
        about: "Stojanovic et al. 2023, Table 1: San Miguel by number of viewers",
        run: grid_table::table1,
    },
    Entry {
        id: "grid-table2",
        about: "Stojanovic et al. 2023, Table 2: Bistro's exterior by number of viewers",
        run: grid_table::table2,
    },
    Entry {
        id: "grid-table3",
        about: "Stojanovic et al. 2023, Table 3: Battle of the Trash God by number of viewers",
        run: grid_table::table3,
    },
    Entry {
        id: "grid-fig11",
        about: "Stojanovic et al. 2023, Figure 11: shadow rays by number of viewers",
        run: grid_rays::run,
    },
    Entry {
        id: "grid-fig12",
        about: "Stojanovic et al. 2023, Figure 12: viewers with a fixed overlap",
        run: grid_overlap::run,
    },
    Entry {
        id: "grid-fig13",
        about: "Stojanovic et al. 2023, Figure 13: time of each stage",
        run: grid_stages::run,
    },
    Entry {
        id: "grid-fig14",
        about: "Stojanovic et al. 2023, Figure 14: memory, dense and in bricks",
        run: grid_memory::run,
    },
    Entry {
        id: "grid-ablation",
        about: "each choice of the shared grid by itself, and more lights than a mask has bits",
        run: grid_ablation::run,
    },
    Entry {
        id: "grid-temporal",
        about: "accumulation over frames: flicker, and how long ghosts last",
        run: grid_temporal::run,
    },
    Entry {
        id: "grid-scale",
        about: "1 to 256 viewers, 50 m to 1 km of scene: how rays and memory grow",
        run: grid_scale::run,
    },
    Entry {
        id: "pareto",
        about: "every technique and setting on every scene: time against error, and what the planner chooses",
        run: pareto::run,
    },
    Entry {
        id: "pareto-speedup",
        about: "the planner's choice against the honest march at equal error on the same map",
        run: pareto::speedup,
    },
];

/// An experiment with nothing found yet.
fn experiment(context: &Context, id: &str, title: &str, source: &str) -> Experiment {
    Experiment {
        id: id.into(),
        title: Some(title.into()),
        source: source.into(),
        preset: context.preset.name().into(),
        adapter: context.adapter.clone(),
        git: context.git.clone(),
        command: Some(format!("cargo xtask repro {id}{}", context.flags)),
        ..Experiment::default()
    }
}

/// What the pictures of a GPU experiment were computed on.
fn gpu_or_cpu(context: &Context) -> Adapter {
    context.gpu.as_ref().map_or_else(|| context.adapter.clone(), gpu::describe)
}

/// The processor that the CPU implementations run on.
pub(crate) fn cpu() -> Adapter {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": ").map(|(_, name)| name));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Adapter {
        name: format!("{}, {cores} threads", model.unwrap_or("CPU").trim()),
        backend: "cpu".into(),
        kind: "CPU".into(),
    }
}

/// Revision of the source tree, or "unknown" outside a repository.
pub(crate) fn revision() -> String {
    let output = Command::new("git").args(["describe", "--always", "--dirty"]).output();
    let text = output
        .ok()
        .filter(|o| o.status.success())
        .map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
    text.unwrap_or_else(|| "unknown".into())
}
