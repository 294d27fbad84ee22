//! Files as other programs write them: what each kind means, and which set it makes.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::Path;

use modiolus::io::{
    MeshDocument, MeshFileError, MeshFileWarning, parse_mesh, parse_surface, read_mesh_document, sha256,
};
use modiolus::mesh::{CellKind, Mesh, Surface, validate_shape};
use modiolus::units::LengthUnit::Millimetre;
use modiolus::units::Vec3;

fn parse(name: &str, text: impl AsRef<[u8]>) -> Result<MeshDocument, MeshFileError> {
    parse_mesh(text.as_ref(), Path::new(name), Millimetre)
}

fn read(what: &str, name: &str, text: impl AsRef<[u8]>) -> Mesh {
    let mesh = parse(name, text).unwrap_or_else(|e| panic!("{what}: {e}")).mesh;
    validate_shape(&mesh).unwrap_or_else(|e| panic!("{what}: {e}"));
    mesh
}

fn refusal(name: &str, text: impl AsRef<[u8]>) -> String {
    parse(name, text).err().map(|e| e.to_string()).unwrap_or_else(|| "it was read".to_owned())
}

/// The numbers of the nodes of set `name`.
/// Every file that the mesh was read from has the fingerprint of its bytes.
fn assert_fingerprints(document: &MeshDocument) {
    for file in &document.files {
        assert_eq!(file.sha256, sha256(&std::fs::read(&file.path).unwrap()), "{}", file.path.display());
    }
}

fn ids(mesh: &Mesh, name: &str) -> Vec<u64> {
    let known: Vec<&String> = mesh.node_sets.keys().collect();
    let set = mesh.node_sets.get(name).unwrap_or_else(|| panic!("no {name} among {known:?}"));
    set.iter().map(|&node| mesh.node_id(node)).collect()
}

const CUBE: [[f64; 3]; 8] = [
    [0., 0., 0.],
    [10., 0., 0.],
    [10., 10., 0.],
    [0., 10., 0.],
    [0., 0., 10.],
    [10., 0., 10.],
    [10., 10., 10.],
    [0., 10., 10.],
];

fn rows(separator: &str, numbered: bool) -> String {
    let row = |(k, p): (usize, &[f64; 3])| {
        let number = if numbered { format!("{}{separator}", k + 1) } else { String::new() };
        number + &p.map(|x| format!("{x:.1}")).join(separator) + "\n"
    };
    CUBE.iter().enumerate().map(row).collect()
}

fn nodes() -> String {
    format!("*NODE\n{}", rows(", ", true))
}

/// A cube of nodes 1 to 8 and element 1, then `rest`.
fn inp(rest: &str) -> String {
    format!("*HEADING\na cube\n{}*ELEMENT, TYPE=C3D8, ELSET=V\n1, 1,2,3,4,5,6,7,8\n{rest}", nodes())
}

/// A part `P` that is a cube with `of_part`, and an assembly.
fn assembled(of_part: &str, assembly: &str) -> String {
    let part = inp(of_part).replace("*HEADING\na cube\n", "*Part, name=P\n");
    format!(
        "*Heading\n{part}*End Part\n*Assembly, name=A\n{assembly}*End Assembly\n*Step\n*Static\n0.1, 1.\n*End Step\n"
    )
}

const INSTANCE: &str = "*Instance, name=P-1, part=P\n*End Instance\n";

