//! Command line arguments, parsed into values that are valid by themselves.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use modiolus::calibration::{LogNormal, StatedPrior};
use modiolus::certainty::Discrepancy;
use modiolus::face::{Jaw, standard::Resolution};
use modiolus::inverse::Target;
use modiolus::io::{ImageScale, ReadOptions, nearest};
use modiolus::render::{MAX_SIDE, MIN_SIDE, Show, View};
use modiolus::study::{HeldStiffness, Mechanics, Stiffness, Strain};
use modiolus::units::LengthUnit;

use super::error::CliError;

use super::activation_list::{Assignment, parse_assignment};

/// Facial biomechanics: the muscle activations that explain an expression, and the expression that
/// activations make.
#[derive(Debug, Parser)]
#[command(name = "modiolus", version, after_help = "Exit code: 0 solved, 1 not solved, 2 bad input.")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Find the activations that come closest to a target, or to each of several.
    Fit(FitOptions),
    /// Fit targets and hold each against the result that its file states for the face.
    Verify(VerifyOptions),
    /// Tell which activations the data determine, and which they leave open.
    Identify(IdentifyOptions),
    /// Find moduli, muscle stress and strengths of a face from expressions whose activations are known, and tell which of them
    /// the data determine.
    Calibrate(CalibrateOptions),
    /// Tell how far the two sides of a moved face are from mirror images, and which muscles make it so.
    Symmetry(SymmetryOptions),
    /// Tell where markers on the skin determine the activations best.
    Markers(MarkersOptions),
    /// Find the activations behind a recording of markers, frame by frame.
    Track(TrackOptions),
    /// Show what given activations do.
    Forward(ForwardOptions),
    /// Write the activation map: what each muscle alone does to each point, without contact.
    Map(MapOptions),
    /// Set two results against each other, such as before and after an operation.
    Compare(CompareOptions),
    /// Write a result as other programs open it: its shape and motion, its activations, or its quadratic program with all
    /// multipliers.
    Export(ExportOptions),
    /// Tell what a recording of markers holds: C3D, TRC, CSV, or the face landmarks of MediaPipe.
    Recording(RecordingOptions),
    /// Draw a face, at rest, under given activations, or as an answer moves it.
    Render(RenderOptions),
    /// Draw the figures of the standard face: rest, smile, where muscle forces go, what each muscle does.
    Figures(FiguresOptions),
    /// Fit targets by linear and by finite strain and draw them beside each other, with an index of their figures.
    Gallery(GalleryOptions),
    /// Write results as a page for a browser: the face that moves, its muscles, markers and tables, in one file.
    Report(ReportOptions),
    /// Plot the figures of a result.
    Plot(PlotOptions),
    /// Match the standard face to the scan of a patient: the face on which every verb then runs.
    Register(RegisterOptions),
    /// Cut and move bones: the face that heals there, on which fit and forward then run.
    Surgery(SurgeryOptions),
    /// Check a face, or write the built-in one as files.
    Face {
        #[command(subcommand)]
        verb: FaceVerb,
    },
}

/// What `--face` takes.
const FACE: &str = "The face: standard, standard_coarse, standard_fine, or a face.toml";

