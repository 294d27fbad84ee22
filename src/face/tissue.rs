//! Tissue constants.

/// Passive isotropic tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    /// Young's modulus, kPa.
    pub young_kpa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// How the tissue stiffens at finite strain: the ratio `c_2/c_1` of the Yeoh law
    /// `c_1 (I - 3) + c_2 (I - 3)^2`, whose `c_1` is half the initial shear modulus; 0 is neo-Hookean. The linear model
    /// does not see it.
    pub strain_stiffening: f64,
}

impl Tissue {
    /// `c_2/c_1` of 1175 to 2500 Pa, the constants of facial tissue in Nazari, Perrier, Chabanas and Payan (2010),
    /// 10.1080/10255840903505147, whose initial modulus is our 15 kPa.
    pub const NAZARI: f64 = 0.47;
}

impl Default for Tissue {
    /// 15 kPa, 0.49: Fung's small-strain slope, nearly incompressible (the founding paper, 3.2.2); stiffening as in
    /// [`NAZARI`](Self::NAZARI).
    fn default() -> Self {
        Self { young_kpa: 15.0, poisson: 0.49, strain_stiffening: Self::NAZARI }
    }
}

/// How the stiffness of muscle follows its activation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MuscleLaw {
    /// An isotropic ground reinforced along the fibre: `C_iso + a (active - rest) f(x)f(x)f(x)f`.
    /// Affine in the activation; the modulus across the fibre drifts up from 6.2 to at most 8.1 kPa.
    #[default]
    Reinforced,
    /// The seed's engineering constants: the modulus across the fibre stays at rest, exactly. Not affine
    /// in the activation; `nu_tt` follows it, up to nearly `2 nu`, so that the tissue stays
    /// quasi-incompressible.
    Orthotropic,
}

impl MuscleLaw {
    /// The names accepted in files.
    pub const NAMES: [&'static str; 2] = ["reinforced", "orthotropic"];

    /// The law called `name`, or `None`.
    pub fn parse(name: &str) -> Option<Self> {
        match name {
            "reinforced" => Some(Self::Reinforced),
            "orthotropic" => Some(Self::Orthotropic),
            _ => None,
        }
    }

    /// The law's name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reinforced => "reinforced",
            Self::Orthotropic => "orthotropic",
        }
    }
}

/// Muscle tissue, stiffened along the fibre by activation: `E_f(a) = rest + (active - rest) a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuscleTissue {
    /// Modulus at rest, along and across the fibre, kPa.
    pub rest_kpa: f64,
    /// Modulus along the fibre at full activation, kPa.
    pub active_kpa: f64,
    /// Poisson's ratio at rest.
    pub poisson: f64,
    /// How the stiffness follows activation.
    pub law: MuscleLaw,
}

impl Default for MuscleTissue {
    /// 6.2 kPa at rest, 110 kPa when contracted (Duck 1990, as the seed uses it, 3.2.2).
    fn default() -> Self {
        Self { rest_kpa: 6.2, active_kpa: 110.0, poisson: 0.49, law: MuscleLaw::default() }
    }
}
