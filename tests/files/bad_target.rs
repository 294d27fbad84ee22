//! What a bad target file gets: one test a line of the list of bad input, and one for each field.

use std::path::Path;

use modiolus::inverse::{Goal, Place};
use modiolus::io::{TargetDocument, TargetFileError, TargetWarning, parse_target, read_target};

const GOOD: &str = r#"name = "smile"
unit = "mm"
effort = 0.1
tied = [["risorius_l", "risorius_r"]]

[[marker]]
landmark = "cheilion_l"
displacement_mm = [8.4, 10.8, nan]
sigma_mm = 1.2

[[marker]]
name = "cheek"
point_mm = [30.0, 20.0, -10.0]
position_mm = [33.0, 25.0, ""]
sigma_mm = 1

[[feature]]
from = "stomion_inferius"
to = "stomion_superius"
axis = "y"
value_mm = 0.0
sigma_mm = 0.2

[[symmetry]]
left = "cheilion_l"
right = "cheilion_r"
sigma_mm = 0.4

[[bounds]]
muscle = "*_r"
max = 0.2

[[bounds]]
muscle = "risorius_r"
min = 0.1
max = 0.5

[[expected]]
face = "standard"
residual_rms_mm = 1.0
tolerance_mm = 0.1
"#;

fn parse(text: &str) -> Result<TargetDocument, TargetFileError> {
    parse_target(text, Path::new("t.toml"))
}

/// The good file with `old` replaced by `new`: its error must hold every one of `parts`.
fn refused(old: &str, new: &str, parts: &[&str]) -> TargetFileError {
    assert!(GOOD.contains(old), "{old} is not in the good file");
    let error = parse(&GOOD.replacen(old, new, 1)).expect_err("refused");
    let text = error.to_string();
    for part in parts {
        assert!(text.contains(part), "\"{part}\" is not in: {text}");
    }
    error
}

fn warnings(old: &str, new: &str) -> Vec<TargetWarning> {
    assert!(GOOD.contains(old));
    parse(&GOOD.replacen(old, new, 1)).expect("accepted").warnings
}

#[test]
fn the_good_file_is_read() {
    let doc = parse(GOOD).expect("good");
    assert!(doc.warnings.is_empty(), "{:?}", doc.warnings);
    let t = &doc.target;
    assert_eq!((t.markers.len(), t.features.len(), t.symmetry.len()), (2, 1, 1));
    assert_eq!(t.markers[0].name, "cheilion_l");
    assert_eq!(t.markers[0].at, Place::Landmark("cheilion_l".into()));
    assert_eq!(t.markers[0].goal, Goal::Displacement([Some(8.4), Some(10.8), None]));
    assert_eq!(t.markers[1].goal, Goal::Position([Some(33.0), Some(25.0), None]));
    assert_eq!(t.features[0].name, "stomion_inferius to stomion_superius");
    assert_eq!(t.effort, 0.1);
    assert_eq!(t.tied, [["risorius_l".to_owned(), "risorius_r".to_owned()]]);
    assert_eq!((t.bounds[0].min, t.bounds[0].max), (0.0, 0.2));
    assert_eq!(t.expected[0].face, "standard");
}

#[test]
fn every_field_has_its_line() {
    let lines = parse(GOOD).expect("good").lines;
    for (field, line) in [
        ("unit", 2),
        ("tied[0][1]", 4),
        ("markers[0]", 6),
        ("markers[0].landmark", 7),
        ("markers[1].sigma_mm", 15),
        ("features[0].axis", 20),
        ("symmetry[0].right", 26),
        ("bounds[1].max", 36),
        ("markers[0].absent", 6),
    ] {
        assert_eq!(lines.location(field).line, Some(line), "{field}");
    }
    assert_eq!(lines.location("markers[0].landmark").to_string(), "t.toml:7: markers[0].landmark");
}

#[test]
fn singular_and_plural_lists_are_the_same() {
    let plural = GOOD.replace("[[marker]]", "[[markers]]").replace("[[feature]]", "[[features]]");
    assert_eq!(parse(&plural).expect("good").target, parse(GOOD).expect("good").target);
}

