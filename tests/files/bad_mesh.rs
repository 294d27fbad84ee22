//! What a bad mesh gets: one test a line of the list, on the variant and on what the message names.

#![allow(missing_docs)]

use crate::mesh_files::{Place, Vtu, inp, mixed, msh_2, msh_4};
use modiolus::io::{MeshFileError, MeshFileErrorKind as Kind, read_mesh};
use modiolus::mesh::{Cell, CellKind, FreeMode, Mesh, MeshError, MeshWarning, validate, validate_shape};
use modiolus::units::{LengthUnit, Vec3};

/// The error that `bytes` in a file `name` get; its message starts with the file.
fn refused(name: &str, bytes: &[u8]) -> MeshFileError {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    let error = read_mesh(&path, LengthUnit::Millimetre).err().unwrap_or_else(|| panic!("{name} was taken"));
    assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    error
}

fn assert_says(error: &impl ToString, words: &[&str]) {
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("text")
}

fn vtu() -> String {
    text(Vtu::ASCII.write(&mixed()))
}

fn gmsh() -> String {
    text(msh_2(&mixed(), None))
}

fn abaqus() -> String {
    text(inp(&mixed()))
}

/// `text` with the first `from` as `to`, which must change it.
fn with(text: &str, from: &str, to: &str) -> Vec<u8> {
    assert!(text.contains(from), "{from} is not in {text}");
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn nan_and_infinite_coordinates_in_files() {
    let error = refused("a.vtu", &with(&vtu(), "26 -7.5 1", "26 nan 1"));
    assert!(matches!(error.kind, Kind::NotFinite { .. }), "{error:?}");
    assert_says(&error, &["a.vtu:27: Points", "`nan` is not finite", "remove the node"]);
    let mut mesh = mixed();
    mesh.points[20].y = f64::INFINITY;
    for (name, bytes, at) in [
        (
            "b.vtu",
            Vtu { place: Place::Inline, zlib: true, ..Vtu::ASCII }.write(&mesh),
            "Points: `inf (node 20)`",
        ),
        ("a.msh", msh_2(&mesh, None), "a.msh:31: $Nodes y: `inf`"),
        ("b.msh", msh_4(&mesh, Some(false)), "byte"),
        ("a.inp", inp(&mesh), "a.inp:25: y: `inf`"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::NotFinite { .. }), "{error:?}");
        assert_says(&error, &[at, "is not finite"]);
    }
}

#[test]
fn not_a_number() {
    for (name, bytes, at) in [
        ("a.vtu", with(&vtu(), "26 -7.5 1", "26 up 1"), "a.vtu:27: Points: `up`"),
        ("a.msh", with(&gmsh(), "\n5 0e0", "\n5 up"), "a.msh:15: $Nodes x: `up`"),
        (
            "b.msh",
            with(&text(msh_4(&mixed(), None)), "\n2 21 1 21", "\n2 x 1 21"),
            "b.msh:17: $Nodes nodes: `x`",
        ),
        ("a.inp", with(&abaqus(), "5, 0.0", "5, up"), "a.inp:9: x: `up`"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::NotANumber { .. }), "{error:?}");
        assert_says(&error, &[at]);
    }
}

#[test]
fn decimal_comma() {
    for (name, bytes, at) in [
        ("a.vtu", with(&vtu(), "26 -7.5 1", "26 -7,5 1"), "a.vtu:27: Points: `-7,5`"),
        ("a.msh", with(&gmsh(), "-7.5e0", "-7,5e0"), "a.msh:31: $Nodes y: `-7,5e0`"),
        (
            "a.inp",
            with(&abaqus(), "21, 26.0, -7.5, 1.0", "21, 26,0, -7,5, 1,0"),
            "a.inp:25: x: `26,0,-7,5,1,0`",
        ),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::DecimalComma { .. }), "{error:?}");
        assert_says(&error, &[at, "decimal comma; write a decimal point"]);
    }
}

