//! Talk on stderr while something takes long, and how long it took.

use std::collections::BTreeMap;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
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
        self.shown(name, ProgressBar::new_spinner(), "{spinner} {msg} ({elapsed})", work)
    }

    /// Runs `work` as the step `name` over `total` of `things`; `work` tells how many are done.
    pub(crate) fn counted_step<T>(
        &mut self,
        name: &str,
        total: usize,
        things: &str,
        work: impl FnOnce(&(dyn Fn(usize) + Sync)) -> T,
    ) -> T {
        let form =
            format!("{{spinner}} {{msg}} {{bar:30}} {{pos}} of {{len}} {things} ({{elapsed}}, {{eta}} left)");
        self.shown(name, ProgressBar::new(total as u64), &form, |bar| work(&|done| bar.inc(done as u64)))
    }

    fn shown<T>(
        &mut self,
        name: &str,
        bar: ProgressBar,
        form: &str,
        work: impl FnOnce(ProgressBar) -> T,
    ) -> T {
        // Hidden by itself when stderr is not a terminal.
        let bar = if self.is_silent { ProgressBar::hidden() } else { bar };
        let bar = bar.with_message(name.replace('_', " "));
        if let Ok(style) = ProgressStyle::with_template(form) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        let start = Instant::now();
        let beat = (!self.is_silent && bar.is_hidden()).then(|| Heartbeat::of(bar.clone(), start));
        let result = work(bar.clone());
        drop(beat);
        bar.finish_and_clear();
        *self.timings_s.entry(name.to_owned()).or_default() += start.elapsed().as_secs_f64();
        result
    }

    /// Wall time of each step, s.
    pub(crate) fn timings_s(self) -> BTreeMap<String, f64> {
        self.timings_s
    }
}

/// How long nothing may be heard of a step where there is no terminal.
const SILENCE: Duration = Duration::from_secs(10);

/// Says every 10 s how a step goes where a bar cannot be drawn.
struct Heartbeat {
    /// Dropped when the step is done.
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    fn of(bar: ProgressBar, start: Instant) -> Self {
        let (done, is_done) = channel();
        let thread = thread::spawn(move || {
            while is_done.recv_timeout(SILENCE) == Err(RecvTimeoutError::Timeout) {
                let (passed, at) = (start.elapsed().as_secs_f64(), bar.position());
                match bar.length() {
                    Some(total) if at > 0 => {
                        let left = passed * (total - at.min(total)) as f64 / at as f64;
                        say(&format!(
                            "{}: {at} of {total} ({passed:.0} s, about {left:.0} s left)",
                            bar.message()
                        ));
                    }
                    _ => say(&format!("{} ({passed:.0} s)", bar.message())),
                }
            }
        });
        Self { done: Some(done), thread: Some(thread) }
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        drop(self.done.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A line of talk on stderr.
pub(crate) fn say(line: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr().lock(), "{}", super::visible(line));
}
