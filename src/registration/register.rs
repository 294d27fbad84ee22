//! The standard face matched to a patient's scan.

use super::bones::Bones;
use super::correspondence::{FaceSkin, SkinAt, Tie, correspond};
use super::dentition::{Clearance, Solids, jaw_motion, moved, moved_jaw};
use super::depth::Depths;
use super::placement::Placement;
use super::proportions::{bring, fit_proportions};
use super::quality::RegistrationQuality;
use super::scan::{OFF_MM, Scan};
use super::tissue::{Spring, Tissue};
use super::{GivenLandmark, RegistrationError, RegistrationWarning, Similarity};
use crate::face::standard::{Parameters, Resolution, standard};
use crate::face::{Face, Teeth};
use crate::forward::finite::FaceContact;
use crate::mesh::Surface;
use crate::units::Vec3;

/// Rounds of correspondence, and how stiff the springs to the scan are in the first and in the last, N/mm³: at first
/// the face moves almost as a whole, at last the tissue hardly resists.
const ROUNDS: usize = 24;
const STIFFNESS: [f64; 2] = [5e-4, 0.1];
/// Rounds in which all is softer than the teeth, which are then placed and hold the mucosa.
const WITHOUT_TEETH: usize = 16;
/// Newton steps a round, and in the last.
const STEPS: usize = 2;
const LAST_STEPS: usize = 12;
/// Distance beyond which nothing corresponds, mm, in the first round and in the last.
const REACH_MM: [f64; 2] = [15., 6.];
/// A tie loses weight at so many times the median distance, and never below so many mm.
const OUTLYING: f64 = 3.;
const OUTLYING_MM: f64 = 1.;
/// Area of skin that a landmark stands for in the first round and in the last, mm².
const LANDMARK_MM2: [f64; 2] = [300., 30.];
/// How much less stiff than the skin what lies below it is held.
const DEPTH: f64 = 0.03;
/// Area of the mucosa about each point that is held off teeth, mm²; how often, and how much firmer each time, what lies in
/// teeth after the last round is pushed out.
const AROUND_MM2: f64 = 3.;
const PUSHES: i32 = 10;
const PUSH: f64 = 2.;
/// Share of the skin that a scan must cover, and below which that is told.
const NEEDED_COVER: f64 = 0.3;
const TOLD_COVER: f64 = 0.7;
/// Turn of the scan above which it is told, degrees.
const TOLD_DEG: f64 = 30.;
/// Opening of the mouth above which it is told, mm.
const OPEN_MM: f64 = 2.;
/// Distance of a hole from the skin, mm, and length of its rim from which it is one.
const HOLE_MM: f64 = 5.;
const HOLE_RIM_MM: f64 = 12.;
/// Least scaled Jacobian that is asked for, and largest rms distance to the scan, mm.
const LEAST_JACOBIAN: f64 = 0.1;
const FAR_MM: f64 = 1.;

/// What is known of a patient, all in one frame, mm.
#[derive(Clone, Debug, Default)]
pub struct Subject {
    /// The skin of the neutral face, closed mouth, its triangles counter-clockwise seen from outside.
    pub scan: Surface,
    /// Landmarks on it; eight at least that the face has.
    pub landmarks: Vec<GivenLandmark>,
    /// Teeth, closed and outward oriented; where there are none of an arch, the standard's are placed.
    pub teeth: Vec<Teeth>,
    /// Bones by their names, outward oriented, such as `skull` and `mandible`; where one is missing, the depth of the
    /// standard's tissue is kept.
    pub bones: Vec<(String, Surface)>,
}

/// What is matched to the patient.
#[derive(Clone, Debug)]
pub enum Template {
    /// The standard face, whose proportions are fitted first.
    Standard(Resolution),
    /// Any face.
    Face(Box<Face>),
}

/// A face matched to a scan.
#[derive(Clone, Debug)]
pub struct Registration {
    /// The face, in the axes of faces: +x the subject's left, +y up, +z anterior, mm of the patient.
    pub face: Face,
    /// From the template to the scan as landmarks tell it; a point `y` of the scan's frame is at
    /// [`unmoved(y)`](Similarity::unmoved) in that of the face.
    pub similarity: Similarity,
    /// What it leaves of the landmarks, rms, mm.
    pub landmark_rms_mm: f64,
    /// The fitted proportions, of a standard face.
    pub parameters: Option<Parameters>,
    /// How far it can be trusted.
    pub quality: RegistrationQuality,
    /// What is odd.
    pub warnings: Vec<RegistrationWarning>,
}

