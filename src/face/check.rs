//! Whether a face can be computed with, whatever file or generator it comes from.

use std::collections::BTreeSet;

use super::curve::polyline_length;
use super::jaw::{LEAST_ARM_MM, MOST_ARM_MM};
use super::{
    ContactReach, Face, FaceError, FaceWarning, Muscle, MuscleLaw, MuscleTissue, RestOverlap, Tissue,
};
use crate::contact::PairKind;
use crate::mesh::{Cell, CellKind, Extent, MAX_EXTENT_MM, validate};
use crate::units::Vec3;

/// Plausible moduli of soft tissue, kPa; muscle at full contraction included.
const PLAUSIBLE_KPA: [f64; 2] = [1., 500.];

/// Moduli and forces beyond which numbers overflow before anything is told, kPa and N.
const LEAST_KPA: f64 = 1e-9;
const MOST_KPA: f64 = 1e12;
const LEAST_N: f64 = 1e-9;
const MOST_N: f64 = 1e4;

/// A fibre that ends this near to a node on bone ends on bone, mm: half a cell.
const ON_BONE_MM: f64 = 2.5;

/// No coordinate of a jaw joint that is beyond this is metres, mm.
const IN_METRES: f64 = 1.;

/// Reference coordinate of the two-point Gauss rule.
const GAUSS: f64 = 0.577_350_269_189_625_8;

impl Tissue {
    /// What is wrong or odd: `E > 0`, `-1 < nu < 1/2`, `c_2/c_1 >= 0`.
    pub fn check(&self) -> (Vec<FaceError>, Vec<FaceWarning>) {
        let mut errors = Vec::new();
        let mut warnings = Vec::new();
        modulus("tissue.young_kpa", self.young_kpa, &mut errors, &mut warnings);
        poisson("tissue.poisson", self.poisson, &mut errors);
        if !(self.strain_stiffening.is_finite() && self.strain_stiffening >= 0.) {
            errors.push(FaceError::StrainStiffening { value: self.strain_stiffening });
        }
        (errors, warnings)
    }
}

impl MuscleTissue {
    /// What is wrong or odd: plausible moduli, and a `C(a)` that is positive definite for every `a` in
    /// [0, 1], so up to [`stable_below`](Self::stable_below).
    pub fn check(&self) -> (Vec<FaceError>, Vec<FaceWarning>) {
        let mut errors = Vec::new();
        let mut warnings = Vec::new();
        modulus("muscle_tissue.rest_kpa", self.rest_kpa, &mut errors, &mut warnings);
        poisson("muscle_tissue.poisson", self.poisson, &mut errors);
        let (rest_kpa, active_kpa) = (self.rest_kpa, self.active_kpa);
        if !active_kpa.is_finite() {
            errors.push(FaceError::Modulus { field: "muscle_tissue.active_kpa", value: active_kpa });
        } else if let Some(threshold) = self.stable_below() {
            errors.push(FaceError::UnstableMuscle { rest_kpa, active_kpa, threshold });
        } else {
            modulus("muscle_tissue.active_kpa", active_kpa, &mut errors, &mut warnings);
            if active_kpa < rest_kpa {
                warnings.push(FaceWarning::SofterWhenActive { rest_kpa, active_kpa });
            }
        }
        (errors, warnings)
    }

    /// The least activation in [0, 1] at which the tissue is not positive definite; `None` when it is
    /// stable throughout.
    ///
    /// Law `reinforced`: `1 + a (active - rest) (f⊗f) : C_iso⁻¹ : (f⊗f) = E_f(a) / rest > 0`. Law
    /// `orthotropic`, with `r = E_t / E_f(a)`: besides `E_f > 0` the eigenvalues of the normal compliance
    /// ask for `1 + 2 nu - nu r > 0` and `1 + nu r > 0`.
    pub fn stable_below(&self) -> Option<f64> {
        let (rest, active, nu) = (self.rest_kpa, self.active_kpa, self.poisson);
        if rest.is_nan() || rest <= 0. {
            return None;
        }
        let reaches = |along: f64| (along - rest) / (active - rest);
        let mut limits = Vec::new();
        if active <= 0. {
            limits.push(reaches(0.));
        }
        if self.law == MuscleLaw::Orthotropic && nu != 0. {
            for (fails, ratio) in [
                (1. + 2. * nu - nu * rest / active <= 0., (1. + 2. * nu) / nu),
                (1. + nu * rest / active <= 0., -1. / nu),
            ] {
                if fails || (active <= 0. && ratio > 0.) {
                    limits.push(reaches(rest / ratio));
                }
            }
        }
        limits.into_iter().filter(|a| (0. ..=1.).contains(a)).min_by(f64::total_cmp)
    }
}