#[test]
fn abaqus_keywords_and_sets() {
    let bottom = vec![1, 2, 3, 4];
    for (what, rest) in [
        ("a list", "*NSET, NSET=bone\n1, 2, 3, 4\n"),
        ("a list over lines", "*NSET, NSET=bone\n1, 2,\n3,\n4,\n"),
        ("a keyword that goes on", "*NSET,\n NSET=bone\n1, 2, 3, 4\n"),
        ("a keyword that goes on after a comment", "*NSET,\n** why\nNSET=bone,\nUNSORTED\n1, 2, 3, 4\n"),
        ("a stray comma", "*NSET, NSET=bone,\n1, 2, 3, 4\n"),
        ("blanks and small letters", "*n set , nset = bone\n1, 2, 3, 4\n"),
        ("a name in quotes", "*NSET, NSET=\"bone\"\n1, 2, 3, 4\n"),
        ("a range", "*NSET, NSET=bone, GENERATE\n1, 4\n"),
        ("steps", "*NSET, NSET=bone, GENERATE\n1, 3, 2\n2, 4, 2\n"),
        ("a range over gaps", "*NSET, NSET=bone, GENERATE\n1, 4, 1\n90, 2000000000, 1\n"),
        ("the nodes of faces", "*ELEMENT, TYPE=S4R, ELSET=f\n7, 1,2,3,4\n*NSET, NSET=bone, ELSET=f\n"),
        ("faces as a set", "*ELEMENT, TYPE=S4, ELSET=bone\n7, 1,2,3,4\n"),
        ("faces in a set", "*ELEMENT, TYPE=CPS3, ELSET=f\n7, 1,2,3\n8, 3,4,1\n*ELSET, ELSET=bone\nf\n"),
        ("numbers of faces", "*ELEMENT, TYPE=M3D4\n7, 1,2,3,4\n*ELSET, ELSET=bone, GENERATE\n7, 9\n"),
        ("a surface of faces", "*SURFACE, TYPE=ELEMENT, NAME=bone\nV, S1\n"),
        ("a surface of one element", "*SURFACE, NAME=bone\n1, s1\n"),
        ("a surface of shells", "*ELEMENT, TYPE=S4, ELSET=f\n7, 1,2,3,4\n*SURFACE, NAME=bone\nf, SNEG\n"),
        ("a surface of nodes", "*NSET, NSET=n\n1,2\n*SURFACE, TYPE=NODE, NAME=bone\nn, 1.\n3\n4, 1.\n"),
        ("a set in a set", "*NSET, NSET=bone\nlater, 4\n*NSET, NSET=Later\n1, 2, 3\n"),
        ("in two pieces", "*NSET, NSET=bone\n1, 2\n*NSET, NSET=BONE\n3, 4, bone\n"),
        ("beside a surface of its name", "*NSET, NSET=bone\n1,2,3,4\n*SURFACE, NAME=bone\nV, S2\n"),
        ("beside springs", "*ELEMENT, TYPE=SPRINGA, ELSET=s\n9, 1, 8\n*NSET, NSET=bone\n1,2,3,4\n"),
        ("beside dashpots", "*ELEMENT, TYPE=DASHPOTA\n9, 1, 8\n*NSET, NSET=bone\n1,2,3,4\n"),
        ("beside connectors to the ground", "*ELEMENT, TYPE=CONN3D2\n9, , 8\n*NSET, NSET=bone\n1,2,3,4\n"),
        (
            "beside masses",
            "*ELEMENT, TYPE=MASS\n9, 1\n*ELEMENT, TYPE=ROTARYI\n10, 1\n*NSET, NSET=bone\n1,2,3,4\n",
        ),
    ] {
        assert_eq!(ids(&read(what, "a.inp", inp(rest)), "bone"), bottom, "{what}");
    }
    let before = format!("*NSET, NSET=bone, GENERATE\n1, 4\n{}", inp(""));
    assert_eq!(ids(&read("before the nodes", "a.inp", before), "bone"), bottom);
    let both = read("a surface too", "a.inp", inp("*NSET, NSET=bone\n1\n*SURFACE, NAME=bone\nV, S2\n"));
    assert_eq!((ids(&both, "bone"), ids(&both, "surface=bone")), (vec![1], vec![5, 6, 7, 8]));
    let free = read("the free surface", "a.inp", inp("*SURFACE, NAME=skin\nV\n"));
    assert_eq!(ids(&free, "skin").len(), 8);
    assert_eq!(free.cell_sets["V"], [0]);
}

#[test]
fn abaqus_faces_are_numbered_as_abaqus_numbers_them() {
    let hexahedron = [[1, 2, 3, 4], [5, 6, 7, 8], [1, 2, 5, 6], [2, 3, 6, 7], [3, 4, 7, 8], [1, 4, 5, 8]];
    for (k, face) in hexahedron.iter().enumerate() {
        let mesh = read("a face", "a.inp", inp(&format!("*SURFACE, NAME=f\n1, S{}\n", k + 1)));
        assert_eq!(ids(&mesh, "f"), face, "S{}", k + 1);
    }
    let tetrahedron = "*NODE\n1,0,0,0\n2,10,0,0\n3,0,10,0\n4,0,0,10\n*ELEMENT, TYPE=C3D4\n1, 1,2,3,4\n";
    for (k, face) in [[1, 2, 3], [1, 2, 4], [2, 3, 4], [1, 3, 4]].iter().enumerate() {
        let mesh = read("a face", "a.inp", format!("{tetrahedron}*SURFACE, NAME=f\n1, S{}\n", k + 1));
        assert_eq!(ids(&mesh, "f"), face, "S{}", k + 1);
    }
    let wrong = refusal("a.inp", format!("{tetrahedron}*SURFACE, NAME=f\n1, S5\n"));
    assert!(wrong.contains("a.inp:9: f: expected a face from S1 to S4 of Tet4, found `S5`"), "{wrong}");
}

