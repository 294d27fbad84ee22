//! What a picture shows.

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Show {
    /// The skin; translucent when muscles or forces are shown with it.
    pub skin: bool,
    /// The teeth.
    pub teeth: bool,
    /// The muscles as bundles of fibres: the active ones red, or each in its colour when none is active.
    pub muscles: bool,
    /// The forces of the active muscles along their fibres, or of all at full activation when none is active.
    pub forces: bool,
    /// How far each point of the skin has moved, as a colour.
    pub displacement: bool,
}

impl Show {
    /// The names accepted at interfaces.
    pub const NAMES: [&'static str; 5] = ["skin", "teeth", "muscles", "forces", "displacement"];
    /// Skin and teeth: what a photograph shows.
    pub const FACE: Self =
        Self { skin: true, teeth: true, muscles: false, forces: false, displacement: false };

    /// Adds what `name` names; false when there is no such name. `displacement` brings the skin with it.
    pub fn add(&mut self, name: &str) -> bool {
        match name {
            "skin" => self.skin = true,
            "teeth" => self.teeth = true,
            "muscles" => self.muscles = true,
            "forces" => self.forces = true,
            "displacement" => (self.skin, self.displacement) = (true, true),
            _ => return false,
        }
        true
    }

    /// Whether the skin is seen through.
    pub(super) fn sees_through(self) -> bool {
        self.muscles || self.forces
    }
}
