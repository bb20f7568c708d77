//! Progress of long work, on stderr: a bar where someone watches, now and then a plain line where a log is kept.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Least time between two lines of a log, which come with every tenth of the work.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// A line comes after this time in any case, so that slow work shows that it lives.
const SILENCE: Duration = Duration::from_secs(60);

/// Progress of one piece of work, countable from any thread.
#[derive(Debug)]
pub(crate) struct Progress {
    label: String,
    bar: ProgressBar,
    /// Absent on a terminal, where the bar shows itself.
    log: Option<Mutex<Log>>,
}

/// What the last line of the log said.
#[derive(Debug)]
struct Log {
    at: Instant,
    tenth: u64,
}

impl Progress {
    /// Starts to count up to `total` units of work; without a label in silence.
    pub(crate) fn new(label: impl Into<String>, total: u64) -> Self {
        let label = label.into();
        let silent = label.is_empty();
        let watched = io::stderr().is_terminal();
        let target =
            if watched && !silent { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total), target).with_message(label.clone());
        // the template is fixed; were it ever wrong, indicatif's own look would do
        if let Ok(style) = ProgressStyle::with_template("{msg:28} {wide_bar} {pos}/{len} {elapsed_precise}") {
            bar.set_style(style);
        }
        let log = (!watched && !silent).then(|| Mutex::new(Log { at: Instant::now(), tenth: 0 }));
        let progress = Self { label, bar, log };
        progress.line(format_args!("0/{total}"));
        progress
    }

    /// Counts `n` more units as done.
    pub(crate) fn inc(&self, n: u64) {
        self.bar.inc(n);
        // a thread that finds the log busy leaves the line to the one that holds it
        let Some(mut log) = self.log.as_ref().and_then(|log| log.try_lock().ok()) else { return };
        let (done, total) = (self.bar.position(), self.bar.length().unwrap_or_default());
        let tenth = (10 * done).checked_div(total).unwrap_or_default();
        let silent = log.at.elapsed();
        let due = silent >= SILENCE || tenth > log.tenth && silent >= LINE_EVERY;
        if done < total && due {
            *log = Log { at: Instant::now(), tenth };
            self.line(format_args!("{done}/{total}"));
        }
    }

    /// Ends the work, done or not.
    pub(crate) fn finish(&self) {
        self.bar.finish();
        let (done, total) = (self.bar.position(), self.bar.length().unwrap_or_default());
        // no time: a picture's time is never printed without its error
        self.line(format_args!("{done}/{total}"));
    }

    /// A line of the log. Progress that cannot be told is not worth an error.
    fn line(&self, what: std::fmt::Arguments<'_>) {
        if self.log.is_some() {
            let _ = writeln!(io::stderr(), "{}: {what}", self.label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_from_many_threads() {
        let progress = Progress::new("counting", 4000);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..1000).for_each(|_| progress.inc(1)));
            }
        });
        assert_eq!(progress.bar.position(), 4000);
        progress.finish();
        Progress::new("nothing to do", 0).inc(1);
    }
}
