//! What deserves a look before an answer is believed.

use std::fmt;

/// A doubt about a target or an answer; [`remedy`](Self::remedy) says what to do.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The markers fit far better with left and right exchanged.
    SwappedSides {
        /// Label pairs that were exchanged.
        pairs: Vec<[String; 2]>,
        /// Root mean square residual as given, mm.
        residual_mm: f64,
        /// Root mean square residual when exchanged, mm.
        swapped_mm: f64,
    },
    /// A marker at exactly (0, 0, 0): often a missing value.
    ExactZero {
        /// Label.
        marker: String,
    },
    /// A muscle that moves no observed point.
    NoInfluence {
        /// Muscle.
        muscle: String,
    },
    /// Muscles that move the observed points in the same way.
    Indistinguishable {
        /// The muscles, two or more.
        muscles: Vec<String>,
    },
    /// A marker that no activation moves, such as one on bone.
    Immovable {
        /// The marker.
        marker: String,
    },
    /// Fewer independent observed components than free unknowns, and no effort to decide.
    Underdetermined {
        /// Rank of the residuals over the free unknowns.
        components: usize,
        /// Muscles, and the opening of the jaw, that are neither fixed nor tied to another.
        muscles: usize,
    },
    /// A linear effort leaves these muscles a way to share the work otherwise, at the same fit and the same effort.
    Undecided {
        /// The muscles, two or more.
        muscles: Vec<String>,
    },
    /// A marker far from where all others want it.
    Outlier {
        /// The marker.
        marker: String,
        /// Its residual, mm.
        residual_mm: f64,
        /// Its residual in its standard deviations.
        sigmas: f64,
    },
    /// A marker stays more than three standard deviations away.
    Unreachable {
        /// The farthest marker.
        marker: String,
        /// Its residual, mm.
        residual_mm: f64,
        /// The limits that stop it and that a user can change, the strongest first.
        limits: Vec<String>,
    },
    /// The contacts did not settle on the surfaces of the deformed face.
    Unsettled {
        /// Deepest overlap beyond that at rest, mm.
        overlap_mm: f64,
    },
    /// The face rests where a small push could make it slip.
    Unstable,
    /// The face does not come to the same place when it is loaded from rest.
    Path {
        /// How far the two places are apart, mm, where most.
        apart_mm: f64,
    },
    /// The face is not found at rest when it is loaded from rest: the fit came there another way.
    OwnPath {
        /// Share of the load up to which it is.
        reached: f64,
    },
}

impl Warning {
    /// What contacts that did not settle leave, in words: the overlap where there is one to be seen.
    pub fn left_by(overlap_mm: f64) -> String {
        if overlap_mm < 5e-4 {
            return "nothing overlaps, but they still change from one linearisation to the next".to_owned();
        }
        format!("tissue overlaps teeth or the other lip by {overlap_mm:.3} mm more than at rest")
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::SwappedSides { .. } => {
                "exchange left and right, or the sign of x: _l is the subject's left, +x"
            }
            Self::ExactZero { .. } => "leave the component out if it is missing",
            Self::NoInfluence { .. } => {
                "its activation means nothing: observe points near it, or fix it at 0"
            }
            Self::Indistinguishable { .. } => {
                "only their sum is determined: tie them, fix one, or add an effort"
            }
            Self::Immovable { .. } => "put it on the skin, or leave it out: it lies on bone",
            Self::Underdetermined { .. } => "observe more points, fix muscles, or add an effort",
            Self::Undecided { .. } => {
                "tie them, bound all but one, give one a cost of its own, observe more points, or write effort_norm = \"l2\""
            }
            Self::Unsettled { .. } => {
                "ask for less movement, bound the muscles that press there, or refine the mesh about them"
            }
            Self::Unstable => {
                "read the state as one of several that contact holds, or ask for less where lips press"
            }
            Self::Path { .. } | Self::OwnPath { .. } => {
                "the state depends on how the muscles came to act: read the answer as one of several, or ask for less"
            }
            Self::Outlier { .. } => {
                "check its label, its side and its unit; leave it out, or write loss = \"huber\" so that it cannot turn the others"
            }
            Self::Unreachable { limits, .. } if limits.is_empty() => {
                "no limit of yours stops it: muscles only pull, and none of these pulls it there; check the marker, its scale \
                 and its side"
            }
            Self::Unreachable { .. } => {
                "loosen a bound or a tie of the target, give a muscle at 1 more max_force_n where that is known, or check the \
                 target's scale"
            }
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SwappedSides { pairs, residual_mm, swapped_mm } => {
                let pairs: Vec<String> = pairs.iter().map(|[l, r]| format!("{l}/{r}")).collect();
                write!(
                    f,
                    "left and right look swapped ({}): residual {residual_mm:.3} mm as given, {swapped_mm:.3} mm exchanged",
                    pairs.join(", ")
                )
            }
            Self::ExactZero { marker } => write!(f, "marker {marker} is exactly (0, 0, 0)"),
            Self::NoInfluence { muscle } => write!(f, "{muscle} moves no observed point"),
            Self::Indistinguishable { muscles } => {
                write!(f, "{} move the observed points alike", muscles.join(" and "))
            }
            Self::Immovable { marker } => write!(f, "no activation moves marker {marker}"),
            Self::Underdetermined { components, muscles } => {
                write!(
                    f,
                    "{components} independent observed components cannot determine {muscles} activations: others fit as well"
                )
            }
            Self::Undecided { muscles } => write!(
                f,
                "{} can share their work otherwise at the same fit and the same effort: the answer is one of many",
                muscles.join(" and ")
            ),
            Self::Unsettled { overlap_mm } => {
                write!(f, "the contacts did not settle on the deformed face: {}", Self::left_by(*overlap_mm))
            }
            Self::Unstable => write!(
                f,
                "the face rests where its tangent stiffness is not positive definite: contact alone holds it there"
            ),
            Self::Path { apart_mm } => write!(
                f,
                "loaded from rest the face comes to another place under these activations, {apart_mm:.3} mm off"
            ),
            Self::OwnPath { reached } => write!(
                f,
                "loaded from rest the face is not found at rest beyond {:.0} % of these activations, which the fit reached \
                 another way",
                100. * reached
            ),
            Self::Outlier { marker, residual_mm, sigmas } => write!(
                f,
                "marker {marker} looks like an outlier: {residual_mm:.3} mm off, {sigmas:.0} standard deviations, where the others are near"
            ),
            Self::Unreachable { marker, residual_mm, limits } => {
                write!(f, "marker {marker} stays {residual_mm:.3} mm away")?;
                match limits.is_empty() {
                    true => Ok(()),
                    false => write!(f, ", held by {}", limits.join(", ")),
                }
            }
        }
    }
}
