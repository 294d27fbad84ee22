//! Arguments become validated options, options become work, work becomes files and a table.

mod activation_list;
mod arguments;
mod calibrate;
mod compare;
mod error;
mod export;
mod face_verbs;
mod figures;
mod fit;
mod forward;
mod gallery;
mod identify;
mod load;
mod map;
mod markers;
mod plot;
mod program;
mod progress;
mod recording;
mod register;
mod render;
mod report;
mod scene;
mod suite;
mod surgery;
mod symmetry;
mod table;
mod track;

use std::borrow::Cow;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use self::arguments::{Arguments, ExportFormat, FaceVerb, Verb};
use self::error::CliError;
use self::progress::say;

/// What a verb prints on stdout, and whether it was solved.
pub(crate) struct Outcome {
    /// The data, for stdout.
    pub(crate) text: String,
    /// Whether the exit code is 0.
    pub(crate) solved: bool,
}

pub(crate) fn run() -> ExitCode {
    let done = match Arguments::try_parse() {
        Ok(arguments) => dispatch(arguments.verb),
        // What was asked for by --help and --version is data, too.
        Err(told) if !told.use_stderr() => Ok(Outcome { text: told.to_string(), solved: true }),
        Err(told) => {
            let _ = io::stderr().lock().write_all(visible(&told.to_string()).as_bytes());
            return ExitCode::from(2);
        }
    };
    let told = done.and_then(|outcome| match print(&outcome.text) {
        Ok(()) => Ok(outcome.solved),
        Err(reason) => Err(CliError::Stdout(reason)),
    });
    match told {
        Ok(solved) => ExitCode::from(u8::from(!solved)),
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

/// Puts `text` on stdout. A reader that closes the pipe early has what it wanted.
fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(visible(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        done => done,
    }
}

/// `text` without characters that would steer a terminal: names in files may hold any.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    let steers = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if steers(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

/// `name` as that of a file or folder: face files may use any letters.
pub(crate) fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
    name.chars().map(safe).collect()
}

fn dispatch(verb: Verb) -> Result<Outcome, CliError> {
    match verb {
        Verb::Fit(options) => fit::run(&options),
        Verb::Verify(options) => suite::verify(options),
        Verb::Compare(options) => compare::run(&options),
        Verb::Export(options) => match options.to {
            ExportFormat::Program(format) => program::run(&options, format),
            ExportFormat::Scene(format) => scene::run(&options, format),
        },
        Verb::Calibrate(options) => calibrate::run(&options),
        Verb::Identify(options) => identify::run(&options),
        Verb::Symmetry(options) => symmetry::run(&options),
        Verb::Markers(options) => markers::run(&options),
        Verb::Track(options) => track::run(&options),
        Verb::Forward(options) => forward::run(&options),
        Verb::Map(options) => map::run(&options),
        Verb::Recording(options) => recording::run(&options),
        Verb::Render(options) => render::run(&options),
        Verb::Figures(options) => figures::run(&options),
        Verb::Gallery(options) => gallery::run(&options),
        Verb::Plot(options) => plot::run(&options),
        Verb::Report(options) => report::run(&options),
        Verb::Register(options) => register::run(&options),
        Verb::Surgery(options) => surgery::run(&options),
        Verb::Face { verb: FaceVerb::Check { face } } => face_verbs::check(&face),
        Verb::Face { verb: FaceVerb::Sample { count, seed, out, resolution } } => {
            face_verbs::sample(count, seed, resolution, &out)
        }
        Verb::Face { verb: FaceVerb::Export { resolution, out, .. } } => face_verbs::export(resolution, &out),
    }
}
