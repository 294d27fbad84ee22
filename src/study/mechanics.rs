//! Which mechanics a face is moved by.

/// How strain is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strain {
    /// `K(a) u = F a + G' lambda`: the founding paper's model, right for small movements; it gives the map and convex
    /// programs.
    #[default]
    Linear,
    /// The minimum of the potential, whatever the movement.
    Finite,
}

impl Strain {
    /// The names accepted at interfaces.
    pub const NAMES: [&'static str; 2] = ["linear", "finite"];

    /// The strain called `name`, or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "linear" => Some(Self::Linear),
            "finite" => Some(Self::Finite),
            _ => None,
        }
    }

    /// Its name at interfaces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Finite => "finite",
        }
    }
}

/// How stiff the muscles are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Stiffness {
    /// As their activation makes them.
    #[default]
    Activated,
    /// All as at one activation, 0 to 1; of linear strain only.
    Fixed(f64),
}

impl Stiffness {
    /// As files and the command line write it: `activated` or `fixed=A`.
    pub fn text(self) -> String {
        match self {
            Self::Activated => "activated".to_owned(),
            Self::Fixed(a) => format!("fixed={a}"),
        }
    }
}

/// The mechanics of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mechanics {
    /// How strain is measured.
    pub strain: Strain,
    /// How stiff the muscles are.
    pub stiffness: Stiffness,
    /// Whether teeth and lips stop the tissue.
    pub contact: bool,
}