fn modulus(field: &'static str, value: f64, errors: &mut Vec<FaceError>, warnings: &mut Vec<FaceWarning>) {
    if !(LEAST_KPA..=MOST_KPA).contains(&value) {
        errors.push(FaceError::Modulus { field, value });
    } else if !(PLAUSIBLE_KPA[0]..=PLAUSIBLE_KPA[1]).contains(&value) {
        warnings.push(FaceWarning::ImplausibleModulus { field, value });
    }
}

fn poisson(field: &'static str, value: f64, errors: &mut Vec<FaceError>) {
    if !(value > -1. && value < 0.5) {
        errors.push(FaceError::Poisson { field, value });
    }
}

impl Face {
    /// Everything that is wrong with the face, and everything that is odd about it.
    pub fn check(&self) -> (Vec<FaceError>, Vec<FaceWarning>) {
        let (mut errors, mut warnings) = self.tissue.check();
        let (e, w) = self.muscle_tissue.check();
        errors.extend(e);
        warnings.extend(w);
        errors.extend(self.missing_nodes());
        if errors.is_empty() {
            errors.extend(self.orphan_nodes());
        }
        errors.extend(self.jaw_error());
        if !errors.is_empty() {
            return (errors, warnings);
        }
        let fixed: BTreeSet<usize> = self.supports.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        match validate(&self.mesh, &Vec::from_iter(fixed)) {
            Ok(odd) => warnings.extend(odd.into_iter().map(FaceWarning::Mesh)),
            Err(error) => return (vec![error.into()], warnings),
        }
        warnings.extend(self.two_bones());
        for (k, muscle) in self.muscles.iter().enumerate() {
            if self.muscles[..k].iter().any(|m| m.name == muscle.name) {
                errors.push(FaceError::DuplicateName { muscle: muscle.name.clone() });
            }
            if let Some(twin) = self.muscles[..k].iter().find(|m| m.fibres == muscle.fibres) {
                let (first, second) = (twin.name.clone(), muscle.name.clone());
                warnings.push(FaceWarning::SameFibres { first, second });
            }
            errors.extend(muscle.check());
        }
        if errors.is_empty() {
            errors.extend(self.muscles.iter().filter_map(|m| self.without_tissue(m)));
            for muscle in &self.muscles {
                warnings.extend(self.odd_fibres(muscle));
            }
            let overlap: RestOverlap = self.rest_overlap();
            if overlap.inside > 0 {
                warnings.push(FaceWarning::RestOverlap(overlap));
            }
            warnings.extend(self.without_contact());
        }
        (errors, FaceWarning::join_sides(warnings, FaceWarning::with_other_side))
    }

    /// The sets that the face names, with their nodes.
    fn sets(&self) -> impl Iterator<Item = (&str, &Vec<usize>)> {
        let named = [
            ("mucosa", &self.mucosa),
            ("upper_lip", &self.upper_lip),
            ("lower_lip", &self.lower_lip),
            ("skin", &self.skin),
        ];
        named.into_iter().chain(self.supports.iter().map(|s| (s.bone.as_str(), &s.nodes)))
    }

    fn missing_nodes(&self) -> Vec<FaceError> {
        let n_nodes = self.mesh.n_nodes();
        let missing = |(set, nodes): (&str, &Vec<usize>)| {
            let node = *nodes.iter().find(|node| **node >= n_nodes)?;
            Some(FaceError::MissingNode { set: set.to_owned(), node, n_nodes })
        };
        self.sets().filter_map(missing).collect()
    }

    /// Sets with a node that no cell carries: it would rest where the tissue goes.
    fn orphan_nodes(&self) -> Vec<FaceError> {
        let mut used = vec![false; self.mesh.n_nodes()];
        for &node in self.mesh.cells.iter().flat_map(Cell::nodes) {
            // Cells on nodes that do not exist are told by the mesh's own check.
            if let Some(used) = used.get_mut(node) {
                *used = true;
            }
        }
        let orphan = |(set, nodes): (&str, &Vec<usize>)| {
            let node = *nodes.iter().find(|node| !used[**node])?;
            Some(FaceError::OrphanNode { set: set.to_owned(), node: self.mesh.node_id(node) })
        };
        self.sets().filter_map(orphan).collect()
    }