#[test]
fn byte_order_mark_and_crlf_are_accepted() {
    let text = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    let doc = parse(&text).expect("good");
    assert_eq!(doc.target, parse(GOOD).expect("good").target);
    assert_eq!(doc.lines.location("bounds[1].max").line, Some(36));
}

#[test]
fn nan_and_blank_are_missing_not_zero() {
    for missing in ["nan", "\"\"", "-nan"] {
        let text = GOOD.replacen("10.8, nan", &format!("{missing}, nan"), 1);
        let goal = parse(&text).expect("good").target.markers[0].goal;
        assert_eq!(goal, Goal::Displacement([Some(8.4), None, None]), "{missing}");
    }
}

#[test]
fn a_marker_without_observation_is_missing_with_a_warning() {
    let w = warnings("displacement_mm = [8.4, 10.8, nan]\n", "");
    assert!(matches!(&w[..], [TargetWarning::MissingMarker { name, .. }] if name == "cheilion_l"));
    let w = warnings("[8.4, 10.8, nan]", "[nan, nan, nan]");
    assert!(matches!(&w[..], [TargetWarning::MissingMarker { .. }]));
    assert!(w[0].to_string().contains("t.toml:6"), "{}", w[0]);
}

#[test]
fn an_exact_zero_earns_a_question() {
    let w = warnings("[8.4, 10.8, nan]", "[0.0, 0, -0.0]");
    assert!(matches!(&w[..], [TargetWarning::ZeroMarker { .. }]));
    assert!(w[0].to_string().contains("t.toml:8: markers[0].displacement_mm"), "{}", w[0]);
    assert!(w[0].to_string().contains("write nan"), "{}", w[0]);
    assert!(warnings("[8.4, 10.8, nan]", "[0.0, 0.0, nan]").is_empty());
}

#[test]
fn an_absent_unit_is_refused() {
    refused("unit = \"mm\"\n", "", &["t.toml: unit", "missing", "\"mm\""]);
}

#[test]
fn an_unknown_unit_is_refused() {
    let e = refused("\"mm\"", "\"m\"", &["t.toml:2: unit", "\"m\"", "unit = \"mm\""]);
    assert!(matches!(e, TargetFileError::UnknownUnit { .. }));
    refused("unit = \"mm\"", "unit = 1", &["t.toml:2: unit", "\"mm\""]);
}

#[test]
fn a_missing_name_is_refused() {
    refused("name = \"smile\"\n", "", &["t.toml: name: missing"]);
    refused("\"smile\"", "\" \"", &["t.toml:1: name: empty"]);
}

#[test]
fn a_name_is_one_plain_word() {
    let good = "name = \"smile\"";
    for bad in ["../../evil", "/abs", "a b", "a\\nb", "a.b", "\\u001b[31m", &"n".repeat(300)] {
        let error = refused(good, &format!("name = \"{bad}\""), &["t.toml:", "name", "one word of letters"]);
        assert!(!error.to_string().contains('\u{1b}'), "{error:?}");
    }
    assert!(parse(&GOOD.replacen(good, "name = \"Lächeln_2-b\"", 1)).is_ok());
}

#[test]
fn an_unknown_field_gets_the_nearest_name() {
    refused("sigma_mm = 1.2", "sigma = 1.2", &["t.toml:9: markers[0].sigma", "did you mean sigma_mm?"]);
    refused("effort", "efort", &["t.toml:3: efort", "did you mean effort?"]);
    refused("[[symmetry]]", "[[simmetry]]", &["t.toml:24: simmetry", "did you mean symmetry?"]);
    refused(
        "axis = ",
        "colour_of_it = ",
        &["t.toml:20: features[0].colour_of_it", "accepted: axis, change_mm"],
    );
}

#[test]
fn a_duplicate_label_is_refused_with_both_lines() {
    let e = refused("name = \"cheek\"", "name = \"cheilion_l\"", &["t.toml:12", "line 7", "unique"]);
    assert!(matches!(e, TargetFileError::Duplicate { first_line: 7, .. }));
}

#[test]
fn a_duplicate_bound_is_refused() {
    refused("muscle = \"risorius_r\"", "muscle = \"*_r\"", &["t.toml:34: bounds[1].muscle", "line 30"]);
}