#[derive(Debug, Args)]
pub(crate) struct FitOptions {
    #[arg(
        value_name = "TARGET.toml",
        required = true,
        help = "The target, such as targets/symmetric_smile.toml; several, or their folder, are fitted as many at once as \
                there are cores, and give one summary"
    )]
    pub(crate) targets: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) common: CommonOptions,
    /// Folder for solution.json and face.vtu; of several targets each gets its own, DIR/NAME [default: out/FACE/NAME, NAME
    /// being the target's].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// How lips, cheeks and teeth touch: reactions are unknown forces, kinematic only forbids to
    /// pass through.
    #[arg(long, value_enum, default_value_t = ContactMode::Reactions)]
    pub(crate) contact: ContactMode,
    /// How far the model may be from the face, for the intervals: not at all, as far as another mesh, or as far as another
    /// anatomist's muscles.
    #[arg(long, value_name = "none|mesh|anatomy", default_value = "anatomy", value_parser = parse_discrepancy)]
    pub(crate) discrepancy: Discrepancy,
    /// Print solution.json instead of the table; of several targets the summary as JSON.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the summary as JUnit XML, too: a target that is not solved is a failure.
    #[arg(long, value_name = "FILE.xml", value_parser = |text: &str| parse_out(text, "xml", "JUnit reports are XML"))]
    pub(crate) junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyOptions {
    #[arg(
        value_name = "TARGET.toml|DIR",
        required = true,
        help = "Target files, or folders of them, such as targets"
    )]
    pub(crate) targets: Vec<PathBuf>,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    #[arg(
        help = "On the coarse standard face, in a third of the time: --face standard_coarse",
        long,
        conflicts_with = "face"
    )]
    pub(crate) fast: bool,
    /// Write each answer to DIR/NAME, NAME being the target's.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print the summary as JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the summary as JUnit XML, too: a target that is not as its file states is a failure.
    #[arg(long, value_name = "FILE.xml", value_parser = |text: &str| parse_out(text, "xml", "JUnit reports are XML"))]
    pub(crate) junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct CompareOptions {
    #[arg(value_name = "A", help = "The first result: a folder that fit or forward wrote")]
    pub(crate) first: PathBuf,
    #[arg(value_name = "B", help = "The second")]
    pub(crate) second: PathBuf,
    /// Draw both side by side, the outline of A over B.
    #[arg(long, value_name = "FILE.png", value_parser = |text: &str| parse_out(text, "png", "pictures are written as PNG"))]
    pub(crate) out: Option<PathBuf>,
    /// Where the faces are seen from.
    #[arg(long, value_name = "front|profile|three-quarter", default_value = "front", value_parser = parse_view, requires = "out")]
    pub(crate) view: View,
    /// Print the comparison as JSON instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportOptions {
    #[arg(
        value_name = "RESULT",
        help = "A folder that fit or forward wrote; for its program the inputs are fitted again"
    )]
    pub(crate) result: PathBuf,
    #[arg(
        long,
        value_name = "FORMAT",
        value_parser = parse_export_format,
        help = "What to write: glb (Blender, three.js: a morph target a muscle, and an animation), obj (the surface), vtu and pvd \
                (ParaView, PyVista: the field, and the way from rest), sto (OpenSim) and csv (activations); of the quadratic \
                program npz (NumPy, with everything), qps (MPS with QUADOBJ) and qp (CPLEX LP)"
    )]
    pub(crate) to: ExportFormat,
    /// The file to write.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// What is written of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExportFormat {
    /// The quadratic program.
    Program(ProgramFormat),
    /// What is seen.
    Scene(SceneFormat),
}

impl ExportFormat {
    const NAMES: [&'static str; 9] = ["glb", "obj", "vtu", "pvd", "sto", "csv", "npz", "qps", "qp"];
}

fn parse_export_format(text: &str) -> Result<ExportFormat, String> {
    use ExportFormat::{Program, Scene};
    Ok(match text {
        "glb" => Scene(SceneFormat::Glb),
        "obj" => Scene(SceneFormat::Obj),
        "vtu" => Scene(SceneFormat::Vtu),
        "pvd" => Scene(SceneFormat::Pvd),
        "sto" => Scene(SceneFormat::Sto),
        "csv" => Scene(SceneFormat::Csv),
        "npz" => Program(ProgramFormat::Npz),
        "qps" => Program(ProgramFormat::Qps),
        "qp" => Program(ProgramFormat::Qp),
        _ => return Err(unknown(text, &ExportFormat::NAMES)),
    })
}

/// Form of a moved face in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SceneFormat {
    /// Binary glTF.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// VTK's unstructured grid.
    Vtu,
    /// A series of them.
    Pvd,
    /// OpenSim's storage.
    Sto,
    /// A table.
    Csv,
}

impl SceneFormat {
    /// The ending of its files.
    pub(crate) fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Obj => "obj",
            Self::Vtu => "vtu",
            Self::Pvd => "pvd",
            Self::Sto => "sto",
            Self::Csv => "csv",
        }
    }
}

/// Form of a program in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProgramFormat {
    /// The LP format of CPLEX, with a quadratic objective.
    Qp,
    /// MPS with a QUADOBJ section.
    Qps,
    /// Arrays of NumPy.
    Npz,
}

/// What is done with a target that has to be fitted first.
#[derive(Debug, Args)]
pub(crate) struct FirstFit {
    #[command(flatten)]
    pub(crate) common: CommonOptions,
    /// How lips, cheeks and teeth touch.
    #[arg(long, value_enum, default_value_t = ContactMode::Reactions)]
    pub(crate) contact: ContactMode,
    /// How far the model may be from the face: not at all, as far as another mesh, or as far as another anatomist's muscles.
    #[arg(long, value_name = "none|mesh|anatomy", default_value = "anatomy", value_parser = parse_discrepancy)]
    pub(crate) discrepancy: Discrepancy,
}

