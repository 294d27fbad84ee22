//! Arguments become validated options, options become work, work becomes files and a table.

mod activation_list;
mod arguments;
mod error;
mod export;
mod face_verbs;
mod figures;
mod fit;
mod forward;
mod load;
mod map;
mod progress;
mod render;
mod surgery;
mod table;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use self::arguments::{Arguments, FaceVerb, Verb};
use self::error::CliError;

/// What a verb prints on stdout, and whether it was solved.
pub(crate) struct Outcome {
    /// The data, for stdout.
    pub(crate) text: String,
    /// Whether the exit code is 0.
    pub(crate) solved: bool,
}

pub(crate) fn run() -> ExitCode {
    match dispatch(Arguments::parse().verb) {
        Ok(outcome) => {
            // A reader that closes the pipe early has what it wanted.
            let _ = io::stdout().lock().write_all(outcome.text.as_bytes());
            ExitCode::from(u8::from(!outcome.solved))
        }
        Err(error) => {
            let _ = writeln!(io::stderr().lock(), "error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}

fn dispatch(verb: Verb) -> Result<Outcome, CliError> {
    match verb {
        Verb::Fit(options) => fit::run(&options),
        Verb::Forward(options) => forward::run(&options),
        Verb::Map(options) => map::run(&options),
        Verb::Render(options) => render::run(&options),
        Verb::Figures(options) => figures::run(&options),
        Verb::Surgery(options) => surgery::run(&options),
        Verb::Face { verb: FaceVerb::Check { face } } => face_verbs::check(&face),
        Verb::Face { verb: FaceVerb::Export { resolution, out, .. } } => face_verbs::export(resolution, &out),
    }
}
