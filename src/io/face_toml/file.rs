//! The tables of a face file, as they are written.

use schemars::JsonSchema;
use serde::Deserialize;

/// A face file: an index of the files of a face. Numbers here are mm, N and kPa in the face's frame (+x
/// the subject's left, +y up, +z anterior); coordinates in the named files are in `unit` and `frame`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Modiolus face")]
pub(super) struct FaceTable {
    /// What the face is called in reports.
    pub(super) name: String,
    /// Unit of the coordinates in the named files: "mm", "cm" or "m". Columns called `x_mm` are mm anyway.
    #[schemars(extend("enum" = ["mm", "cm", "m"]))]
    pub(super) unit: String,
    /// Folder of the named files, relative to this file; this file's own folder when absent.
    pub(super) base: Option<String>,
    /// Volume mesh: VTK, Gmsh, Abaqus, TetGen or FEBio.
    pub(super) mesh: String,
    /// Further node sets: a JSON object of lists of 0-based nodes.
    pub(super) node_sets: Option<String>,
    /// Frame of the coordinates in the named files; the face's own when absent.
    pub(super) frame: Option<FrameTable>,
    /// Passive tissue; 15 kPa and 0.49 when absent.
    pub(super) tissue: Option<TissueTable>,
    /// Muscle tissue; 6.2 to 110 kPa and 0.49 when absent.
    pub(super) muscle_tissue: Option<MuscleTissueTable>,
    /// Node sets fixed to bone.
    pub(super) supports: Vec<SupportTable>,
    /// Node sets selected by place and direction, beside those of the mesh.
    #[serde(default)]
    pub(super) select: Vec<SelectTable>,
    /// Node set of the skin.
    pub(super) skin: String,
    /// Node set of the free inner surface that may touch teeth.
    pub(super) mucosa: Option<String>,
    /// Node set of the upper lip that may touch the lower.
    pub(super) upper_lip: Option<String>,
    /// Node set of the lower lip that may touch the upper.
    pub(super) lower_lip: Option<String>,
    /// The jaw joint; without one the jaw cannot be opened.
    pub(super) jaw: Option<JawTable>,
    /// Tooth surfaces.
    #[serde(default)]
    pub(super) teeth: Vec<TeethTable>,
    /// Landmarks: a CSV with columns landmark, x, y, z (or `x_mm`, `y_mm`, `z_mm`), which are moved to the closest point
    /// of the skin; or stay where they are with the nodes and weights that a further column carriers states.
    pub(super) landmarks: Option<String>,
    /// Further landmarks.
    #[serde(default)]
    pub(super) points: Vec<PointTable>,
    /// Fibres: a CSV with columns muscle, side, fibre, point, x, y, z (or `x_mm`, `y_mm`, `z_mm`), in the order of
    /// the points; side is l, r or empty.
    pub(super) fibres: Option<String>,
    /// Greatest distance outside the mesh from which fibre points and landmarks are moved into it, mm.
    #[serde(default = "five")]
    pub(super) max_projection_mm: f64,
    /// Greatest distance between neighbouring fibre points, mm.
    #[serde(default = "one")]
    pub(super) fibre_step_mm: f64,
    /// How the fibres run: "smooth" (the default), along smooth curves through their points that are brought inside
    /// the mesh and cut into equal steps; or "polyline", from point to point as given, as an exported face has them.
    #[schemars(extend("enum" = ["smooth", "polyline"]))]
    pub(super) fibre_course: Option<String>,
    /// Muscles.
    #[serde(default)]
    pub(super) muscles: Vec<MuscleTable>,
}

/// Where the axes of the files point and where the face's origin lies in them.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameTable {
    /// Where the files' x, y and z point: each one of left, right, up, down, anterior, posterior.
    #[serde(default = "own_axes")]
    pub(super) axes: [String; 3],
    /// The face's origin in the files' coordinates and unit; the mid-sagittal plane x = 0 goes through it.
    #[serde(default)]
    pub(super) origin: [f64; 3],
}

/// Passive isotropic tissue.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TissueTable {
    /// Young's modulus, kPa.
    pub(super) young_kpa: f64,
    /// Poisson's ratio.
    pub(super) poisson: f64,
    /// Stiffening at finite strain, the ratio c2/c1 of the Yeoh law; 0 is neo-Hookean. Default 0.47.
    pub(super) strain_stiffening: Option<f64>,
}

/// Muscle tissue.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MuscleTissueTable {
    /// Modulus at rest, kPa.
    pub(super) rest_kpa: f64,
    /// Modulus along the fibre at full activation, kPa.
    pub(super) active_kpa: f64,
    /// Poisson's ratio.
    pub(super) poisson: f64,
    /// How the stiffness follows activation: "reinforced" (the default) or "orthotropic".
    #[schemars(extend("enum" = ["reinforced", "orthotropic"]))]
    pub(super) law: Option<String>,
}

