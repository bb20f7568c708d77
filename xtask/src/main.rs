//! Command line of the workspace: `cargo xtask help` lists what it does.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod compare;
mod eval;
mod failure;
mod image_file;
mod metrics;
mod output_file;
mod progress;
mod report;

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
    Compare(compare::CompareArgs),
    Eval(eval::EvalArgs),
}

fn run(command: &Command) -> Outcome {
    match command {
        Command::Compare(args) => compare::run(args),
        Command::Eval(args) => eval::run(args),
    }
}

fn main() -> ExitCode {
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
    let text = error.to_string();
    let first = text.lines().take_while(|line| !line.is_empty() && !line.starts_with("Usage")).collect::<Vec<_>>();
    let line = first.join(" ").split_whitespace().collect::<Vec<_>>().join(" ");
    say(&if line.starts_with("error:") { line } else { format!("error: {line}") });
    ExitCode::from(2)
}

/// One line on stderr; nobody is left to tell if that fails.
fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{line}");
}
