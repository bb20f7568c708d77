//! `test` and `bench`: what cargo is asked to do.

use std::io::Write;
use std::process::Command;

use clap::Args;

use crate::failure::{Failure, Outcome};
use crate::gpu;

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
    if args.install_software_gpu {
        install_software_gpu()?;
    }
    let gpu = if args.no_gpu { None } else { gpu::open(args.adapter.as_deref())? };
    // the CPU crates in dev, with debug assertions and overflow checks; what needs wgpu shares the release build
    let mut done = cargo(
        &[
            "test",
            "--workspace",
            "--exclude",
            "gpu-backend",
            "--exclude",
            "xtask",
            "--no-fail-fast",
            "--locked",
        ],
        &[],
    )?;
    let release =
        ["test", "--release", "--package", "gpu-backend", "--package", "xtask", "--no-fail-fast", "--locked"];
    match &gpu {
        Some(gpu) => {
            // from here on a GPU test that does not run is a failure
            let mut environment = vec![("REQUIRE_GPU", "1")];
            environment.extend(args.adapter.as_deref().map(|name| ("AIRLIGHT_ADAPTER", name)));
            done &= cargo(&release, &environment)?;
            // and once more on a device that has no more than every device has
            environment.push(("AIRLIGHT_FEATURES", "core"));
            let core = [
                "test",
                "--release",
                "--package",
                "gpu-backend",
                "--test",
                "*",
                "--no-fail-fast",
                "--locked",
            ];
            done &= cargo(&core, &environment)?;
            crate::print(&format!(
                "GPU tests: {} ran on {}, with all features and with core features alone\n",
                gpu_tests()?,
                gpu.info.name
            ));
        }
        None => {
            done &= cargo(&[&release[..], &["--lib", "--bins"]].concat(), &[])?;
            let why =
                if args.no_gpu { "as asked" } else { "for want of an adapter; see --install-software-gpu" };
            crate::print(&format!("GPU tests: {} did not run, {why}\n", gpu_tests()?));
        }
    }
    if done { Ok(()) } else { Err(Failure::program("tests failed")) }
}

/// How many tests need a GPU: all of the backend's integration tests.
fn gpu_tests() -> Outcome<usize> {
    let list = [
        "test",
        "--quiet",
        "--release",
        "--package",
        "gpu-backend",
        "--test",
        "*",
        "--locked",
        "--",
        "--list",
    ];
    let output = Command::new(program()).args(list).output();
    let output = output.map_err(|e| Failure::program(format!("cargo: {e}")))?;
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter(|line| line.ends_with(": test")).count())
}

pub(crate) fn bench(args: &BenchArgs) -> Outcome {
    let mut command = vec!["bench", "--package", "airlight-benches", "--locked"];
    if let Some(filter) = &args.filter {
        command.extend(["--", filter]);
    }
    if cargo(&command, &[])? { Ok(()) } else { Err(Failure::program("benchmarks failed")) }
}

fn program() -> std::ffi::OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs cargo with this process's terminal; whether it succeeded.
fn cargo(args: &[&str], environment: &[(&str, &str)]) -> Outcome<bool> {
    // what was said so far comes before what cargo says
    let _ = std::io::stdout().flush();
    tracing::info!("cargo {}", args.join(" "));
    let status = Command::new(program()).args(args).envs(environment.iter().copied()).status();
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
