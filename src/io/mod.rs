//! File formats: everything that is read from or written to disk.

#[cfg(feature = "parquet")]
mod activation_parquet;
mod activation_table;
mod answer;
mod atomic;
mod calibration_json;
mod certainty_json;
mod comparison_json;
mod csv;
mod escaped;
mod face_export;
mod face_toml;
mod feb;
mod file_set;
mod format;
mod inp;
mod input;
mod input_file;
mod junit;
mod lines;
mod location;
mod map_npz;
mod mapped_recording;
mod marker_map_toml;
mod mesh_document;
mod mesh_file;
mod mesh_file_error;
mod msh;
mod nearest;
mod nonlinear_json;
mod npz;
mod numbered;
mod obj;
mod plan_toml;
mod ply;
mod polygons;
mod program_file;
mod program_text;
mod recording_file;
mod registration_json;
mod result_npz;
mod schema;
mod sha256;
mod solution_json;
mod standing;
mod stl;
mod sto;
mod suite_json;
mod surface_file;
mod symmetry_json;
mod target_files;
mod target_toml;
mod tetgen;
mod text;
mod track_blocks;
mod track_files;
mod track_json;
mod track_tables;
mod vtk;
mod write_error;

pub use activation_table::{ActivationTable, ActivationTableError, parse_activations, read_activations};
pub use answer::{AnswerFileError, AnswerFiles, read_answer};
pub use atomic::write_atomically;
pub use calibration_json::{
    CalibrationJson, CombinationJson, ExplainedJson, ModuliJson, ParameterJson, TradeJson, calibration_schema,
};
pub use certainty_json::{
    CertaintyJson, CorrelationJson, DiscrepancyJson, EffortJson, IntervalJson, NormJson, SideJson,
    UnknownJson,
};
pub use comparison_json::{
    ComparedActivationJson, ComparedContactJson, ComparedLandmarkJson, ComparedMarkerJson,
    ComparedResultJson, ComparisonJson, SidesJson, comparison_schema,
};
pub use face_export::{FaceExportError, put_face, write_face};
pub use face_toml::{
    FaceDocument, FaceFileError, FaceFileErrorKind, FaceFileWarning, FaceFileWarningKind, face_schema,
    read_face, read_landmarks,
};
pub use file_set::{FileSet, settle_folder};
pub use input_file::{InputFile, UnreadableText};
pub use junit::junit_text;
pub use location::Location;
pub use map_npz::{MapFileError, MapNpz};
pub use mapped_recording::{MappedRecording, MappedRecordingError, read_mapped_recording};
pub use marker_map_toml::{
    MarkerMapDocument, MarkerMapError, marker_map_schema, parse_marker_map, read_marker_map,
};
pub use mesh_document::{MeshDocument, MeshFileWarning, NoSet};
pub use mesh_file::{parse_mesh, read_mesh, read_mesh_document};
pub use mesh_file_error::{MAX_ID, MeshFileError, MeshFileErrorKind};
pub use nearest::nearest;
pub use nonlinear_json::{DeformationJson, LinearJson, OtherJson, StepJson};
pub use plan_toml::{PlanDocument, PlanFileError, parse_plan, plan_schema, read_plan};
pub use program_file::ProgramFile;
pub use recording_file::{
    ImageScale, ReadOptions, RecordingDocument, RecordingFileError, RecordingFileErrorKind,
    RecordingFileWarning, RecordingFormat, parse_recording, read_recording, recording_csv,
};
pub use registration_json::{
    AsymmetryJson, DepthJson, DistancesJson, LandmarkErrorJson, MuscleLengthJson, RegistrationJson,
    SimilarityJson, registration_schema,
};
pub use result_npz::result_npz;
pub use sha256::sha256;
pub use solution_json::{
    CertificateJson, ContactJson, ExpectedJson, FeatureJson, LimitJson, LimitKindWord, MarkerJson,
    RelaxationEndWord, ResidualJson, SolutionJson, StatusWord, TargetJson, solution_schema,
};
pub use standing::Standing;
pub use sto::sto_text;
pub use suite_json::{SuiteJson, SuiteTargetJson, VerdictWord, suite_schema};
pub use surface_file::{parse_surface, read_surface, read_surface_file};
pub use symmetry_json::{MiddleJson, PairJson, PublishedJson, SymmetryJson, given_side, symmetry_schema};
pub use target_files::{SuiteError, read_targets};
pub use target_toml::{
    FieldLines, RecordedFrame, TargetDocument, TargetFileError, TargetWarning, parse_target, read_target,
    target_schema,
};
pub use track_blocks::TrackBlocks;
pub use track_files::{FrameRow, TrackFileError, TrackFiles, read_track};
pub use track_json::{
    AlignmentJson, BoundJson, CheckedFrameJson, CheckedJson, HeadJson, IntervalsJson, MetJson, OutlierJson,
    SettledJson, SwapJson, TrackJson, track_schema,
};
pub use track_tables::{frames_csv, intervals_csv, residuals_csv, tracked_activations};
pub use vtk::{VtuData, vtu_text, write_vtu};
pub use write_error::{WriteError, WriteErrorKind};