impl FirstFit {
    /// The fit of the target in the file `target`.
    pub(crate) fn of(&self, target: &Path) -> FitOptions {
        let Self { common, contact, discrepancy } = self;
        FitOptions {
            targets: vec![target.to_owned()],
            common: common.clone(),
            out: None,
            contact: *contact,
            discrepancy: *discrepancy,
            json: false,
            junit: None,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct IdentifyOptions {
    #[arg(
        value_name = "RESULT|TARGET.toml",
        help = "A folder that fit wrote, or a target to fit first; nothing is written"
    )]
    pub(crate) what: PathBuf,
    #[command(flatten)]
    pub(crate) fit: FirstFit,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CalibrateOptions {
    #[arg(
        value_name = "TARGET.toml",
        required = true,
        help = "Targets with markers that were measured and the activations behind them as [[prior]]; muscles that none names are at rest"
    )]
    pub(crate) targets: Vec<PathBuf>,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    #[arg(
        help = "What is known before, as a multiple of the face's and the standard deviation of its logarithm, of tissue_modulus, \
                muscle_modulus, muscle_stress, one muscle without its side, or strength for all muscles; a spread of 0 holds it \
                [default: 1:0.8 for the first three, 1:0.4 for muscles]",
        long,
        value_name = "NAME=MEDIAN:SPREAD",
        value_delimiter = ',',
        value_parser = parse_prior
    )]
    pub(crate) prior: Vec<StatedPrior>,
    /// How far the model may be from the face, from point to point: not at all, as far as another mesh, or as far as another
    /// anatomist's muscles.
    #[arg(long, value_name = "none|mesh|anatomy", default_value = "anatomy", value_parser = parse_discrepancy)]
    pub(crate) discrepancy: Discrepancy,
    /// How lips, cheeks and teeth touch: reactions are contact forces, off is no contact.
    #[arg(long, value_parser = parse_forward_contact, value_name = "reactions|off", default_value = "reactions")]
    pub(crate) contact: ContactMode,
    /// Folder for calibration.json and the calibrated face (face.toml and its files); nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print calibration.json instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SymmetryOptions {
    #[arg(
        value_name = "RESULT|TARGET.toml",
        help = "A folder that fit or forward wrote, or a target to fit first"
    )]
    pub(crate) what: PathBuf,
    #[command(flatten)]
    pub(crate) fit: FirstFit,
    /// Exit code 1 when a landmark differs by more than this from the mirror image of the other side, mm.
    #[arg(long, value_name = "MM", value_parser = parse_asymmetry)]
    pub(crate) max_asymmetry_mm: Option<f64>,
    /// Folder for symmetry.json, and the map over the skin as symmetry.vtu and symmetry.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print symmetry.json instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct MarkersOptions {
    /// How many markers.
    #[arg(long, value_name = "N", default_value = "12", value_parser = clap::value_parser!(u16).range(1..=100))]
    pub(crate) count: u16,
    /// Standard deviation of each component of a marker, mm.
    #[arg(long, value_name = "MM", default_value = "0.5", value_parser = parse_sigma)]
    pub(crate) sigma_mm: f64,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// How strong the muscles are, as a multiple of their `max_force_n`.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength)]
    pub(crate) strength: f64,
    /// The activation at which every muscle's stiffness is held.
    #[arg(long, value_name = "fixed=A", default_value = "fixed=0.5", value_parser = parse_fixed)]
    pub(crate) stiffness: f64,
    /// How far the model may be from the face: not at all, as far as another mesh, or as far as another anatomist's muscles.
    #[arg(long, value_name = "none|mesh|anatomy", default_value = "mesh", value_parser = parse_discrepancy)]
    pub(crate) discrepancy: Discrepancy,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct TrackOptions {
    #[command(flatten)]
    pub(crate) input: RecordingInput,
    /// Which marker is which point of the face, and how they are to be read; without it labels are names of landmarks, and
    /// the first frame is neutral.
    #[arg(long, value_name = "MAP.toml")]
    pub(crate) map: Option<PathBuf>,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// How strong the muscles are, as a multiple of their `max_force_n`.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength)]
    pub(crate) strength: f64,
    /// How strain is measured. At finite strain the face is settled where frames stand for many, and each frame has what muscles
    /// and jaw do about the nearest of these faces.
    #[arg(long, value_name = "linear|finite", default_value = "linear", value_parser = parse_strain)]
    pub(crate) strain: Strain,
    /// Where the stiffness of the muscles is held at linear strain: each at its mean activation over the recording, or all at A;
    /// follow lets it follow the activations, as at finite strain it always does.
    #[arg(long, value_name = "mean|follow|fixed=A", value_parser = parse_held)]
    pub(crate) stiffness: Option<HeldStiffness>,
    /// How lips, cheeks and teeth touch.
    #[arg(long, value_parser = parse_forward_contact, value_name = "reactions|off", default_value = "reactions")]
    pub(crate) contact: ContactMode,
    /// Write the interval that the noise allows each activation in every Kth frame, too: what its markers determine.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) intervals: Option<u16>,
    /// How far the model may be from the face, for the intervals: not at all, as far as another mesh, or as far as another
    /// anatomist's muscles.
    #[arg(long, value_name = "none|mesh|anatomy", default_value = "anatomy", value_parser = parse_discrepancy)]
    pub(crate) discrepancy: Discrepancy,
    /// Settle the face anew in the strongest frame of each block, its muscles as stiff as they are active, and tell how far the
    /// markers are from where they were fitted.
    #[arg(long, value_name = "linear|finite", value_parser = parse_strain)]
    pub(crate) check: Option<Strain>,
    /// Write every Kth frame of the whole face, too, and series.pvd that lists them.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) series: Option<u16>,
    /// Folder for the tables and summary.json; a run that was stopped goes on there.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Print summary.json instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

impl TrackOptions {
    /// Where the stiffness is held at linear strain.
    pub(crate) fn stiffness(&self) -> Result<HeldStiffness, CliError> {
        match (self.strain, self.stiffness) {
            (Strain::Finite, Some(held)) if held != HeldStiffness::Follow => {
                Err(CliError::HeldAtFiniteStrain(held.text()))
            }
            (Strain::Finite, _) => Ok(HeldStiffness::Mean),
            (Strain::Linear, held) => Ok(held.unwrap_or_default()),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct ForwardOptions {
    #[command(flatten)]
    pub(crate) common: CommonOptions,
    #[arg(
        help = "Activations from 0 to 1, such as zygomaticus_major=0.5,risorius_l=1; a name without side is both sides",
long, required_unless_present = "jaw_opening", value_name = "NAME=VALUE", value_delimiter = ',', value_parser = parse_assignment)]
    pub(crate) activate: Vec<Assignment>,
    /// How far the jaw is open: the arc of the lower incisal point about the condylar axis, mm.
    #[arg(long, value_name = "MM", value_parser = parse_opening)]
    pub(crate) jaw_opening: Option<f64>,
    /// Folder for solution.json and face.vtu [default: out/FACE/forward].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// How lips, cheeks and teeth touch.
    #[arg(long, value_parser = parse_forward_contact, value_name = "reactions|off", default_value = "reactions")]
    pub(crate) contact: ContactMode,
    /// Print solution.json instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct MapOptions {
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// The activation at which every muscle's stiffness is held: only then is there a linear map.
    #[arg(long, value_name = "fixed=A", default_value = "fixed=0.5", value_parser = parse_fixed)]
    pub(crate) stiffness: f64,
    /// The file to write.
    #[arg(long, value_name = "FILE.npz", value_parser = |text: &str| parse_out(text, "npz", "a map is written as NPZ, for NumPy"))]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RecordingOptions {
    #[command(flatten)]
    pub(crate) input: RecordingInput,
    /// Write it as a table with a row a frame, in mm and s.
    #[arg(long, value_name = "FILE.csv", value_parser = |text: &str| parse_out(text, "csv", "recordings are written as CSV"))]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A recording, and what its file may leave unsaid.
#[derive(Debug, Args)]
pub(crate) struct RecordingInput {
    #[arg(
        value_name = "RECORDING",
        help = "Markers over time: C3D, TRC, CSV, or landmarks of MediaPipe; the content decides"
    )]
    pub(crate) recording: PathBuf,
    /// The unit of its lengths, where the file states none or a wrong one.
    #[arg(long, value_name = "mm|cm|m", value_parser = parse_unit)]
    pub(crate) unit: Option<LengthUnit>,
    /// Frames a second, where the file numbers its frames and gives no time.
    #[arg(long, value_name = "HZ", value_parser = parse_rate)]
    pub(crate) rate_hz: Option<f64>,
    /// The file of the positions from which the displacements of a table count.
    #[arg(long, value_name = "FILE")]
    pub(crate) neutral: Option<PathBuf>,
    /// The size of the image, in pixels, of which the landmarks of a video are shares.
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_image)]
    pub(crate) image: Option<[f64; 2]>,
    /// What tells how large the face in a video is, in place of its irises of 11.77 mm: a distance that was measured.
    #[arg(long, value_name = "FROM,TO=MM", value_parser = parse_length)]
    pub(crate) length: Option<MeasuredLength>,
}

