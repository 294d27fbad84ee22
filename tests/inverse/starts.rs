//! Every shipped target from five starts in the box: one answer, or the others are told.

use std::path::Path;

use modiolus::face::standard::{Resolution, standard};
use modiolus::forward::Model;
use modiolus::inverse::{
    ActivatedProblem, ActivatedSolution, ContactMode, Observations, SequentialStep, Status,
};
use modiolus::io::read_target;
use nalgebra::DVector;

#[test]
fn five_starts_lead_to_optima_and_different_ones_are_told() {
    let face = standard(&Resolution::COARSE);
    let muscles: Vec<String> = face.muscles.iter().map(|m| m.name.clone()).collect();
    let model = Model::new(&face, face.contact_pairs(Default::default())).unwrap();
    let m = muscles.len();
    let starts = [
        DVector::zeros(m),
        DVector::from_element(m, 1.),
        DVector::from_element(m, 0.5),
        DVector::from_fn(m, |k, _| if k % 2 == 0 { 1. } else { 0. }),
        DVector::from_fn(m, |k, _| (k as f64 * 0.618_033_988_75).fract()),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("targets");
    for name in
        ["symmetric_smile", "asymmetric_smile", "lip_closure", "lip_press", "pucker", "snarl", "frown"]
    {
        let document = read_target(&folder.join(format!("{name}.toml"))).unwrap();
        let target = document.expand_patterns(&muscles).unwrap().target;
        let observations = Observations::resolve(&target, &face, |_| Err(f64::INFINITY)).unwrap();
        let problem = ActivatedProblem::new(&model, &target, &observations, ContactMode::Reactions);
        let found: Vec<ActivatedSolution> =
            starts.iter().map(|start| problem.solve(start.clone(), |_| {}).unwrap()).collect();
        for (k, one) in found.iter().enumerate() {
            assert_eq!(one.solution.status, Status::Solved, "{name} from start {k}: {:?}", one.history);
            assert!(one.solution.certificate.worst() <= 1e-8, "{name} from start {k}");
            // A step that makes it worse is never taken; rounding is 1e-12 of the objective.
            let falls = |w: &[SequentialStep]| w[1].objective <= w[0].objective * (1. + 1e-11);
            assert!(one.history.windows(2).all(falls), "{name} from start {k}: {:?}", one.history);
        }
        let steps: Vec<usize> = found.iter().map(|one| one.history.len()).collect();
        let answers: Vec<DVector<f64>> =
            found.iter().map(|one| DVector::from_vec(one.solution.activations.values.clone())).collect();
        let best = ActivatedSolution::best_of(found).unwrap();
        let objectives: Vec<f64> = best.others.iter().map(|s| s.objective).collect();
        println!("{name}: steps {steps:?}, best {:.4}, others {objectives:.4?}", best.solution.objective);
        assert!(objectives.iter().all(|o| *o >= best.solution.objective));
        // Each start's answer is the best or among the others, to 1e-5.
        for (k, answer) in answers.iter().enumerate() {
            let told = std::iter::once(&best.solution).chain(&best.others);
            let mut off = told.map(|s| (DVector::from_vec(s.activations.values.clone()) - answer).amax());
            assert!(off.any(|off| off <= 1e-5), "{name} from start {k} is told by no solution");
        }
    }
}