#[test]
fn abaqus_names_hold_within_their_part() {
    let bone = "*Nset, nset=bone\n1,2,3,4\n";
    // The reference point of an assembly is number 1 again, and no node of the mesh.
    let point = "*Node\n1, 5., 5., 5.\n*Nset, nset=RP\n1\n*Nset, nset=skin, instance=P-1\n5,6,7,8\n";
    let document = parse("a.inp", assembled(bone, &format!("{INSTANCE}{point}"))).unwrap();
    assert_eq!(document.mesh.n_nodes(), 8);
    assert_eq!(
        (ids(&document.mesh, "bone"), ids(&document.mesh, "skin")),
        (vec![1, 2, 3, 4], vec![5, 6, 7, 8])
    );
    assert_eq!(document.no_sets.iter().map(|no| no.name.as_str()).collect::<Vec<_>>(), ["RP"]);
    for (what, assembly) in [
        ("prefixed numbers", "*Nset, nset=skin\nP-1.5, P-1.6,\np-1.7,\nP-1.8\n"),
        ("a prefixed set", "*Nset, nset=skin\nP-1.top\n"),
        ("of the instance", "*Nset, nset=skin, instance=P-1\ntop\n"),
        ("by faces", "*Surface, name=skin\nP-1.V, S2\n"),
        ("by an element set", "*Elset, elset=e, internal, instance=P-1\n1\n*Surface, name=skin\ne, S2\n"),
    ] {
        let text = assembled("*Nset, nset=top\n5,6,7,8\n", &format!("{INSTANCE}{assembly}"));
        assert_eq!(ids(&read(what, "a.inp", text), "skin"), [5, 6, 7, 8], "{what}");
    }
    // The same name twice is two sets, and alone it stands for neither.
    let twice =
        read("twice", "a.inp", assembled(bone, &format!("{INSTANCE}*Nset, nset=bone, instance=P-1\n5\n")));
    assert!(!twice.node_sets.contains_key("bone"));
    assert_eq!((ids(&twice, "P-1.bone"), ids(&twice, "A.bone")), (vec![1, 2, 3, 4], vec![5]));
    let same = format!("{INSTANCE}*Nset, nset=bone, instance=P-1\n1,2,3,4\n");
    assert_eq!(ids(&read("the same", "a.inp", assembled(bone, &same)), "bone"), [1, 2, 3, 4]);
    assert_eq!(ids(&read("no assembly", "a.inp", assembled(bone, "")), "bone"), [1, 2, 3, 4]);
}

#[test]
fn abaqus_instances_are_placed_and_numbered_on() {
    let placed = "*Instance, name=P-1, part=P\n*End Instance\n\
                  *Instance, name=P-2, part=P\n20., 0., 0.\n*End Instance\n\
                  *Instance, name=P-3, part=P\n0., 0., 0.\n0., 0., 0., 0., 0., 1., 90.\n*End Instance\n";
    let mesh = read("three", "a.inp", assembled("*Nset, nset=bone\n2\n", placed));
    assert_eq!((mesh.n_nodes(), mesh.cells.len()), (24, 3));
    let at = |name: &str| mesh.points[mesh.node_sets[name][0]];
    for (name, expected) in
        [("P-1.bone", [10., 0., 0.]), ("P-2.bone", [30., 0., 0.]), ("P-3.bone", [0., 10., 0.])]
    {
        assert!((at(name) - Vec3::from(expected)).norm() < 1e-12, "{name} {}", at(name));
    }
    assert_eq!(mesh.node_ids[8], 9);
    assert_eq!(mesh.cell_sets["P-3.V"], [2]);
    let two = assembled("*End Part\n*Part, name=Q\n*Node\n1, 0.,0.,0.\n", "*Instance, name=Q-1, part=R\n");
    assert!(refusal("a.inp", two).contains("expected the name of a *PART above, found `R`"));
}