#[test]
fn a_sigma_that_is_not_positive_and_finite_is_refused() {
    for bad in ["0.0", "0", "-1.0"] {
        refused(
            "sigma_mm = 1.2",
            &format!("sigma_mm = {bad}"),
            &["t.toml:9: markers[0].sigma_mm", "not positive"],
        );
    }
    for bad in ["nan", "inf", "-inf"] {
        refused("sigma_mm = 1.2", &format!("sigma_mm = {bad}"), &["t.toml:9: markers[0].sigma_mm", "finite"]);
    }
    for bad in ["1e-10", "1e-300", "1e5"] {
        let parts = ["t.toml:9: markers[0].sigma_mm", "out of range", "1e-4 to 1e4"];
        refused("sigma_mm = 1.2", &format!("sigma_mm = {bad}"), &parts);
    }
    refused("sigma_mm = 0.2", "sigma_mm = 0", &["features[0].sigma_mm", "not positive"]);
    refused("sigma_mm = 0.4", "sigma_mm = 0", &["symmetry[0].sigma_mm", "not positive"]);
    refused("sigma_mm = 1.2\n", "", &["t.toml:6: markers[0].sigma_mm: missing", "Standard deviation"]);
}

#[test]
fn an_infinite_component_is_refused() {
    refused("10.8", "inf", &["t.toml:8: markers[0].displacement_mm[1]", "finite"]);
    refused("[30.0,", "[nan,", &["t.toml:13: markers[1].point_mm[0]", "finite"]);
}

#[test]
fn text_is_not_a_number() {
    refused("8.4,", "\"8.4\",", &["t.toml:8: markers[0].displacement_mm", "8.4"]);
    refused("effort = 0.1", "effort = \"low\"", &["t.toml:3: effort", "\"low\"", "Weight"]);
    refused("8.4,", "true,", &["t.toml:8: markers[0].displacement_mm[0]", "true", "Displacement from rest"]);
}

#[test]
fn a_decimal_comma_is_refused_with_its_remedy() {
    let e = refused("[8.4, 10.8, nan]", "[8,4, 10,8, nan]", &["t.toml:8", "5 entries", "decimal point"]);
    assert!(matches!(e, TargetFileError::WrongLength { found: 5, expected: 3, .. }));
}

#[test]
fn a_short_or_long_row_is_refused() {
    refused("[8.4, 10.8, nan]", "[8.4, 10.8]", &["t.toml:8", "2 entries", "write 3"]);
    refused("[8.4, 10.8, nan]", "[8.4, 10.8, nan, nan]", &["4 entries"]);
    refused("[\"risorius_l\", \"risorius_r\"]", "[\"risorius_l\"]", &["t.toml:4: tied[0]", "write 2"]);
}

#[test]
fn metres_are_recognised() {
    let small =
        [("[8.4, 10.8, nan]", "[0.0084, 0.0108, nan]", "metres?"), ("10.8", "108", "more than the 100 mm")];
    let problems = ["largest displacement, under 0.05 mm", "metres"];
    for ((old, new, _), problem) in small.iter().zip(problems) {
        refused(old, new, &["t.toml:8: markers[0].displacement_mm", problem, "Convert to mm"]);
    }
    refused("[33.0, 25.0, \"\"]", "[3300.0, 25.0, nan]", &["t.toml:14", "500 mm"]);
    refused("[30.0, 20.0, -10.0]", "[30000.0, 20.0, -10.0]", &["t.toml:13", "500 mm"]);
    refused("value_mm = 0.0", "value_mm = 1e6", &["t.toml:21", "500 mm"]);
}

#[test]
fn both_and_neither_of_two_fields_are_refused() {
    refused(
        "landmark = \"cheilion_l\"",
        "landmark = \"a\"\npoint_mm = [1, 2, 3]",
        &["both landmark and point_mm"],
    );
    refused(
        "landmark = \"cheilion_l\"\n",
        "name = \"a\"\n",
        &["t.toml:6: markers[0]", "landmark or point_mm"],
    );
    refused(
        "displacement_mm = [8.4, 10.8, nan]",
        "displacement_mm = [8.4, 10.8, nan]\nposition_mm = [1, 2, 3]",
        &["t.toml:6", "both displacement_mm and position_mm"],
    );
    refused("value_mm = 0.0", "value_mm = 0.0\nchange_mm = 1.0", &["both value_mm and change_mm"]);
    refused("value_mm = 0.0\n", "", &["t.toml:17: features[0]", "value_mm or change_mm"]);
    refused("name = \"cheek\"\n", "", &["t.toml:11: markers[1].name", "label"]);
}

