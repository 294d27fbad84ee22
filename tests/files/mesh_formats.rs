//! The same mesh in every format and encoding is the same mesh.

#![allow(missing_docs)]

use std::path::{Path, PathBuf};

use crate::mesh_files::{Place, Vtu, inp, mixed, msh_2, msh_4};
use modiolus::io::{VtuData, read_mesh, read_surface, write_vtu};
use modiolus::mesh::{CellKind, Locator, Mesh, MeshWarning, Quality, Skin, boundary_facets, validate};
use modiolus::units::LengthUnit::{Centimetre, Millimetre};
use modiolus::units::Vec3;

fn read(name: &str, bytes: &[u8]) -> Mesh {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    read_mesh(&path, Millimetre).unwrap_or_else(|e| panic!("{e}"))
}

/// Equal but for the numbers that files give to nodes and cells.
fn assert_same(mesh: &Mesh, expected: &Mesh, what: &str) {
    assert_eq!(mesh.points, expected.points, "{what}");
    assert_eq!(mesh.cells, expected.cells, "{what}");
    assert_eq!(mesh.node_sets.get("skin"), expected.node_sets.get("skin"), "{what}");
    assert_eq!(mesh.cell_sets, expected.cell_sets, "{what}");
}

#[test]
fn every_vtu_encoding_is_the_same_mesh() {
    let expected = mixed();
    let mut n = 0;
    for place in [Place::Ascii, Place::Inline, Place::AppendedBase64, Place::AppendedRaw] {
        for (zlib, wide_header, big_endian, joint) in
            (0..16).map(|k| (k & 1 > 0, k & 2 > 0, k & 4 > 0, k & 8 > 0))
        {
            for (float, int) in
                [("Float32", "Int32"), ("Float64", "Int64"), ("Float64", "UInt16"), ("Float32", "UInt64")]
            {
                let vtu = Vtu { place, zlib, wide_header, big_endian, float, int, joint };
                let mesh = read("a.vtu", &vtu.write(&expected));
                assert_same(&mesh, &expected, &format!("{vtu:?}"));
                assert_eq!(mesh.node_ids[20], 20);
                n += 1;
            }
        }
    }
    assert_eq!(n, 256);
}

#[test]
fn msh_and_inp_are_the_same_mesh() {
    let expected = mixed();
    for binary in [None, Some(false), Some(true)] {
        for (what, bytes) in [("2.2", msh_2(&expected, binary)), ("4.1", msh_4(&expected, binary))] {
            let mesh = read("a.msh", &bytes);
            assert_same(&mesh, &expected, &format!("MSH {what}, {binary:?}"));
            assert_eq!((mesh.node_ids[0], &mesh.cell_ids[..]), (1, &[2, 3, 4, 5][..]));
        }
    }
    let mesh = read("a.inp", &inp(&expected));
    assert_same(&mesh, &expected, "INP");
    assert_eq!(mesh.node_sets["all"].len(), 21);
}

#[test]
fn byte_order_marks_and_carriage_returns_are_accepted() {
    let expected = mixed();
    for (name, bytes) in [
        ("a.vtu", Vtu::ASCII.write(&expected)),
        ("a.msh", msh_2(&expected, None)),
        ("a.MSH", msh_4(&expected, None)),
        ("a.inp", inp(&expected)),
    ] {
        let text = String::from_utf8(bytes).expect("text").replace('\n', "\r\n");
        let mesh = read(name, &[b"\xEF\xBB\xBF", text.as_bytes()].concat());
        assert_same(&mesh, &expected, name);
    }
}

#[test]
fn wedges_in_either_order_are_the_same_mesh() {
    let expected = mixed();
    let text = String::from_utf8(inp(&expected)).expect("text");
    let turned = text.replace("2, 5, 8, 9, 6,\n 7, 10", "2, 5, 9, 8, 6,\n 10, 7");
    assert_ne!(turned, text);
    assert_same(&read("a.inp", turned.as_bytes()), &expected, "turned wedge");
}

#[test]
fn lengths_become_millimetres() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.inp");
    std::fs::write(&path, inp(&mixed())).expect("a file");
    let mesh = read_mesh(&path, Centimetre).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(mesh.points[6], 10. * mixed().points[6]);
}

