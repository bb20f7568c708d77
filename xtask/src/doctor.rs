//! `doctor`: what this machine has and what will run on it.

use std::path::Path;
use std::process::Command;

use clap::Args;
use gpu_backend::{GpuContext, software_or_hardware};

use crate::experiments::{cpu, revision};
use crate::failure::Outcome;
use crate::repro::{SCENES, scenes_folder};
use crate::setups::Setups;

/// Say what this machine has and what will run on it.
#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {}

pub(crate) fn run(_args: &DoctorArgs) -> Outcome {
    let cpu = cpu();
    let folder = scenes_folder();
    let lines = [
        ("version".to_owned(), format!("{} ({})", env!("CARGO_PKG_VERSION"), revision())),
        ("processor".into(), cpu.name),
        ("rustc".into(), first_line("rustc", &["--version"])),
        ("Vulkan loader".into(), vulkan_loader()),
        ("GPU adapter".into(), adapter()),
        ("scenes".into(), scenes(folder.as_deref())),
    ];
    let text: String = lines.iter().map(|(name, value)| format!("{name:<18}{value}\n")).collect();
    crate::print(&text);
    Ok(())
}

fn first_line(program: &str, args: &[&str]) -> String {
    let output = Command::new(program).args(args).output().ok().filter(|output| output.status.success());
    output
        .and_then(|output| String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_owned))
        .unwrap_or_else(|| "not found".into())
}

fn adapter() -> String {
    match GpuContext::headless(None) {
        Ok(gpu) => format!("{} ({}, {})", gpu.info.name, gpu.info.backend, software_or_hardware(&gpu.info)),
        Err(error) => format!("{error}: everything runs on the CPU"),
    }
}

fn vulkan_loader() -> String {
    let known = [
        "/usr/lib/x86_64-linux-gnu/libvulkan.so.1",
        "/usr/lib/aarch64-linux-gnu/libvulkan.so.1",
        "/usr/lib/libvulkan.so.1",
        "/usr/lib64/libvulkan.so.1",
    ];
    match known.iter().find(|path| Path::new(path).exists()) {
        Some(path) => format!("{path} (cargo xtask test --install-software-gpu adds a software driver)"),
        None => "not found (cargo xtask test --install-software-gpu installs one on Debian)".into(),
    }
}

fn scenes(folder: Option<&Path>) -> String {
    let Some(folder) = folder else {
        return format!("{SCENES} is not set: generated scenes stand in for the models");
    };
    match Setups::load(Some((SCENES, folder))) {
        Ok(setups) => {
            format!("{}: {} of the known scenes", folder.display(), setups.given())
        }
        Err(failure) => failure.to_string(),
    }
}