#[test]
fn truncated() {
    let cut = |bytes: Vec<u8>, part: usize| bytes[..bytes.len() * part / 10].to_vec();
    let appended = Vtu { place: Place::AppendedRaw, ..Vtu::ASCII }.write(&mixed());
    for (name, bytes) in [
        ("a.vtu", cut(vtu().into_bytes(), 5)),
        ("b.vtu", cut(appended, 8)),
        ("a.msh", cut(gmsh().into_bytes(), 5)),
        ("b.msh", cut(msh_2(&mixed(), Some(false)), 5)),
        ("c.msh", cut(msh_4(&mixed(), Some(true)), 8)),
    ] {
        let error = refused(name, &bytes);
        assert!(
            matches!(error.kind, Kind::Truncated { .. } | Kind::DeclaredTooMany { .. }),
            "{name} {error:?}"
        );
        assert!(error.location.line.is_some() || error.location.byte.is_some(), "{error}");
    }
    let abaqus = abaqus();
    let error = refused("a.inp", &abaqus.as_bytes()[..abaqus.find(" 5, 6, 7, 8\n").expect("second line")]);
    assert!(matches!(error.kind, Kind::Truncated { .. }), "{error:?}");
    assert_says(&error, &["a.inp:27: element", "the other nodes of element 1", "export or copy it again"]);
}

#[test]
fn empty() {
    for name in ["a.vtu", "a.msh", "a.inp"] {
        for bytes in [&b""[..], b" \r\n\n"] {
            let error = refused(name, bytes);
            assert_eq!(error.kind, Kind::Empty);
            assert_says(&error, &["is empty; export the mesh again"]);
        }
    }
    let error = refused("a.inp", b"*HEADING\nnothing\n");
    assert_eq!(error.kind, Kind::Nothing { what: "nodes" });
    let error = refused("a.inp", b"*NODE\n1, 0., 0., 0.\n");
    assert_says(&error, &["has no volume elements; export the volume mesh"]);
}

#[test]
fn binary_as_text() {
    let bytes = msh_2(&mixed(), Some(false));
    let lied = [b"$MeshFormat\n2.2 0 8\n".as_slice(), &bytes[24..]].concat();
    let inp = [abaqus().as_bytes(), b"\x01"].concat();
    let vtu = with(&vtu(), "</Points>", "\x01</Points>");
    for (name, bytes) in [("a.msh", &lied[..]), ("a.inp", &inp), ("a.vtu", &vtu), ("b.vtu", b"\0\x01\x02")] {
        let error = refused(name, bytes);
        assert!(matches!(error.kind, Kind::BinaryAsText { .. }), "{error:?}");
        assert_says(&error, &[": byte ", "is not text (byte 0x", "export as ASCII"]);
    }
}

#[test]
fn declared_two_billion_nodes() {
    let wide = Vtu { place: Place::Inline, zlib: true, wide_header: true, ..Vtu::ASCII };
    // The first header word of the points: 8 blocks become 2e9.
    let blocks = |n: u64| base64_of(&n.to_le_bytes());
    let packed = text(wide.write(&mixed()));
    for (name, bytes, at) in [
        ("a.vtu", with(&vtu(), "NumberOfPoints=\"21\"", "NumberOfPoints=\"2000000000\""), "NumberOfPoints"),
        ("b.vtu", with(&packed, &blocks(8), &blocks(2_000_000_000)), "Points"),
        ("a.msh", with(&gmsh(), "$Nodes\n21", "$Nodes\n2000000000"), "a.msh:10: $Nodes nodes"),
        ("b.msh", with(&text(msh_4(&mixed(), None)), "\n2 21 1 21", "\n2 2000000000 1 21"), "$Nodes nodes"),
        ("c.msh", with(&text(msh_4(&mixed(), None)), "\n2 1 0 5", "\n2 1 0 2000000000"), "$Nodes nodes"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::DeclaredTooMany { .. }), "{name} {error:?}");
        assert_says(&error, &[at, "2000000000", "correct the count"]);
    }
}

fn base64_of(bytes: &[u8]) -> String {
    use base64::Engine;
    // Ten of eleven characters: the last also holds bits of the next word.
    base64::prelude::BASE64_STANDARD.encode(bytes)[..10].to_owned()
}

