//! Command line of the workspace: `cargo xtask help` lists what it does.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod airlight;
mod airlight_gpu;
mod cargo;
mod compare;
mod doctor;
mod eval;
mod experiments;
mod failure;
mod frame;
mod froxels;
mod gpu;
mod image_file;
mod maps;
mod median;
mod metrics;
mod output_file;
mod planned;
mod progress;
mod render;
mod report;
mod repro;
mod scene_args;
mod scenes;
mod setups;
mod stained_glass;
mod surfaces;
mod surfaces_gpu;
mod technique;
mod view_rays;
mod viewers;
mod volumes;

use failure::Outcome;

/// Volumetric shadows in single-scattering media: render, compare, evaluate, reproduce.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bench(cargo::BenchArgs),
    Compare(compare::CompareArgs),
    Doctor(doctor::DoctorArgs),
    Eval(eval::EvalArgs),
    Render(Box<render::RenderArgs>),
    Repro(repro::ReproArgs),
    Scenes(scenes::ScenesArgs),
    Test(cargo::TestArgs),
}

fn run(command: &Command) -> Outcome {
    match command {
        Command::Bench(args) => cargo::bench(args),
        Command::Compare(args) => compare::run(args),
        Command::Doctor(args) => doctor::run(args),
        Command::Eval(args) => eval::run(args),
        Command::Render(args) => render::run(args),
        Command::Repro(args) => repro::run(args),
        Command::Scenes(args) => scenes::run(args),
        Command::Test(args) => cargo::test(args),
    }
}

/// Results go to stdout; a reader that has gone away is no failure.
fn print(text: &str) {
    use std::io::Write;
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// Plain lines on stderr: what a default was, what a flag did not do.
fn start_log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("off,xtask=info"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false)
        .with_ansi(false)
        .without_time()
        .init();
}

/// Names a runtime folder where the environment has none.
///
/// Without one, a layer of Mesa's Vulkan drivers writes complaints of its own to stderr, where a script expects one
/// line or none.
#[expect(unsafe_code, reason = "setting a variable is sound while no other thread runs")]
fn settle_environment() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: first thing in main, before any thread is started
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
}

fn main() -> ExitCode {
    settle_environment();
    start_log();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    match run(&cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say(&format!("error: {failure}"));
            ExitCode::from(failure.code())
        }
    }
}

/// Help goes to stdout as it is; a mistake becomes one line on stderr.
fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // a closed pipe is the reader's choice
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        say("error: no command given; cargo xtask help lists them");
        return ExitCode::from(2);
    }
    let text = error.to_string();
    let end = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|part| text.find(part)).min();
    let line = text[..end.unwrap_or(text.len())].split_whitespace().collect::<Vec<_>>().join(" ");
    say(&if line.starts_with("error:") { line } else { format!("error: {line}") });
    ExitCode::from(2)
}

/// One line on stderr; nobody is left to tell if that fails.
fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{line}");
}
