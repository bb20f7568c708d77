//! `test` and `bench`: what cargo is asked to do.

use std::io::Write;
use std::process::Command;

use clap::Args;

use crate::failure::{Failure, Outcome};

/// Run every test.
#[derive(Debug, Args)]
pub(crate) struct TestArgs {
    /// Install a software Vulkan driver first, on Debian and its relatives.
    #[arg(long)]
    install_software_gpu: bool,
    /// Leave the GPU tests out.
    #[arg(long, conflicts_with_all = ["adapter", "install_software_gpu"])]
    no_gpu: bool,
    /// Part of the name of the GPU adapter to test on.
    #[arg(long)]
    adapter: Option<String>,
}

/// Run the criterion benchmarks.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Part of the benchmarks' names.
    filter: Option<String>,
}

/// Debian packages of a software Vulkan adapter.
const SOFTWARE_GPU: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

pub(crate) fn test(args: &TestArgs) -> Outcome {
    if let Some(name) = &args.adapter {
        return Err(Failure::input(format!("--adapter {name}: this version has no GPU backend")));
    }
    if args.install_software_gpu {
        install_software_gpu()?;
    }
    // one build for all: the CPU crates in dev, with debug assertions and overflow checks
    let done = cargo(&["test", "--workspace", "--locked"])?;
    crate::print(if args.no_gpu {
        "GPU tests: left out as asked\n"
    } else {
        "GPU tests: 0, this version has no GPU backend\n"
    });
    if done { Ok(()) } else { Err(Failure::program("tests failed")) }
}

pub(crate) fn bench(args: &BenchArgs) -> Outcome {
    let mut command = vec!["bench", "--package", "airlight-benches", "--locked"];
    if let Some(filter) = &args.filter {
        command.extend(["--", filter]);
    }
    if cargo(&command)? { Ok(()) } else { Err(Failure::program("benchmarks failed")) }
}

/// Runs cargo with this process's terminal; whether it succeeded.
fn cargo(args: &[&str]) -> Outcome<bool> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // what was said so far comes before what cargo says
    let _ = std::io::stdout().flush();
    tracing::info!("cargo {}", args.join(" "));
    let status = Command::new(cargo).args(args).status();
    status.map(|status| status.success()).map_err(|e| Failure::program(format!("cargo: {e}")))
}

fn install_software_gpu() -> Outcome {
    let apt = |args: &[&str]| -> Outcome {
        tracing::info!("apt-get {}", args.join(" "));
        let status = Command::new("apt-get").args(args).env("DEBIAN_FRONTEND", "noninteractive").status();
        match status {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(Failure::program(format!(
                "--install-software-gpu: apt-get {} ended with {status}",
                args.join(" ")
            ))),
            Err(e) => Err(Failure::input(format!(
                "--install-software-gpu: apt-get cannot be run ({e}); install {} by hand",
                SOFTWARE_GPU.join(" and ")
            ))),
        }
    };
    apt(&["-qq", "update"])?;
    let mut install = vec!["-qq", "--yes", "--no-install-recommends", "install"];
    install.extend(SOFTWARE_GPU);
    apt(&install)
}
