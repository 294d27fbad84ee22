//! What several targets gave, as systems for continuous integration read it.

use std::fmt::Write;

use super::escaped::escaped;
use super::{SuiteJson, SuiteTargetJson};

/// The suite as JUnit XML: one `testsuite` for the face, one `testcase` a target. One that did not pass is a `failure`, one
/// without an answer an `error`, one without a statement `skipped`; `time` is wall time, s.
///
/// The form is that of the reports of Apache Ant's JUnit task, which has no schema of its own.
pub fn junit_text(suite: &SuiteJson) -> String {
    let time = |name: &str| suite.timings_s.get(name).copied().unwrap_or(0.);
    let errors = suite.targets.iter().filter(|t| t.status.is_none()).count();
    let counts = format!(
        "tests=\"{}\" failures=\"{}\" errors=\"{errors}\" skipped=\"{}\" time=\"{:.3}\"",
        suite.targets.len(),
        suite.failed - errors,
        suite.skipped,
        time("all")
    );
    let face = escaped(&suite.face_name);
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"modiolus\" {counts}>\n  \
         <testsuite name=\"{face}\" {counts}>\n"
    );
    for target in &suite.targets {
        let (name, file) = (escaped(&target.name), escaped(&target.file));
        let seconds = time(&target.name);
        let case = format!(
            "    <testcase classname=\"modiolus.{face}\" name=\"{name}\" file=\"{file}\" time=\"{seconds:.3}\""
        );
        let _ = match result(target) {
            None => writeln!(text, "{case}/>"),
            Some((kind, message)) => {
                writeln!(text, "{case}>\n      <{kind} message=\"{}\"/>\n    </testcase>", escaped(&message))
            }
        };
    }
    text + "  </testsuite>\n</testsuites>\n"
}

/// The element of a case that did not pass, and its message.
fn result(target: &SuiteTargetJson) -> Option<(&'static str, String)> {
    let remark = target.remark.clone().unwrap_or_default();
    let Some(status) = target.status else { return Some(("error", remark)) };
    match target.passed {
        Some(true) => None,
        None => Some(("skipped", remark)),
        Some(false) => {
            let found = target.found_rms_mm.map_or("no residual".to_owned(), |mm| format!("{mm:.3} mm"));
            let stated = target.stated_rms_mm.zip(target.tolerance_mm);
            let stated =
                stated.map_or_else(String::new, |(mm, by)| format!(", stated {mm:.3} mm within {by:.3}"));
            Some(("failure", format!("{}: {found}{stated}", status.said())))
        }
    }
}