/// Matches `template` to `subject`; `tell` hears of each step.
///
/// The face that comes out has the mesh, the muscles and the names of the template. A scan that is the template's own skin, with its
/// landmarks, gives the template.
///
/// # Errors
/// [`RegistrationError`] for landmarks or a scan that are not those of a face in mm, and tissue that cannot be solved.
pub fn register(
    subject: &Subject,
    template: &Template,
    mut tell: impl FnMut(&str),
) -> Result<Registration, RegistrationError> {
    let mut warnings = Vec::new();
    let standing = match template {
        Template::Standard(resolution) => standard(resolution),
        Template::Face(face) => (**face).clone(),
    };
    tell("placing the face by its landmarks");
    let placement = Placement::new(&standing, &subject.landmarks, &mut warnings)?;
    let similarity = placement.similarity;
    if similarity.angle_deg() > TOLD_DEG {
        warnings.push(RegistrationWarning::Turned { degrees: similarity.angle_deg() });
    }
    let own = |surface: &Surface| Surface {
        points: surface.points.iter().map(|&y| similarity.unmoved(y)).collect(),
        triangles: surface.triangles.clone(),
    };
    let known: Vec<(usize, Vec3)> =
        placement.known.iter().map(|&(k, y)| (k, similarity.unmoved(y))).collect();
    let places: Vec<Vec3> = known.iter().map(|(_, y)| *y).collect();
    let mut extent = standing.mesh.extent();
    (extent.lo, extent.hi) = (similarity.scale * extent.lo, similarity.scale * extent.hi);
    let scan = Scan::new(own(&subject.scan), &places, extent, &mut warnings)?;
    let sound: Vec<(usize, Vec3)> =
        known.iter().zip(&placement.is_sound).filter(|(_, sound)| **sound).map(|(k, _)| *k).collect();
    let first = bring(&standing, &sound).ok_or(RegistrationError::Collinear)?;
    let scan = facing_outward(scan, &standing, &first, &mut warnings);

    tell("fitting the standard face's proportions");
    let (start, parameters) = match template {
        Template::Standard(resolution) => {
            let fitted = fit_proportions(resolution, &sound, &scan)?.ok_or(RegistrationError::Collinear)?;
            (scaled(&fitted.face, &fitted.similarity), Some(fitted.parameters))
        }
        Template::Face(_) => (scaled(&standing, &first), None),
    };

    // What lies on the scan is held to its place; what does not only helped to find the position.
    let mut held = Vec::new();
    for &(k, y) in &sound {
        let distance_mm = scan.sheet.nearest(y, None, f64::INFINITY).map_or(f64::NAN, |f| f.distance_mm);
        if distance_mm <= OFF_MM {
            held.push((k, y));
        } else {
            let name = standing.landmarks[k].name.clone();
            warnings.push(RegistrationWarning::LandmarkOffScan { name, distance_mm });
        }
    }

    let given: Vec<Teeth> =
        subject.teeth.iter().map(|t| Teeth { surface: own(&t.surface), ..t.clone() }).collect();
    let bones = subject.bones.iter().map(|(name, surface)| (name.clone(), own(surface)));
    let bones = Bones::new(bones, &start, &mut warnings);
    let matching = Matching { start: &start, scan: &scan, held: &held, given: &given, bones: &bones };
    let (x, teeth) = matching.solve(&mut tell)?;
    bones.tell(&start, &x, &mut warnings)?;

    tell("measuring");
    let face = matching.face(&x, teeth, &standing.name);
    let quality = RegistrationQuality::new(&face, &standing, &scan, &known, &held);
    tell_quality(&quality, &face, &scan, &mut warnings)?;
    Ok(Registration { face, similarity, landmark_rms_mm: placement.rms_mm, parameters, quality, warnings })
}

/// The scan with its triangles facing as the skin of `face` does there.
fn facing_outward(
    scan: Scan,
    face: &Face,
    similarity: &Similarity,
    warnings: &mut Vec<RegistrationWarning>,
) -> Scan {
    let x: Vec<Vec3> = face.mesh.points.iter().map(|&x| similarity.apply(x)).collect();
    let skin = FaceSkin::of(face).at(face, &x);
    let along = |(x, normal): (&Vec3, &Vec3)| {
        let foot = scan.sheet.nearest(*x, None, REACH_MM[0])?;
        Some(foot.normal.dot(normal))
    };
    let sum: f64 = skin.sheet.surface.points.iter().zip(&skin.sheet.normals).filter_map(along).sum();
    if sum >= 0. {
        return scan;
    }
    warnings.push(RegistrationWarning::InsideOut);
    scan.turned()
}