#[test]
fn labels_and_numbered_groups_become_sets() {
    let text = String::from_utf8(Vtu::ASCII.write(&mixed())).expect("text");
    let layers: String = (0..21).map(|k| format!("{} ", k % 3)).collect();
    let array = format!(
        "<PointData>\n<DataArray type=\"Int32\" Name=\"layer\" format=\"ascii\">{layers}</DataArray>"
    );
    let mesh = read("a.vtu", text.replace("<PointData>", &array).as_bytes());
    assert_eq!(mesh.node_sets["layer=2"], [2, 5, 8, 11, 14, 17, 20]);
    let text = String::from_utf8(msh_4(&mixed(), None)).expect("text");
    let names = text.find("$PhysicalNames").expect("names")..text.find("$Entities").expect("entities");
    let mesh = read("a.msh", text.replace(&text[names], "").as_bytes());
    assert_eq!(mesh.node_sets["surface=7"], [4, 5, 6, 7]);
    assert_eq!(mesh.cell_sets["volume=9"], [0]);
}

#[test]
fn written_files_read_back_and_are_byte_identical() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (a, b) = (folder.path().join("a.vtu"), folder.path().join("b.vtu"));
    let mut mesh = mixed();
    mesh.node_sets.insert("a \"<b>\" & c".into(), vec![0, 3]);
    let data = VtuData {
        point_vectors: [("displacement".into(), (0..63).map(|k| f64::from(k) / 7.).collect())].into(),
        point_scalars: [("pressure".into(), vec![0.25; 21])].into(),
        cell_scalars: [("activation".into(), vec![0.5; 4])].into(),
        cell_labels: [("muscle_id".into(), vec![-1, 0, 1, 2])].into(),
    };
    for path in [&a, &b] {
        write_vtu(path, &mesh, &data).unwrap_or_else(|e| panic!("{e}"));
    }
    assert_eq!(std::fs::read(&a).ok(), std::fs::read(&b).ok());
    let mut back = read_mesh(&a, Millimetre).unwrap_or_else(|e| panic!("{e}"));
    for label in -1..=2 {
        assert_eq!(back.cell_sets.remove(&format!("muscle_id={label}")).map(|s| s.len()), Some(1));
    }
    assert_eq!(back, mesh);
    let short = VtuData { point_scalars: [("pressure".into(), vec![0.; 3])].into(), ..VtuData::default() };
    let error = write_vtu(&a, &mesh, &short).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains("pressure: declares 21 values of pressure but has 3"), "{error}");
}

/// Files cut at many places and with bytes changed at many places: none may panic, and a truncated file
/// must not be taken for a whole one.
#[test]
fn damaged_files_are_refused_without_panic() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = mixed();
    let vtu = |place, zlib| Vtu { place, zlib, ..Vtu::ASCII }.write(&mesh);
    let files = [
        ("a.vtu", vtu(Place::Ascii, false)),
        ("b.vtu", vtu(Place::Inline, true)),
        ("c.vtu", vtu(Place::AppendedRaw, true)),
        ("d.vtu", vtu(Place::AppendedBase64, false)),
        ("a.msh", msh_2(&mesh, None)),
        ("b.msh", msh_2(&mesh, Some(false))),
        ("c.msh", msh_4(&mesh, None)),
        ("d.msh", msh_4(&mesh, Some(true))),
        ("a.inp", inp(&mesh)),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 4 3\nf 1/2/3 -1 2\n".to_vec()),
    ];
    let whole = |path: &Path| match path.extension() {
        Some(e) if e == "obj" => read_surface(path, Millimetre).is_ok(),
        // A mesh that is read must be fit to be looked at, whatever its shape.
        _ => read_mesh(path, Millimetre).is_ok_and(|mesh| {
            let _ = validate(&mesh, &[0]);
            Locator::new(&mesh).locate(mesh.points[0]);
            true
        }),
    };
    for (name, bytes) in files {
        let path = folder.path().join(name);
        let write = |bytes: &[u8]| std::fs::write(&path, bytes).expect("a file");
        let step = (bytes.len() / 80).max(1);
        for cut in (0..bytes.len()).step_by(step) {
            write(&bytes[..cut]);
            // What follows the last element may go: sets in an INP, faces in an OBJ, appended padding.
            let text = !matches!(name, "a.inp" | "a.obj");
            let read = whole(&path);
            assert!(!(read && text && cut < bytes.len() * 9 / 10), "{name} cut at {cut} was taken as whole");
        }
        let mut state = 1_u32;
        for round in 0..100 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + round % 3 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let at = (state >> 8) as usize % damaged.len();
                let values = [0, b'-', b'9', b' ', b'\n', b',', 0xFF, b'<', (state & 0xFF) as u8];
                damaged[at] = values[state as usize % values.len()];
            }
            write(&damaged);
            whole(&path);
        }
    }
}

