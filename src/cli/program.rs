//! `modiolus export`.

use std::path::{Path, PathBuf};

use modiolus::certainty::Discrepancy;
use modiolus::io::{AnswerFiles, ProgramFile, read_answer, read_target, result_npz, write_atomically};
use modiolus::study::Strain;

use super::Outcome;
use super::arguments::{
    CommonOptions, ContactMode, ExportOptions, FaceChoice, FitOptions, ProgramFormat, parse_stiffness,
};
use super::error::CliError;
use super::export::keep_inputs;
use super::fit::Asked;
use super::load::{input_name, load};
use super::progress::{Progress, say};
use super::render::read_moved;

pub(crate) fn run(options: &ExportOptions, format: ProgramFormat) -> Result<Outcome, CliError> {
    let dir = &options.result;
    let answer = read_answer(dir)?;
    keep_inputs(&answer.inputs, [options.out.clone()])?;
    let mut progress = Progress::new();
    let Some(target) = &answer.target else {
        if format != ProgramFormat::Npz {
            return Err(CliError::NothingFitted(dir.clone()));
        }
        let (loaded, answer) = read_moved(dir, &mut progress)?;
        let bytes = result_npz(&loaded.face, &answer, None).map_err(CliError::Npz)?;
        write_atomically(&options.out, &bytes)?;
        say(&format!("wrote {}: the field and the activations; nothing was fitted", options.out.display()));
        return Ok(Outcome { text: format!("{}\n", options.out.display()), solved: true });
    };
    let path = PathBuf::from(&target.file);
    let fit_options = fit_options(&answer).ok_or_else(|| CliError::OlderResult(dir.clone()))?;
    let document = read_target(&path)?;
    unchanged(dir, &answer, &input_name(&path), &document.sha256)?;
    let loaded = load(&fit_options.common.face, &mut progress)?.with_strength(fit_options.common.strength);
    for (name, sha256) in &loaded.inputs {
        unchanged(dir, &answer, name, sha256)?;
    }
    // A result does not hold its program; the fit is the same bytes every time.
    let asked = Asked::new(&loaded, &document, &path, &mut progress)?;
    let fitted = asked.fit(&fit_options, false, progress)?;
    if fitted.answer.json.activations != answer.activations {
        return Err(CliError::OtherAnswer(dir.clone()));
    }
    let program = fitted.program.ok_or_else(|| CliError::NothingFitted(dir.clone()))?;
    let file = ProgramFile::new(asked.target(), &program);
    let bytes = match format {
        ProgramFormat::Npz => result_npz(&loaded.face, &answer, Some(&file)).map_err(CliError::Npz)?,
        ProgramFormat::Qps => file.qps().into_bytes(),
        ProgramFormat::Qp => file.lp().into_bytes(),
    };
    write_atomically(&options.out, &bytes)?;
    let problem = program.program().problem;
    say(&format!(
        "wrote {}: {} variables, {} equalities, {} inequalities",
        options.out.display(),
        problem.linear.len(),
        problem.equality_value.len(),
        problem.inequality_limit.len()
    ));
    Ok(Outcome { text: format!("{}\n", options.out.display()), solved: fitted.solved })
}

/// The options with which `answer` was fitted; `None` where it does not say them all.
fn fit_options(answer: &AnswerFiles) -> Option<FitOptions> {
    Some(FitOptions {
        targets: Vec::new(),
        common: CommonOptions {
            face: FaceChoice::named(&answer.face),
            strain: Strain::parse(&answer.strain)?,
            strength: answer.strength,
            stiffness: parse_stiffness(&answer.stiffness).ok()?,
        },
        out: None,
        contact: ContactMode::named(&answer.contact_mode)?,
        discrepancy: Discrepancy::ANATOMY,
        json: false,
        junit: None,
    })
}

/// Refuses an input that is not the one that the answer was computed from.
fn unchanged(dir: &Path, answer: &AnswerFiles, name: &str, sha256: &str) -> Result<(), CliError> {
    match answer.inputs.get(name) {
        Some(known) if known == sha256 => Ok(()),
        _ => Err(CliError::ChangedInput { dir: dir.to_owned(), input: name.to_owned() }),
    }
}