impl RecordingInput {
    /// What is said in place of the file.
    pub(crate) fn stated(&self) -> ReadOptions<'_> {
        let scale = match &self.length {
            None => ImageScale::Iris,
            Some(MeasuredLength { from, to, mm }) => ImageScale::Length { from, to, length_mm: *mm },
        };
        ReadOptions {
            unit: self.unit,
            rate_hz: self.rate_hz,
            neutral: self.neutral.as_deref(),
            image: self.image,
            scale,
        }
    }
}

/// A distance between two landmarks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredLength {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) mm: f64,
}

#[derive(Debug, Args)]
pub(crate) struct ReportOptions {
    #[arg(
        value_name = "RESULT",
        required = true,
        help = "A folder that fit or forward wrote; two are shown beside each other; or one that track wrote"
    )]
    pub(crate) results: Vec<PathBuf>,
    /// The page to write.
    #[arg(long, value_name = "FILE.html", value_parser = |text: &str| parse_out(text, "html", "a report is a page"))]
    pub(crate) out: PathBuf,
    #[arg(
        help = "Parts into which the way from rest to an answer is cut; the face is computed at each",
        long,
        value_name = "PARTS",
        default_value_t = 4,
        value_parser = clap::value_parser!(u8).range(1..=32)
    )]
    pub(crate) parts: u8,
    /// Play the results, which are of one face, one after the other.
    #[arg(long)]
    pub(crate) sequence: bool,
    /// Play the rows of a table of activations by superposition of the tangent at RESULT: columns `time_s` and the muscles'.
    #[arg(long, value_name = "TABLE.csv", conflicts_with = "sequence")]
    pub(crate) frames: Option<PathBuf>,
    /// Show every Kth frame of a track [default: so that there are eighty at most].
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) every: Option<u16>,
}

