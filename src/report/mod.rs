//! Results to look at and to open elsewhere: the page, the plots, scenes for other programs.

mod arrays;
mod drawn_face;
mod gallery;
mod glb;
mod markup;
mod motion;
mod obj;
mod page;
mod plot;
mod tables;
mod track_tables;
mod tracked;

pub use gallery::{GalleryFigures, GalleryFit, GalleryTarget, gallery_text};
pub use glb::glb;
pub use motion::{Motion, MotionKind, MotionState};
pub use obj::obj_text;
pub use page::{MOST_RESULTS, ReportError, ShownResult, Told, page};
pub use plot::{
    Recovered, activation_plot, l_curve_plot, length_plot, recovery_plot, residual_plot, symmetry_plot,
    time_plot,
};
pub use tracked::{MOST_FRAMES, tracked_motion};
