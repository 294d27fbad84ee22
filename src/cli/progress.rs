//! Talk on stderr while something takes long, and how long it took.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Shows one step at a time on a terminal and adds up their wall times.
pub(crate) struct Progress {
    timings_s: BTreeMap<String, f64>,
    is_silent: bool,
}

impl Progress {
    pub(crate) fn new() -> Self {
        Self { timings_s: BTreeMap::new(), is_silent: false }
    }

    /// One of several that go on at once: it only adds up.
    pub(crate) fn silent() -> Self {
        Self { is_silent: true, ..Self::new() }
    }

    /// Runs `work` as the step `name`.
    pub(crate) fn step<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        self.told_step(name, |_| work())
    }

    /// Runs `work` as the step `name`; `work` may tell how it goes.
    pub(crate) fn told_step<T>(&mut self, name: &str, work: impl FnOnce(ProgressBar) -> T) -> T {
        // Hidden by itself when stderr is not a terminal.
        let bar = if self.is_silent { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        let bar = bar.with_message(name.replace('_', " "));
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        let start = Instant::now();
        let result = work(bar.clone());
        bar.finish_and_clear();
        *self.timings_s.entry(name.to_owned()).or_default() += start.elapsed().as_secs_f64();
        result
    }

    /// Wall time of each step, s.
    pub(crate) fn timings_s(self) -> BTreeMap<String, f64> {
        self.timings_s
    }
}

/// A line of talk on stderr.
pub(crate) fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr().lock(), "{}", super::visible(line));
}