#[test]
fn count_differs_from_rows() {
    for (name, bytes, words) in [
        ("a.vtu", with(&vtu(), "NumberOfPoints=\"21\"", "NumberOfPoints=\"22\""), "declares 22 points"),
        ("b.vtu", with(&vtu(), "NumberOfCells=\"4\"", "NumberOfCells=\"3\""), "declares 3 cells but has 4"),
        ("a.msh", with(&gmsh(), "$Nodes\n21", "$Nodes\n22"), "declares 22 nodes but has 21"),
        ("b.msh", with(&gmsh(), "$Nodes\n21", "$Nodes\n20"), "declares 20 nodes but has 21"),
        ("c.msh", with(&gmsh(), "$Elements\n5", "$Elements\n7"), "declares 7 elements but has 5"),
        (
            "d.msh",
            with(&text(msh_4(&mixed(), None)), "\n2 21 1 21", "\n2 25 1 21"),
            "declares 25 nodes but has 21",
        ),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::CountMismatch { .. }), "{name} {error:?}");
        assert_says(&error, &[words, "correct the count or restore the entries"]);
    }
    let error = refused("a.inp", &with(&abaqus(), "3, 11, 12, 14, 21", "3, 11, 12, 14"));
    assert_says(&error, &["a.inp:33: element: expected a number and 4 nodes of C3D4, found `4 fields`"]);
    let error = refused("a.msh", &with(&gmsh(), "-7.5e0 1e0", "-7.5e0"));
    assert_says(&error, &["a.msh:31: $Nodes z: expected z, found `the end of the row`"]);
}

#[test]
fn duplicate_node_id() {
    for (name, bytes, line) in [
        ("a.msh", with(&gmsh(), "\n5 0e0", "\n4 0e0"), 15),
        ("b.msh", with(&text(msh_4(&mixed(), None)), "\n1 \n2 \n3 \n", "\n1 \n2 \n2 \n"), 21),
        ("a.inp", with(&abaqus(), "5, 0.0", "4, 0.0"), 9),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::DuplicateId { what: "node", .. }), "{error:?}");
        assert_says(&error, &[&format!("{name}:{line}: node: node"), "is defined twice; renumber"]);
    }
    let error = refused("a.inp", &with(&abaqus(), "\n3, 11,", "\n2, 11,"));
    assert_eq!(error.kind, Kind::DuplicateId { what: "element", id: 2 });
}

#[test]
fn missing_node() {
    for (name, bytes, at) in [
        ("a.vtu", with(&vtu(), "\n20\n", "\n99\n"), "a.vtu:31: connectivity"),
        ("a.msh", with(&gmsh(), "11 12 14 21", "11 12 14 99"), "a.msh:39: nodes"),
        ("a.inp", with(&abaqus(), "11, 12, 14, 21", "11, 12, 14, 99"), "a.inp:33: nodes"),
        ("b.inp", with(&abaqus(), "*ELSET", "*NSET, NSET=skin\n99\n*ELSET"), "b.inp:40: skin"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::MissingNode { .. }), "{error:?}");
        assert_says(&error, &[at, "uses node 99, which is not defined; add the node or correct the number"]);
    }
    let error = refused("a.inp", &with(&abaqus(), "ELSET=soft\n1,", "ELSET=soft\n77"));
    assert_eq!(error.kind, Kind::MissingElement { set: "soft".into(), element: 77 });
    let error = refused("a.inp", &with(&abaqus(), "ELSET=soft\n1,", "ELSET=soft\nhard"));
    assert_says(&error, &["set `hard` is not defined; defined are: soft"]);
}

#[test]
fn unsupported_element() {
    for (name, bytes, words) in [
        ("a.vtu", with(&vtu(), "\n24\n", "\n14\n"), "element 3 is of the unsupported kind 5-node pyramid"),
        ("a.msh", with(&gmsh(), "\n4 4 2", "\n4 7 2"), "element 4 is of the unsupported kind 5-node pyramid"),
        ("a.inp", with(&abaqus(), "C3D10M", "C3D5"), "unsupported kind C3D5"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::UnsupportedElement { .. }), "{error:?}");
        assert_says(&error, &[words, "convert it to one of: 8-node hexahedra, 6-node wedges"]);
    }
}

