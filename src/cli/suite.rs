//! Several targets at once: `modiolus fit` of several, and `modiolus verify`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use modiolus::certainty::Discrepancy;
use modiolus::face::standard::Resolution;
use modiolus::io::{FileSet, SuiteJson, SuiteTargetJson, junit_text, read_targets, write_atomically};
use modiolus::study::{Stiffness, Strain, Verdict, at_once};
use modiolus::units::counted;

use super::Outcome;
use super::arguments::{CommonOptions, ContactMode, FaceChoice, FitOptions, VerifyOptions};
use super::error::CliError;
use super::export::{ANSWER, default_out, export, keep_inputs};
use super::fit::{Asked, Fitted, has_defaults, stated};
use super::load::{LoadedFace, input_name, load};
use super::progress::{Progress, say};

/// What a target must do to pass.
#[derive(Clone, Copy, PartialEq)]
enum Asks {
    /// Be solved.
    Solved,
    /// Give what its file states.
    AsStated,
}

/// Where the answers go.
enum Place<'a> {
    Default,
    Folder(&'a Path),
    Nowhere,
}

pub(crate) fn fit(options: &FitOptions) -> Result<Outcome, CliError> {
    let place = options.out.as_deref().map_or(Place::Default, Place::Folder);
    run(options, Asks::Solved, &place)
}

pub(crate) fn verify(options: VerifyOptions) -> Result<Outcome, CliError> {
    let VerifyOptions { targets, face, fast, out, json, junit } = options;
    let face = if fast { FaceChoice::Standard(Resolution::COARSE) } else { face };
    let common =
        CommonOptions { face, strain: Strain::default(), strength: 1., stiffness: Stiffness::default() };
    let contact = ContactMode::Reactions;
    let discrepancy = Discrepancy::ANATOMY;
    let options = FitOptions { targets, common, out, contact, discrepancy, json, junit };
    let place = options.out.as_deref().map_or(Place::Nowhere, Place::Folder);
    run(&options, Asks::AsStated, &place)
}

