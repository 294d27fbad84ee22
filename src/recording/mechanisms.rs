//! Which mechanism describes which frame.

use super::mechanism::Mechanism;

/// Mechanisms that describe the face about different activations, and which of them each frame has.
#[derive(Clone, Debug)]
pub struct Mechanisms {
    all: Vec<Mechanism>,
    /// Which of all each frame has, (f); empty: all have the first.
    of_frame: Vec<usize>,
}

impl Mechanisms {
    /// One for all frames.
    pub fn one(mechanism: Mechanism) -> Self {
        Self { all: vec![mechanism], of_frame: Vec::new() }
    }

    /// The mechanism `of_frame` (f) of `all` for each frame; `None` where there is no such mechanism, or they are not of the
    /// same unknowns.
    pub fn new(all: Vec<Mechanism>, of_frame: Vec<usize>) -> Option<Self> {
        let unknowns = all.first()?.unknowns();
        let is_whole =
            of_frame.iter().all(|k| *k < all.len()) && all.iter().all(|one| one.unknowns() == unknowns);
        is_whole.then_some(Self { all, of_frame })
    }

    /// Those of every `step`th frame.
    #[must_use]
    pub fn every(&self, step: usize) -> Self {
        let of_frame = self.of_frame.iter().step_by(step.max(1)).copied().collect();
        Self { all: self.all.clone(), of_frame }
    }

    /// Which of [`all`](Self::all) a frame has.
    pub fn index(&self, frame: usize) -> usize {
        self.of_frame.get(frame).copied().unwrap_or(0)
    }

    /// That of a frame.
    pub fn of(&self, frame: usize) -> &Mechanism {
        &self.all[self.index(frame)]
    }

    /// All of them, at least one; muscles, bounds and jaw are the same in each.
    pub fn all(&self) -> &[Mechanism] {
        &self.all
    }

    /// The first.
    pub fn first(&self) -> &Mechanism {
        &self.all[0]
    }
}