#[test]
fn bounds_outside_the_unit_interval_are_refused() {
    refused("max = 0.2", "max = 20", &["t.toml:31: bounds[0].max", "20", "fractions"]);
    refused("min = 0.1", "min = -0.1", &["t.toml:35: bounds[1].min", "-0.1"]);
    refused("min = 0.1", "min = nan", &["t.toml:35: bounds[1].min", "finite"]);
}

#[test]
fn crossed_bounds_are_refused() {
    let e = refused("min = 0.1", "min = 0.6", &["t.toml:33: bounds[1]", "min 0.6", "max 0.5", "risorius_r"]);
    assert!(matches!(e, TargetFileError::BoundsCrossed { .. }));
}

#[test]
fn an_effort_of_another_norm_is_refused() {
    let good = parse(&GOOD.replacen("effort = 0.1", "effort = 0.1\neffort_norm = \"l1\"", 1)).expect("good");
    assert_eq!(good.target.effort_norm, modiolus::inverse::EffortNorm::L1);
    assert_eq!(parse(GOOD).expect("good").target.effort_norm, modiolus::inverse::EffortNorm::L2);
    let norm = "effort = 0.1\neffort_norm = \"l3\"";
    refused("effort = 0.1", norm, &["t.toml:4: effort_norm", "\"l3\"", "l1", "l2"]);
    refused("effort = 0.1", "effort = 0.1\neffort_norm = 1", &["t.toml:4: effort_norm", "l1"]);
    refused("effort = 0.1", "effort = 0.1\neffort_nrom = \"l1\"", &["t.toml:4", "did you mean effort_norm?"]);
}

#[test]
fn a_negative_effort_is_refused() {
    refused("effort = 0.1", "effort = -0.1", &["t.toml:3: effort", "-0.1"]);
    refused("effort = 0.1", "effort = nan", &["t.toml:3: effort", "finite"]);
}

#[test]
fn a_negative_distance_is_refused() {
    refused("axis = \"y\"\nvalue_mm = 0.0", "value_mm = -3.0", &["features[0].value_mm", "-3"]);
}

#[test]
fn an_unknown_axis_is_refused() {
    refused(
        "axis = \"y\"",
        "axis = \"up\"",
        &["t.toml:20: features[0].axis", "\"up\"", "\"x\", \"y\" or \"z\""],
    );
}

#[test]
fn the_same_point_twice_is_refused() {
    refused(
        "to = \"stomion_superius\"",
        "to = \"stomion_inferius\"",
        &["t.toml:17", "from and to are the same"],
    );
    refused("right = \"cheilion_r\"", "right = \"cheilion_l\"", &["left and right are the same"]);
    refused("\"risorius_r\"]", "\"risorius_l\"]", &["t.toml:4: tied[0]", "the same"]);
}

#[test]
fn lengths_in_metres_are_refused_wherever_they_stand() {
    let feature = "value_mm = 0.0";
    refused(feature, "value_mm = 0.04", &["features[0].value_mm", "metres"]);
    refused(feature, "change_mm = -0.01", &["features[0].change_mm", "metres"]);
    let opening = "effort = 0.1\njaw_opening_mm = 0.004";
    refused("effort = 0.1", opening, &["jaw_opening_mm", "metres"]);
    let second = "point_mm = [0.03, 0.02, -0.01]\ndisplacement_mm = [1.0, 0.0, 0.0]\nsigma_mm = 1\n\n\
                  [[marker]]\nname = \"other\"\npoint_mm = [-0.03, 0.02, -0.01]";
    refused("point_mm = [30.0, 20.0, -10.0]", second, &["point_mm", "rest point", "metres"]);
}