#[test]
fn abaqus_includes_and_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("nodes.inp", &nodes());
    put("bone.txt", "1, 2,\n3, 4\n");
    let main = "*INCLUDE, INPUT=nodes.inp\n*ELEMENT, TYPE=C3D8\n1, 1,2,3,4,5,6,7,8\n\
                *NSET, NSET=bone\n*INCLUDE, INPUT=bone.txt\n*NSET, NSET=more, INPUT=bone.txt\n5\n";
    put("a.inp", main);
    let document = read_mesh_document(&folder.path().join("a.inp"), Millimetre).unwrap();
    assert_eq!((ids(&document.mesh, "bone"), ids(&document.mesh, "more").len()), (vec![1, 2, 3, 4], 5));
    assert_eq!(document.files.len(), 4, "each inclusion is a reading");
    assert_fingerprints(&document);
    put("round.inp", "*INCLUDE, INPUT=round.inp\n");
    put("secret", "root:x:0:0\n");
    put("b.inp", "*INCLUDE, INPUT=secret\n");
    let message = |name: &str| {
        read_mesh_document(&folder.path().join(name), Millimetre)
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    assert!(message("round.inp").contains("an include within eight others is not read"));
    assert!(message("b.inp").contains("is no Abaqus file") && !message("b.inp").contains("root"));
    for (rest, words) in [
        (
            "*NSET, NSET=a, ELSETS=V\n",
            "a.inp:14: ELSETS: expected a parameter of *NSET that is read (NSET, ELSET,",
        ),
        ("*NSET, NSET=a\nb\n*NSET, NSET=b\na\n", "sets that do not list each other in a circle"),
        ("*NSET, NSET=a, INSTANCE=X\n1\n", "there is no instance `X`; known are: none"),
        ("*NSET, NSET=a\nb\n", "a.inp:15: a: set `b` is not defined; defined are: a"),
        ("*NSET, NSET=a\n9\n", "a.inp:15: a: set a uses node 9, which is not defined"),
        ("*ELSET, ELSET=a\n9\n", "set a lists element 9, which is not defined"),
    ] {
        let message = refusal("a.inp", inp(rest));
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn quadratic_hexahedra_are_read_by_their_corners_with_a_warning() {
    let between = (0..12).map(|k| format!("{}, {k}., 5., 5.\n", 9 + k)).collect::<String>();
    let numbers = (1..=20).map(|k| k.to_string()).collect::<Vec<_>>().join(", ");
    let text =
        format!("{}{between}*ELEMENT, TYPE=C3D20R\n1, {numbers}\n*NSET, NSET=bone\n1, 2, 9\n", nodes());
    let document = parse("a.inp", text).unwrap();
    assert_eq!((document.mesh.n_nodes(), document.mesh.cells.len()), (8, 1));
    assert_eq!(ids(&document.mesh, "bone"), [1, 2]);
    assert!(
        matches!(&document.warnings[..], [MeshFileWarning::Corners { kind, count: 1, first: 1 }] if kind == "C3D20")
    );
}

/// A cube as MSH 2.2 with faces 1 (below, group 7) and 2 (above, group 8), then `cells`.
fn msh(names: &str, elements: &[&str], late: &str) -> String {
    let faces = ["1 3 2 7 1 1 2 3 4", "2 3 2 8 2 5 6 7 8"];
    let all = [&faces, elements].concat();
    let nodes = rows(" ", true);
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$Nodes\n8\n{nodes}$EndNodes\n$Elements\n{}\n{}\n$EndElements\n{late}",
        all.len(),
        all.join("\n")
    )
}

#[test]
fn gmsh_groups_and_names() {
    let cell = ["3 5 2 9 1 1 2 3 4 5 6 7 8"];
    for (what, rows) in [
        ("as Gmsh writes them", "2 7 \"bone\"\n2 8 \"skin\""),
        ("two blanks", "2  7  \"bone\"\n 2 8 \"skin\" "),
        ("tabs", "2\t7\t\"bone\"\n2\t8\t\"skin\""),
        ("empty lines", "2 7 \"bone\"\n\n2 8 \"skin\""),
        ("no quotes", "2 7 bone\n2 8 skin"),
    ] {
        let names = format!("$PhysicalNames\n2\n{rows}\n$EndPhysicalNames\n");
        for (early, late) in [(names.as_str(), ""), ("", names.as_str())] {
            let mesh = read(what, "a.msh", msh(early, &cell, late));
            assert_eq!(
                (ids(&mesh, "bone"), ids(&mesh, "skin")),
                (vec![1, 2, 3, 4], vec![5, 6, 7, 8]),
                "{what}"
            );
        }
    }
    let names = "$PhysicalNames\n2\n2 7 \"a  \"b\"\"\n2 8 \"c d\"\n$EndPhysicalNames\n";
    let mesh = read("quotes", "a.msh", msh(names, &cell, ""));
    assert_eq!((ids(&mesh, "a  \"b\"").len(), ids(&mesh, "c d").len()), (4, 4));
    let same = "$PhysicalNames\n2\n2 7 \"a\"\n2 8 \"a\"\n$EndPhysicalNames\n";
    let mesh = read("one name", "a.msh", msh(same, &cell, ""));
    assert_eq!((ids(&mesh, "surface=7"), ids(&mesh, "surface=8")), (vec![1, 2, 3, 4], vec![5, 6, 7, 8]));
    let twice = ["3 5 2 9 1 1 2 3 4 5 6 7 8", "4 5 2 10 1 1 2 3 4 5 6 7 8", "5 3 2 11 1 1 2 3 4"];
    let mesh = read("a cell in two groups", "a.msh", msh("", &twice, ""));
    assert_eq!(
        (mesh.cells.len(), &mesh.cell_sets["volume=9"], &mesh.cell_sets["volume=10"]),
        (1, &vec![0], &vec![0])
    );
    assert_eq!(ids(&mesh, "surface=11"), [1, 2, 3, 4]);
    let one =
        msh("", &cell, "").replace("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "").replace("$Nodes", "$NOD");
    assert!(
        refusal("a.msh", one)
            .contains("a.msh:1: $MeshFormat version: MSH version 1 is not read; save as MSH 2.2")
    );
}

#[test]
fn gmsh_partitions_have_the_groups_of_their_parents() {
    let nodes = rows(" ", false);
    let text = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"bone\"\n$EndPhysicalNames\n\
         $Entities\n0 0 1 1\n1 0 0 0 10 10 0 1 7 0\n1 0 0 0 10 10 10 1 9 0\n$EndEntities\n\
         $PartitionedEntities\n2\n0\n0 0 1 1\n5 2 1 1 1 0 0 0 10 10 0 0 0\n6 3 1 1 1 0 0 0 10 10 10 0 0\n\
         $EndPartitionedEntities\n$Nodes\n1 8 1 8\n3 6 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n{nodes}$EndNodes\n\
         $Elements\n2 2 1 2\n2 5 3 1\n1 1 2 3 4\n3 6 5 1\n2 1 2 3 4 5 6 7 8\n$EndElements\n"
    );
    let mesh = read("partitions", "a.msh", text);
    assert_eq!((ids(&mesh, "bone"), &mesh.cell_sets["volume=9"]), (vec![1, 2, 3, 4], &vec![0]));
}

/// A cube and a quadrilateral below it, with arrays of points and of cells.
fn vtu(points: &str, cells: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n\
         <Piece NumberOfPoints=\" 8 \" NumberOfCells=\"2 \">\n<PointData>{points}</PointData><CellData>{cells}</CellData>\n\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\" 3 \" format=\"ascii\">\n{}</DataArray></Points>\n\
         <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 0 1 2 3 4 5 6 7</DataArray>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 12</DataArray>\n\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">9 12</DataArray></Cells>\n\
         </Piece></UnstructuredGrid></VTKFile>\n",
        rows(" ", false)
    )
}

