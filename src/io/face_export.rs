//! Writes a face as a face file with its mesh, fibres, landmarks and teeth.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::csv::entry;
use super::{FileSet, MeshFileError, VtuData, WriteError, vtu_text};
use crate::face::{Face, Muscle};
use crate::mesh::{Mesh, Surface};
use crate::units::Vec3;

/// A face cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FaceExportError {
    /// The file system refuses.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The mesh cannot be written.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
}

/// Writes `face` to `folder` as `face.toml`, `mesh.vtu`, `fibres.csv`, `landmarks.csv` and one
/// `teeth_*.obj` a tooth surface, all of them or none; returns their paths. Lengths mm.
///
/// [`read_face`](super::read_face) gives the same face back: fibres and the carriers of landmarks are read as they
/// are.
///
/// # Errors
/// [`FaceExportError`] when the file system refuses.
pub fn write_face(folder: &Path, face: &Face) -> Result<Vec<PathBuf>, FaceExportError> {
    let mut set = FileSet::new(folder);
    put_face(&mut set, face)?;
    Ok(set.write()?)
}

/// Adds the files of `face` to a set.
///
/// # Errors
/// [`FaceExportError::Mesh`] when the mesh has no form in a file.
pub fn put_face(set: &mut FileSet, face: &Face) -> Result<(), FaceExportError> {
    let mesh = vtu_text("mesh.vtu".as_ref(), &named_sets(face), &VtuData::default())?;
    set.put("mesh.vtu", mesh.into_bytes());
    for (k, teeth) in face.teeth.iter().enumerate() {
        set.put(&teeth_file(face, k), obj(&teeth.surface).into_bytes());
    }
    set.put("landmarks.csv", landmarks(face).into_bytes());
    set.put("fibres.csv", fibres(face).into_bytes());
    set.put("face.toml", index(face).into_bytes());
    Ok(())
}

/// The mesh with every node set that the face file names.
fn named_sets(face: &Face) -> Mesh {
    let mut mesh = face.mesh.clone();
    let named = [
        ("skin", &face.skin),
        ("mucosa", &face.mucosa),
        ("upper_lip", &face.upper_lip),
        ("lower_lip", &face.lower_lip),
    ];
    for (name, nodes) in named {
        mesh.node_sets.insert(name.to_owned(), nodes.clone());
    }
    for support in &face.supports {
        mesh.node_sets.insert(support.bone.clone(), support.nodes.clone());
    }
    mesh
}

fn teeth_file(face: &Face, k: usize) -> String {
    let arch = arch(face.teeth[k].upper);
    match face.teeth[..k].iter().filter(|t| t.upper == face.teeth[k].upper).count() {
        0 => format!("teeth_{arch}.obj"),
        before => format!("teeth_{arch}_{}.obj", before + 1),
    }
}

fn arch(upper: bool) -> &'static str {
    if upper { "upper" } else { "lower" }
}

fn obj(surface: &Surface) -> String {
    let mut text = String::new();
    for p in &surface.points {
        let _ = writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z);
    }
    for [a, b, c] in &surface.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

fn landmarks(face: &Face) -> String {
    let mut text = "landmark,x_mm,y_mm,z_mm,carriers\n".to_owned();
    for landmark in &face.landmarks {
        let (p, carriers) = (landmark.site.position, &landmark.site.weights);
        let carriers: Vec<String> = carriers.iter().map(|(node, w)| format!("{node}:{w:?}")).collect();
        let (name, carriers) = (entry(&landmark.name), carriers.join(" "));
        let _ = writeln!(text, "{name},{:?},{:?},{:?},{carriers}", p.x, p.y, p.z);
    }
    text
}

/// Name without the side, and the side: `l`, `r` or none.
fn sided(muscle: &Muscle) -> (&str, &str) {
    let name = muscle.name.as_str();
    match (name.strip_suffix("_l"), name.strip_suffix("_r")) {
        (Some(stem), _) => (stem, "l"),
        (_, Some(stem)) => (stem, "r"),
        _ => (name, ""),
    }
}

fn fibres(face: &Face) -> String {
    let mut text = "muscle,side,fibre,point,x_mm,y_mm,z_mm\n".to_owned();
    for muscle in &face.muscles {
        let (stem, side) = sided(muscle);
        let stem = entry(stem);
        for (k, fibre) in muscle.fibres.iter().enumerate() {
            for (i, p) in fibre.points.iter().enumerate() {
                // Fibres are read in the order of their names.
                let _ = writeln!(text, "{stem},{side},{k:06},{i},{:?},{:?},{:?}", p.x, p.y, p.z);
            }
        }
    }
    text
}