#[test]
fn what_is_not_toml_is_refused_with_its_line() {
    let e = refused("effort = 0.1", "effort = = 0.1", &["t.toml:3", "not TOML"]);
    assert!(matches!(e, TargetFileError::Syntax { .. }));
    refused("sigma_mm = 1.2", "sigma_mm = 1.2\nsigma_mm = 1.3", &["t.toml:10", "not TOML"]);
    refused("[[symmetry]]", "[symmetry]", &["t.toml:24: symmetry", "a table", "write: tables [[symmetry]]"]);
}

#[test]
fn an_empty_file_is_refused() {
    let text = parse("").expect_err("refused").to_string();
    assert!(text.contains("missing"), "{text}");
}

#[test]
fn a_file_that_is_not_there_or_not_text_is_refused() {
    let e = read_target(Path::new("no/such.toml")).expect_err("refused");
    assert!(e.to_string().contains("no/such.toml: there is no such file"), "{e}");
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("binary.toml");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).expect("written");
    assert!(read_target(&path).expect_err("refused").to_string().contains("UTF-8"));
}

#[test]
fn patterns_name_muscles_and_exact_names_win() {
    let muscles: Vec<String> =
        ["risorius_l", "risorius_r", "mentalis_l", "mentalis_r"].map(str::to_owned).into();
    let doc = parse(GOOD).expect("good").expand_patterns(&muscles).expect("expanded");
    let mut bounds: Vec<_> = doc.target.bounds.iter().map(|b| (b.muscle.as_str(), b.max)).collect();
    bounds.sort_by(|a, b| a.0.cmp(b.0));
    assert_eq!(bounds, [("mentalis_r", 0.2), ("risorius_r", 0.5)]);
    for (i, bound) in doc.target.bounds.iter().enumerate() {
        let line = doc.lines.location(&format!("bounds[{i}].max")).line;
        assert_eq!(line, Some(if bound.muscle == "mentalis_r" { 31 } else { 36 }), "{}", bound.muscle);
    }
    let tied = GOOD.replace("[\"risorius_l\", \"risorius_r\"]", "[\"*_l\", \"*_r\"]");
    let doc = parse(&tied).expect("good").expand_patterns(&muscles).expect("expanded");
    assert_eq!(doc.target.tied.len(), 2);
}

#[test]
fn a_pattern_that_matches_nothing_is_refused() {
    let muscles = ["mentalis_l".to_owned()];
    let e = parse(GOOD).expect("good").expand_patterns(&muscles).expect_err("refused").to_string();
    assert!(e.contains("t.toml:30: bounds[0].muscle") && e.contains("mentalis_l"), "{e}");
}

#[test]
fn openings_of_the_jaw_are_a_number_or_bounds_and_refused_where_they_make_no_sense() {
    use modiolus::face::JawRange;
    use modiolus::inverse::JawOpening;
    let with = |value: &str| GOOD.replacen("effort", &format!("jaw_opening_mm = {value}\neffort"), 1);
    let read = |value: &str| parse(&with(value)).expect("accepted").target.jaw_opening;
    assert_eq!(parse(GOOD).expect("good").target.jaw_opening, None);
    assert_eq!(read("4"), Some(JawOpening::Held(4.0)));
    let range = JawRange { min_mm: 0.0, max_mm: 12.0 };
    assert_eq!(read("{ max = 12.0 }"), Some(JawOpening::Within(range)));
    assert_eq!(read("{ min = 3.0, max = 3.0 }"), Some(JawOpening::Held(3.0)));
    for (value, parts) in [
        ("-1.0", ["t.toml:3", "jaw_opening_mm", "0 to 60"]),
        ("{ max = 70 }", ["t.toml:3", "jaw_opening_mm.max", "0 to 60"]),
        ("{ min = 5.0, max = 4.0 }", ["t.toml:3", "jaw_opening_mm", "exchange them"]),
        ("nan", ["t.toml:3", "jaw_opening_mm", "NaN"]),
        ("{ maximum = 4.0 }", ["t.toml:3", "jaw_opening_mm.maximum", "max"]),
        ("{ min = 4.0 }", ["t.toml:3", "jaw_opening_mm.max", "Greatest opening"]),
        ("\"wide\"", ["t.toml:3", "jaw_opening_mm", "\"wide\""]),
    ] {
        let text = parse(&with(value)).expect_err("refused").to_string();
        for part in parts {
            assert!(text.contains(part), "{value}: \"{part}\" is not in: {text}");
        }
    }
}