/// `face` moved and scaled as a whole, its muscles as strong and as thick as before.
fn scaled(face: &Face, similarity: &Similarity) -> Face {
    let u: Vec<f64> =
        face.mesh.points.iter().flat_map(|&x| Into::<[f64; 3]>::into(similarity.apply(x) - x)).collect();
    let mut moved_face = face.with_tissue_moved(&u);
    // To the bit what the similarity says, also of points outside the mesh.
    moved_face.mesh.points = face.mesh.points.iter().map(|&x| similarity.apply(x)).collect();
    for (muscle, own) in moved_face.muscles.iter_mut().zip(&face.muscles) {
        for (fibre, own) in muscle.fibres.iter_mut().zip(&own.fibres) {
            fibre.points = own.points.iter().map(|&p| similarity.apply(p)).collect();
        }
    }
    for landmark in &mut moved_face.landmarks {
        let carried = landmark.site.weights.iter().map(|&(n, w)| w * moved_face.mesh.points[n]);
        landmark.site.position = carried.sum();
    }
    moved_face.teeth = face.teeth.iter().map(|teeth| moved(teeth, similarity)).collect();
    moved_face.jaw = face.jaw.as_ref().map(|jaw| moved_jaw(jaw, similarity, None));
    moved_face
}

/// The non-rigid match.
struct Matching<'a> {
    /// The face where the match begins.
    start: &'a Face,
    scan: &'a Scan,
    /// Landmarks that are held: number on the face, and place, mm.
    held: &'a [(usize, Vec3)],
    given: &'a [Teeth],
    bones: &'a Bones,
}

impl Matching<'_> {
    /// Where the nodes (n, mm) come to lie, and the teeth.
    fn solve(&self, tell: &mut impl FnMut(&str)) -> Result<(Vec<Vec3>, Vec<Teeth>), RegistrationError> {
        let face = self.start;
        let skin = FaceSkin::of(face);
        let mut x = face.mesh.points.clone();
        let depths = Depths::new(face, &x, &skin.at(face, &x));
        let clearance = Clearance::new(face, &x, &Solids::of(&face.teeth));
        let groups: Vec<Vec<usize>> = face
            .landmarks
            .iter()
            .map(|landmark| landmark.site.weights.iter().map(|(node, _)| *node).collect())
            .collect();
        let mut tissue = Tissue::new(&face.mesh, &groups)?;
        let mut teeth = self.teeth_at(&x);
        let mut solids = Solids::of(&teeth);
        for round in 0..ROUNDS {
            tell(&format!("matching the skin, round {} of {ROUNDS}", round + 1));
            let share = round as f64 / (ROUNDS - 1) as f64;
            let between = |ends: [f64; 2]| ends[0] * (ends[1] / ends[0]).powf(share);
            let stiffness = between(STIFFNESS);
            let at = skin.at(face, &x);
            let ties = correspond(&at, &self.scan.sheet, &self.scan.drawn, between(REACH_MM));
            let mut springs = springs_of(&ties, stiffness);
            springs.extend(self.landmark_springs(stiffness * between(LANDMARK_MM2)));
            let (on_bone, bone_springs) = self.bones.springs(face, &x, stiffness);
            springs.extend(depths.springs(&x, &at, DEPTH * stiffness, |n| on_bone.binary_search(&n).is_ok()));
            springs.extend(bone_springs);
            if round == WITHOUT_TEETH {
                teeth = self.teeth_at(&x);
                solids = Solids::of(&teeth);
            }
            if round >= WITHOUT_TEETH {
                let only_out = self.given.is_empty();
                springs.extend(clearance.springs(&x, &solids, stiffness * AROUND_MM2, only_out));
            }
            let is_last = round + 1 == ROUNDS;
            tissue.relax(&mut x, &springs, if is_last { LAST_STEPS } else { STEPS })?;
            if is_last {
                // What the skin pulled into the teeth comes out again, ever more firmly.
                for push in 1..=PUSHES {
                    if clearance.lacking(&x, &solids) == 0 {
                        break;
                    }
                    tell("keeping the mucosa off the teeth");
                    let firm = stiffness * AROUND_MM2 * PUSH.powi(push);
                    let mut all = springs.clone();
                    all.extend(clearance.springs(&x, &solids, firm, true));
                    tissue.relax(&mut x, &all, STEPS)?;
                }
            }
        }
        Ok((x, teeth))
    }

    fn landmark_springs(&self, stiffness: f64) -> impl Iterator<Item = Spring> {
        self.held.iter().map(move |&(k, target)| Spring {
            carriers: self.start.landmarks[k].site.weights.clone(),
            target,
            normal: Vec3::z(),
            along: stiffness,
            across: stiffness,
        })
    }

    /// The teeth with the nodes at `x` (n, mm): the patient's, or the template's where the tissue has brought them.
    fn teeth_at(&self, x: &[Vec3]) -> Vec<Teeth> {
        let face = self.start;
        let bring = |teeth: &Teeth| match self.given.iter().find(|given| given.upper == teeth.upper) {
            Some(given) => Teeth { bone: teeth.bone.clone(), ..given.clone() },
            None => match jaw_motion(face, teeth.upper, &face.mesh.points, x) {
                Some(motion) => moved(teeth, &motion),
                None => teeth.clone(),
            },
        };
        let mut teeth: Vec<Teeth> = face.teeth.iter().map(bring).collect();
        let is_new = |given: &&Teeth| face.teeth.iter().all(|own| own.upper != given.upper);
        teeth.extend(self.given.iter().filter(is_new).cloned());
        teeth
    }

    /// The face with its nodes at `x` (n, mm) and these `teeth`.
    fn face(&self, x: &[Vec3], teeth: Vec<Teeth>, name: &str) -> Face {
        let start = self.start;
        let u: Vec<f64> = x
            .iter()
            .zip(&start.mesh.points)
            .flat_map(|(to, from)| Into::<[f64; 3]>::into(to - from))
            .collect();
        let motion = jaw_motion(start, false, &start.mesh.points, x);
        let given = self.given.iter().find(|teeth| !teeth.upper);
        let jaw = start.jaw.as_ref().map(|jaw| match &motion {
            Some(motion) => moved_jaw(jaw, motion, given),
            None => jaw.clone(),
        });
        let name = format!("{name}_registered");
        let mut face = Face { name, jaw, teeth, ..start.with_tissue_moved(&u) };
        face.mesh.points = x.to_vec();
        for landmark in &mut face.landmarks {
            landmark.site.position = landmark.site.weights.iter().map(|&(n, w)| w * x[n]).sum();
        }
        face
    }
}