fn index(face: &Face) -> String {
    let mut text = String::from("# A face: the index of its files. Lengths mm, forces N, moduli kPa.\n");
    let name = toml::Value::String(face.name.clone());
    let _ = writeln!(text, "name = {name}\nunit = \"mm\"\nmesh = \"mesh.vtu\"");
    // As they are: curves through points of curves would be others.
    let _ = writeln!(text, "fibres = \"fibres.csv\"\nfibre_course = \"polyline\"");
    let _ = writeln!(text, "landmarks = \"landmarks.csv\"\nskin = \"skin\"");
    let optional = [("mucosa", &face.mucosa), ("upper_lip", &face.upper_lip), ("lower_lip", &face.lower_lip)];
    for (set, _) in optional.iter().filter(|(_, nodes)| !nodes.is_empty()) {
        let _ = writeln!(text, "{set} = \"{set}\"");
    }
    let (passive, muscle) = (face.tissue, face.muscle_tissue);
    let _ =
        writeln!(text, "\n[tissue]\nyoung_kpa = {:?}\npoisson = {:?}", passive.young_kpa, passive.poisson);
    let _ = writeln!(text, "strain_stiffening = {:?}", passive.strain_stiffening);
    let _ = writeln!(text, "\n[muscle_tissue]\nrest_kpa = {:?}", muscle.rest_kpa);
    let _ = writeln!(text, "active_kpa = {:?}\npoisson = {:?}", muscle.active_kpa, muscle.poisson);
    let _ = writeln!(text, "law = \"{}\"", muscle.law.name());
    for support in &face.supports {
        let name = toml::Value::String(support.bone.clone());
        let _ = writeln!(text, "\n[[supports]]\nbone = {name}\nset = {name}");
        if let Some(whole) = &support.part_of {
            let _ = writeln!(text, "part_of = {}", toml::Value::String(whole.clone()));
        }
    }
    if let Some(jaw) = &face.jaw {
        let place = |p: &Vec3| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z);
        let [left, right] = jaw.condyles.each_ref().map(place);
        let bone = toml::Value::String(jaw.bone.clone());
        let _ = writeln!(text, "\n[jaw]\nbone = {bone}\ncondyles_mm = [{left}, {right}]");
        let _ = writeln!(text, "incisor_mm = {}", place(&jaw.incisor));
    }
    for (k, teeth) in face.teeth.iter().enumerate() {
        let file = teeth_file(face, k);
        let bone = toml::Value::String(teeth.bone.clone());
        let _ = writeln!(text, "\n[[teeth]]\narch = \"{}\"\nbone = {bone}", arch(teeth.upper));
        let _ = writeln!(text, "file = \"{file}\"");
    }
    let mut k = 0;
    while let Some(muscle) = face.muscles.get(k) {
        let (stem, side) = sided(muscle);
        let twin = face.muscles.get(k + 1).filter(|other| {
            let like = |m: &Muscle| (m.max_force_n, m.radius_mm, m.area_mm2, m.insertion_mm);
            let (other_stem, other_side) = sided(other);
            other_stem == stem && ![side, other_side].contains(&"") && like(other) == like(muscle)
        });
        let sides: Vec<String> = [Some(muscle), twin]
            .into_iter()
            .flatten()
            .map(|m| sided(m).1)
            .filter(|side| !side.is_empty())
            .map(|side| format!("\"{side}\""))
            .collect();
        let _ = writeln!(text, "\n[[muscles]]\nname = {}", toml::Value::String(stem.to_owned()));
        let _ = writeln!(text, "sides = [{}]", sides.join(", "));
        let _ = writeln!(text, "max_force_n = {:?}\nradius_mm = {:?}", muscle.max_force_n, muscle.radius_mm);
        if let Some(area_mm2) = muscle.area_mm2 {
            let _ = writeln!(text, "area_mm2 = {area_mm2:?}");
        }
        let _ = writeln!(text, "insertion_mm = {:?}", muscle.insertion_mm);
        if muscle.fibres.iter().any(|f| f.closed) {
            text += "closed = true\n";
        }
        k += 1 + usize::from(twin.is_some());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::standard;
    use crate::face::standard::Resolution;
    use crate::forward::Model;
    use crate::io::read_face;

    #[test]
    fn a_face_comes_back() {
        let face = standard(&Resolution::COARSE);
        let folder = tempfile::tempdir().expect("a folder");
        let files = write_face(folder.path(), &face).expect("written");
        assert!(files.contains(&folder.path().join("face.toml")), "{files:?}");
        let back = read_face(&folder.path().join("face.toml"), None).expect("a face").face;
        assert_eq!(back.mesh.points, face.mesh.points);
        assert_eq!(back.mesh.cells, face.mesh.cells);
        assert_eq!((back.tissue, back.muscle_tissue), (face.tissue, face.muscle_tissue));
        assert_eq!(back.supports, face.supports);
        assert_eq!(
            (&back.skin, &back.mucosa, &back.upper_lip, &back.lower_lip),
            (&face.skin, &face.mucosa, &face.upper_lip, &face.lower_lip)
        );
        assert_eq!((&back.jaw, &back.teeth), (&face.jaw, &face.teeth));
        assert_eq!(back.muscles.len(), face.muscles.len());
        for (a, b) in back.muscles.iter().zip(&face.muscles) {
            assert_eq!((&a.name, a.max_force_n, a.radius_mm), (&b.name, b.max_force_n, b.radius_mm));
            assert_eq!(a.area_mm2, b.area_mm2);
            assert_eq!(a.fibres, b.fibres, "{}", a.name);
        }
        assert_eq!(back.landmarks, face.landmarks);
        let map = |face: &Face| {
            let model = Model::new(face, Vec::new()).expect("a model");
            model.at(&vec![0.5; face.muscles.len()]).expect("factorised").map().concat()
        };
        let (there, here) = (map(&back), map(&face));
        let largest = here.iter().fold(0., |most: f64, u| most.max(u.abs()));
        let apart = there.iter().zip(&here).map(|(a, b)| (a - b).abs()).fold(0., f64::max);
        assert!(apart <= 1e-9 * largest, "{apart} of {largest}");
    }
}