#[test]
fn unsupported_variants_of_a_format() {
    let other = with(&vtu(), "header_type", "compressor=\"vtkOtherCompressor\" header_type");
    for (name, bytes, words) in [
        ("a.vtu", other, "vtkOtherCompressor is not read; export with zlib"),
        (
            "a.vtu",
            with(&vtu(), "\"UnstructuredGrid\"", "\"PolyData\""),
            "PolyData is not read; save the volume",
        ),
        ("a.msh", with(&gmsh(), "2.2 0 8", "4 0 8"), "MSH version 4 is not read; save as MSH 2.2 or 4.1"),
        ("a.msh", with(&gmsh(), "$MeshFormat\n2.2 0 8\n$EndMeshFormat", "$NOD"), "a.msh:1: "),
        ("a.msh", with(&gmsh(), "$MeshFormat\n2.2 0 8\n$EndMeshFormat", "$NOD"), "MSH version 1 is not read"),
        ("a.inp", with(&abaqus(), "*STEP", "*NGEN"), "*NGEN is not read; export the nodes"),
        ("a.stl", b"solid a\nfacet normal 0 0 1".to_vec(), "a surface in place of a volume mesh is not read"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::UnsupportedFormat { .. }), "{error:?}");
        assert_says(&error, &[words]);
    }
    let unknown = refused("a.inp", b"hello world\nthis is not a mesh\n");
    assert!(matches!(unknown.kind, Kind::Unrecognised { .. }), "{unknown:?}");
    assert_says(
        &unknown,
        &["a.inp: is no Abaqus file, nor one of another format that is read (VTU, VTK, Gmsh, Abaqus"],
    );
    assert!(!unknown.to_string().contains("hello"), "what is in a foreign file stays there: {unknown}");
    let missing = read_mesh("absent.msh".as_ref(), LengthUnit::Millimetre);
    assert!(matches!(missing.err().map(|e| e.kind), Some(Kind::Io { .. })));
}

#[test]
fn negative_or_huge_id() {
    for (name, bytes, words) in [
        ("a.vtu", with(&vtu(), "\n20\n", "\n-20\n"), "connectivity: `-20` is no node number"),
        ("a.msh", with(&gmsh(), "\n5 0e0", "\n-5 0e0"), "a.msh:15: $Nodes node: `-5` is no node number"),
        (
            "b.msh",
            with(&gmsh(), "\n5 0e0", "\n4294967295 0e0"),
            "`4294967295` is no node number; number from",
        ),
        ("a.inp", with(&abaqus(), "5, 0.0", "-5, 0.0"), "a.inp:9: node: `-5` is no node number"),
        ("b.inp", with(&abaqus(), "\n3, 11,", "\n18446744073709551617, 11,"), "is no element number"),
    ] {
        let error = refused(name, &bytes);
        assert!(matches!(error.kind, Kind::BadId { .. }), "{error:?}");
        assert_says(&error, &[words]);
    }
}

// From here on: meshes that are complete but not sound.

/// `n` hexahedra of 10 mm in a row along x, with nodes numbered from 1.
fn bar(n: usize) -> Mesh {
    let mut points = Vec::new();
    for i in 0..=n {
        for [y, z] in [[0., 0.], [1., 0.], [1., 1.], [0., 1.]] {
            points.push(10. * Vec3::new(i as f64, y, z));
        }
    }
    let cells = (0..n).map(|i| {
        let nodes: Vec<usize> = (4 * i..4 * i + 8).collect();
        Cell::new(CellKind::Hex8, &nodes)
    });
    numbered(points, cells.collect())
}

