//! Where the stiffness of a recording is held.

/// Where the stiffness of a recording is held at linear strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum HeldStiffness {
    /// At none: it follows the activations to first order about twelve states of the recording, each frame having the nearest.
    Follow,
    /// Each muscle at its mean activation over the recording, found at a uniform stiffness first.
    #[default]
    Mean,
    /// All muscles at one activation, 0 to 1.
    At(f64),
}

impl HeldStiffness {
    /// As the command line writes it: `mean`, `follow` or `fixed=A`.
    pub fn text(self) -> String {
        match self {
            Self::Mean => "mean".to_owned(),
            Self::Follow => "follow".to_owned(),
            Self::At(a) => format!("fixed={a}"),
        }
    }
}
