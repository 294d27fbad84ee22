//! Faces made after public reports about other programs' files, and crafted ones that asked for too much.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::PathBuf;
use std::time::{Duration, Instant};

use modiolus::io::{read_face, write_face};

fn cases() -> PathBuf {
    let data = std::env::var_os("MODIOLUS_DATA").expect("MODIOLUS_DATA names the folder of the real data");
    let folder = PathBuf::from(data).join("../cases");
    assert!(folder.is_dir(), "{} is missing", folder.display());
    folder
}

/// What is told of a case, and how many nodes its skin and its bone have where it is read.
fn read(case: &str) -> Result<(usize, usize), String> {
    let face = read_face(&cases().join(case).join("face.toml"), None).map_err(|e| e.to_string())?.face;
    Ok((face.skin.len(), face.supports[0].nodes.len()))
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn files_as_other_programs_write_them() {
    for case in [
        "00_base",
        "01_inp_keyword_continuation",
        "05_inp_nset_from_elset",
        "06_inp_cae_reference_point",
        "10_inp_connector",
        "11_inp_surface_as_skin",
        "12_inp_generate_gaps",
        "13_inp_set_before_nodes",
        "16_inp_instance_prefix",
        "43_vtu_lz4",
        "48_vtu_ascii_nan_field",
        "51_vtu_float_labels",
        "53_vtu_spaced_offset",
        "54_vtu_spaced_counts",
        "66_vtu_mixed_lower",
        "76_inp_elset_of_elset_lower",
        "98a_csv_semicolon",
        "98c_csv_quoted",
        "T_ngon_obj",
    ] {
        assert_eq!(read(case), Ok((25, 25)), "{case}");
    }
    // Its labels on faces and lines are sets; the bone is one line, about which the tissue may turn.
    let hinged = read("67_vtu_skin_by_cell_label").unwrap_err();
    assert!(hinged.contains("the supports leave rotation about x"), "{hinged}");
    for case in [
        "22_msh22_overlap_groups",
        "28_msh41_partitioned",
        "33_msh41_spaces",
        "35_inp_gmsh_default",
        "82_msh_names_two_blanks",
        "83_msh_names_tabs",
        "84_msh_names_last",
    ] {
        let (skin, bone) = read(case).unwrap_or_else(|e| panic!("{case}: {e}"));
        assert!(skin > 20 && bone > 20 && skin < 93 && bone < 93, "{case}: {skin} {bone}");
    }
    for (case, words) in [
        ("38_msh1", "m.msh:1: $MeshFormat version: MSH version 1 is not read; save as MSH 2.2 or 4.1"),
        (
            "73_inp_same_name_part_assembly",
            "there is no node set `bone`; known are: Assembly.bone, Face-1.bone",
        ),
        ("74_inp_garbage", "m.inp: is no Abaqus file"),
        ("T_stl_ascii_stl", "the tooth surface is open"),
    ] {
        let message = read(case).unwrap_err();
        assert!(message.contains(words), "{case}: {message}");
    }
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn crafted_files_are_refused_at_once() {
    for case in [
        "hang_inp_5000_nested_sets",
        "hang_width_1e9",
        "oom_fibre_coord_1e12",
        "oom_fibre_step_1e-9",
        "oom_zlib_bomb_vtu",
    ] {
        let start = Instant::now();
        let message = read(&format!("hostile/{case}"));
        assert!(start.elapsed() < Duration::from_secs(5), "{case}: {:?}", start.elapsed());
        assert!(message.is_err() || case == "hang_inp_5000_nested_sets", "{case}");
    }
    let folder = tempfile::tempdir().unwrap();
    let face = read_face(&cases().join("hostile/export_muscle_quote/face.toml"), None).unwrap().face;
    write_face(folder.path(), &face).unwrap();
    let back = read_face(&folder.path().join("face.toml"), None).unwrap().face;
    assert_eq!(back.muscles[0].name, "zy\"g_l");
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn targets_out_of_reach_are_solved_and_their_outlier_is_named() {
    let out = tempfile::tempdir().unwrap();
    for (target, outlier) in [("X_min3", "corner_l"), ("T_outlier_20", "edge_l")] {
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_modiolus"))
            .arg("fit")
            .arg(cases().join("81_fits").join(target).with_extension("toml"))
            .arg("--face")
            .arg(cases().join("80_inv_face/face.toml"))
            .arg("--out")
            .arg(out.path())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&run.stdout).into_owned();
        assert!(run.status.success() && text.contains(": solved"), "{target}: {text}");
        assert!(text.contains(&format!("marker {outlier} stays 19.5")), "{target}: {text}");
    }
}