#[derive(Debug, Args)]
pub(crate) struct PlotOptions {
    #[arg(value_name = "RESULT", help = "A folder that fit or forward wrote")]
    pub(crate) result: PathBuf,
    /// What to plot: activations with their intervals, residuals of the markers, effort against misfit, left against right, force
    /// over length, or activations over time.
    #[arg(long, value_enum)]
    pub(crate) kind: PlotKind,
    /// The plot to write.
    #[arg(long, value_name = "FILE.svg", value_parser = |text: &str| parse_out(text, "svg", "plots are written as SVG"))]
    pub(crate) out: PathBuf,
    /// The table of activations over time, of --kind time: columns `time_s` and the muscles'.
    #[arg(long, value_name = "TABLE.csv")]
    pub(crate) frames: Option<PathBuf>,
}

/// What is plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlotKind {
    /// Activations with their intervals.
    Activations,
    /// Residuals of the markers.
    Residuals,
    /// Effort against misfit.
    LCurve,
    /// Left against right.
    Symmetry,
    /// Force of the muscles over their length.
    Length,
    /// Activations over time.
    Time,
}

#[derive(Debug, Args)]
pub(crate) struct RenderOptions {
    /// "standard", a face.toml, or a folder written by fit or forward.
    #[arg(value_name = "standard|FACE.toml|DIR", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// Where the face is seen from.
    #[arg(long, value_name = "front|profile|three-quarter", default_value = "front", value_parser = parse_view)]
    pub(crate) view: View,
    /// The picture to write.
    #[arg(long, value_name = "FILE.png", value_parser = |text: &str| parse_out(text, "png", "pictures are written as PNG"))]
    pub(crate) out: PathBuf,
    /// Size in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "640x600", value_parser = parse_size)]
    pub(crate) size: Size,
    #[arg(long, value_name = "WHAT[,WHAT...]", help = "What to draw, of skin, teeth, muscles, forces and displacement [default: skin,teeth]", value_parser = parse_show)]
    pub(crate) show: Option<Show>,
    #[arg(
        help = "Activations from 0 to 1, such as zygomaticus_major=0.5; a name without side is both sides",
        long,
        value_name = "NAME=VALUE",
        value_delimiter = ',',
        value_parser = parse_assignment
    )]
    pub(crate) activate: Vec<Assignment>,
    /// How strain is measured: linear is right for small movements and the founding paper's, finite for any.
    #[arg(long, value_name = "linear|finite", default_value = "linear", value_parser = parse_strain)]
    pub(crate) strain: Strain,
    /// How strong the muscles are, as a multiple of their `max_force_n`: 2.5 brings the standard face to 0.25 N/mm², about
    /// the specific tension of human skeletal muscle.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength)]
    pub(crate) strength: f64,
    /// How stiff the muscles are: as their activation makes them, or all held at activation A.
    #[arg(long, value_name = "activated|fixed=A", default_value = "activated", value_parser = parse_stiffness)]
    pub(crate) stiffness: Stiffness,
    /// How lips, cheeks and teeth touch.
    #[arg(long, value_parser = parse_forward_contact, value_name = "reactions|off", default_value = "reactions")]
    pub(crate) contact: ContactMode,
    /// Trace the outline of the face at rest.
    #[arg(long)]
    pub(crate) rest_outline: bool,
}

#[derive(Debug, Args)]
pub(crate) struct FiguresOptions {
    #[command(flatten)]
    pub(crate) common: CommonOptions,
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR", default_value = "docs/figures")]
    pub(crate) out: PathBuf,
    /// The target whose answer is drawn as smile.png.
    #[arg(long, value_name = "TARGET.toml", default_value = "targets/symmetric_smile.toml")]
    pub(crate) smile: PathBuf,
    /// The surgical plan whose faces before and after are drawn under its name.
    #[arg(long, value_name = "PLAN.toml", default_value = "examples/setback/plan.toml")]
    pub(crate) plan: PathBuf,
    /// The activation of each muscle in its picture.
    #[arg(long, value_name = "A", default_value = "0.5", value_parser = parse_fraction)]
    pub(crate) activation: f64,
}