fn array(kind: &str, name: &str, values: &str) -> String {
    format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\" ascii \">{values}</DataArray>")
}

#[test]
fn vtk_labels_of_points_faces_and_cells() {
    for (what, points, cells, set) in [
        ("flags", array("Int8", "bone", "1 1 1 1 0 0 0 0"), String::new(), "bone"),
        ("float flags", array("Float32", "bone", "1 1 1 1 0 0 0 0"), String::new(), "bone"),
        ("float labels", array("Float64", "part", "2.0 2 2 2 0 1 0 -1"), String::new(), "part=2"),
        ("labels of faces", String::new(), array("Int32", "part", "3 5"), "part=3"),
        ("float labels of faces", String::new(), array("Float32", "part", "3 5"), "part=3"),
        ("flags of faces", String::new(), array("UInt8", "bone", "1 0"), "bone"),
    ] {
        assert_eq!(ids(&read(what, "a.vtu", vtu(&points, &cells)), set), [0, 1, 2, 3], "{what}");
    }
    let mesh = read("both", "a.vtu", vtu("", &array("Int32", "part", "3 5")));
    assert_eq!((mesh.cells.len(), &mesh.cell_sets["part=5"]), (1, &vec![0]));
    let two = vtu(&array("Int8", "bone", "0 0 0 0 1 1 1 1"), &array("Int8", "bone", "1 0"));
    let mesh = read("two of a name", "a.vtu", two);
    assert_eq!((ids(&mesh, "bone"), ids(&mesh, "faces=bone")), (vec![4, 5, 6, 7], vec![0, 1, 2, 3]));
    let unused = array("Float64", "pressure", "nan 1 2 3 4 5 6 inf")
        + &array("Float64", "half", "0.5 1 2 3 4 5 6 7")
        + &array("Float64", "broken", "1 2 up")
        + &array("Int32", "short", "1 2")
        + "<DataArray type=\"Float64\" Name=\"u\" NumberOfComponents=\"3\" format=\"ascii\">1</DataArray>";
    let document = parse("a.vtu", vtu(&unused, "")).unwrap();
    let why = |name: &str| document.no_sets.iter().find(|no| no.name == name).unwrap().why.clone();
    assert_eq!(
        (why("pressure"), why("u")),
        ("its values are not all whole numbers".into(), "it has 3 components".into())
    );
    assert!(
        why("short").contains("declares 8 values but has 2")
            && why("broken").contains("`up` is not a number")
    );
    let ghost =
        vtu("", "").replace("4 12<", "4 12 20<").replace("9 12<", "9 12 12<").replace("\"2 \"", "\"3\"");
    let ghost = ghost.replace("4 5 6 7<", "4 5 6 7 4 5 6 7 0 1 2 3<");
    let ghost =
        ghost.replace("<CellData>", &format!("<CellData>{}", array("UInt8", "vtkGhostType", "0 0 1")));
    let document = parse("a.vtu", ghost).unwrap();
    assert_eq!((document.mesh.cells.len(), document.mesh.n_nodes()), (1, 8));
    assert_eq!(document.warnings, [MeshFileWarning::Ghosts { count: 1 }]);
}

