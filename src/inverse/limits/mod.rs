//! The limits on the unknowns.

mod activation_bounds;
mod contact_reactions;
mod kinematic_contact;
mod tied_pairs;
mod trust_region;

pub use activation_bounds::ActivationBounds;
pub use contact_reactions::ContactReactions;
pub use kinematic_contact::KinematicContact;
pub use tied_pairs::TiedPairs;
pub use trust_region::TrustRegion;