#[derive(Debug, Args)]
pub(crate) struct GalleryOptions {
    #[arg(
        value_name = "TARGET.toml|DIR",
        default_value = "targets",
        help = "Target files, or folders of them"
    )]
    pub(crate) targets: Vec<PathBuf>,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// How strong the muscles are at finite strain, as a multiple of their `max_force_n`.
    #[arg(long, value_name = "FACTOR", default_value = "2.5", value_parser = parse_strength)]
    pub(crate) strength: f64,
    /// How long a fit may take; one that has not ended by then has no answer.
    #[arg(long, value_name = "MINUTES", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=1440))]
    pub(crate) minutes: u16,
    /// Folder for the answers, DIR/TARGET/STRAIN; those that are there already are drawn as they are.
    #[arg(long, value_name = "DIR", default_value = "out/gallery")]
    pub(crate) answers: PathBuf,
    /// Folder for the pictures and README.md, their index.
    #[arg(long, value_name = "DIR", default_value = "docs/gallery")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RegisterOptions {
    #[arg(
        value_name = "SCAN",
        help = "The skin of the neutral face, lips closed: OBJ, PLY or STL, +x the subject's left, +y up, +z anterior as far \
                as landmarks do not tell otherwise"
    )]
    pub(crate) scan: PathBuf,
    /// Landmarks on it, eight at least: columns landmark, `x_mm`, `y_mm`, `z_mm`, or x, y, z in --unit.
    #[arg(long, value_name = "L.csv")]
    pub(crate) landmarks: PathBuf,
    /// The unit of the scan and of all other surfaces.
    #[arg(long, value_name = "mm|cm|m", default_value = "mm", value_parser = parse_unit)]
    pub(crate) unit: LengthUnit,
    /// Upper teeth; without them the standard's are placed behind the lips.
    #[arg(long, value_name = "FILE")]
    pub(crate) teeth_upper: Option<PathBuf>,
    /// Lower teeth.
    #[arg(long, value_name = "FILE")]
    pub(crate) teeth_lower: Option<PathBuf>,
    /// The skull, from a segmentation; without it the standard's depths of tissue are kept.
    #[arg(long, value_name = "FILE")]
    pub(crate) skull: Option<PathBuf>,
    /// The mandible.
    #[arg(long, value_name = "FILE")]
    pub(crate) mandible: Option<PathBuf>,
    #[arg(help = "The face that is matched: standard, standard_coarse, standard_fine, or a face.toml", long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// What the face is called [default: as the scan].
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Folder for the face (face.toml and its files), registration.json and registration.vtu, the maps.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Print registration.json instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SurgeryOptions {
    #[arg(value_name = "PLAN.toml", help = "The plan, such as examples/setback/plan.toml")]
    pub(crate) plan: PathBuf,
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// How strain is measured: linear is right for small movements, finite for any, and nothing crosses on the way.
    #[arg(long, value_name = "linear|finite", default_value = "linear", value_parser = parse_strain)]
    pub(crate) strain: Strain,
    /// Folder for the new face (face.toml and its files), and for solution.json and face.vtu: how the old one
    /// moves.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Draw the face before and after, from the front and the left, the profile before over both.
    #[arg(long, value_name = "FILE.png", value_parser = |text: &str| parse_out(text, "png", "pictures are written as PNG"))]
    pub(crate) picture: Option<PathBuf>,
    /// Print solution.json instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct CommonOptions {
    #[arg(help = FACE, long, value_name = "standard|FACE.toml", default_value = "standard", value_parser = parse_face)]
    pub(crate) face: FaceChoice,
    /// How strain is measured: linear is right for small movements and the founding paper's, finite for any.
    #[arg(long, value_name = "linear|finite", default_value = "linear", value_parser = parse_strain)]
    pub(crate) strain: Strain,
    /// How strong the muscles are, as a multiple of their `max_force_n`: 2.5 brings the standard face to 0.25 N/mm², about
    /// the specific tension of human skeletal muscle.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = parse_strength)]
    pub(crate) strength: f64,
    /// How stiff the muscles are: as their activation makes them, or all held at activation A.
    #[arg(long, value_name = "activated|fixed=A", default_value = "activated", value_parser = parse_stiffness)]
    pub(crate) stiffness: Stiffness,
}

#[derive(Debug, Subcommand)]
pub(crate) enum FaceVerb {
    /// Say whether a face can be used, and what is odd about it.
    Check {
        #[arg(help = FACE, value_parser = parse_face)]
        face: FaceChoice,
    },
    /// Write faces of many people: the standard face with proportions drawn from their published spread.
    Sample {
        /// How many.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
        count: u16,
        /// Which people: the same number gives the same.
        #[arg(long, value_name = "S", default_value_t = 0)]
        seed: u64,
        /// Folder for one folder a face, and for faces.csv, their proportions.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// How finely they are meshed.
        #[arg(long, value_name = "coarse|standard|fine", default_value = "standard", value_parser = parse_resolution)]
        resolution: Resolution,
    },
    /// Write a built-in face as a face.toml with its files.
    Export {
        /// The built-in face.
        #[arg(value_parser = ["standard"])]
        face: String,
        /// Folder to write to.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// How finely it is meshed.
        #[arg(long, value_name = "coarse|standard|fine", default_value = "standard", value_parser = parse_resolution)]
        resolution: Resolution,
    },
}