#[test]
fn legacy_vtk_of_both_versions() {
    let points = rows(" ", false);
    let data = "CELL_DATA 2\nSCALARS part int 1\nLOOKUP_TABLE default\n3\n5\n\
                POINT_DATA 8\nVECTORS u float\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n\
                FIELD f 4\nwho 1 8 string\nPOINT_DATA 3\n\nc d\ne\nf\ng\nh\ni%0A\n\
                on 1 8 bit\n0 0 0 0 0 0 1 1\nbone 1 8 double\n1 1 1 1 0 0 0 0\np 1 8 double\n0 nan 1 1 0 0 0 0\nMETADATA\nINFORMATION 0\n\n";
    let head = "# vtk DataFile Version 4.2\na cube\nASCII\nDATASET UNSTRUCTURED_GRID\n";
    let old = "CELLS 2 14\n4 0 1 2 3\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 2\n9\n12\n";
    let new = "CELLS 3 12\nOFFSETS vtktypeint64\n0 4 12\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 1 2 3 4 5 6 7\nCELL_TYPES 2\n9\n12\n";
    for cells in [old, new] {
        let mesh = read("legacy", "a.vtk", format!("{head}POINTS 8 double\n{points}{cells}{data}"));
        assert_eq!((ids(&mesh, "bone"), ids(&mesh, "part=3")), (vec![0, 1, 2, 3], vec![0, 1, 2, 3]));
        assert_eq!((&mesh.cell_sets["part=5"], ids(&mesh, "on")), (&vec![0], vec![6, 7]));
    }
    // The same in binary, big endian.
    let mut bytes = head.replace("ASCII", "BINARY").into_bytes();
    bytes.extend(b"POINTS 8 float\n");
    bytes.extend(CUBE.iter().flatten().flat_map(|x| (*x as f32).to_be_bytes()));
    bytes.extend(b"\nCELLS 1 9\n");
    bytes.extend([8, 0, 1, 2, 3, 4, 5, 6, 7_i32].iter().flat_map(|x| x.to_be_bytes()));
    bytes.extend(b"\nCELL_TYPES 1\n");
    bytes.extend(12_i32.to_be_bytes());
    bytes.extend(b"\nPOINT_DATA 8\nSCALARS bone unsigned_char\nLOOKUP_TABLE default\n");
    bytes.extend([1, 1, 1, 1, 0, 0, 0, 0]);
    let mesh = read("binary", "a.vtk", &bytes);
    assert_eq!((ids(&mesh, "bone"), mesh.points[6]), (vec![0, 1, 2, 3], Vec3::repeat(10.)));
    // Strings of lengths in one byte, two and four; then bits.
    bytes.extend(b"\nFIELD f 2\nwho 1 5 string\n");
    for word in ["\n", "", "FIELD"] {
        bytes.push(0xc0 | word.len() as u8);
        bytes.extend(word.bytes());
    }
    for (head, length) in
        [(0x8000_u16.to_be_bytes().to_vec(), 100), (0x4000_0000_u32.to_be_bytes().to_vec(), 70)]
    {
        bytes.extend(&head);
        *bytes.last_mut().unwrap() = length;
        bytes.extend(vec![b'\n'; usize::from(length)]);
    }
    bytes.extend(b"\non 1 8 bit\n\x03\n");
    let document = parse("a.vtk", &bytes).unwrap();
    assert_eq!(ids(&document.mesh, "on"), vec![6, 7]);
    assert!(document.no_sets.iter().any(|no| no.name == "who" && no.why == "it has 5 entries"));
    let cut = bytes.len() - 90;
    assert!(refusal("a.vtk", &bytes[..cut]).contains("5 strings"), "{}", refusal("a.vtk", &bytes[..cut]));
}

