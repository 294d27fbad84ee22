//! `modiolus plot`.

use modiolus::io::{read_activations, read_answer, write_atomically};
use modiolus::report::{activation_plot, l_curve_plot, length_plot, residual_plot, symmetry_plot, time_plot};

use super::Outcome;
use super::arguments::{PlotKind, PlotOptions};
use super::error::CliError;
use super::export::keep_inputs;
use super::progress::{Progress, say};
use super::render::read_moved;
use super::report::mechanics;

pub(crate) fn run(options: &PlotOptions) -> Result<Outcome, CliError> {
    let answer = read_answer(&options.result)?;
    keep_inputs(&answer.inputs, [options.out.clone()])?;
    let drawn = match (options.kind, &options.frames) {
        (PlotKind::Time, Some(path)) => {
            let muscles: Vec<String> = answer.activations.keys().cloned().collect();
            Some(time_plot(&read_activations(path, &muscles)?))
        }
        (PlotKind::Time, None) => return Err(CliError::NoFrames),
        (PlotKind::Activations, _) => Some(activation_plot(&answer)),
        (PlotKind::Residuals, _) => residual_plot(&answer),
        (PlotKind::LCurve, _) => l_curve_plot(&answer),
        (PlotKind::Symmetry, _) => symmetry_plot(&answer),
        (PlotKind::Length, _) => {
            let (loaded, answer) = read_moved(&options.result, &mut Progress::new())?;
            let mechanics =
                mechanics(&answer).ok_or_else(|| CliError::OlderResult(options.result.clone()))?;
            let face = loaded.with_strength(answer.strength).face;
            length_plot(&face, &answer, mechanics)
        }
    };
    let Some(svg) = drawn else { return Err(CliError::NothingToPlot(options.result.clone())) };
    write_atomically(&options.out, svg.as_bytes())?;
    say(&format!("wrote {}", options.out.display()));
    Ok(Outcome { text: format!("{}\n", options.out.display()), solved: true })
}