    /// Arches without a candidate pair.
    fn without_contact(&self) -> Vec<FaceWarning> {
        if self.teeth.is_empty() {
            return Vec::new();
        }
        let reach = ContactReach::default();
        let touched: Vec<PairKind> = self.contact_pairs(reach).iter().map(|pair| pair.kind).collect();
        let arches = [("upper", true, PairKind::UpperTeeth), ("lower", false, PairKind::LowerTeeth)];
        let has_none = arches.into_iter().filter(|(_, upper, kind)| {
            self.teeth.iter().any(|teeth| teeth.upper == *upper) && !touched.contains(kind)
        });
        let (mucosa, reach_mm) = (self.mucosa.len(), reach.teeth_mm);
        has_none.map(|(arch, ..)| FaceWarning::NoContact { arch, mucosa, reach_mm }).collect()
    }

    /// Supports that share nodes with one before them.
    fn two_bones(&self) -> Vec<FaceWarning> {
        let mut warnings = Vec::new();
        for (support, second) in self.supports.iter().enumerate() {
            for first in self.supports[..support].iter().filter(|first| first.bone != second.bone) {
                let taken: BTreeSet<usize> = first.nodes.iter().copied().collect();
                let shared: Vec<usize> = second.nodes.iter().copied().filter(|n| taken.contains(n)).collect();
                if let Some(&node) = shared.first() {
                    let (first, second) = (first.bone.clone(), second.bone.clone());
                    warnings.push(FaceWarning::TwoBones {
                        first,
                        second,
                        support,
                        node,
                        nodes: shared.len(),
                    });
                }
            }
        }
        warnings
    }

    fn jaw_error(&self) -> Option<FaceError> {
        let jaw = self.jaw.as_ref()?;
        let wrong = |field, problem: String| Some(FaceError::Jaw { field, problem });
        if !self.has_bone(&jaw.bone) {
            let field = "jaw.bone".to_owned();
            return Some(FaceError::UnknownBone { field, bone: jaw.bone.clone(), known: self.bones() });
        }
        let [left, right] = jaw.condyles;
        if [left, right, jaw.incisor].iter().any(|p| !p.iter().all(|x| x.is_finite())) {
            return wrong("jaw.condyles_mm", "a coordinate is not finite; give places in mm".to_owned());
        }
        let apart = left.x - right.x;
        // The greatest coordinate of a jaw in metres is 0.1.
        let all = [left, right, jaw.incisor];
        if all.iter().all(|p| p.amax() < IN_METRES) {
            let problem = format!("no coordinate reaches {IN_METRES} mm: metres? Give places in mm");
            return wrong("jaw.condyles_mm", problem);
        }
        if !(LEAST_ARM_MM..=MOST_ARM_MM).contains(&apart) {
            let problem = format!(
                "the left condyle must be {LEAST_ARM_MM} to {MOST_ARM_MM} mm to the left (+x) of the right one, not \
                 {apart:.2}; give the left one first, in mm"
            );
            return wrong("jaw.condyles_mm", problem);
        }
        let arm = jaw.arm_mm();
        if !(LEAST_ARM_MM..=MOST_ARM_MM).contains(&arm) {
            let problem = format!(
                "the lower incisal point is {arm:.2} mm from the axis through the condyles; give one {LEAST_ARM_MM} to \
                 {MOST_ARM_MM} mm away, in mm"
            );
            return wrong("jaw.incisor_mm", problem);
        }
        if let Some(condyle) = [left, right].iter().find(|c| c.z >= jaw.incisor.z) {
            let problem = format!(
                "a condyle at z = {:.1} mm lies in front of the lower incisal point at z = {:.1} mm, so that opening would \
                 turn the chin up; give places with +z to the front",
                condyle.z, jaw.incisor.z
            );
            return wrong("jaw.condyles_mm", problem);
        }
        let (face, incisor) = (self.mesh.extent(), Extent::of(&[jaw.incisor]));
        let (gap, size) = (incisor.gap_mm(&face), face.longest_mm());
        if gap > size {
            let problem = format!(
                "the lower incisal point lies {gap:.0} mm away from the mesh, which measures {size:.0} mm; give it in mm in \
                 the face's frame"
            );
            return wrong("jaw.incisor_mm", problem);
        }
        None
    }

    fn odd_fibres(&self, muscle: &Muscle) -> Vec<FaceWarning> {
        let mut odd = Vec::new();
        let bone: Vec<Vec3> =
            self.supports.iter().flat_map(|s| &s.nodes).map(|node| self.mesh.points[*node]).collect();
        // A muscle may arise from soft tissue, nearer to no bone than it inserts: only an insertion on bone is odd.
        let on_bone_mm = muscle.radius_mm.max(ON_BONE_MM);
        let is_on_bone = |p: Option<&Vec3>| {
            p.is_some_and(|p| bone.iter().any(|b| (b - p).norm_squared() <= on_bone_mm * on_bone_mm))
        };
        let open = || muscle.fibres.iter().filter(|f| !f.closed);
        let flipped = open().filter(|f| is_on_bone(f.points.last()) && !is_on_bone(f.points.first())).count();
        // Ends at the edge of a support decide for single fibres either way; most of them tell.
        if 2 * flipped > muscle.fibres.len() {
            odd.push(FaceWarning::FlippedFibres { muscle: muscle.name.clone(), fibres: flipped });
        }
        let length_mm = open().map(|f| polyline_length(&f.points, false)).fold(f64::INFINITY, f64::min);
        if length_mm <= muscle.insertion_mm {
            odd.push(FaceWarning::AllInsertion { muscle: muscle.name.clone(), length_mm });
        }
        odd
    }