#[test]
fn tetgen_and_febio() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    put("a.node", "# nodes\n4 3 0 1\n1 0 0 0 5\n2 10 0 0 5\n3 0 10 0 5\n4 0 0 10 0\n");
    put("a.ele", "1 4 1\n1 1 2 3 4 2\n# made by TetGen\n");
    put("a.face", "1 1\n1 2 3 4 9\n");
    for name in ["a.ele", "a.node"] {
        let document = read_mesh_document(&folder.path().join(name), Millimetre).unwrap();
        let mesh = &document.mesh;
        assert_eq!((ids(mesh, "marker=5"), ids(mesh, "face=9")), (vec![1, 2, 3], vec![2, 3, 4]));
        assert_eq!((&mesh.cell_sets["region=2"], document.files.len()), (&vec![0], 3));
        assert_fingerprints(&document);
        validate_shape(mesh).unwrap();
    }
    // Corners 1 to 4, then a node between every two.
    let corners = [[0., 0., 0.], [10., 0., 0.], [0., 10., 0.], [0., 0., 10.]].map(Vec3::from);
    let between = |[a, b]: [usize; 2]| (corners[a] + corners[b]) / 2.;
    let of_five = [[2, 3], [0, 3], [0, 1], [1, 2], [1, 3], [0, 2]];
    let of_four = [[0, 1], [0, 2], [1, 2], [1, 3], [0, 3], [2, 3]];
    for (version, edges) in [("1.5", of_five), ("1.4", of_four)] {
        let points = corners.into_iter().chain(edges.map(between));
        let rows: String = (1..).zip(points).map(|(k, p)| format!("{k} {} {} {}\n", p.x, p.y, p.z)).collect();
        put("b.node", &format!("10 3 0 0\n{rows}"));
        put("b.ele", "1 10 0\n1 1 2 3 4 5 6 7 8 9 10\n");
        let mesh = read_mesh_document(&folder.path().join("b.ele"), Millimetre).unwrap().mesh;
        validate_shape(&mesh).unwrap();
        let nodes = mesh.cells[0].nodes();
        for (&edge, &node) in CellKind::Tet10.edges().iter().zip(&nodes[4..]) {
            assert_eq!(mesh.points[node], between(edge), "version {version}");
        }
    }
    let nodes: String =
        (1..).zip(CUBE).map(|(k, [x, y, z])| format!("<node id=\"{k}\">{x},{y}, {z}</node>\n")).collect();
    let feb = |sets: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<febio_spec version=\"4.0\"><Mesh>\n<Nodes name=\"all\">\n{nodes}</Nodes>\n\
             <Elements type=\"hex8\" name=\"tissue\"><elem id=\"1\">1,2,3,4,5,6,7,8</elem></Elements>\n{sets}</Mesh></febio_spec>"
        )
    };
    for (what, set) in [
        ("version 4", "<NodeSet name=\"bone\">1,2,\n3,4</NodeSet>"),
        (
            "version 2",
            "<NodeSet name=\"bone\"><node id=\"1\"/><node id=\"2\"/><node id=\"3\"/><node id=\"4\"/></NodeSet>",
        ),
        ("a surface", "<Surface name=\"bone\"><quad4 id=\"1\">1,2,3,4</quad4></Surface>"),
        ("a shell", "<Elements type=\"quad4\" name=\"bone\"><elem id=\"2\">1,2,3,4</elem></Elements>"),
        (
            "a set of sets",
            "<NodeSet name=\"b\">1,2,3,4</NodeSet><NodeSet name=\"bone\"><NodeSet node_set=\"b\"/></NodeSet>",
        ),
    ] {
        let mesh = read(what, "a.feb", feb(set));
        assert_eq!((ids(&mesh, "bone"), &mesh.cell_sets["tissue"]), (vec![1, 2, 3, 4], &vec![0]), "{what}");
    }
    let pyramid = feb("").replace("hex8", "pyra5");
    assert!(refusal("a.feb", pyramid).contains("element 1 is of the unsupported kind pyra5"));
}

#[test]
fn the_content_decides_the_format() {
    for (name, text) in
        [("a.vtu", inp("")), ("a.inp", msh("", &["3 5 2 9 1 1 2 3 4 5 6 7 8"], "")), ("a", vtu("", ""))]
    {
        assert_eq!(read(name, name, text).cells.len(), 1);
    }
}

fn surface(name: &str, bytes: impl AsRef<[u8]>) -> Surface {
    parse_surface(bytes.as_ref(), Path::new(name), Millimetre).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Enclosed volume: that of the cube when it is closed and its triangles turn outward.
fn volume(surface: &Surface) -> f64 {
    let corners = |t: &[usize; 3]| t.map(|v| surface.points[v]);
    surface.triangles.iter().map(corners).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.).sum()
}

const SIDES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