fn data_folder() -> PathBuf {
    let folder = std::env::var("MODIOLUS_DATA").expect("set MODIOLUS_DATA to the folder of shared data");
    Path::new(&folder).join("badin_face")
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn the_public_face_is_the_same_in_both_formats_and_sound() {
    let folder = data_folder();
    let [vtu, msh] = ["mesh.vtu", "mesh.msh"]
        .map(|name| read_mesh(&folder.join(name), Millimetre).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!((vtu.n_nodes(), vtu.cells.len()), (8720, 6342));
    let count = |kind| vtu.cells.iter().filter(|c| c.kind() == kind).count();
    assert_eq!((count(CellKind::Hex8), count(CellKind::Wedge6)), (6024, 318));
    assert!(vtu.cells == msh.cells);
    for (a, b) in vtu.points.iter().zip(&msh.points) {
        assert!((a - b).norm() < 1e-12);
    }
    let file = std::fs::read(folder.join("node_sets.json")).expect("node_sets.json");
    let sets: std::collections::BTreeMap<String, Vec<usize>> =
        serde_json::from_slice(&file).expect("sets of numbers");
    for (name, mut nodes) in sets {
        nodes.sort_unstable();
        let name = match name.as_str() {
            "inner" => "layer=0",
            "skin" => "layer=3",
            other => other,
        };
        assert!(vtu.node_sets.get(name) == Some(&nodes), "{name}");
    }
    let fixed = [&vtu.node_sets["skull"][..], &vtu.node_sets["mandible"]].concat();
    let warnings = validate(&vtu, &fixed).unwrap_or_else(|e| panic!("{e}"));
    let is_known = matches!(warnings[..], [MeshWarning::Slivers { .. }, MeshWarning::Thin { count: 1, .. }]);
    assert!(is_known, "{warnings:?}");

    let qualities: Vec<Quality> = vtu.cells.iter().map(|c| Quality::new(c, &vtu.points)).collect();
    assert!(qualities.iter().all(|q| !q.is_inverted() && q.jacobian_ratio() > 0.1));
    // Counted independently (numpy) for the hexahedra: 175.
    let slivers = qualities.iter().zip(&vtu.cells).filter(|(q, _)| q.scaled_jacobian < 0.1);
    assert_eq!(slivers.filter(|(_, c)| c.kind() == CellKind::Hex8).count(), 175);

    let facets = boundary_facets(&vtu);
    let skin = Skin::new(&vtu, &facets);
    let at = |t: &[usize; 3]| t.map(|v| skin.surface.points[v]);
    let enclosed: f64 = skin.surface.triangles.iter().map(at).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.).sum();
    let volume: f64 = qualities.iter().map(|q| q.volume).sum();
    // Warped faces are split flat, so the two differ a little.
    assert!((enclosed / volume - 1.).abs() < 2e-3, "{enclosed} {volume}");
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn points_of_the_public_face_are_found_and_mirrored() {
    let mesh = read_mesh(&data_folder().join("mesh.vtu"), Millimetre).unwrap_or_else(|e| panic!("{e}"));
    let locator = Locator::new(&mesh);
    for (k, cell) in mesh.cells.iter().enumerate() {
        let p = mesh.cell_points(k).sum::<Vec3>() / cell.nodes().len() as f64;
        let found = locator.locate(p).expect("the mesh has cells");
        assert_eq!((found.cell, found.distance_mm), (k, 0.));
        let carried: Vec3 = found.site.weights.iter().map(|&(node, w)| w * mesh.points[node]).sum();
        assert!((carried - p).norm() < 1e-10);
    }
    // 8,137 of 8,720 nodes have a mirror partner, so most pairs of queries must mirror too.
    let mut mirrored = 0;
    let queries: Vec<_> = mesh.points.iter().map(|p| p * 1.05).filter(|p| p.x > 1.).collect();
    for p in &queries {
        let [a, b] =
            [1., -1.].map(|s| locator.locate(Vec3::new(s * p.x, p.y, p.z)).expect("the mesh has cells"));
        let (a, b) = (a.site.position, b.site.position);
        mirrored += usize::from((a - Vec3::new(-b.x, b.y, b.z)).norm() < 1e-3);
    }
    assert!(mirrored * 100 > queries.len() * 85, "{mirrored} of {}", queries.len());
}