    /// The error of a muscle whose radius holds no quadrature point.
    fn without_tissue(&self, muscle: &Muscle) -> Option<FaceError> {
        let fibres: Vec<Vec3> = muscle.fibres.iter().flat_map(|f| f.points.iter().copied()).collect();
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let (lo, hi) = fibres.iter().fold(start, |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        let samples = CellKind::ALL.map(quadrature_points);
        let mut needed_mm = f64::INFINITY;
        for cell in &self.mesh.cells {
            let Some(kind) = CellKind::ALL.iter().position(|k| *k == cell.kind()) else { continue };
            for xi in &samples[kind] {
                let weights = cell.kind().shape(*xi);
                let q: Vec3 =
                    cell.nodes().iter().zip(weights).map(|(node, w)| w * self.mesh.points[*node]).sum();
                let to_box = (lo - q).sup(&(q - hi)).sup(&Vec3::zeros()).norm();
                if to_box >= needed_mm {
                    continue;
                }
                needed_mm = muscle
                    .fibres
                    .iter()
                    .map(|f| distance_to_fibre(q, &f.points, f.closed))
                    .fold(needed_mm, f64::min);
                if needed_mm <= muscle.radius_mm {
                    return None;
                }
            }
        }
        let (muscle, radius_mm) = (muscle.name.clone(), muscle.radius_mm);
        Some(FaceError::NoTissue { muscle, radius_mm, needed_mm })
    }
}

impl Muscle {
    /// What is wrong with the muscle by itself.
    pub fn check(&self) -> Vec<FaceError> {
        let number = |field, value: f64, ok: bool, accepted| {
            (!ok || !value.is_finite()).then(|| FaceError::MuscleNumber {
                muscle: self.name.clone(),
                field,
                value,
                accepted,
            })
        };
        let mut errors: Vec<FaceError> = [
            number(
                "max_force_n",
                self.max_force_n,
                (LEAST_N..=MOST_N).contains(&self.max_force_n),
                "a positive force in N, of some newtons for a muscle of the face",
            ),
            number(
                "radius_mm",
                self.radius_mm,
                self.radius_mm > 0. && self.radius_mm <= MAX_EXTENT_MM,
                "a positive length in mm, no longer than a face",
            ),
            self.area_mm2.and_then(|area| number("area_mm2", area, area > 0., "a positive area in mm2")),
            number(
                "insertion_mm",
                self.insertion_mm,
                (0. ..=MAX_EXTENT_MM).contains(&self.insertion_mm),
                "0 or a length in mm, no longer than a face",
            ),
        ]
        .into_iter()
        .flatten()
        .collect();
        if self.fibres.is_empty() {
            errors.push(FaceError::NoFibre { muscle: self.name.clone() });
        }
        for (k, fibre) in self.fibres.iter().enumerate() {
            let places: BTreeSet<[u64; 3]> =
                fibre.points.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
            let length = polyline_length(&fibre.points, fibre.closed);
            // A NaN length is as useless as none.
            if places.len() < 2 || !(length > 1e-9 && length.is_finite()) {
                errors.push(FaceError::ZeroLength { muscle: self.name.clone(), fibre: k + 1 });
            }
        }
        errors
    }
}

/// Quadrature points at which muscle tissue is told from passive tissue.
fn quadrature_points(kind: CellKind) -> Vec<Vec3> {
    let centre = kind.centre();
    let corners = kind.node_positions()[..kind.n_corners()].iter().map(|p| Vec3::from(*p));
    corners.map(|p| centre + GAUSS * (p - centre)).chain([centre]).collect()
}

fn distance_to_fibre(q: Vec3, points: &[Vec3], closed: bool) -> f64 {
    let to_segment = |a: Vec3, b: Vec3| {
        let (along, from) = (b - a, q - a);
        let s = (from.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0., 1.);
        (from - s * along).norm()
    };
    let closing = closed.then(|| Some(to_segment(*points.last()?, *points.first()?))).flatten();
    points.windows(2).map(|p| to_segment(p[0], p[1])).chain(closing).fold(f64::INFINITY, f64::min)
}
