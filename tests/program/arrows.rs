//! The arrows of ARCHITECTURE.md: a chapter imports only from chapters below it.

use std::fs;
use std::path::{Path, PathBuf};

/// Chapters and what each may import; `cli` is the program, the others are the library.
const ARROWS: [(&str, &[&str]); 16] = [
    (
        "cli",
        &[
            "report",
            "render",
            "io",
            "study",
            "registration",
            "recording",
            "calibration",
            "certainty",
            "inverse",
            "forward",
            "face",
            "contact",
            "mesh",
            "qp",
            "units",
        ],
    ),
    ("render", &["forward", "face", "contact", "mesh", "units"]),
    (
        "report",
        &[
            "render",
            "io",
            "study",
            "recording",
            "certainty",
            "inverse",
            "forward",
            "face",
            "contact",
            "mesh",
            "units",
        ],
    ),
    (
        "io",
        &[
            "study",
            "registration",
            "recording",
            "calibration",
            "certainty",
            "inverse",
            "forward",
            "face",
            "contact",
            "mesh",
            "qp",
            "units",
        ],
    ),
    (
        "study",
        &[
            "registration",
            "recording",
            "calibration",
            "certainty",
            "inverse",
            "forward",
            "face",
            "contact",
            "mesh",
            "qp",
            "units",
        ],
    ),
    ("registration", &["forward", "face", "contact", "mesh", "units"]),
    ("recording", &["certainty", "inverse", "forward", "face", "contact", "mesh", "qp", "units"]),
    ("calibration", &["certainty", "inverse", "forward", "face", "contact", "mesh", "units"]),
    ("certainty", &["inverse", "face", "qp", "units"]),
    ("inverse", &["forward", "face", "contact", "mesh", "qp", "units"]),
    ("forward", &["face", "contact", "mesh", "qp", "units"]),
    ("face", &["contact", "mesh", "units"]),
    ("contact", &["mesh", "units"]),
    ("mesh", &["units"]),
    ("qp", &[]),
    ("units", &[]),
];

/// The first names that follow `root::` in `code`: `a` of `root::a::B`, `a` and `b` of `root::{a::B, b}`.
fn names_after(code: &str, root: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (start, _) in code.match_indices(root) {
        if code[..start].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = code[start + root.len()..].trim_start();
        match rest.strip_prefix('{') {
            None => names.extend(first_name(rest)),
            Some(group) => {
                let (mut depth, mut item) = (0, String::new());
                for c in group.chars() {
                    match c {
                        '}' if depth == 0 => break,
                        '{' => depth += 1,
                        '}' => depth -= 1,
                        _ => {}
                    }
                    if c == ',' && depth == 0 {
                        names.extend(first_name(item.trim()));
                        item.clear();
                    } else {
                        item.push(c);
                    }
                }
                names.extend(first_name(item.trim()));
            }
        }
    }
    names
}

fn first_name(code: &str) -> Option<String> {
    let name: String = code.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

/// The code without its comments, whose links may point anywhere.
fn without_comments(code: &str) -> String {
    code.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Imports of `code` that its chapter may not have; `file` is its path below `src`.
fn upward(file: &Path, code: &str) -> Vec<String> {
    let parts: Vec<String> = file
        .components()
        .map(|c| c.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned())
        .collect();
    let chapter = parts[0].as_str();
    let code = without_comments(code);
    let mut imported = names_after(&code, "crate::");
    imported.extend(names_after(&code, "modiolus::"));
    // `super` climbs one folder from a file, none from a folder's own `mod`.
    let depth = parts.len() - usize::from(parts.last().is_some_and(|p| p == "mod"));
    imported.extend(names_after(&code, &"super::".repeat(depth)));
    let known = |name: &String| ARROWS.iter().any(|(c, _)| c == name);
    let allowed: &[&str] = match ARROWS.iter().find(|(c, _)| *c == chapter) {
        Some((_, allowed)) => allowed,
        None if chapter == "main" => &["cli"],
        None => return Vec::new(),
    };
    imported
        .into_iter()
        .filter(known)
        .filter(|name| name != chapter && !allowed.contains(&name.as_str()))
        .map(|name| format!("{}: {chapter} imports {name}", file.display()))
        .collect()
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn no_chapter_imports_from_above() {
    let src = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 20, "src was not scanned");
    let mut wrong = Vec::new();
    for path in files {
        let code = fs::read_to_string(&path).expect("readable");
        wrong.extend(upward(path.strip_prefix(&src).expect("below src"), &code));
    }
    assert!(wrong.is_empty(), "against the arrows of ARCHITECTURE.md:\n{}", wrong.join("\n"));
}

#[test]
fn every_chapter_has_its_row() {
    let src = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(src).expect("src") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        assert!(["lib", "main"].contains(&name.as_str()) || ARROWS.iter().any(|(c, _)| *c == name), "{name}");
    }
}

#[test]
fn the_table_has_no_cycle() {
    for (chapter, allowed) in ARROWS {
        for below in allowed {
            let (_, back) = ARROWS.iter().find(|(c, _)| c == below).expect("a chapter");
            assert!(!back.contains(&chapter), "{chapter} and {below} import each other");
        }
    }
}

#[test]
fn an_upward_import_is_found() {
    for (file, code) in [
        ("mesh/solid.rs", "use crate::face::Face;"),
        ("mesh/solid.rs", "use crate::{units::Vec3, face::Face};"),
        ("mesh/solid.rs", "use crate::{\n    units::{Vec3, LengthUnit},\n    face,\n};"),
        ("mesh/solid.rs", "fn f(x: &crate::forward::Model) {}"),
        ("mesh/solid.rs", "use super::super::face::Face;"),
        ("mesh/mod.rs", "use super::face::Face;"),
        ("units.rs", "use super::mesh::Mesh;"),
        ("qp/problem.rs", "use crate::inverse::Target;"),
        ("contact/teeth.rs", "pub(in crate::face) fn f() {} use crate::face::Teeth;"),
        ("io/vtu/writer.rs", "use modiolus::cli::Options;"),
        ("main.rs", "use modiolus::forward::Model;"),
    ] {
        assert_eq!(upward(Path::new(file), code).len().min(1), 1, "{file}: {code}");
    }
}

#[test]
fn a_downward_import_and_a_link_are_not() {
    for (file, code) in [
        ("io/vtu/writer.rs", "use crate::mesh::Mesh; use crate::io::Location; use super::super::Location;"),
        ("inverse/builder.rs", "use crate::{forward::Response, qp::Problem};"),
        ("mesh/solid.rs", "/// As [`crate::face::Face`] has it.\nuse super::Cell;"),
        ("cli/fit.rs", "use modiolus::inverse::Target; use crate::cli::Options;"),
        ("main.rs", "mod cli; use cli::run; use crate::cli::run;"),
        ("lib.rs", "pub mod mesh;"),
    ] {
        assert_eq!(upward(Path::new(file), code), Vec::<String>::new(), "{file}: {code}");
    }
}
