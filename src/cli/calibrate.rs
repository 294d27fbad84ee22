//! `modiolus calibrate`.

use modiolus::calibration::CalibrationError;
use modiolus::io::{CalibrationJson, DiscrepancyJson, FileSet, TargetDocument, put_face, read_target};
use modiolus::study;
use modiolus::units::counted;

use super::Outcome;
use super::arguments::{CalibrateOptions, ContactMode};
use super::error::CliError;
use super::export::keep_inputs;
use super::fit::Asked;
use super::load::load;
use super::progress::{Progress, say};

/// What is written beside the face.
const FILE: &str = "calibration.json";

pub(crate) fn run(options: &CalibrateOptions) -> Result<Outcome, CliError> {
    let documents: Vec<TargetDocument> =
        options.targets.iter().map(|path| read_target(path)).collect::<Result<_, _>>()?;
    let mut progress = Progress::new();
    let loaded = load(&options.face, &mut progress)?;
    let mut asked = Vec::new();
    for (document, path) in documents.iter().zip(&options.targets) {
        asked.push(Asked::new(&loaded, document, path, &mut progress)?);
    }
    let mut inputs = loaded.inputs.clone();
    asked.iter().for_each(|asked| inputs.extend(asked.inputs()));
    let set = match &options.out {
        Some(out) => {
            // Before the work: the names of its files are those of any written face.
            let mut set = FileSet::new(out);
            put_face(&mut set, &loaded.face)?;
            keep_inputs(&inputs, set.names().chain([FILE]).map(|name| out.join(name)))?;
            Some(set)
        }
        None => None,
    };
    let targets: Vec<_> = asked.iter().map(|asked| (asked.target(), asked.observations())).collect();
    let touches = options.contact != ContactMode::Off;
    let found = progress.step("calibrate", || {
        study::calibrate(&loaded.face, &targets, &options.prior, options.discrepancy, touches)
    });
    let mut found = found.map_err(|error| match error {
        CalibrationError::Forward(error) => {
            CliError::Forward { face: loaded.called.clone(), error: Box::new(error) }
        }
        other => CliError::Calibration(Box::new(other)),
    })?;
    found.face.name = name_of(&loaded.face.name);
    let discrepancy = DiscrepancyJson { strength: 0., ..DiscrepancyJson::from(&options.discrepancy) };
    let mut json = CalibrationJson::new(&found, loaded.name.clone(), discrepancy, options.contact.name());
    (json.inputs, json.timings_s) = (inputs, progress.timings_s());
    json.warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
    let text = serde_json::to_string_pretty(&json)? + "\n";
    if let Some(mut set) = set {
        put_face(&mut set, &found.face)?;
        set.put(FILE, text.clone().into_bytes());
        set.write()?;
        say(&format!("wrote {FILE} and the calibrated face, face.toml, to {}", set.folder().display()));
    }
    let solved = found.calibration.converged;
    Ok(Outcome { text: if options.json { text } else { table(&json, &loaded.called) }, solved })
}

/// The name of the calibrated face: never that of one that is built in.
fn name_of(face: &str) -> String {
    const MARK: &str = "_calibrated";
    if face.ends_with(MARK) { face.to_owned() } else { face.to_owned() + MARK }
}

fn table(json: &CalibrationJson, face: &str) -> String {
    let mut text = format!(
        "Calibration of {face} by {}: {}\n",
        counted(json.expressions.len(), "expression"),
        json.status.replace('_', " ")
    );
    let moduli = &json.moduli;
    text += &format!(
        "tissue {:.2} kPa, muscle {:.2} kPa at rest and {:.1} kPa contracted\n",
        moduli.tissue_young_kpa, moduli.muscle_rest_kpa, moduli.muscle_active_kpa
    );
    if json.noise_factor > 1.005 {
        text += &format!(
            "The residuals are {:.1} times as large as noise and model explain: the spreads are wider by as much\n",
            json.noise_factor
        );
    }
    let (unseen, told): (Vec<_>, Vec<_>) = json.parameters.iter().partition(|p| p.knowledge == "unseen");
    let width = told.iter().map(|p| p.name.len()).max().unwrap_or(0).max(24);
    text += &format!(
        "\n{:width$}  {:>7}  {:>7}  {:>7}  {:>8}\n",
        "Multiple of the face's", "factor", "spread", "prior's", "by data"
    );
    for p in told {
        text += &format!(
            "{:width$}  {:7.3}  {:7.3}  {:7.3}  {:6.0} %  {}\n",
            p.name,
            p.factor,
            p.spread,
            p.prior_spread,
            100. * p.resolution,
            p.sentence
        );
    }
    if !unseen.is_empty() {
        let names: Vec<&str> = unseen.iter().map(|p| p.name.as_str()).collect();
        text += &format!(
            "Not determined, since active in no expression or where nothing was observed; they keep their priors: {}\n",
            names.join(", ")
        );
    }
    text += "\nWhat the data alone determine, the best first\n";
    for combination in &json.combinations {
        text += &format!("- {}\n", combination.sentence);
    }
    text += &format!(
        "\n{:width$}  {:>10}  {:>12}  {:>11}\n",
        "Expression", "components", "rms before", "rms after"
    );
    for e in &json.expressions {
        text +=
            &format!("{:width$}  {:10}  {:12.2}  {:11.2}\n", e.name, e.components, e.rms_before, e.rms_after);
    }
    text + "rms in standard deviations of the markers\n"
}