/// A node set fixed to bone.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportTable {
    /// Bone segment: "skull", "maxilla" or "mandible"; with `part_of` the name of a piece.
    pub(super) bone: String,
    /// The bone of which this is a piece: "skull", "maxilla" or "mandible". What moves that one moves this too.
    #[schemars(extend("enum" = ["skull", "maxilla", "mandible"]))]
    pub(super) part_of: Option<String>,
    /// Node set.
    pub(super) set: String,
}

/// The jaw joint: opening turns the bone about the line through the condyles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JawTable {
    /// The bone that turns, with every piece of it.
    #[serde(default = "mandible")]
    pub(super) bone: String,
    /// Centres of the subject's left and right condyle, mm.
    pub(super) condyles_mm: [[f64; 3]; 2],
    /// Lower incisal point, where the opening is measured, mm.
    pub(super) incisor_mm: [f64; 3],
}

/// The outer nodes in a box, and if `facing` is given only those whose outward normal faces that way.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SelectTable {
    /// Name of the set.
    pub(super) name: String,
    /// Smallest and largest corner of the box, mm.
    pub(super) within_mm: [[f64; 3]; 2],
    /// Direction.
    pub(super) facing: Option<[f64; 3]>,
    /// Least cosine between the outward normal and `facing`.
    #[serde(default = "three_tenths")]
    pub(super) facing_cosine: f64,
}

/// A tooth surface.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TeethTable {
    /// "upper" or "lower".
    #[schemars(extend("enum" = ["upper", "lower"]))]
    pub(super) arch: String,
    /// The bone that carries it: when absent the maxilla if the face has one, else the skull, for the upper
    /// arch, and the mandible for the lower.
    pub(super) bone: Option<String>,
    /// Surface: OBJ, STL, PLY or VTK.
    pub(super) file: String,
    /// Close the holes of the surface, and leave out pieces that enclose nothing.
    #[serde(default)]
    pub(super) cap_holes: bool,
    /// Turn triangles so that each piece of the surface is oriented alike throughout, and outward.
    #[serde(default)]
    pub(super) orient: bool,
}

/// A landmark by its place.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PointTable {
    /// Name.
    pub(super) name: String,
    /// Place, mm; moved to the closest point of the skin.
    pub(super) at_mm: [f64; 3],
}

/// A muscle, on one or both sides.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MuscleTable {
    /// Name as in the fibres file; the side is appended to a paired muscle.
    pub(super) name: String,
    /// Sides, "l" and "r"; an empty list is an unpaired muscle.
    #[serde(default = "both_sides")]
    pub(super) sides: Vec<String>,
    /// Fibres file, when it is not the one of all muscles.
    pub(super) file: Option<String>,
    /// Force at full activation, N.
    pub(super) max_force_n: f64,
    /// Tissue within this distance of a fibre is muscle tissue, mm.
    pub(super) radius_mm: Option<f64>,
    /// Cross-section, mm². With a radius the tissue within it is muscle in the fraction that this
    /// area fills; alone it gives the radius, that of the fibres together as round strands.
    pub(super) area_mm2: Option<f64>,
    /// Length at the insertion over which the tension ramps to zero, mm.
    #[serde(default)]
    pub(super) insertion_mm: f64,
    /// The end of the polylines in the file at which the muscle arises, "first" or "last": one for all, or
    /// a list of one for each polyline of a side.
    #[serde(default)]
    pub(super) origin: Origins,
    /// Into how many fibres each polyline is spread.
    #[serde(default = "one_fibre")]
    #[schemars(range(min = 1, max = 1000))]
    pub(super) fibres: usize,
    /// Width over which they are spread in the plane tangent to the skin, mm.
    #[serde(default)]
    pub(super) width_mm: f64,
    /// Each polyline is a closed ring by itself.
    #[serde(default)]
    pub(super) closed: bool,
    /// Join all polylines of the muscle, of both sides, to one closed ring without sides.
    #[serde(default)]
    pub(super) ring: bool,
}

/// One end for all polylines, or one for each.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Origins {
    /// One for all.
    All(End),
    /// One for each.
    Each(Vec<End>),
}

impl Default for Origins {
    fn default() -> Self {
        Self::All(End::First)
    }
}

/// An end of a polyline.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum End {
    /// The first point.
    First,
    /// The last point.
    Last,
}

fn mandible() -> String {
    "mandible".to_owned()
}

fn one() -> f64 {
    1.
}

fn five() -> f64 {
    5.
}

fn three_tenths() -> f64 {
    0.3
}

fn one_fibre() -> usize {
    1
}

fn both_sides() -> Vec<String> {
    vec!["l".to_owned(), "r".to_owned()]
}

fn own_axes() -> [String; 3] {
    ["left", "up", "anterior"].map(str::to_owned)
}