fn numbered(points: Vec<Vec3>, cells: Vec<Cell>) -> Mesh {
    let mut mesh = Mesh::new(points, cells);
    mesh.node_ids.iter_mut().for_each(|id| *id += 1);
    mesh.cell_ids.iter_mut().for_each(|id| *id += 101);
    mesh
}

/// Two meshes as one; nodes at the same place stay two.
fn beside(a: &Mesh, b: &Mesh, shift: Vec3) -> Mesh {
    let n = a.n_nodes();
    let points = a.points.iter().copied().chain(b.points.iter().map(|p| p + shift)).collect();
    let moved = b.cells.iter().map(|c| {
        let nodes: Vec<usize> = c.nodes().iter().map(|node| node + n).collect();
        Cell::new(c.kind(), &nodes)
    });
    numbered(points, a.cells.iter().copied().chain(moved).collect())
}

/// `mesh` with nodes at one place made one.
fn merged(mesh: &Mesh) -> Mesh {
    let first = |p: &Vec3| mesh.points.iter().position(|q| (p - q).norm() < 1e-9).expect("itself");
    let cells = mesh.cells.iter().map(|c| {
        let nodes: Vec<usize> = c.nodes().iter().map(|&node| first(&mesh.points[node])).collect();
        Cell::new(c.kind(), &nodes)
    });
    numbered(mesh.points.clone(), cells.collect())
}

const END: [usize; 4] = [0, 1, 2, 3];

fn error(mesh: &Mesh, fixed: &[usize]) -> MeshError {
    validate(mesh, fixed).err().unwrap_or_else(|| panic!("the mesh was taken"))
}

#[test]
fn a_sound_mesh_has_no_warning() {
    assert_eq!(validate(&bar(3), &END), Ok(vec![]));
}

#[test]
fn nan_coordinate() {
    let mut mesh = bar(2);
    mesh.points[5].z = f64::NAN;
    let error = error(&mesh, &END);
    assert!(matches!(error, MeshError::NotFinite { node: 6, axis: 'z', .. }), "{error:?}");
    assert_says(&error, &["node 6: coordinate z is NaN", "give it a position"]);
}

#[test]
fn node_that_does_not_exist() {
    let mut mesh = bar(1);
    mesh.points.pop();
    assert_eq!(error(&mesh, &END), MeshError::MissingNode { cell: 101, node: 7, n_nodes: 7 });
    assert_eq!(error(&bar(1), &[8]), MeshError::MissingSupportNode { node: 8, n_nodes: 8 });
    assert_eq!(error(&Mesh::default(), &[]), MeshError::NoCells);
}

#[test]
fn repeated_node() {
    let mut mesh = bar(2);
    mesh.cells[1] = Cell::new(CellKind::Hex8, &[4, 5, 6, 7, 8, 9, 9, 11]);
    let error = error(&mesh, &END);
    assert_eq!(error, MeshError::RepeatedNode { cell: 102, node: 10 });
    assert_says(&error, &["cell 102 has node 10 more than once; use a wedge"]);
}

#[test]
fn inverted() {
    let mut mesh = bar(3);
    mesh.cells[1] = Cell::new(CellKind::Hex8, &[4, 7, 6, 5, 8, 11, 10, 9]);
    let reordered = error(&mesh, &END);
    assert!(
        matches!(&reordered, MeshError::Inverted { cells, count: 1, everywhere: true, .. } if cells[..] == [102])
    );
    assert_says(&reordered, &["1 inverted cell (", "102", "-1.250e2 mm3", "reorder their nodes"]);
    let mut mesh = bar(2);
    mesh.points[10] = Vec3::new(9., 1., 1.);
    let folded = error(&mesh, &END);
    assert!(matches!(&folded, MeshError::Inverted { everywhere: false, .. }), "{folded:?}");
    assert_says(&folded, &["changes sign inside: move the nodes"]);
}

#[test]
fn zero_volume() {
    let mut mesh = bar(1);
    mesh.points.iter_mut().for_each(|p| p.y = 0.);
    let error = error(&mesh, &END);
    assert!(matches!(error, MeshError::ZeroVolume { cell: 101, .. }), "{error:?}");
    assert_says(&error, &["cell 101 has no volume", "remove it or move its nodes"]);
}

