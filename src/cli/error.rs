//! What stops the program, and its exit code.

use std::path::PathBuf;

use modiolus::calibration::CalibrationError;
use modiolus::contact::TeethError;
use modiolus::face::standard::ParameterError;
use modiolus::face::{FaceError, PlanError};
use modiolus::forward::finite::FiniteError;
use modiolus::forward::{ForwardError, OperationError};
use modiolus::inverse::{InverseError, TargetError};
use modiolus::io::{
    ActivationTableError, AnswerFileError, FaceExportError, FaceFileError, Location, MapFileError,
    MappedRecordingError, MeshFileError, PlanFileError, RecordingFileError, Standing, SuiteError,
    TargetFileError, TrackFileError, WriteError,
};
use modiolus::recording::SubjectError;
use modiolus::registration::RegistrationError;
use modiolus::render::RenderError;
use modiolus::report::ReportError;
use modiolus::study::{StudyError, TrackError};
use thiserror::Error;

/// What stops the program.
#[derive(Debug, Error)]
pub(crate) enum CliError {
    /// A stiffness that is held, at finite strain.
    #[error(
        "--stiffness {0} is of the linear model: at finite strain the stiffness follows the activations; leave it out, or use --strain linear"
    )]
    HeldAtFiniteStrain(String),
    #[error(transparent)]
    TargetFile(#[from] TargetFileError),
    #[error("{}: {error}", place(.at))]
    Target { at: Location, error: Box<TargetError> },
    #[error("--activate: no muscle is called {name}; the face has: {known}")]
    UnknownMuscle { name: String, known: String },
    #[error("--jaw-opening: {face} has no jaw joint; give its face file a [jaw] table")]
    NoJaw { face: String },
    #[error("--activate: {name} is given twice; keep one")]
    ActivatedTwice { name: String },
    #[error("{0}")]
    Calibration(Box<CalibrationError>),
    #[error(transparent)]
    PlanFile(#[from] PlanFileError),
    #[error("{at}: {error}", at = place(at))]
    Plan { at: Location, error: Box<PlanError> },
    #[error("{}: {error}", scan.display())]
    Registration { scan: PathBuf, error: Box<RegistrationError> },
    #[error("{}: {error}", path.display())]
    Teeth { path: PathBuf, error: Box<TeethError> },
    #[error("{}: {error}", plan.display())]
    Operation { plan: PathBuf, error: Box<OperationError> },
    #[error(transparent)]
    Suite(#[from] SuiteError),
    #[error(transparent)]
    FaceFile(#[from] FaceFileError),
    #[error(transparent)]
    Proportions(#[from] ParameterError),
    #[error(transparent)]
    FaceExport(#[from] FaceExportError),
    #[error("{face}: {}", list(.errors))]
    Face { face: String, errors: Vec<FaceError> },
    #[error("{face}: {error}")]
    Forward { face: String, error: Box<ForwardError> },
    #[error("{face}: {error}")]
    Study { face: String, error: Box<StudyError> },
    #[error("{0}")]
    Inverse(Box<InverseError>),
    #[error("{}: holds no certainty, because nothing was fitted; give a folder that fit wrote, or a target", .0.display())]
    NoCertainty(PathBuf),
    #[error(
        "{heading}: there is no answer of which anything could be determined; give the target markers, and limits that do not contradict each other"
    )]
    NothingToIdentify { heading: String },
    #[error(transparent)]
    MappedRecording(#[from] MappedRecordingError),
    #[error("{}: {error}", recording.display())]
    Subject { recording: PathBuf, error: Box<SubjectError> },
    #[error("{}: {error}", recording.display())]
    Track { recording: PathBuf, error: Box<TrackError> },
    #[error("the displacements of the face cannot be computed: {0}")]
    Displacements(Box<TrackError>),
    #[cfg(feature = "parquet")]
    #[error("activations.parquet cannot be put together: {0}")]
    Parquet(std::io::Error),
    #[error(transparent)]
    Map(#[from] MapFileError),
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    #[error(transparent)]
    RecordingFile(#[from] RecordingFileError),
    #[error(transparent)]
    Answer(#[from] AnswerFileError),
    #[error("{}: the face was given as {face}, which cannot be read from here: {reason}; run from the folder where the answer was computed", dir.display())]
    FaceOfAnswer { dir: PathBuf, face: String, reason: Box<CliError> },
    #[error("{}: {error}; compute it again with this face", path.display())]
    AnswerOfOtherFace { path: PathBuf, error: RenderError },
    #[error("{}: nothing was fitted there, so that there is no program; give a folder that fit wrote", .0.display())]
    NothingFitted(PathBuf),
    #[error("{}: was written by a version that did not say all its options; fit it again", .0.display())]
    OlderResult(PathBuf),
    #[error("{}: {input} is not what the result was computed from; fit it again, or put the file back", dir.display())]
    ChangedInput { dir: PathBuf, input: String },
    #[error("{}: fitted again, its inputs give other activations: it was written by another version; fit it again", .0.display())]
    OtherAnswer(PathBuf),
    #[error("the arrays cannot be put together: {0}")]
    Npz(std::io::Error),
    #[error("{}: holds how the tissue follows moved bones, not what muscles do; compare results of fit or forward on the faces before and after", .0.display())]
    ResultOfOperation(PathBuf),
    #[error("{} and {} are results on different faces: a sequence is of one", first.display(), other.display())]
    SequenceOfFaces { first: PathBuf, other: PathBuf },
    #[error("{}: is a track, which is shown alone: leave out other results, --sequence and --frames", .0.display())]
    TrackAlone(PathBuf),
    #[error("--every: {} is no track: only the frames of what `modiolus track` wrote can be left out", .0.display())]
    EveryOfNoTrack(PathBuf),
    #[error(transparent)]
    TrackFiles(#[from] TrackFileError),
    #[error("--frames: there is no tangent at the answer of {0}, by which frames could be superposed")]
    NoTangent(String),
    #[error("--kind time needs a table of activations: give --frames TABLE.csv")]
    NoFrames,
    #[error("{}: has nothing of that kind to plot; give a folder that fit wrote, with markers", .0.display())]
    NothingToPlot(PathBuf),
    #[error("--out: a {ending} file ends in .{ending}; name it {}", out.display())]
    Ending { out: PathBuf, ending: &'static str },
    #[error("--frames: {0}")]
    Activations(#[from] ActivationTableError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error("--activate: {} already holds activations; leave one of the two out", dir.display())]
    ActivatedAnswer { dir: PathBuf },
    #[error(
        "--show displacement: nothing moves; add --activate NAME=VALUE or give the output folder of fit or forward"
    )]
    NothingMoves,
    #[error("--show teeth: {face} has no teeth; leave them out, or give its face file [[teeth]]")]
    NoTeeth { face: String },
    #[error("--out: {} holds files that are no figures, such as {found}; give a folder of its own", folder.display())]
    OtherFolder { folder: PathBuf, found: String },
    #[error("{}: the fit ended with the error above", target.display())]
    GalleryFit { target: PathBuf },
    #[error("a fit cannot be run as a process of its own: {0}")]
    Process(std::io::Error),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error("--out: {0}")]
    Write(#[from] WriteError),
    #[error("--out: {} would be replaced, but is read; give another place", .0.display())]
    OverInput(PathBuf),
    #[error("{} holds {}; give another place with --out, or remove it", folder.display(), result_of(.standing))]
    OtherResult { folder: PathBuf, standing: Standing },
    #[error("there is no face {}; did you mean `{face}`?", path.display())]
    MisspeltFace { path: PathBuf, face: &'static str },
    #[error("stdout cannot be written: {0}; send it to where there is room")]
    Stdout(std::io::Error),
    #[error("solution.json cannot be put together: {0}")]
    Json(#[from] serde_json::Error),
}

impl CliError {
    /// 1 when the input is good and no answer was found, 2 when the input is bad.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::NothingToIdentify { .. } => 1,
            Self::Calibration(error)
                if matches!(**error, CalibrationError::Search(_) | CalibrationError::Contact { .. }) =>
            {
                1
            }
            Self::Study { error, .. } if error.is_without_rest() => 1,
            Self::Inverse(error)
                if matches!(
                    **error,
                    InverseError::Contact(_) | InverseError::Finite(FiniteError::NoRest { .. })
                ) =>
            {
                1
            }
            _ => 2,
        }
    }
}

/// File and line; the field stands in the error itself.
fn place(at: &Location) -> String {
    Location { field: None, ..at.clone() }.to_string()
}

/// What stands where another result would be written.
fn result_of(standing: &Standing) -> String {
    match standing {
        Standing::Result { face, inputs, .. } if inputs.is_empty() => format!("a result on {face}"),
        Standing::Result { face, inputs, .. } => format!("the result of {} on {face}", inputs.join(" and ")),
        _ => "a solution.json of something else".to_owned(),
    }
}

fn list(errors: &[FaceError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n  ")
}
