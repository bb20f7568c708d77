//! The command line as its users run it: a process, its exit code, and what it prints.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;

/// The folder for files that a command is to write, beside those that it reads.
pub const OUT: &str = "out";

/// Part of the name of no adapter.
pub const NO_ADAPTER: &str = "abacus";

/// What a command printed or wrote.
pub fn json_of(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Names of an object's fields, none of anything else's.
pub fn keys(value: &Value) -> Vec<&str> {
    value.as_object().map(|object| object.keys().map(String::as_str).collect()).unwrap_or_default()
}

/// Where `xtask` is, once it is built.
///
/// Cargo names the binary of another package to no test, so it is asked to build it into the folder and profile that
/// this test runs from; where all is fresh that takes a moment.
static XTASK: LazyLock<PathBuf> = LazyLock::new(|| {
    // <target>/<profile>/deps/<test>
    let test = std::env::current_exe().unwrap();
    let deps = test.parent().unwrap();
    let profile = deps.parent().unwrap();
    let target = profile.parent().unwrap();
    let name = match profile.file_name().and_then(OsStr::to_str).unwrap() {
        "debug" => "dev",
        other => other,
    };
    let built = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap())
        .args(["build", "--quiet", "--package", "xtask", "--profile", name, "--target-dir"])
        .arg(target)
        .output()
        .unwrap();
    assert!(built.status.success(), "xtask: {}", String::from_utf8_lossy(&built.stderr));
    profile.join(format!("xtask{}", std::env::consts::EXE_SUFFIX))
});

/// A folder of its own for one test, with an empty folder [`OUT`] in it; commands run in it.
///
/// By default they find no Vulkan driver, so that a test says the same on every machine.
#[derive(Debug)]
pub struct Desk {
    folder: tempfile::TempDir,
    with_gpu: bool,
}

/// How a command ended.
#[derive(Debug)]
pub struct Ended {
    /// Exit code.
    pub code: i32,
    /// What it printed.
    pub stdout: String,
    /// What it complained of.
    pub stderr: String,
}

impl Ended {
    /// The lines on stderr that are not progress, which is written as `what: done/all`.
    pub fn said(&self) -> Vec<&str> {
        let progress = |line: &&str| {
            line.rsplit_once(": ")
                .and_then(|(_, count)| count.split_once('/'))
                .is_some_and(|(done, all)| done.parse::<u64>().is_ok() && all.parse::<u64>().is_ok())
        };
        self.stderr.lines().filter(|line| !progress(line)).collect()
    }
}

impl Default for Desk {
    fn default() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join(OUT)).unwrap();
        Self { folder, with_gpu: false }
    }
}

impl Desk {
    /// A desk whose commands find the GPUs that the machine has, software ones included.
    pub fn with_gpu() -> Self {
        Self { with_gpu: true, ..Self::default() }
    }

    /// The same where a GPU works; `None` with a line that says so where there is none, which fails if `REQUIRE_GPU` is set.
    #[expect(clippy::print_stdout, reason = "a test that does not run says so")]
    pub fn with_working_gpu() -> Option<Self> {
        let desk = Self::with_gpu();
        let probe =
            "render procedural:slats -o out/probe.npy --size 4x4 --backend gpu --technique brute-force";
        let ended = desk.run(probe);
        if ended.code == 0 {
            return Some(desk);
        }
        assert!(std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but: {}", ended.stderr);
        println!("GPU test did not run: {}", ended.stderr);
        None
    }

    /// A file or folder on the desk.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Puts a file on the desk.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Names of the files in [`OUT`], hidden ones included.
    pub fn outputs(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(OUT)).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs `xtask` with the words of `command`.
    pub fn run(&self, command: &str) -> Ended {
        self.run_words(command.split_whitespace())
    }

    /// Runs `xtask` with these arguments.
    pub fn run_words<A: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = A>) -> Ended {
        let mut command = Command::new(&*XTASK);
        command.current_dir(self.folder.path()).args(arguments);
        // the caller's own settings are no part of a test
        command.env_remove("RUST_LOG").env_remove("AIRLIGHT_SCENES");
        if !self.with_gpu {
            // both names that the Vulkan loader has had for it
            command.env("VK_DRIVER_FILES", "absent").env("VK_ICD_FILENAMES", "absent");
        }
        let output = command.output().unwrap();
        Ended {
            code: output.status.code().unwrap_or_else(|| panic!("ended by {}", output.status)),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that must succeed.
    pub fn done(&self, command: &str) -> Ended {
        let ended = self.run(command);
        assert_eq!(ended.code, 0, "{command}: {}", ended.stderr);
        ended
    }

    /// Why a command is not refused as it must be, if so: with exit code 2, nothing on stdout, a single line on
    /// stderr that starts with `error:` and contains `named`, and nothing written.
    pub fn misrefused(&self, command: &str, named: &str) -> Option<String> {
        self.misrefused_words(command.split_whitespace(), command, named)
    }

    /// As [`Desk::misrefused`], with the arguments one by one.
    pub fn misrefused_words<A: AsRef<OsStr>>(
        &self,
        arguments: impl IntoIterator<Item = A>,
        name: &str,
        named: &str,
    ) -> Option<String> {
        let before = self.outputs();
        let ended = self.run_words(arguments);
        let lines: Vec<&str> = ended.stderr.lines().collect();
        let wrong = if ended.code != 2 {
            format!("exit code {}", ended.code)
        } else if !(matches!(lines[..], [line] if line.starts_with("error: "))) {
            format!("{} lines", lines.len())
        } else if !ended.stderr.contains(named) {
            format!("{named:?} is not named")
        } else if !ended.stdout.is_empty() {
            format!("printed {:?}", ended.stdout)
        } else if self.outputs() != before {
            format!("left {:?} behind", self.outputs())
        } else {
            return None;
        };
        Some(format!("{name}: {wrong}: {:?}", ended.stderr))
    }
}

/// Fails with every line of `wrong` unless there is none.
pub fn all_right(wrong: impl IntoIterator<Item = Option<String>>) {
    let mut count = 0;
    let wrong: Vec<String> = wrong.into_iter().inspect(|_| count += 1).flatten().collect();
    assert!(count > 0, "nothing was tried");
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}