#[test]
fn sliver() {
    let points = [[0., 0., 0.], [10., 0., 0.], [0., 10., 0.], [4., 4., 0.1]].map(Vec3::from).to_vec();
    let mesh = numbered(points, vec![Cell::new(CellKind::Tet4, &[0, 1, 2, 3])]);
    let warnings = validate(&mesh, &[0, 1, 2]).unwrap_or_else(|e| panic!("{e}"));
    assert!(matches!(&warnings[..], [MeshWarning::Slivers { cells, count: 1, .. }] if cells[..] == [101]));
    assert_says(&warnings[0], &["1 sliver cell (", "101", "remesh or smooth"]);
}

#[test]
fn thin_layer() {
    let mut mesh = bar(2);
    mesh.points.iter_mut().for_each(|p| p.x = if p.x > 15. { 10.02 } else { p.x });
    let warnings = validate(&mesh, &END).unwrap_or_else(|e| panic!("{e}"));
    assert!(
        matches!(&warnings[..], [MeshWarning::Thin { cells, count: 1, .. }] if cells[..] == [102]),
        "{warnings:?}"
    );
    assert_says(&warnings[0], &["1 thin cell (thickness over width down to 0.0020)", "merge it"]);
}

#[test]
fn mid_edge_node_off_its_edge() {
    let mut points: Vec<Vec3> =
        CellKind::Tet10.node_positions().iter().map(|p| 10. * Vec3::from(*p)).collect();
    points[4] += Vec3::new(0., -2.6, 0.);
    let cell = Cell::new(CellKind::Tet10, &(0..10).collect::<Vec<_>>());
    let moved = error(&numbered(points.clone(), vec![cell]), &[0, 1, 2]);
    assert!(matches!(moved, MeshError::MidEdgeNode { cell: 101, node: 5, .. }), "{moved:?}");
    assert_says(&moved, &["mid-edge node 5 lies 2.6000 mm", "edge of 10.0000 mm", "check the node order"]);
    points[4] += Vec3::new(0., 0.2, 0.);
    assert!(validate(&numbered(points, vec![cell]), &[0, 1, 2]).is_ok());
}

#[test]
fn coincident_and_orphan_nodes() {
    let mut mesh = beside(&bar(1), &bar(1), Vec3::new(0., 0., 10.));
    mesh.points.push(Vec3::new(3., 3., 3.));
    mesh.node_ids.push(99);
    let warnings = validate_shape(&mesh).unwrap_or_else(|e| panic!("{e}"));
    let [coincident, orphan] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(matches!(coincident, MeshWarning::CoincidentNodes { count: 4, .. }), "{coincident:?}");
    assert_says(coincident, &["4 pairs of nodes at one place: 3-10, 4-9", "merge them"]);
    assert_eq!(*orphan, MeshWarning::OrphanNodes { nodes: vec![99], count: 1 });
    assert_says(orphan, &["1 node of no cell, without effect: 99", "remove them"]);
}

#[test]
fn disconnected_part() {
    let mesh = beside(&bar(2), &bar(1), Vec3::new(0., 30., 0.));
    let free = error(&mesh, &END);
    assert_eq!(free, MeshError::Disconnected { cells: vec![103], n_cells: 1 });
    assert_says(&free, &["a part of 1 cell (103) is joined to nothing that is fixed; merge coincident"]);
    let fixed: Vec<usize> = END.iter().flat_map(|k| [*k, 12 + k]).collect();
    assert!(validate(&mesh, &fixed).is_ok(), "both parts are held");
}

#[test]
fn no_supports() {
    let error = error(&bar(2), &[]);
    assert!(matches!(&error, MeshError::NoSupports { modes } if modes.len() == 6));
    assert_says(
        &error,
        &[
            "no node is fixed",
            "translation along x",
            "rotation about z through (10.000, 5.000, 5.000) mm",
            "bone",
        ],
    );
}

