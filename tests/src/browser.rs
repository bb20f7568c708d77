//! Pages as a browser shows them: headless Chromium, driven by its command line alone.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Names that Chromium goes by.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Longer than a page takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(240);

/// A browser that is installed.
#[derive(Debug)]
pub struct Browser {
    program: PathBuf,
    /// Its profile, and what it writes.
    folder: tempfile::TempDir,
}

impl Browser {
    /// The browser that `PATH` has; where there is none, that fails if `REQUIRE_BROWSER` is set.
    #[expect(clippy::print_stdout, reason = "a test that does not run says so")]
    pub fn find() -> Option<Self> {
        let path = std::env::var_os("PATH").unwrap_or_default();
        let places = std::env::split_paths(&path).flat_map(|folder| NAMES.map(|name| folder.join(name)));
        match places.into_iter().find(|place| place.is_file()) {
            Some(program) => Some(Self { program, folder: tempfile::tempdir().unwrap() }),
            None => {
                let names = NAMES.join(", ");
                let required = std::env::var_os("REQUIRE_BROWSER").is_some();
                assert!(!required, "REQUIRE_BROWSER is set, but none of {names} is on the PATH");
                println!("BROWSER TEST DID NOT RUN: none of {names} is on the PATH");
                None
            }
        }
    }

    /// The document of a page after its scripts ran, in a window of `size` (width, height), as HTML.
    pub fn document(&self, page: &Path, size: (u32, u32)) -> String {
        self.run(page, size, "--dump-dom")
    }

    /// A picture of the page's upper part, with the window's size: width, height and RGB values.
    pub fn picture(&self, page: &Path, size: (u32, u32)) -> (u32, u32, Vec<[u8; 3]>) {
        let path = self.folder.path().join("picture.png");
        // one of an earlier page is no picture of this one
        let _ = std::fs::remove_file(&path);
        self.run(page, size, &format!("--screenshot={}", path.display()));
        let picture = image::open(&path).unwrap_or_else(|e| panic!("no picture was taken: {e}")).into_rgb8();
        let pixels = picture.pixels().map(|pixel| pixel.0).collect();
        (picture.width(), picture.height(), pixels)
    }

    /// The page printed, as a PDF file's bytes.
    pub fn print(&self, page: &Path) -> Vec<u8> {
        let path = self.folder.path().join("printed.pdf");
        self.run(page, (1280, 800), &format!("--print-to-pdf={}", path.display()));
        std::fs::read(&path).unwrap_or_else(|e| panic!("nothing was printed: {e}"))
    }

    /// Runs the browser on a page and returns what it prints.
    fn run(&self, page: &Path, (width, height): (u32, u32), what: &str) -> String {
        let said = self.folder.path().join("said.txt");
        let mut child = Command::new(&self.program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"])
            .args(["--no-first-run", "--hide-scrollbars", "--virtual-time-budget=10000"])
            .arg(format!("--user-data-dir={}", self.folder.path().join("profile").display()))
            .arg(format!("--window-size={width},{height}"))
            .arg(what)
            .arg(format!("file://{}", page.display()))
            .stdout(std::fs::File::create(&said).unwrap())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|e| panic!("{}: {e}", self.program.display()));
        let started = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if started.elapsed() > PATIENCE {
                child.kill().unwrap();
                panic!("{what} of {} took longer than {PATIENCE:?}", page.display());
            }
            std::thread::sleep(Duration::from_millis(50));
        };
        assert!(status.success(), "{what} of {}: {status}", page.display());
        std::fs::read_to_string(&said).unwrap()
    }
}