#[test]
fn the_same_cube_in_every_format_of_surfaces() {
    let points = rows(" ", false);
    let sides = |from: usize, count: bool| -> String {
        let side = |s: &[usize; 4]| {
            let count = if count { "4 " } else { "" };
            format!("{count}{}\n", s.map(|v| (v + from).to_string()).join(" "))
        };
        SIDES.iter().map(side).collect()
    };
    let triangles = || SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let facet = |t: [usize; 3]| {
        let corners: String = t
            .iter()
            .map(|&v| CUBE[v].map(|x| x.to_string()).join(" "))
            .map(|p| format!("vertex {p}\n"))
            .collect();
        format!("facet normal 0 0 0\n outer loop\n{corners} endloop\nendfacet\n")
    };
    let obj: String = points.lines().map(|l| format!("v {l}\n")).collect::<String>()
        + &sides(1, false).lines().map(|l| format!("f {l}\n")).collect::<String>();
    let ply = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment a cube\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let coloured: String = points.lines().map(|l| format!("{l} 255\n")).collect();
    let mut binary_ply = ply("binary_little_endian").into_bytes();
    for p in CUBE {
        binary_ply.extend(p.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        binary_ply.push(255);
    }
    for side in SIDES {
        binary_ply.push(4);
        binary_ply.extend(side.iter().flat_map(|v| (*v as i32).to_le_bytes()));
    }
    let mut binary_stl = b"solid but binary".to_vec();
    binary_stl.resize(80, b' ');
    binary_stl.extend(12_u32.to_le_bytes());
    for t in triangles() {
        binary_stl.extend([0; 12]);
        binary_stl.extend(t.iter().flat_map(|&v| CUBE[v]).flat_map(|x| (x as f32).to_le_bytes()));
        binary_stl.extend([0; 2]);
    }
    let vtp = format!(
        "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"8\" NumberOfPolys=\"6\">\
         <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points>\
         <Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">{}</DataArray>\
         <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4 8 12 16 20 24</DataArray></Polys></Piece></PolyData></VTKFile>",
        sides(0, false)
    );
    let vtk = format!(
        "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n{points}POLYGONS 6 30\n{}",
        sides(0, true)
    );
    for (name, bytes) in [
        ("a.obj", obj.into_bytes()),
        (
            "ascii.stl",
            format!("solid a\n{}endsolid a\n", triangles().map(facet).collect::<String>()).into_bytes(),
        ),
        ("binary.stl", binary_stl),
        ("ascii.ply", (ply("ascii") + &coloured + &sides(0, true)).into_bytes()),
        ("binary.ply", binary_ply),
        ("a.vtp", vtp.into_bytes()),
        ("a.vtk", vtk.into_bytes()),
    ] {
        let cube = surface(name, &bytes);
        assert_eq!((cube.points.len(), cube.triangles.len()), (8, 12), "{name}");
        assert!((volume(&cube) - 1000.).abs() < 1e-9, "{name}");
        // The content decides: the wrong ending does no harm.
        assert_eq!(surface("a.obj", &bytes), cube, "{name}");
        for cut in [bytes.len() / 3, bytes.len() * 2 / 3] {
            let cut = parse_surface(&bytes[..cut], Path::new(name), Millimetre);
            assert!(name == "a.obj" || cut.is_err(), "{name} was taken as whole");
        }
    }
    let unknown = parse_surface(b"hello", Path::new("a.obj"), Millimetre).unwrap_err().to_string();
    assert!(
        unknown.contains("is no OBJ file, nor one of another format that is read (OBJ, STL"),
        "{unknown}"
    );
    let volume_mesh =
        parse_surface(inp("").as_bytes(), Path::new("a.obj"), Millimetre).unwrap_err().to_string();
    assert!(volume_mesh.contains("a volume mesh in place of a surface"), "{volume_mesh}");
}

#[test]
fn polygons_of_many_corners_enclose_what_they_enclosed() {
    // A corner in the middle of an edge that only one of its two polygons has.
    let text = "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 10 10 10\nv 0 10 10\nv 5 0 0\n\
                f 1 4 3 2 9\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let cube = surface("a.obj", text);
    assert_eq!(cube.triangles.len(), 12);
    assert!((volume(&cube) - 1000.).abs() < 1e-9);
    // A prism of 24 sides.
    let ring = |z: f64| (0..24).map(move |k| (f64::from(k) / 24. * std::f64::consts::TAU, z));
    let mut text: String = [0., 1.]
        .into_iter()
        .flat_map(ring)
        .map(|(a, z)| format!("v {} {} {z}\n", a.cos(), a.sin()))
        .collect();
    let list = |from: usize| (from..from + 24).map(|v| v.to_string()).collect::<Vec<_>>();
    let below: Vec<String> = list(1).into_iter().rev().collect();
    text += &format!("f {}\nf {}\n", below.join(" "), list(25).join(" "));
    for k in 0..24 {
        let next = (k + 1) % 24;
        text += &format!("f {} {} {} {}\n", k + 1, next + 1, next + 25, k + 25);
    }
    let prism = surface("a.obj", text);
    assert_eq!(prism.triangles.len(), 22 + 22 + 48);
    assert!((volume(&prism) - 12. * (std::f64::consts::TAU / 24.).sin()).abs() < 1e-9);
}