/// Springs of `stiffness` (N/mm³) for `ties`, those that are far off the softer.
fn springs_of(ties: &[Tie], stiffness: f64) -> Vec<Spring> {
    let mut distances: Vec<f64> = ties.iter().map(|tie| tie.distance_mm).collect();
    distances.sort_by(f64::total_cmp);
    let median = distances.get(distances.len() / 2).copied().unwrap_or(0.);
    let outlying = (OUTLYING * median).max(OUTLYING_MM).powi(2);
    let spring = |tie: &Tie| {
        let weight = (outlying / (outlying + tie.distance_mm.powi(2))).powi(2);
        let along = 0.5 * weight * stiffness * tie.area;
        Spring::sliding(tie.carriers.clone(), tie.target, tie.normal, along)
    };
    ties.iter().map(spring).collect()
}

/// What of the quality is odd.
fn tell_quality(
    quality: &RegistrationQuality,
    face: &Face,
    scan: &Scan,
    warnings: &mut Vec<RegistrationWarning>,
) -> Result<(), RegistrationError> {
    let covered = quality.covered;
    if covered < NEEDED_COVER {
        return Err(RegistrationError::LittleCovered { covered, needed: NEEDED_COVER });
    }
    if covered < TOLD_COVER {
        warnings.push(RegistrationWarning::Uncovered { covered });
    }
    let SkinAt { sheet: skin, .. } = FaceSkin::of(face).at(face, &face.mesh.points);
    let is_hole = |(length, rim): &(f64, Vec<usize>)| {
        let is_on_skin = |&v: &usize| {
            let (y, normal) = (scan.sheet.surface.points[v], scan.sheet.normals[v]);
            skin.nearest(y, Some(normal), HOLE_MM).is_some_and(|foot| !foot.is_rim)
        };
        *length >= HOLE_RIM_MM && 2 * rim.iter().filter(|v| is_on_skin(v)).count() > rim.len()
    };
    // The longest is the scan's own margin.
    let holes: Vec<f64> =
        scan.sheet.rims().iter().skip(1).filter(|rim| is_hole(rim)).map(|(length, _)| *length).collect();
    if let Some(&longest_mm) = holes.first() {
        warnings.push(RegistrationWarning::Holes { holes: holes.len(), longest_mm });
    }
    let at = |name: &str| quality.landmarks.iter().find(|l| l.name == name).map(|l| l.given_mm);
    if let (Some(upper), Some(lower)) = (at("stomion_superius"), at("stomion_inferius")) {
        let gap_mm = (upper - lower).norm();
        if gap_mm > OPEN_MM {
            warnings.push(RegistrationWarning::OpenMouth { gap_mm });
        }
    }
    let rms_mm = quality.from_skin.rms_mm;
    if rms_mm > FAR_MM {
        warnings.push(RegistrationWarning::FarFromScan { rms_mm });
    }
    if quality.scaled_jacobian < LEAST_JACOBIAN {
        let scaled_jacobian = quality.scaled_jacobian;
        warnings.push(RegistrationWarning::PoorCell { scaled_jacobian, least: LEAST_JACOBIAN });
    }
    if let Err(crossing) = FaceContact::new(face) {
        warnings.push(RegistrationWarning::Crossing { what: crossing.to_string() });
    }
    Ok(())
}