/// Which face to use.
#[derive(Clone, Debug)]
pub(crate) enum FaceChoice {
    /// A built-in one.
    Standard(Resolution),
    /// One described by a file.
    File(PathBuf),
}

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub(crate) usize, pub(crate) usize);

impl CommonOptions {
    /// The mechanics that they ask for.
    pub(crate) fn mechanics(&self, contact: ContactMode) -> Mechanics {
        Mechanics { strain: self.strain, stiffness: self.stiffness, contact: contact != ContactMode::Off }
    }
}

impl RenderOptions {
    /// The mechanics that they ask for.
    pub(crate) fn mechanics(&self) -> Mechanics {
        let contact = self.contact != ContactMode::Off;
        Mechanics { strain: self.strain, stiffness: self.stiffness, contact }
    }
}

/// How contact is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ContactMode {
    /// Contact forces are unknowns.
    Reactions,
    /// The gaps of the contact-free map must stay open.
    Kinematic,
    /// No contact.
    Off,
}

impl FaceChoice {
    /// The face that `text` names: a built-in one, or a path.
    pub(crate) fn named(text: &str) -> Self {
        Resolution::of_face(text).map_or_else(|| Self::File(PathBuf::from(text)), Self::Standard)
    }
}

fn parse_face(text: &str) -> Result<FaceChoice, String> {
    match text {
        "" => Err("give \"standard\" or the path of a face.toml".to_owned()),
        text => Ok(FaceChoice::named(text)),
    }
}

impl ContactMode {
    /// The mode called `name`, or `None`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        [Self::Reactions, Self::Kinematic, Self::Off].into_iter().find(|mode| mode.name() == name)
    }

    /// Its name at interfaces.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Reactions => "reactions",
            Self::Kinematic => "kinematic",
            Self::Off => "off",
        }
    }
}

fn parse_strain(text: &str) -> Result<Strain, String> {
    Strain::parse(text).ok_or_else(|| unknown(text, &Strain::NAMES))
}

fn parse_discrepancy(text: &str) -> Result<Discrepancy, String> {
    Discrepancy::parse(text).ok_or_else(|| unknown(text, &Discrepancy::NAMES))
}

fn parse_prior(text: &str) -> Result<StatedPrior, String> {
    let parse = || {
        let (name, prior) = text.split_once('=')?;
        let (median, spread) = prior.split_once(':')?;
        let (median, spread) = (median.trim().parse().ok()?, spread.trim().parse().ok()?);
        Some(StatedPrior { name: name.trim().to_owned(), prior: LogNormal { median, spread } })
    };
    parse().ok_or_else(|| {
        "write a name, a multiple of the face's value and the spread of its logarithm, such as muscle_stress=2.5:0.3"
            .to_owned()
    })
}

fn parse_sigma(text: &str) -> Result<f64, String> {
    let [least, most] = Target::SIGMA_MM;
    match text.parse() {
        Ok(mm) if (least..=most).contains(&mm) => Ok(mm),
        _ => Err(format!("write a standard deviation in mm, from {least} to {most}, such as 0.5")),
    }
}

fn parse_unit(text: &str) -> Result<LengthUnit, String> {
    LengthUnit::parse(text).ok_or_else(|| unknown(text, &LengthUnit::NAMES))
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if hz > 0. && hz <= 1e6 => Ok(hz),
        _ => Err("write the frames a second, such as 60".to_owned()),
    }
}

fn parse_image(text: &str) -> Result<[f64; 2], String> {
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| *side > 0).map(f64::from);
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "write WIDTHxHEIGHT in pixels, such as 1920x1080".to_owned())
}

fn parse_length(text: &str) -> Result<MeasuredLength, String> {
    let parse = || {
        let (ends, mm) = text.split_once('=')?;
        let (from, to) = ends.split_once(',')?;
        let mm = mm.trim().parse().ok().filter(|mm| (1. ..=1000.).contains(mm))?;
        Some(MeasuredLength { from: from.trim().to_owned(), to: to.trim().to_owned(), mm })
    };
    parse().ok_or_else(|| {
        "write two landmarks and their distance in mm, such as exocanthion_r,exocanthion_l=90".to_owned()
    })
}

fn parse_asymmetry(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(mm) if (0. ..=100.).contains(&mm) => Ok(mm),
        _ => Err("write a length in mm, from 0 to 100, such as 3".to_owned()),
    }
}

fn parse_strength(text: &str) -> Result<f64, String> {
    const STRONGEST: f64 = 100.;
    match text.parse() {
        Ok(factor) if factor > 0. && factor <= STRONGEST => Ok(factor),
        _ => Err(format!("give a factor above 0, {STRONGEST} at most, such as 2.5")),
    }
}

pub(crate) fn parse_stiffness(text: &str) -> Result<Stiffness, String> {
    match text {
        "activated" => Ok(Stiffness::Activated),
        _ => parse_fixed(text).map(Stiffness::Fixed).map_err(|e| format!("write activated, or {e}")),
    }
}

