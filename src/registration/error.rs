//! What stops a registration, and what is odd about one.

use thiserror::Error;

use crate::face::standard::ParameterError;
use crate::forward::ForwardError;
use crate::units::counted;

/// Why a scan cannot be registered.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RegistrationError {
    /// Too few landmarks that the face knows.
    #[error(
        "{} of the landmarks given {} known to the face, and {needed} are needed; it knows: {}",
        known, if *known == 1 { "is" } else { "are" }, names.join(", ")
    )]
    FewLandmarks {
        /// Landmarks given that the face has.
        known: usize,
        /// How many are needed.
        needed: usize,
        /// Those that the face has.
        names: Vec<String>,
    },
    /// A landmark twice.
    #[error("the landmark {name} is given twice; keep one")]
    Twice {
        /// Its name.
        name: String,
    },
    /// A coordinate that is no number.
    #[error("{what} has a coordinate that is not finite; leave it out or mend it")]
    NotFinite {
        /// A landmark or a surface.
        what: String,
    },
    /// Landmarks that lie in a line or at one place.
    #[error(
        "the landmarks lie in one line or at one place, which fixes no position; give them as they are on the face"
    )]
    Collinear,
    /// Coordinates in another unit.
    #[error(
        "the landmarks spread over {ratio:.4} of the size of a face in mm: {}", unit_hint(.unit)
    )]
    Unit {
        /// Size over that of the face.
        ratio: f64,
        /// The unit that it seems to be.
        unit: Option<&'static str>,
    },
    /// Left and right are exchanged throughout.
    #[error(
        "left and right are exchanged: the landmarks fit a mirrored face to {mirrored_mm:.1} mm and a face only to \
         {rms_mm:.1} mm; _l is the subject's own left, and a scan that was mirrored on the way must be mirrored back"
    )]
    Mirrored {
        /// What a rotation leaves, rms, mm.
        rms_mm: f64,
        /// What a reflection leaves, rms, mm.
        mirrored_mm: f64,
    },
    /// Two landmarks have each other's names.
    #[error(
        "the landmarks {first} and {second} seem to be exchanged: the other way round all fit to {exchanged_mm:.1} mm, \
         as they are to {rms_mm:.1} mm; exchange their names"
    )]
    Exchanged {
        /// One.
        first: String,
        /// The other.
        second: String,
        /// What the fit leaves, rms, mm.
        rms_mm: f64,
        /// What it leaves the other way round, rms, mm.
        exchanged_mm: f64,
    },
    /// Landmarks that are not those of a face.
    #[error(
        "the landmarks fit a face only to {rms_mm:.1} mm, {name} worst by {worst_mm:.0} mm; check names and axes \
         (+x the subject's left, +y up, +z anterior)"
    )]
    NoFace {
        /// What the fit leaves, rms, mm.
        rms_mm: f64,
        /// The landmark that is farthest off.
        name: String,
        /// By how much, mm.
        worst_mm: f64,
    },
    /// A scan without triangles.
    #[error("the scan has no triangle; export it as a mesh, not as points")]
    EmptyScan,
    /// Landmarks and scan do not belong together.
    #[error(
        "{off} of {} are farther than {limit_mm:.0} mm from the scan, {median_mm:.3} mm in the median: landmarks and \
         scan differ in unit or axes; export both from one program without turning or scaling either", counted(*landmarks, "landmark")
    )]
    OffScan {
        /// How many are off.
        off: usize,
        /// Of how many.
        landmarks: usize,
        /// What counts as off, mm.
        limit_mm: f64,
        /// Median distance, mm.
        median_mm: f64,
    },
    /// Hardly any of the face's skin has a counterpart.
    #[error(
        "the scan covers {:.0} per cent of the lower face's skin, and {:.0} are needed; give one that reaches from the nose \
         to the chin and from cheek to cheek", 100. * covered, 100. * needed
    )]
    LittleCovered {
        /// Share of the skin with a counterpart.
        covered: f64,
        /// What is needed.
        needed: f64,
    },
    /// A bone that is elsewhere.
    #[error(
        "{:.0} per cent of the tissue that belongs on the {bone} is within {reach_mm:.0} mm of the one given: bone and scan differ in unit or \
         axes; export both from one program without turning or scaling either", 100. * held
    )]
    BoneAway {
        /// The bone.
        bone: String,
        /// Share of its nodes that found it.
        held: f64,
        /// How far it is sought, mm.
        reach_mm: f64,
    },
    /// The proportions cannot be built.
    #[error(transparent)]
    Proportions(#[from] ParameterError),
    /// The tissue that regularises the match cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
}