#[test]
fn under_constrained() {
    // Two nodes on the edge y = z = 0 leave the turn about it.
    let hinged = error(&bar(2), &[0, 8]);
    let MeshError::UnderConstrained { modes } = &hinged else { panic!("{hinged:?}") };
    let [FreeMode::Rotation { axis, through }] = modes[..] else { panic!("{modes:?}") };
    assert!((axis - Vec3::x()).norm() < 1e-6 && through.yz().norm() < 1e-6, "{axis} {through}");
    assert_says(&hinged, &["rotation about x through (", "not all on one line"]);
    let pinned = error(&bar(2), &[0]);
    assert!(matches!(&pinned, MeshError::UnderConstrained { modes } if modes.len() == 3), "{pinned:?}");
    assert!(validate(&bar(2), &[0, 8, 2]).is_ok());
}

#[test]
fn hinge() {
    let one = bar(1);
    let edge = merged(&beside(&one, &one, Vec3::new(0., 10., 10.)));
    let turning = error(&edge, &END);
    let MeshError::Hinge { nodes, modes, .. } = &turning else { panic!("{turning:?}") };
    assert_eq!((&nodes[..], modes.len()), (&[3, 7][..], 1));
    let FreeMode::Rotation { axis, through } = modes[0] else { panic!("{modes:?}") };
    assert!((axis - Vec3::x()).norm() < 1e-6 && (through.yz() - Vec3::repeat(10.).yz()).norm() < 1e-6);
    assert_says(&turning, &["hangs on 2 nodes (3, 7) only and is free in rotation about x", "whole faces"]);
    let node = merged(&beside(&one, &one, Vec3::repeat(10.)));
    let turning = error(&node, &END);
    assert!(
        matches!(&turning, MeshError::Hinge { modes, nodes, .. } if modes.len() == 3 && nodes[..] == [7])
    );
    // The same joint is no mechanism once the other part is held too.
    assert!(validate(&edge, &[0, 1, 2, 3, 10]).is_ok());
    assert!(validate(&node, &[0, 1, 2, 3, 10, 11]).is_ok());
}

#[test]
fn parts_that_hold_each_other_move_as_one() {
    // Three blocks, each joined to the other two by an edge along x, y or z: no mechanism.
    let one = bar(1);
    let two = beside(&one, &one, Vec3::new(0., 10., 10.));
    let three = merged(&beside(&two, &one, Vec3::new(10., 10., 0.)));
    assert_eq!(validate(&three, &END).map(|_| ()), Ok(()));
    let pinned = error(&three, &[0]);
    assert!(matches!(&pinned, MeshError::UnderConstrained { modes } if modes.len() == 3), "{pinned:?}");
}

/// A square pyramid on either side of a square: one is split along the diagonal 0-2, the other as `split` says.
fn two_pyramids(kind: CellKind, split: [[usize; 3]; 2]) -> Mesh {
    let corners = [[0., 0., 0.], [0., 10., 0.], [0., 10., 10.], [0., 0., 10.], [-8., 5., 5.], [8., 5., 5.]];
    let mut points: Vec<Vec3> = corners.map(Vec3::from).to_vec();
    let tets = [([0, 1, 2], 4), ([0, 2, 3], 4), (split[0], 5), (split[1], 5)];
    let mut middle = std::collections::BTreeMap::new();
    let mut cells = Vec::new();
    for ([a, b, c], top) in tets {
        let inverted =
            (points[b] - points[a]).cross(&(points[c] - points[a])).dot(&(points[top] - points[a])) < 0.;
        let mut nodes = if inverted { vec![a, c, b, top] } else { vec![a, b, c, top] };
        if kind == CellKind::Tet10 {
            for &[i, j] in kind.edges() {
                let ends = [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])];
                nodes.push(*middle.entry(ends).or_insert_with(|| {
                    points.push(0.5 * (points[ends[0]] + points[ends[1]]));
                    points.len() - 1
                }));
            }
        }
        cells.push(Cell::new(kind, &nodes));
    }
    numbered(points, cells)
}

