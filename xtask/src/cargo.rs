//! `test` and `bench`: what cargo is asked to do.

use std::io::Write;
use std::path::{Path, PathBuf};
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

/// Run the criterion benchmarks; --save NAME keeps their times, --compare NAME says how they have changed.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Part of the benchmarks' names.
    filter: Option<String>,
    /// Keep what is measured under this name, for later comparisons.
    #[arg(long, value_name = "NAME", allow_hyphen_values = true, value_parser = parse_baseline, conflicts_with = "compare")]
    save: Option<String>,
    /// Say how times differ from those that were saved under this name.
    #[arg(long, value_name = "NAME", allow_hyphen_values = true, value_parser = parse_baseline)]
    compare: Option<String>,
}

/// Folders that criterion has beside those of baselines.
const NO_BASELINES: [&str; 4] = ["base", "change", "new", "report"];

/// The name of a folder, and none of criterion's own.
fn parse_baseline(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let fine = text.chars().all(plain) && text.starts_with(|c: char| c.is_ascii_alphanumeric());
    if fine && !NO_BASELINES.contains(&text) {
        Ok(text.to_owned())
    } else {
        Err(format!("expected letters, digits, '-', '_' and '.', and none of {}", NO_BASELINES.join(", ")))
    }
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
        &[("REQUIRE_DEBUG_ASSERTIONS", "1")],
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
    let home = criterion_home()?;
    if let Some(name) = &args.compare
        && !has_baseline(&home, name)
    {
        let home = home.display();
        return Err(Failure::input(format!("--compare {name}: nothing in {home} was saved under this name")));
    }
    let mut command = vec!["bench", "--package", "airlight-benches", "--locked", "--"];
    command.extend(args.filter.as_deref());
    if let Some(name) = &args.save {
        command.extend(["--save-baseline", name]);
    }
    if let Some(name) = &args.compare {
        // benchmarks that were not there then are measured all the same
        command.extend(["--baseline-lenient", name]);
    }
    let home = home.to_string_lossy();
    if cargo(&command, &[("CRITERION_HOME", &home)])? {
        Ok(())
    } else {
        Err(Failure::program("benchmarks failed"))
    }
}

/// Where criterion keeps what it has measured.
fn criterion_home() -> Outcome<PathBuf> {
    if let Some(home) = std::env::var_os("CRITERION_HOME") {
        // cargo runs benchmarks in their package's folder
        return std::path::absolute(home).map_err(|e| Failure::input(format!("CRITERION_HOME: {e}")));
    }
    // <target>/<profile>/xtask
    let program = std::env::current_exe().map_err(|e| Failure::program(format!("this program: {e}")))?;
    let target = program.ancestors().nth(2).unwrap_or(Path::new("target"));
    Ok(target.join("criterion"))
}

/// Whether any benchmark in `folder` has a baseline of this name.
fn has_baseline(folder: &Path, name: &str) -> bool {
    let Ok(entries) = std::fs::read_dir(folder) else { return false };
    let folders = entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    folders.map(|entry| entry.path()).any(|path| {
        let is_baseline = path.file_name().is_some_and(|last| last == name);
        (is_baseline && path.join("estimates.json").is_file()) || has_baseline(&path, name)
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn baselines_are_found_by_name() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("march_hall/exact/before");
        std::fs::create_dir_all(&folder).unwrap();
        assert!(!has_baseline(home.path(), "before"), "an empty folder");
        std::fs::write(folder.join("estimates.json"), "{}").unwrap();
        assert!(has_baseline(home.path(), "before"));
        assert!(!has_baseline(home.path(), "after") && !has_baseline(&home.path().join("absent"), "before"));
    }

    #[test]
    fn names_of_baselines_are_folders() {
        for good in ["before", "v0.1", "a-b_c"] {
            assert!(parse_baseline(good).is_ok(), "{good}");
        }
        for bad in ["", ".", "..", "a/b", "-x", "new", "base", "a b", "\u{e4}"] {
            assert!(parse_baseline(bad).is_err(), "{bad}");
        }
    }
}
