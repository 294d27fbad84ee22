//! SVG elements and the colours that they name.

use std::fmt::Write;

use super::super::markup::escaped;

/// The classes of a plot's elements. Blue, vermilion, green and the others are those of Okabe and Ito (2008), lighter on dark
/// ground.
pub(in super::super) const STYLE: &str = "\
.plot { --p-ink: #20242a; --p-soft: #59616b; --p-line: #d5d8dc; --p0: #0072b2; --p1: #d55e00; --p2: #009e73; --p3: #cc79a7; --p4: #b8860b; --p5: #56b4e9; --p6: #8c510a; --p7: #555555; font-family: system-ui, sans-serif; font-size: 12px; }
@media (prefers-color-scheme: dark) { .plot { --p-ink: #e6e8eb; --p-soft: #a3acb7; --p-line: #3a414a; --p0: #6cb8ea; --p1: #ff9a52; --p2: #4fcfa8; --p3: #e6a3c8; --p4: #f0d05a; --p5: #a5d8f5; --p6: #d9a066; --p7: #bbbbbb; } }
@media print { .plot { --p-ink: #000; --p-soft: #444; --p-line: #bbb; } }
.plot text { fill: var(--p-ink); } .plot .soft { fill: var(--p-soft); } .plot .bold { font-weight: 600; }
.plot .grid { stroke: var(--p-line); stroke-width: 1; } .plot .axis { stroke: var(--p-soft); stroke-width: 1; }
.plot .thin { stroke: var(--p-ink); stroke-width: 1.6; } .plot .run { fill: none; stroke-width: 2; } .plot .dashed { stroke-width: 1.2; stroke-dasharray: 4 4; } .plot .dot { stroke: none; } .plot .ring { fill: none; stroke-width: 2; }
.plot .f0 { fill: var(--p0); } .plot .f1 { fill: var(--p1); } .plot .f2 { fill: var(--p2); } .plot .f3 { fill: var(--p3); } .plot .f4 { fill: var(--p4); } .plot .f5 { fill: var(--p5); } .plot .f6 { fill: var(--p6); } .plot .f7 { fill: var(--p7); }
.plot .s0 { stroke: var(--p0); } .plot .s1 { stroke: var(--p1); } .plot .s2 { stroke: var(--p2); } .plot .s3 { stroke: var(--p3); } .plot .s4 { stroke: var(--p4); } .plot .s5 { stroke: var(--p5); } .plot .s6 { stroke: var(--p6); } .plot .s7 { stroke: var(--p7); }
";

/// Where a text begins, or what of it lies at its place.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// An SVG picture as it grows; lengths are pixels from the upper left.
#[derive(Clone, Debug)]
pub(super) struct Svg {
    size: (f64, f64),
    body: String,
}

impl Svg {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { size: (width, height), body: String::new() }
    }

    fn put(&mut self, arguments: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(arguments);
    }

    pub(super) fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, class: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{text}</text>"
        ));
    }

    pub(super) fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), class: &str) {
        self.put(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" class=\"{class}\"/>"
        ));
    }

    pub(super) fn bar(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), class: &str) {
        self.put(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\"/>"
        ));
    }

    pub(super) fn dot(&mut self, (x, y): (f64, f64), radius: f64, class: &str) {
        self.put(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" class=\"dot {class}\"/>"));
    }

    pub(super) fn ring(&mut self, (x, y): (f64, f64), radius: f64, class: &str) {
        self.put(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" class=\"ring {class}\"/>"));
    }

    pub(super) fn run(&mut self, points: &[(f64, f64)], class: &str) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        self.put(format_args!("<polyline points=\"{}\" class=\"run {class}\"/>", points.join(" ")));
    }

    /// An interval from `x1` to `x2` with its ends.
    pub(super) fn interval(&mut self, (x1, x2): (f64, f64), y: f64) {
        self.line((x1, y), (x2, y), "thin");
        for x in [x1, x2] {
            self.line((x, y - 3.5), (x, y + 3.5), "thin");
        }
    }

    /// The picture for a page that has the [`STYLE`], `label` being what a reader who does not see it is told.
    pub(super) fn inline(&self, label: &str) -> String {
        let (width, height) = self.size;
        format!(
            "<svg class=\"plot\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{}\">{}</svg>",
            escaped(label),
            self.body
        )
    }
}

/// A picture that was made to stand in a page, as a file of its own.
pub(super) fn standalone(inline: &str) -> String {
    let (head, body) = inline.split_once('>').unwrap_or((inline, ""));
    let head = head.replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1);
    format!("{head}><style>{STYLE}</style>{body}\n")
}