#[test]
fn non_conforming_faces() {
    // A large block beside four small ones: the small ones' nodes hang in its face.
    let big = numbered(bar(1).points.iter().map(|p| p * 2.).collect(), bar(1).cells);
    let small = |y: f64, z: f64| (bar(1), Vec3::new(20., y, z));
    let mut mesh = big;
    for (part, shift) in [small(0., 0.), small(10., 0.), small(0., 10.), small(10., 10.)] {
        mesh = beside(&mesh, &part, shift);
    }
    let hanging = error(&merged(&mesh), &END);
    assert!(matches!(hanging, MeshError::HangingNode { cell: 101, .. }), "{hanging:?}");
    assert_says(&hanging, &["hangs on a face of cell 101", "refine the neighbour too"]);
    // A wedge against half of a hexahedron's face.
    let mut mesh = bar(1);
    mesh.points.push(Vec3::new(18., 2., 2.));
    let half = numbered(mesh.points, vec![mesh.cells[0], Cell::new(CellKind::Tet4, &[4, 5, 6, 8])]);
    let mismatch = error(&half, &END);
    assert!(matches!(mismatch, MeshError::MismatchedFaces { first: 101, second: 102, .. }), "{mismatch:?}");
    // A quadratic tetrahedron on a linear one.
    let orders = validate_shape(&mixed()).err();
    assert!(
        matches!(orders, Some(MeshError::MismatchedFaces { first_nodes: 3, second_nodes: 6, .. })),
        "{orders:?}"
    );
    for kind in [CellKind::Tet4, CellKind::Tet10] {
        let alike = two_pyramids(kind, [[0, 1, 2], [0, 2, 3]]);
        assert!(validate_shape(&alike).is_ok(), "{kind:?}");
        let crossed = validate_shape(&two_pyramids(kind, [[0, 1, 3], [1, 2, 3]])).err();
        assert!(matches!(crossed, Some(MeshError::MismatchedFaces { .. })), "{kind:?}: {crossed:?}");
    }
    let twice = numbered(bar(1).points, vec![bar(1).cells[0]; 3]);
    assert!(matches!(error(&twice, &END), MeshError::SharedFace { cells } if cells[..] == [101, 102, 103]));
    // Surfaces that touch without sharing a node are two surfaces.
    let touching = beside(&bar(1), &bar(1), Vec3::new(5., 0., 10.));
    assert!(validate_shape(&touching).is_ok());
}

#[test]
fn extent() {
    for (factor, value) in [(1e-3, "measures 0.03 mm"), (1e3, "measures 30000 mm")] {
        let mut mesh = bar(3);
        mesh.points.iter_mut().for_each(|p| *p *= factor);
        let error = error(&mesh, &END);
        assert!(matches!(error, MeshError::Extent { .. }), "{error:?}");
        assert_says(&error, &[value, "between 5 mm and 1000 mm", "metres", "State the unit"]);
    }
}

#[test]
fn a_file_error_names_file_and_cell() {
    let error = MeshFileError::invalid("face.msh", MeshError::RepeatedNode { cell: 7, node: 3 });
    assert_says(&error, &["face.msh: cell 7 has node 3 more than once"]);
}

#[test]
fn every_row_of_the_list_of_bad_input_names_a_test() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut folders, mut sources) = (vec![root.join("tests"), root.join("src")], String::new());
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).expect("a folder").filter_map(|e| Some(e.ok()?.path())) {
            if path.ends_with("node_modules") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(path).expect("a source");
                text.lines().for_each(|line| sources.extend([line.trim_start(), "\n"]));
            }
        }
    }
    let list = std::fs::read_to_string(root.join("docs/bad_input.md")).expect("the list");
    let rows = list.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| **"));
    let mut named = 0;
    for row in rows.skip(1) {
        let tests = row.rsplit('|').nth(1).expect("a last column");
        for test in tests.split('`').skip(1).step_by(2) {
            assert!(sources.contains(&format!("#[test]\nfn {test}() {{")), "{test} is no test");
            named += 1;
        }
        assert!(tests.contains('`'), "no test holds: {row}");
    }
    assert!(named > 60, "{named}");
}