fn parse_fixed(text: &str) -> Result<f64, String> {
    let example = "fixed=A with A from 0 to 1, such as fixed=0.5";
    if text == "activated" {
        return Err(format!("a map is linear only at a held stiffness; write {example}"));
    }
    match text.strip_prefix("fixed=").map(str::parse) {
        Some(Ok(value)) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err(example.to_owned()),
    }
}

fn parse_forward_contact(text: &str) -> Result<ContactMode, String> {
    match text {
        "reactions" => Ok(ContactMode::Reactions),
        "off" => Ok(ContactMode::Off),
        "kinematic" => {
            Err("kinematic contact limits a fit and moves nothing; write reactions or off".to_owned())
        }
        _ => Err("write reactions or off".to_owned()),
    }
}

/// What is wrong with `text`, the valid choices, and the nearest of them.
fn unknown(text: &str, choices: &[&str]) -> String {
    let hint = nearest(text, choices.iter().copied()).map(|c| format!("; did you mean {c}?"));
    format!("write one of {}{}", choices.join(", "), hint.unwrap_or_default())
}

/// A file to write whose ending tells its format.
fn parse_out(text: &str, ending: &str, why: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(own) if own.eq_ignore_ascii_case(ending) => Ok(path),
        _ => Err(format!("{why}; name it {}", path.with_extension(ending).display())),
    }
}

fn parse_view(text: &str) -> Result<View, String> {
    View::parse(text).ok_or_else(|| unknown(text, &View::NAMES))
}

fn parse_show(text: &str) -> Result<Show, String> {
    let mut show = Show::default();
    for name in text.split(',').map(str::trim) {
        if !show.add(name) {
            return Err(format!("nothing is called {name}; {}", unknown(name, &Show::NAMES)));
        }
    }
    Ok(show)
}

fn parse_size(text: &str) -> Result<Size, String> {
    let sides = || {
        let (width, height) = text.split_once('x')?;
        Some(Size(width.trim().parse().ok()?, height.trim().parse().ok()?))
    };
    let side = MIN_SIDE..=MAX_SIDE;
    match sides() {
        None => Err("write WIDTHxHEIGHT in pixels, such as 640x720".to_owned()),
        Some(size) if side.contains(&size.0) && side.contains(&size.1) => Ok(size),
        Some(_) => Err(format!("each side may be from {MIN_SIDE} to {MAX_SIDE} pixels, such as 640x720")),
    }
}

fn parse_opening(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if 0.0 < value && value < 0.05 => {
            Err("less than a jaw opens: metres? Write the opening in mm, such as 4".to_owned())
        }
        Ok(value) if (0.0..=Jaw::WIDEST_MM).contains(&value) => Ok(value),
        _ => Err(format!("write the opening in mm, from 0 to {}, such as 4", Jaw::WIDEST_MM)),
    }
}

fn parse_held(text: &str) -> Result<HeldStiffness, String> {
    match text {
        "mean" => Ok(HeldStiffness::Mean),
        "follow" => Ok(HeldStiffness::Follow),
        _ => parse_fixed(text)
            .map(HeldStiffness::At)
            .map_err(|_| "write mean, follow, or fixed=A with A from 0 to 1".to_owned()),
    }
}

fn parse_fraction(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("write a number above 0 and up to 1, such as 0.5".to_owned()),
    }
}

fn parse_resolution(text: &str) -> Result<Resolution, String> {
    Resolution::parse(text).ok_or_else(|| format!("write one of {}", Resolution::NAMES.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn what_a_recording_leaves_unsaid_is_stated() {
        assert_eq!(parse_image("1920x1080"), Ok([1920., 1080.]));
        let expected = MeasuredLength { from: "p4".into(), to: "nasion".into(), mm: 51.5 };
        assert_eq!(parse_length("p4,nasion=51.5"), Ok(expected));
        assert!(parse_image("0x5").is_err() && parse_image("5").is_err() && parse_length("a=1").is_err());
        assert!(["a,b=", "a,b=0", "a,b=nan"].iter().all(|bad| parse_length(bad).is_err()));
        assert!(["0", "-1", "inf", "x"].iter().all(|bad| parse_rate(bad).is_err()));
        assert!(parse_unit("inch").is_err_and(|e| e.contains("mm, cm, m")));
    }

    #[test]
    fn stiffness_is_activated_or_a_fraction() {
        assert_eq!(parse_stiffness("fixed=0.25"), Ok(Stiffness::Fixed(0.25)));
        assert_eq!(parse_stiffness("activated"), Ok(Stiffness::Activated));
        for bad in ["fixed", "fixed=", "fixed=1.1", "fixed=nan", "0.5", "active"] {
            assert!(
                parse_stiffness(bad).is_err_and(|e| e.contains("activated") && e.contains("fixed=0.5")),
                "{bad}"
            );
        }
        assert!(parse_fixed("activated").is_err_and(|e| e.contains("fixed=0.5")));
    }
}