fn unit_hint(unit: &Option<&'static str>) -> String {
    match unit {
        Some("in") => "inches? Multiply scan and landmarks by 25.4".to_owned(),
        Some(unit) => format!("give --unit {unit}, or scan and landmarks in mm"),
        None => "give scan and landmarks in mm, or state their unit with --unit".to_owned(),
    }
}

/// What is odd about a registration, with its remedy.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RegistrationWarning {
    /// The scan is turned against the face's axes.
    #[error(
        "the scan was turned by {degrees:.0} degrees into the face's axes; registration.json has the motion"
    )]
    Turned {
        /// By how much.
        degrees: f64,
    },
    /// The triangles of the scan face inward.
    #[error("the scan's triangles face inward; they were taken the other way round")]
    InsideOut,
    /// The triangles of a bone face into it.
    #[error("the triangles of the {bone} face inward; they were taken the other way round")]
    BoneInsideOut {
        /// The bone.
        bone: String,
    },
    /// A bone of which the tissue has found a part.
    #[error(
        "{:.0} per cent of the tissue that belongs on the {bone} has found the one given; elsewhere it has the depth of the standard's",
        100. * held
    )]
    BonePartly {
        /// The bone.
        bone: String,
        /// Share of its nodes that found it.
        held: f64,
    },
    /// Parts of the scan were left out.
    #[error(
        "the scan has {}; those without a landmark, {:.0} per cent of its area, were left out",
        counted(*pieces, "separate piece"), 100. * share
    )]
    Pieces {
        /// How many pieces.
        pieces: usize,
        /// Share of the area that was left out.
        share: f64,
    },
    /// The scan was thinned.
    #[error("the scan's {triangles} triangles were thinned to {kept}, about {spacing_mm} mm apart")]
    Thinned {
        /// Before.
        triangles: usize,
        /// After.
        kept: usize,
        /// Side of the cells in which vertices were joined, mm.
        spacing_mm: f64,
    },
    /// A landmark that the face does not have.
    #[error("the face has no landmark {name}, which was left out; it knows: {}", known.join(", "))]
    UnknownLandmark {
        /// Its name.
        name: String,
        /// Those that the face has.
        known: Vec<String>,
    },
    /// A landmark far from where the others have it.
    #[error(
        "the landmark {name} is {distance_mm:.0} mm from where the others have it, and was left out; check its place"
    )]
    MisplacedLandmark {
        /// Its name.
        name: String,
        /// How far, mm.
        distance_mm: f64,
    },
    /// A landmark off the scan.
    #[error("the landmark {name} is {distance_mm:.1} mm from the scan; it counts for the position alone")]
    LandmarkOffScan {
        /// Its name.
        name: String,
        /// How far, mm.
        distance_mm: f64,
    },
    /// The scan has holes.
    #[error("the scan has {} in the lower face, {longest_mm:.0} mm round the longest; there the skin is the face's own", counted(*holes, "hole"))]
    Holes {
        /// How many.
        holes: usize,
        /// Length of the longest rim, mm.
        longest_mm: f64,
    },
    /// The mouth is open.
    #[error(
        "the mouth is open by {gap_mm:.1} mm; scan it with the lips closed, for the face rests with them together"
    )]
    OpenMouth {
        /// Distance of the stomia, mm.
        gap_mm: f64,
    },
    /// Part of the skin has no counterpart.
    #[error("the scan covers {:.0} per cent of the skin; the rest follows the tissue beside it", 100. * covered)]
    Uncovered {
        /// Share of the area with a counterpart.
        covered: f64,
    },
    /// The skin is far from the scan.
    #[error("the skin is {rms_mm:.2} mm from the scan (rms); look at the map and at the landmarks")]
    FarFromScan {
        /// Root mean square distance, mm.
        rms_mm: f64,
    },
    /// Cells of poor shape.
    #[error(
        "the smallest scaled Jacobian is {scaled_jacobian:.3}, below {least}; displacements near that cell are inexact"
    )]
    PoorCell {
        /// Of the worst cell.
        scaled_jacobian: f64,
        /// What is asked for.
        least: f64,
    },
    /// Lips or teeth that cross at rest.
    #[error("surfaces cross at rest, so that finite strain has no contact there: {what}")]
    Crossing {
        /// Where.
        what: String,
    },
}