fn run(options: &FitOptions, asks: Asks, place: &Place) -> Result<Outcome, CliError> {
    let start = Instant::now();
    let targets = read_targets(&options.targets)?;
    let mut progress = Progress::new();
    let loaded = load(&options.common.face, &mut progress)?.with_strength(options.common.strength);
    let mut inputs = loaded.inputs.clone();
    inputs.extend(targets.iter().map(|(path, read)| (input_name(path), read.sha256.clone())));
    let folders: Vec<Option<PathBuf>> = targets
        .iter()
        .map(|(path, read)| match place {
            Place::Default => default_out(&loaded, &read.target.name, Some(path)).map(Some),
            Place::Folder(folder) => Ok(Some(folder.join(&read.target.name))),
            Place::Nowhere => Ok(None),
        })
        .collect::<Result<_, _>>()?;
    let answers = folders.iter().flatten().flat_map(|folder| ANSWER.map(|name| folder.join(name)));
    keep_inputs(&inputs, answers.chain(options.junit.clone()))?;
    let asked: Vec<Asked> = targets
        .iter()
        .map(|(path, read)| Asked::new(&loaded, read, path, &mut progress))
        .collect::<Result<_, _>>()?;

    let mut timings_s = BTreeMap::new();
    let mut rows = Vec::new();
    // What is not written needs no certainty.
    let wants_certainty = !matches!(place, Place::Nowhere);
    let fits = fit_all(&asked, options, wants_certainty, &mut progress);
    // Nothing is written where one of them is refused.
    let fits: Vec<_> = fits.into_iter().map(answered).collect::<Result<_, _>>()?;
    for (((fitted, seconds), asked), folder) in fits.into_iter().zip(&asked).zip(&folders) {
        timings_s.insert(asked.target().name.clone(), seconds);
        rows.push(row(&fitted, asked, options, asks));
        if let (Ok(fitted), Some(folder)) = (fitted, folder) {
            export(fitted.answer, &loaded.face, FileSet::new(folder), true)?;
        }
    }
    timings_s.insert("all".to_owned(), start.elapsed().as_secs_f64());
    let count = |passed: Option<bool>| rows.iter().filter(|row| row.passed == passed).count();
    let suite = SuiteJson {
        face: loaded.name.clone(),
        face_name: loaded.face.name.clone(),
        strain: options.common.strain.name().to_owned(),
        stiffness: options.common.stiffness.text(),
        strength: options.common.strength,
        passed: count(Some(true)),
        failed: count(Some(false)),
        skipped: count(None),
        targets: rows,
        timings_s,
        inputs,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    if let Some(path) = &options.junit {
        write_atomically(path, junit_text(&suite).as_bytes())?;
        say(&format!("wrote {}", path.display()));
    }
    if suite.skipped == suite.targets.len() {
        say(&format!("nothing was verified: no target states a result for {}", loaded.called));
    }
    let solved = suite.failed == 0 && suite.passed > 0;
    let text = if options.json { suite.to_text()? } else { table(&suite, &loaded.called) };
    Ok(Outcome { text, solved })
}

/// Each fit with its wall time, s.
fn fit_all(
    asked: &[Asked],
    options: &FitOptions,
    wants_certainty: bool,
    progress: &mut Progress,
) -> Vec<(Result<Fitted, CliError>, f64)> {
    let done = AtomicUsize::new(0);
    let n = asked.len();
    progress.told_step("fit", |bar| {
        bar.set_message(format!("fit {}", counted(n, "target")));
        at_once(asked, |asked| {
            let start = Instant::now();
            let fitted = asked.fit(options, wants_certainty, Progress::silent());
            let seconds = start.elapsed().as_secs_f64();
            let k = done.fetch_add(1, Ordering::Relaxed) + 1;
            let word = fitted.as_ref().map_or("no answer", |f| f.answer.json.status.said());
            let name = &asked.target().name;
            bar.suspend(|| say(&format!("{k} of {n}: {name}: {word}, {seconds:.1} s")));
            (fitted, seconds)
        })
    })
}

/// `fit`, or what it says of bad input; a target without an answer is a result.
fn answered(
    (fitted, seconds): (Result<Fitted, CliError>, f64),
) -> Result<(Result<Fitted, CliError>, f64), CliError> {
    match fitted {
        Err(error) if error.exit_code() == 2 => Err(error),
        fitted => Ok((fitted, seconds)),
    }
}

fn row(
    fitted: &Result<Fitted, CliError>,
    asked: &Asked,
    options: &FitOptions,
    asks: Asks,
) -> SuiteTargetJson {
    let target = asked.target();
    let stated = stated(target, asked.loaded(), options);
    let verdict = match fitted {
        Ok(fitted) => fitted.verdict,
        Err(_) if stated.is_some() => Verdict::NotAsStated,
        Err(_) => Verdict::NotStated,
    };
    let passed = match (asks, verdict) {
        (Asks::Solved, _) => Some(fitted.as_ref().is_ok_and(|f| f.solved)),
        (Asks::AsStated, Verdict::NotStated) => None,
        (Asks::AsStated, verdict) => Some(verdict == Verdict::AsStated),
    };
    let remark = match fitted {
        Err(error) => Some(error.to_string()),
        Ok(_) if stated.is_none() => Some(unstated(asked.loaded(), options)),
        Ok(_) => None,
    };
    SuiteTargetJson {
        name: target.name.clone(),
        file: input_name(asked.path()),
        status: fitted.as_ref().ok().map(|f| f.answer.json.status),
        found_rms_mm: fitted.as_ref().ok().and_then(|f| f.rms_mm),
        stated_rms_mm: stated.map(|e| e.residual_rms_mm),
        tolerance_mm: stated.map(|e| e.tolerance_mm),
        verdict: verdict.into(),
        passed,
        programs: fitted.as_ref().map_or(0, |f| f.answer.json.steps.len()),
        remark,
    }
}

/// Why nothing is stated.
fn unstated(loaded: &LoadedFace, options: &FitOptions) -> String {
    match loaded.stated_as() {
        _ if !has_defaults(options) => {
            "results are stated for the default strain, strength, stiffness and contact".to_owned()
        }
        Some(name) => format!("the file states no result for {name}"),
        None => format!(
            "results are stated for the built-in {}; give the face file a `name` of its own",
            loaded.face.name
        ),
    }
}

/// The summary as a table.
fn table(suite: &SuiteJson, called: &str) -> String {
    let width = suite.targets.iter().map(|t| t.name.chars().count()).max().unwrap_or(0).max(6);
    let number = |mm: Option<f64>| mm.map_or("-".to_owned(), |mm| format!("{mm:.3}"));
    let mut text = format!(
        "{} on {called}\n\n{:width$}  {:15}{:>8}{:>8}{:>8}  {:15}{:>8}\n",
        counted(suite.targets.len(), "target"),
        "Target",
        "status",
        "rms mm",
        "stated",
        "within",
        "verdict",
        "programs"
    );
    for row in &suite.targets {
        let status = row.status.map_or("no answer", |s| s.said());
        let [found, stated, within] = [row.found_rms_mm, row.stated_rms_mm, row.tolerance_mm].map(number);
        text += &format!(
            "{:width$}  {status:15}{found:>8}{stated:>8}{within:>8}  {:15}{:>8}\n",
            row.name,
            row.verdict.said(),
            row.programs
        );
    }
    let mut remarks: Vec<(&str, Vec<&str>)> = Vec::new();
    for row in &suite.targets {
        let Some(remark) = row.remark.as_deref() else { continue };
        match remarks.iter_mut().find(|(known, _)| *known == remark) {
            Some((_, names)) => names.push(&row.name),
            None => remarks.push((remark, vec![&row.name])),
        }
    }
    if !remarks.is_empty() {
        text.push('\n');
    }
    text.extend(remarks.iter().map(|(remark, names)| format!("- {}: {remark}\n", names.join(", "))));
    let SuiteJson { passed, failed, skipped, .. } = suite;
    text + &format!("\n{passed} passed, {failed} failed, {skipped} without anything to hold it against\n")
}
