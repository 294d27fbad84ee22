//! Pictures of a face, drawn by the processor alone: the same bytes for the same face on every run.

mod bundles;
mod camera;
mod cavity;
mod colour;
mod error;
mod figures;
mod image;
mod legend;
mod occlusion;
mod raster;
mod scene;
mod shading;
mod show;
mod skin;
mod solid;
mod subdivision;
mod vermilion;

pub use camera::{Camera, Margins, Projected, View};
pub use colour::{ColourMap, Rgb, distinct, mix, srgb, to_srgb};
pub use error::RenderError;
pub use figures::{
    Action, MovedScene, TitledPose, action_sheet, before_and_after, contact_sheet, force_sheet,
    front_and_profile, muscle_stems, side_by_side, three_views,
};
pub use image::{Image, LETTER, LINE};
pub use raster::{Hit, Layer};
pub use scene::{Drawing, MAX_SIDE, MIN_SIDE, Scene};
pub use show::Show;
pub use subdivision::{Refined, refine};
