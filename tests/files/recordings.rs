//! Recordings of markers: what is read of each format, and what bad ones get.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say where")]

use std::path::{Path, PathBuf};

use modiolus::io::{
    ImageScale, ReadOptions, RecordingDocument, RecordingFileErrorKind, RecordingFileWarning,
    RecordingFormat, parse_recording, read_recording, recording_csv,
};
use modiolus::units::{LengthUnit, Vec3};

fn read(name: &str, bytes: &[u8]) -> RecordingDocument {
    parse_recording(bytes, Path::new(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Why `bytes` are refused; every one of `parts` is in the message.
fn refused(name: &str, bytes: &[u8], options: &ReadOptions, parts: &[&str]) -> RecordingFileErrorKind {
    let error = parse_recording(bytes, Path::new(name), options).expect_err("refused");
    let text = error.to_string();
    for part in [name].iter().chain(parts) {
        assert!(text.contains(part), "\"{part}\" is not in: {text}");
    }
    error.kind
}

fn vec3(x: f64, y: f64, z: f64) -> Option<Vec3> {
    Some(Vec3::new(x, y, z))
}

// C3D

#[derive(Clone, Copy, Debug, PartialEq)]
enum Processor {
    Intel = 84,
    Dec = 85,
    Mips = 86,
}

/// Group, name, kind, dimensions and data of a parameter.
type Parameter = (&'static str, &'static str, i8, Vec<u8>, Vec<u8>);

/// A C3D file as its specification lays it out.
#[derive(Clone)]
struct C3d {
    processor: Processor,
    scale: f32,
    units: Option<&'static str>,
    rate: f32,
    /// First frame and last one, as the header says.
    span: [u16; 2],
    labels: Vec<String>,
    /// By frame and point: three coordinates in the file's numbers, and the fourth word.
    frames: Vec<Vec<[f32; 4]>>,
    /// Analog numbers a frame.
    analog: u16,
    /// More parameters: group, name, type, dimensions, data.
    more: Vec<Parameter>,
    without: &'static [&'static str],
}

impl C3d {
    fn new(labels: &[&str], frames: &[&[[f32; 4]]]) -> Self {
        Self {
            processor: Processor::Intel,
            scale: -1.,
            units: Some("mm"),
            rate: 50.,
            span: [1, frames.len() as u16],
            labels: labels.iter().map(|l| (*l).to_owned()).collect(),
            frames: frames.iter().map(|f| f.to_vec()).collect(),
            analog: 0,
            more: Vec::new(),
            without: &[],
        }
    }

    fn word(&self, value: u16) -> [u8; 2] {
        if self.processor == Processor::Mips { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    /// Four times a number has the bits that it has on a VAX, the words swapped.
    fn float(&self, value: f32) -> [u8; 4] {
        match self.processor {
            Processor::Intel => value.to_le_bytes(),
            Processor::Mips => value.to_be_bytes(),
            Processor::Dec => {
                let [a, b, c, d] = (value * 4.).to_be_bytes();
                [b, a, d, c]
            }
        }
    }

    fn parameters(&self) -> Vec<u8> {
        let n = self.frames[0].len();
        let texts = |all: &[String]| -> (Vec<u8>, Vec<u8>) {
            let length = all.iter().map(String::len).max().unwrap_or(0);
            let padded = all.iter().flat_map(|l| format!("{l:length$}").into_bytes()).collect();
            (vec![length as u8, all.len() as u8], padded)
        };
        let mut all = self.more.clone();
        let mut point = |name, kind, dimensions, data| all.push(("POINT", name, kind, dimensions, data));
        point("USED", 2, vec![], self.word(n as u16).to_vec());
        point("SCALE", 4, vec![], self.float(self.scale).to_vec());
        point("RATE", 4, vec![], self.float(self.rate).to_vec());
        point("DATA_START", 2, vec![], self.word(0).to_vec());
        point("FRAMES", 2, vec![], self.word(self.frames.len() as u16).to_vec());
        if let Some(units) = self.units {
            point("UNITS", -1, vec![units.len() as u8], units.as_bytes().to_vec());
        }
        for (k, labels) in self.labels.chunks(255).enumerate() {
            let (dimensions, data) = texts(labels);
            let name = ["LABELS", "LABELS2", "LABELS3"][k];
            point(name, -1, dimensions, data);
        }
        let mut bytes = vec![1, 0x50, 0, self.processor as u8];
        let mut entry = |name: &str, id: i8, data: Vec<u8>| {
            bytes.push(name.len() as u8);
            bytes.push(id as u8);
            bytes.extend(name.bytes());
            bytes.extend(self.word(data.len() as u16 + 2));
            bytes.extend(data);
        };
        let groups = ["POINT", "TRIAL", "ANALOG"];
        for (k, group) in groups.iter().enumerate() {
            entry(group, -(k as i8 + 1), vec![0]);
        }
        for (group, name, kind, dimensions, data) in all {
            if self.without.contains(&name) {
                continue;
            }
            let id = groups.iter().position(|g| *g == group).unwrap() as i8 + 1;
            let mut entry_data = vec![kind as u8, dimensions.len() as u8];
            entry_data.extend(dimensions);
            entry_data.extend(data);
            entry_data.push(0);
            entry(name, id, entry_data);
        }
        bytes.extend([0, 0]);
        bytes
    }

    fn bytes(&self) -> Vec<u8> {
        let mut parameters = self.parameters();
        let blocks = parameters.len().div_ceil(512);
        parameters[2] = blocks as u8;
        parameters.resize(blocks * 512, 0);
        let mut bytes = vec![2, 0x50];
        for word in [self.frames[0].len() as u16, self.analog, self.span[0], self.span[1], 10] {
            bytes.extend(self.word(word));
        }
        bytes.extend(self.float(self.scale));
        bytes.extend(self.word(blocks as u16 + 2));
        bytes.extend(self.word(u16::from(self.analog > 0)));
        bytes.extend(self.float(self.rate));
        bytes.resize(512, 0);
        bytes.extend(parameters);
        for frame in &self.frames {
            let numbers =
                frame.iter().flatten().copied().chain((0..self.analog).map(|k| 1000. + f32::from(k)));
            for number in numbers {
                if self.scale < 0. {
                    bytes.extend(self.float(number));
                } else {
                    bytes.extend(self.word(number as i16 as u16));
                }
            }
        }
        bytes
    }
}

/// Two markers over three frames with every kind of gap: NaN where the processor has it, a residual of -1 beside zeros
/// and beside a position, and zeros alone.
fn gaps(processor: Processor, scale: f32) -> C3d {
    let unseen = if processor == Processor::Dec || scale > 0. { [0., 0., 0., -1.] } else { [f32::NAN; 4] };
    let frames: [&[[f32; 4]]; 4] = [
        &[[10., -20., 30., 0.], [1., 2., 3., 5.]],
        &[unseen, [4., 5., 6., -1.]],
        &[[0., 0., 0., -1.], [0., 0., 0., 0.]],
        &[[11., -21., 31., 2.], [2., 3., -4., 0.]],
    ];
    C3d { processor, scale, ..C3d::new(&["a", "b"], &frames) }
}

#[test]
fn c3d_of_three_processors_in_floats_and_integers_with_gaps() {
    for processor in [Processor::Intel, Processor::Dec, Processor::Mips] {
        for (scale, unit) in [(-0.25, 1.), (0.5, 0.5)] {
            let mut file = gaps(processor, scale);
            for analog in [0, 3] {
                file.analog = analog;
                let document = read("a.c3d", &file.bytes());
                let r = &document.recording;
                assert_eq!(document.format, RecordingFormat::C3d);
                assert_eq!(r.names(), ["a", "b"]);
                assert_eq!(r.times_s(), [0., 0.02, 0.04, 0.06]);
                assert_eq!(
                    r.frame(0),
                    [vec3(10. * unit, -20. * unit, 30. * unit), vec3(unit, 2. * unit, 3. * unit)]
                );
                assert_eq!(r.frame(1), [None, None]);
                assert_eq!(r.frame(2), [None, None]);
                assert_eq!(
                    r.frame(3),
                    [vec3(11. * unit, -21. * unit, 31. * unit), vec3(2. * unit, 3. * unit, -4. * unit)]
                );
                let told = RecordingFileWarning::ZeroGap { marker: "b".into(), first: 2, frames: 1 };
                assert_eq!(document.warnings, [told], "{processor:?} {scale}");
            }
        }
    }
}

#[test]
fn c3d_labels_lose_their_subject_and_those_without_a_point() {
    let frames: [&[[f32; 4]]; 1] = [&[[1., 2., 3., 0.], [4., 5., 6., 0.]]];
    let document = read("a.c3d", &C3d::new(&["Ann:lip", "Ann:chin", "Ann:Angle", ""], &frames).bytes());
    assert_eq!(document.recording.names(), ["lip", "chin"]);
    assert_eq!(document.warnings, [RecordingFileWarning::Labels { count: 1, names: "Ann:Angle".into() }]);
    let document = read("a.c3d", &C3d::new(&["Ann:lip", "Bob:lip"], &frames).bytes());
    assert_eq!(document.recording.names(), ["Ann:lip", "Bob:lip"]);
    let document = read("a.c3d", &C3d::new(&["lip"], &frames).bytes());
    assert_eq!(document.recording.names(), ["lip", "point_2"]);
    assert_eq!(document.warnings, [RecordingFileWarning::Unlabelled { count: 1, first: 1 }]);
    refused(
        "a.c3d",
        &C3d::new(&["lip", "lip"], &frames).bytes(),
        &ReadOptions::default(),
        &["POINT:LABELS", "`lip`"],
    );
}

#[test]
fn c3d_of_more_than_255_points() {
    let names: Vec<String> = (0..600).map(|k| format!("m{k}")).collect();
    let frame: Vec<[f32; 4]> = (0..600).map(|k| [k as f32, 1., 2., 0.]).collect();
    let labels: Vec<&str> = names.iter().map(String::as_str).collect();
    let document = read("a.c3d", &C3d::new(&labels, &[&frame]).bytes());
    assert_eq!(document.recording.names(), names);
    assert_eq!(document.recording.frame(0)[599], vec3(599., 1., 2.));
}

#[test]
fn c3d_of_more_frames_than_a_word_counts() {
    let frames: Vec<Vec<[f32; 4]>> = (0..70_000).map(|k| vec![[1. + (k % 7) as f32, 0., 0., 0.]]).collect();
    let mut file = C3d { frames, span: [1, 65535], ..C3d::new(&["a"], &[&[[0.; 4]]]) };
    let long = |value: u32| vec![value as u8, (value >> 8) as u8, (value >> 16) as u8, (value >> 24) as u8];
    // The counts that fit no word: in the TRIAL group, as LONG_FRAMES, and FRAMES as a floating number.
    let trial = vec![
        ("TRIAL", "ACTUAL_START_FIELD", 2, vec![2], long(1)),
        ("TRIAL", "ACTUAL_END_FIELD", 2, vec![2], long(70_000)),
    ];
    let long_frames = vec![("POINT", "LONG_FRAMES", 4, vec![], 70_000f32.to_le_bytes().to_vec())];
    for (more, span) in [(trial.clone(), [1, 65535]), (long_frames, [1, 65535]), (trial, [1, 4464])] {
        (file.more, file.span) = (more, span);
        let document = read("a.c3d", &file.bytes());
        assert_eq!(document.recording.n_frames(), 70_000);
        assert_eq!(document.recording.times_s()[69_999], 69_999. / 50.);
        assert_eq!(document.recording.frame(69_999)[0], vec3(1. + f64::from(69_999 % 7), 0., 0.));
    }
    // One that fits and disagrees is told.
    file.frames.truncate(3);
    file.span = [11, 13];
    file.more = vec![("POINT", "LONG_FRAMES", 4, vec![], 5f32.to_le_bytes().to_vec())];
    let document = read("a.c3d", &file.bytes());
    assert_eq!(document.recording.times_s(), [0.2, 0.22, 0.24]);
    let told = RecordingFileWarning::Frames { parameter: "POINT:LONG_FRAMES", other: 5, taken: 3 };
    assert_eq!(document.warnings, [told]);
}

#[test]
fn c3d_units() {
    let good = C3d::new(&["a"], &[&[[1., 2., 3., 0.]]]);
    for (units, scale) in [("mm", 1.), ("cm", 10.), ("m", 1000.), ("Meters", 1000.)] {
        let file = C3d { units: Some(units), ..good.clone() };
        assert_eq!(read("a.c3d", &file.bytes()).recording.frame(0)[0], vec3(scale, 2. * scale, 3. * scale));
    }
    let cubits = C3d { units: Some("cubits"), ..good.clone() }.bytes();
    refused(
        "a.c3d",
        &cubits,
        &ReadOptions::default(),
        &["POINT:UNITS", "cubits", "mm, cm or m", "--unit mm"],
    );
    for units in [None, Some("    ")] {
        let bytes = C3d { units, ..good.clone() }.bytes();
        refused("a.c3d", &bytes, &ReadOptions::default(), &["POINT:UNITS", "no unit", "--unit mm"]);
        let options = ReadOptions { unit: Some(LengthUnit::Centimetre), ..ReadOptions::default() };
        let document = parse_recording(&bytes, Path::new("a.c3d"), &options).unwrap();
        assert_eq!(document.recording.frame(0)[0], vec3(10., 20., 30.));
    }
    let options = ReadOptions { unit: Some(LengthUnit::Metre), ..ReadOptions::default() };
    let document = parse_recording(&good.bytes(), Path::new("a.c3d"), &options).unwrap();
    let told = RecordingFileWarning::OtherUnit { stated: "mm".into(), taken: "m" };
    assert_eq!(document.warnings[0], told);
}

#[test]
fn what_c3d_cannot_be() {
    let good = C3d::new(&["a"], &[&[[1., 2., 3., 0.]], &[[1., 2., 3., 0.]]]);
    let none = ReadOptions::default();
    for scale in [0., f32::NAN] {
        let bytes = C3d { scale, ..good.clone() }.bytes();
        refused(
            "a.c3d",
            &bytes,
            &none,
            &["byte", "POINT:SCALE", "0", "export the file again"]
                .map(|p| if scale == 0. { p } else { "POINT:SCALE" }),
        );
    }
    for rate in [0., -1.] {
        let bytes = C3d { rate, ..good.clone() }.bytes();
        refused("a.c3d", &bytes, &none, &["byte", "POINT:RATE", &rate.to_string(), "--rate-hz"]);
        let options = ReadOptions { rate_hz: Some(10.), ..none };
        let document = parse_recording(&bytes, Path::new("a.c3d"), &options).unwrap();
        assert_eq!(document.recording.times_s(), [0., 0.1]);
    }
    let bytes = C3d { span: [1, 0], ..good.clone() }.bytes();
    refused("a.c3d", &bytes, &none, &["frames", "no frames"]);
    let bytes = C3d { span: [1, 3], ..good.clone() }.bytes();
    let kind = refused("a.c3d", &bytes, &none, &["the header says 3 frames", "holds 2", "truncated"]);
    assert!(matches!(kind, RecordingFileErrorKind::FramesPastEnd { declared: 3, held: 2, .. }));
    let mut bytes = good.bytes();
    bytes[0] = 200;
    refused("a.c3d", &bytes, &none, &["byte 0", "parameter block", "block 200", "export it again"]);
    let mut bytes = good.bytes();
    bytes[16] = 200;
    refused("a.c3d", &bytes, &none, &["byte 16", "data block", "block 200"]);
    let mut bytes = good.bytes();
    bytes[515] = 7;
    refused("a.c3d", &bytes, &none, &["byte 515", "processor type", "7", "84 (Intel)"]);
    // LABELS that claim more than the file has.
    let bytes = good.bytes();
    let at = bytes.windows(6).position(|w| w == b"LABELS").unwrap();
    let mut damaged = bytes[..1024].to_vec();
    damaged[at + 10..at + 12].copy_from_slice(&[255, 255]);
    refused("a.c3d", &damaged, &none, &["POINT:LABELS", "past the end of the file"]);
    for length in [100, 514] {
        assert!(parse_recording(&bytes[..length], Path::new("a.c3d"), &none).is_err());
    }
    let infinite = C3d::new(&["a"], &[&[[f32::INFINITY, 2., 3., 0.]]]).bytes();
    refused("a.c3d", &infinite, &none, &["frame 1", "`a`", "finite"]);
}

// TRC

const TRC: &str = "PathFileType\t4\t(X/Y/Z)\ta.trc\n\
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
100\t100\t3\t2\tmm\t100\t1\t3\n\
Frame#\tTime\tlip\t\t\tchin\t\t\n\
\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\
\n\
1\t0.00\t1\t2\t3\t4\t5\t6\n\
2\t0.01\t\t\t\t4.5\t5\tnan\n\
3\t0.02\t1.5\t2\t3\t7\t8\t9\n";

fn trc(old: &str, new: &str) -> Vec<u8> {
    assert!(TRC.contains(old), "{old}");
    TRC.replacen(old, new, 1).into_bytes()
}

#[test]
fn trc_of_tabs_and_commas_with_blank_cells() {
    let document = read("a.trc", TRC.as_bytes());
    let r = &document.recording;
    assert_eq!(
        (document.format, r.names()),
        (RecordingFormat::Trc, &["lip".to_owned(), "chin".to_owned()][..])
    );
    assert_eq!(r.times_s(), [0., 0.01, 0.02]);
    assert_eq!(r.frame(0), [vec3(1., 2., 3.), vec3(4., 5., 6.)]);
    assert_eq!(r.frame(1), [None, None]);
    assert_eq!(r.frame(2), [vec3(1.5, 2., 3.), vec3(7., 8., 9.)]);
    let told = RecordingFileWarning::Partial { marker: "chin".into(), first: 1, frames: 1 };
    assert_eq!(document.warnings, [told]);
    for other in [
        TRC.replace('\t', ","),
        TRC.replace('\t', ";").replace("1.5", "1,5").replace("0.0", "0,0"),
        TRC.replace('\n', "\r\n"),
        TRC.replace("\n\n", "\n\t\t\t\t\n\n"),
        TRC.replace("\n\n", "\n"),
        TRC.replace("\t5\t6\n", "\t5\t6\t\t\n"),
        format!("\u{feff}{TRC}\n\n\t\t\n"),
        TRC.replace("Frame#\tTime\tlip\t\t\tchin\t\t\n", "Frame#\tTime\tlip\t\t\tchin\n"),
        TRC.replace("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n", ""),
        TRC.replace("mm", "Meters").replace("NumMarkers", "nummarkers"),
    ] {
        let scale = if other.contains("Meters") { 1000. } else { 1. };
        let other = read("a.trc", other.as_bytes()).recording;
        assert_eq!((other.names(), other.times_s()), (r.names(), r.times_s()));
        for f in 0..3 {
            assert!(other.frame(f).iter().zip(r.frame(f)).all(|(a, b)| *a == b.map(|b| scale * b)), "{f}");
        }
    }
}

#[test]
fn what_trc_cannot_be() {
    let none = ReadOptions::default();
    refused(
        "a.trc",
        &trc("\t3\t2\tmm", "\t4\t2\tmm"),
        &none,
        &["a.trc:3: NumFrames", "4 frames", "3 are there"],
    );
    refused(
        "a.trc",
        &trc("\t3\t2\tmm", "\t3\t3\tmm"),
        &none,
        &["a.trc:3: NumMarkers", "3 markers", "2 are there"],
    );
    refused("a.trc", &trc("\t2\tmm", "\tx\tmm"), &none, &["a.trc:3: NumMarkers", "x", "whole number"]);
    refused("a.trc", &trc("\tmm", "\tfoot"), &none, &["a.trc:3: Units", "foot", "--unit mm"]);
    refused("a.trc", &trc("\tmm", "\t"), &none, &["a.trc:3: Units", "no unit", "--unit mm"]);
    refused("a.trc", &trc("Units", "Einheit"), &none, &["a.trc:2", "no column Units"]);
    refused("a.trc", &trc("0.02", "0.01"), &none, &["a.trc:9", "0.01 s", "not after"]);
    refused("a.trc", &trc("0.02", ""), &none, &["a.trc:9: Time", "number"]);
    refused("a.trc", &trc("chin", "lip"), &none, &["a.trc:4", "two markers are called `lip`"]);
    refused("a.trc", &trc("\t8\t9", "\t8"), &none, &["a.trc:9", "7 entries", "8"]);
    refused("a.trc", &trc("\t8\t9", "\t8\t9\t10"), &none, &["a.trc:9", "9 entries", "8"]);
    refused("a.trc", &trc("\t8\t9", "\tx\t9"), &none, &["a.trc:9: chin y", "`x`", "not a finite number"]);
    refused("a.trc", &trc("\t8\t9", "\tinf\t9"), &none, &["a.trc:9: chin y", "`inf`"]);
    let end = TRC.find("Frame#").unwrap();
    refused("a.trc", &TRC.as_bytes()[..end], &none, &["ends before the names of its markers", "truncated"]);
    let no_rows = TRC[..TRC.find("1\t0.00").unwrap()].replacen("\t3\t2", "\t0\t2", 1);
    refused("a.trc", no_rows.as_bytes(), &none, &["no frames"]);
}

#[test]
fn a_zero_earns_a_question_and_a_jump_is_told() {
    let zero = read("a.trc", &trc("1\t2\t3", "0\t0\t0"));
    assert_eq!(
        zero.warnings[1],
        RecordingFileWarning::ZeroPosition { marker: "lip".into(), first: 0, frames: 1 }
    );
    assert_eq!(zero.recording.frame(0)[0], vec3(0., 0., 0.));
    assert!(zero.warnings[1].to_string().contains("lip") && zero.warnings[1].to_string().contains("frame 1"));
    let jumping = TRC.replace("\t\t\t\t4.5\t5\tnan", "\t61\t2\t3\t4\t5\t6");
    let told = read("a.trc", jumping.as_bytes()).warnings;
    let jump = RecordingFileWarning::Jump { marker: "lip".into(), frame: 1, distance_mm: 60., jumps: 2 };
    assert_eq!(told, [jump]);
    assert!(told[0].to_string().contains("lip jumps by 60 mm to frame 2"), "{}", told[0]);
}

// Tables

#[test]
fn long_tables_of_times_frames_and_names() {
    let text = "time_s,marker,x_mm,y_mm,z_mm\n0,lip,1,2,3\n0,chin,4,5,6\n0.1,lip,1.5,,\n0.1,chin,4,5,7\n";
    let document = read("a.csv", text.as_bytes());
    let r = &document.recording;
    assert_eq!((r.names(), r.times_s()), (&["lip".to_owned(), "chin".to_owned()][..], &[0., 0.1][..]));
    assert_eq!(r.frame(1), [None, vec3(4., 5., 7.)]);
    assert_eq!(document.format, RecordingFormat::LongTable);
    // Sorted by marker, in centimetres, with semicolons, decimal commas and quotes; milliseconds.
    for same in [
        "time_ms;x_cm;y_cm;z_cm;\"marker\"\n0;0,1;0,2;0,3;\"lip\"\n100;0,15;;;lip\n0;0,4;0,5;0,6;chin\n100;0,4;0,5;0,7;chin\n",
        "Time (Seconds)\tlandmark\tX (mm)\tY (mm)\tZ (mm)\n0\tlip\t1\t2\t3\n0\tchin\t4\t5\t6\n0.1\tchin\t4\t5\t7\n",
    ] {
        let other = read("a.csv", same.as_bytes()).recording;
        assert_eq!((other.names(), other.times_s()), (r.names(), r.times_s()));
        for f in 0..2 {
            for (a, b) in other.frame(f).iter().zip(r.frame(f)) {
                assert_eq!(a.is_some(), b.is_some());
                assert!(a.zip(*b).is_none_or(|(a, b)| (a - b).norm() < 1e-12));
            }
        }
    }
    let numbered = text.replace("time_s", "frame").replace("0.1", "6");
    refused("a.csv", numbered.as_bytes(), &ReadOptions::default(), &["no times", "time_s", "--rate-hz"]);
    let options = ReadOptions { rate_hz: Some(60.), ..ReadOptions::default() };
    let document = parse_recording(numbered.as_bytes(), Path::new("a.csv"), &options).unwrap();
    assert_eq!(document.recording.times_s(), [0., 0.1]);
    let one = read("a.csv", b"marker,x_mm,y_mm,z_mm\nlip,1,2,3\nchin,4,5,6\n").recording;
    assert_eq!((one.times_s(), one.frame(0)), (&[0.][..], &[vec3(1., 2., 3.), vec3(4., 5., 6.)][..]));
    let posed =
        read("a.csv", b"expression,marker,x_mm,y_mm,z_mm\nrest,lip,1,2,3\nsmile,lip,4,5,6\n").recording;
    assert_eq!(posed.frame_names(), Some(&["rest".to_owned(), "smile".to_owned()][..]));
    assert_eq!(posed.frame(1), [vec3(4., 5., 6.)]);
    let told = read("a.csv", b"time,marker,x_mm,y_mm,z_mm,quality\n0,lip,1,2,3,good\n").warnings;
    assert_eq!(
        told,
        [
            RecordingFileWarning::TimeUnit { column: "time".into() },
            RecordingFileWarning::Columns { count: 1, names: "quality".into() }
        ]
    );
}

#[test]
fn what_long_tables_cannot_be() {
    let none = ReadOptions::default();
    let good = "time_s,marker,x_mm,y_mm,z_mm\n0,lip,1,2,3\n0.1,lip,1,2,3\n";
    let bad = |old: &str, new: &str| good.replacen(old, new, 1).into_bytes();
    refused("a.csv", &bad("0.1,lip", "0,lip"), &none, &["a.csv:3", "lip", "twice", "line 2"]);
    refused("a.csv", &bad("0.1,lip", "-1,lip"), &none, &["a.csv:3", "-1 s", "not after"]);
    refused("a.csv", &bad("0.1,lip", "x,lip"), &none, &["a.csv:3: time_s", "`x`"]);
    refused("a.csv", &bad("0.1,lip", "0.1,"), &none, &["marker 2 has no name"]);
    refused("a.csv", &bad("1,2,3\n0.1", "1,2\n0.1"), &none, &["a.csv:2", "4 entries", "5"]);
    refused("a.csv", &bad("1,2,3\n0.1", "1,2,3,4\n0.1"), &none, &["a.csv:2", "6 entries", "5"]);
    refused("a.csv", &bad("1,2,3", "1,\"2\"\"\",3"), &none, &["a.csv:2: lip y"]);
    refused("a.csv", &bad("1,2,3", "1,\"2,3"), &none, &["a.csv:2", "quote"]);
    refused("a.csv", &bad("x_mm,y_mm,z_mm", "x,y,z"), &none, &["a.csv:1", "no unit", "x_mm", "--unit mm"]);
    refused("a.csv", &bad("y_mm", "y_cm"), &none, &["a.csv:1", "mm", "cm"]);
    refused("a.csv", &bad("y_mm", "dy_mm"), &none, &["a.csv:1", "not both"]);
    refused("a.csv", &bad("y_mm", "x_mm"), &none, &["a.csv:1", "two columns are x"]);
    refused("a.csv", &bad("z_mm", "w_mm"), &none, &["a.csv:1", "no column z"]);
    refused("a.csv", b"time_s,marker,x_mm,y_mm,z_mm\n", &none, &["no markers"]);
    refused("a.csv", b" \n", &none, &["is empty"]);
    refused("a.csv", b"hello world\n", &none, &["no recording that is read", "C3D, TRC"]);
    refused("a.csv", b"a\x01b", &none, &["byte 1", "0x01"]);
    // Every row another marker at another time: a thousandfold of what the file has.
    let sparse: String = (0..3000).map(|k| format!("{k},m{k},1,2,3\n")).collect();
    let sparse = format!("time_s,marker,x_mm,y_mm,z_mm\n{sparse}");
    refused("a.csv", sparse.as_bytes(), &none, &["3000 rows", "3000 frames", "3000 markers"]);
}

#[test]
fn displacements_count_from_a_neutral_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("neutral.csv");
    std::fs::write(&path, "marker,x_cm,y_cm,z_cm\nlip,1,2,3\nchin,4,5,6\nbrow,7,8,9\n").unwrap();
    let text = "expression,marker,dx_mm,dy_mm,dz_mm\nsmile,chin,1,0,0\nsmile,lip,0,2,0\nsnarl,lip,0,0,3\n";
    let none = ReadOptions::default();
    refused("a.csv", text.as_bytes(), &none, &["a.csv", "displacements", "--neutral FILE"]);
    let options = ReadOptions { neutral: Some(&path), ..none };
    let document = parse_recording(text.as_bytes(), Path::new("a.csv"), &options).unwrap();
    let r = &document.recording;
    assert_eq!(r.names(), ["lip", "chin", "brow"]);
    assert_eq!(r.frame_names().unwrap(), ["neutral", "smile", "snarl"]);
    assert_eq!(r.frame(0), [vec3(10., 20., 30.), vec3(40., 50., 60.), vec3(70., 80., 90.)]);
    assert_eq!(r.frame(1), [vec3(10., 22., 30.), vec3(41., 50., 60.), None]);
    assert_eq!(r.frame(2), [vec3(10., 20., 33.), None, None]);
    assert_eq!(document.files.len(), 2);
    let other = text.replace("snarl,lip", "snarl,lib");
    refused("a.csv", other.as_bytes(), &options, &["a.csv:4", "lib", "neutral.csv", "did you mean lip?"]);
    let positions = text.replace("dx_mm,dy_mm,dz_mm", "x_mm,y_mm,z_mm");
    refused("a.csv", positions.as_bytes(), &options, &["positions", "leave --neutral out"]);
}

#[test]
fn wide_tables() {
    let text =
        "time_s,lip_x_mm,lip_y_mm,lip_z_mm,chin_x_mm,chin_y_mm,chin_z_mm\n0,1,2,3,4,5,6\n0.1,1.5,,,NaN,,\n";
    let document = read("a.csv", text.as_bytes());
    let r = &document.recording;
    assert_eq!(
        (document.format, r.names()),
        (RecordingFormat::WideTable, &["lip".to_owned(), "chin".to_owned()][..])
    );
    assert_eq!((r.times_s(), r.frame(0)), (&[0., 0.1][..], &[vec3(1., 2., 3.), vec3(4., 5., 6.)][..]));
    assert_eq!(r.frame(1), [None, None]);
    let cm = ReadOptions { unit: Some(LengthUnit::Centimetre), ..ReadOptions::default() };
    for (same, options) in [
        ("time_s;lip.x;lip.y;lip.z;chin.x;chin.y;chin.z\n0;0,1;0,2;0,3;0,4;0,5;0,6\n0,1;;;;;;\n", cm),
        (
            "\"t_ms\"\t\"S:lip_X (mm)\"\tS:lip_Y (mm)\tS:lip_Z (mm)\tS:chin_X (mm)\tS:chin_Y (mm)\tS:chin_Z (mm)\n0\t1\t2\t3\t4\t5\t6\n100\t\t\t\t\t\t\n",
            ReadOptions::default(),
        ),
        (
            "frame,lip_x_mm,lip_y_mm,lip_z_mm,chin_x_mm,chin_y_mm,chin_z_mm\n7,1,2,3,4,5,6\n8,,,,,,\n",
            ReadOptions { rate_hz: Some(10.), ..ReadOptions::default() },
        ),
        (
            "lip_x_mm,lip_y_mm,lip_z_mm,chin_x_mm,chin_y_mm,chin_z_mm\n1,2,3,4,5,6\n,,,,,\n",
            ReadOptions { rate_hz: Some(10.), ..ReadOptions::default() },
        ),
    ] {
        let other = parse_recording(same.as_bytes(), Path::new("a.csv"), &options)
            .unwrap_or_else(|e| panic!("{e}"))
            .recording;
        assert_eq!(
            (other.names(), other.times_s(), other.frame(1)),
            (r.names(), r.times_s(), r.frame(1)),
            "{same}"
        );
        for (a, b) in other.frame(0).iter().zip(r.frame(0)) {
            assert!((a.unwrap() - b.unwrap()).norm() < 1e-12, "{same}");
        }
    }
    let posed = read("a.csv", b"pose,lip_x_mm,lip_y_mm,lip_z_mm\nrest,1,2,3\nsmile,4,5,6\n").recording;
    assert_eq!(posed.frame_names(), Some(&["rest".to_owned(), "smile".to_owned()][..]));
}

#[test]
fn what_wide_tables_cannot_be() {
    let none = ReadOptions::default();
    let good = "time_s,lip_x_mm,lip_y_mm,lip_z_mm\n0,1,2,3\n0.1,1,2,3\n";
    let bad = |old: &str, new: &str| good.replacen(old, new, 1).into_bytes();
    refused(
        "a.csv",
        &bad("_mm,lip_y_mm,lip_z_mm", ",lip_y,lip_z"),
        &none,
        &["a.csv:1", "no unit", "--unit mm"],
    );
    refused("a.csv", &bad("lip_y_mm", "lib_y_mm"), &none, &["a.csv:1", "no column lip y"]);
    refused("a.csv", &bad("lip_y_mm", "lip_x_mm"), &none, &["a.csv:1", "lip_x_mm"]);
    refused("a.csv", &bad("\n0.1", "\n0"), &none, &["a.csv:3", "0 s, not after"]);
    refused("a.csv", &bad("time_s", "frame"), &none, &["no times", "--rate-hz"]);
    refused("a.csv", &bad("0,1,2,3", "0,1,2"), &none, &["a.csv:2", "3 entries", "4"]);
    refused("a.csv", &bad("0,1,2,3", "0,1,2,3,4"), &none, &["a.csv:2", "5 entries", "4"]);
    refused("a.csv", &bad("0,1,2,3", "0,1,b,3"), &none, &["a.csv:2: lip y", "`b`"]);
}

/// The layouts that the programs' manuals show.
#[test]
fn exports_with_several_rows_of_names() {
    let nexus = "Trajectories\n100\n,,Ann:lip,,,Ann:chin,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,cm,cm,cm,cm,cm,cm\n\
                 11,0,.1,.2,.3,.4,.5,.6\n12,0,.1,.2,.3,,,\n";
    let devices =
        format!("Devices\n1000\n,,Force\nFrame,Sub Frame,Fx\n,,N\n1,0,3\n\n{nexus}\nModel Outputs\n100\nx\n");
    let motive = "Format Version,1.23,Take Name,a,Capture Frame Rate,100,Rotation Type,Quaternion,Length Units,Centimeters,Coordinate Space,Global\n\
                  \n,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Marker,Marker,Marker,Marker,Marker,Marker\n\
                  ,Name,head,head,head,head,head,head,head,head:1,head:1,head:1,head:1,lip,lip,lip,chin,chin,chin\n\
                  ,ID,1,1,1,1,1,1,1,2,2,2,2,3,3,3,4,4,4\n\
                  ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Position,Position,Position,Marker Quality,Position,Position,Position,Position,Position,Position\n\
                  Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,Y,Z,,X,Y,Z,X,Y,Z\n\
                  10,0.1,0,0,0,1,9,9,9,8,8,8,1,.1,.2,.3,.4,.5,.6\n11,0.11,0,0,0,1,9,9,9,8,8,8,1,.1,.2,.3,,,\n";
    let bare = "Frame#;Time;lip;;;chin;;\n;;X1;Y1;Z1;X2;Y2;Z2\n10;0,1;0,1;0,2;0,3;0,4;0,5;0,6\n11;0,11;0,1;0,2;0,3;;;\n";
    let cm = ReadOptions { unit: Some(LengthUnit::Centimetre), ..ReadOptions::default() };
    for (text, options) in [
        (nexus, ReadOptions::default()),
        (&devices, ReadOptions::default()),
        (motive, ReadOptions::default()),
        (bare, cm),
    ] {
        let r = parse_recording(text.as_bytes(), Path::new("a.csv"), &options)
            .unwrap_or_else(|e| panic!("{e}\n{text}"))
            .recording;
        assert_eq!((r.names(), r.times_s()), (&["lip".to_owned(), "chin".to_owned()][..], &[0.1, 0.11][..]));
        let expected = [Vec3::new(1., 2., 3.), Vec3::new(4., 5., 6.)];
        assert!(r.frame(0).iter().zip(expected).all(|(p, q)| (p.unwrap() - q).norm() < 1e-12));
        assert!(r.frame(1)[0].is_some() && r.frame(1)[1].is_none());
    }
    refused("a.csv", bare.as_bytes(), &ReadOptions::default(), &["no unit"]);
    let metres = motive.replace("Centimeters", "Furlongs");
    refused("a.csv", metres.as_bytes(), &ReadOptions::default(), &["a.csv:1", "Furlongs"]);
}

// MediaPipe

/// Where point `k` is, pixels; both irises are 10 pixels wide, and the outer corners of the eyes 3, 4 and 12 pixels apart.
fn pixel(k: usize) -> [f64; 3] {
    match k {
        33 => [300., 200., 5.],
        263 => [303., 204., -7.],
        469 | 474 => [300., 210., 0.],
        471 | 476 => [306., 218., 9.],
        _ => [100. + k as f64, 300. - k as f64, 0.5 * k as f64 - 20.],
    }
}

fn face(points: usize, [w, h]: [f64; 2]) -> Vec<[f64; 3]> {
    (0..points).map(pixel).map(|[x, y, z]| [x / w, y / h, z / w]).collect()
}

const SIZE: [f64; 2] = [640., 480.];

fn points_json(face: &[[f64; 3]]) -> String {
    let all: Vec<String> = face
        .iter()
        .map(|[x, y, z]| format!("{{\"x\":{x:e},\"y\":{y:e},\"z\":{z:e},\"visibility\":null}}"))
        .collect();
    format!("[{}]", all.join(","))
}

/// Every layout of JSON and tables gives the same face: up is up, towards the camera is forward, irises are 11.77 mm.
#[test]
fn faces_of_mediapipe_in_json_and_tables() {
    let face = face(478, SIZE);
    let json = points_json(&face);
    let arrays = format!(
        "[{}]",
        face.iter().map(|[x, y, z]| format!("[{x:e},{y:e},{z:e}]")).collect::<Vec<_>>().join(",")
    );
    let size = "\"width\":640,\"height\":480";
    let wide_heads: Vec<String> = (0..478).flat_map(|k| ["x", "y", "z"].map(|a| format!("{a}{k}"))).collect();
    let row = |f: &[[f64; 3]]| f.iter().flatten().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(",");
    let long: String =
        face.iter().enumerate().rev().map(|(k, [x, y, z])| format!("0,{k},{x:e},{y:e},{z:e}\n")).collect();
    let with_size = ReadOptions { image: Some(SIZE), ..ReadOptions::default() };
    let with_rate = ReadOptions { rate_hz: Some(20.), ..with_size };
    let none = ReadOptions::default();
    for (text, options, times, missing) in [
        (
            format!(
                "{{{size},\"frames\":[{{\"time_s\":0,\"landmarks\":{json}}},{{\"time_s\":0.05,\"landmarks\":[]}}]}}"
            ),
            none,
            2,
            true,
        ),
        (
            format!(
                "[{{\"timestamp_ms\":0,\"faceLandmarks\":[{json}],{size}}},{{\"timestamp_ms\":50,\"face_landmarks\":[{json}]}}]"
            ),
            none,
            2,
            false,
        ),
        (
            format!(
                "{{\"timestamp_ms\":0,\"multi_face_landmarks\":[{{\"landmark\":{json}}}]}}\n{{\"timestamp_ms\":50,\"multi_face_landmarks\":null}}\n"
            ),
            with_size,
            2,
            true,
        ),
        (format!("[[{json}],[{json}]]"), with_rate, 2, false),
        (format!("[{arrays},[]]"), with_rate, 2, true),
        (json.clone(), with_size, 1, false),
        (
            format!("time_s,{}\n0,{}\n0.05,{}\n", wide_heads.join(","), row(&face), ",".repeat(3 * 478 - 1)),
            with_size,
            2,
            true,
        ),
        (format!("time_s,landmark_index,x,y,z\n{long}"), with_size, 1, false),
    ] {
        let document =
            parse_recording(text.as_bytes(), Path::new("a.json"), &options).unwrap_or_else(|e| panic!("{e}"));
        let r = &document.recording;
        assert_eq!(document.format, RecordingFormat::MediaPipe);
        assert_eq!((r.names().len(), r.n_frames()), (478, times));
        assert!(times == 1 || r.times_s() == [0., 0.05]);
        assert!(times == 1 || r.frame(1).iter().all(|p| p.is_none() == missing));
        let scale = 11.77 / 10.;
        for k in 0..478 {
            let [x, y, z] = pixel(k);
            let expected = Vec3::new(x, -y, -z) * scale;
            assert!((r.frame(0)[k].unwrap() - expected).norm() < 1e-9, "{k}");
        }
        for (k, name) in [(61, "cheilion_r"), (291, "cheilion_l"), (2, "subnasale"), (5, "p5"), (477, "p477")]
        {
            assert_eq!(r.names()[k], name);
        }
        assert!(r.depth_weight() < 0.5);
        let RecordingFileWarning::VideoTracker { mm_a_pixel, .. } = document.warnings[0] else { panic!() };
        assert!((mm_a_pixel - scale).abs() < 1e-12);
        assert!(document.warnings[0].to_string().contains("symmetric"));
    }
}

#[test]
fn what_tells_the_size_of_a_face_in_a_video() {
    let text = points_json(&face(468, SIZE));
    let none = ReadOptions { image: Some(SIZE), ..ReadOptions::default() };
    refused("a.json", text.as_bytes(), &none, &["468 points", "no irises", "--length"]);
    let scale = ImageScale::Length { from: "exocanthion_r", to: "exocanthion_l", length_mm: 91. };
    let options = ReadOptions { scale, ..none };
    let r = parse_recording(text.as_bytes(), Path::new("a.json"), &options).unwrap().recording;
    assert!((r.frame(0)[33].unwrap() - r.frame(0)[263].unwrap()).norm() - 91. < 1e-9);
    assert!((r.frame(0)[33].unwrap() - Vec3::new(300., -200., -5.) * 7.).norm() < 1e-9);
    let scale = ImageScale::Length { from: "p4", to: "p468", length_mm: 91. };
    refused("a.json", text.as_bytes(), &ReadOptions { scale, ..none }, &["p468", "p467"]);
    let scale = ImageScale::Length { from: "p4", to: "p4", length_mm: 91. };
    refused("a.json", text.as_bytes(), &ReadOptions { scale, ..none }, &["no scale", "p4 to p4"]);
}

#[test]
fn what_mediapipe_cannot_be() {
    let good = points_json(&face(478, SIZE));
    let none = ReadOptions::default();
    let sized = ReadOptions { image: Some(SIZE), ..none };
    refused("a.json", good.as_bytes(), &none, &["--image 1920x1080", "width"]);
    refused("a.json", format!("[[{good}],[{good}]]").as_bytes(), &sized, &["no times", "--rate-hz"]);
    refused(
        "a.json",
        format!("{{\"faces\":[{good},{good}]}}").as_bytes(),
        &sized,
        &["frame 1", "several faces"],
    );
    refused("a.json", points_json(&face(400, SIZE)).as_bytes(), &sized, &["400 points", "468", "478"]);
    refused("a.json", points_json(&face(478, [2., 2.])).as_bytes(), &sized, &["no share of the image"]);
    let truncated = &good[..good.len() / 2];
    refused("a.json", truncated.as_bytes(), &sized, &["a.json:1", "no JSON", "EOF"]);
    refused("a.json", b"{\"a\": 1}", &sized, &["holds no face"]);
    refused("a.json", b"[1, [2], {}]", &sized, &["side by side"]);
    refused("a.json", b"[{\"x\": 1, \"z\": 2}]", &sized, &["lacks x or y"]);
    let hardly = format!("[{good}{}]", ",[]".repeat(100));
    let rated = ReadOptions { rate_hz: Some(30.), ..sized };
    refused("a.json", hardly.as_bytes(), &rated, &["one frame in 64"]);
    let backwards = format!("[{{\"t\":1,\"landmarks\":{good}}},{{\"t\":0,\"landmarks\":{good}}}]");
    refused("a.json", backwards.as_bytes(), &sized, &["0 s", "not after"]);
}

#[test]
fn a_recording_is_written_as_a_table_and_read_back() {
    let frames: [&[[f32; 4]]; 2] =
        [&[[0.1, -2e-7, 3e9, 0.], [1., 2., 3., 0.]], &[[1., 2., 3., -1.], [1., 2.5, 3., 0.]]];
    let r = read("a.c3d", &C3d::new(&["a,\"b\"", "c"], &frames).bytes()).recording;
    assert_eq!(read("a.csv", recording_csv(&r).as_bytes()).recording, r);
    let named = r.with_frame_names(vec!["rest".into(), "smile; open".into()]).unwrap();
    let back = read("a.csv", recording_csv(&named).as_bytes()).recording;
    assert_eq!((back.frame_names(), back.frame(1)), (named.frame_names(), named.frame(1)));
}

#[test]
fn the_program_tells_what_a_recording_holds_and_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.c3d");
    std::fs::write(&path, gaps(Processor::Mips, -1.).bytes()).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("modiolus").unwrap();
        let output = command.current_dir(folder.path()).arg("recording").args(arguments).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    };
    let (code, told, _) = run(&["a.c3d", "--out", "a.csv"]);
    assert_eq!(code, 0);
    for part in [
        "a.c3d: C3D in mm, 4 frames of 2 markers",
        "0.000 to 0.060 s at 50",
        "seen: 50.00 per cent",
        "Warnings\n- marker b",
    ] {
        assert!(told.contains(part), "{told}");
    }
    let (code, json, _) = run(&["a.csv", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((code, &json["frames"], &json["markers"][0]["longest_gap"]), (0, &4.into(), &2.into()));
    assert_eq!(json["markers"][0]["span_mm"], serde_json::json!([[10., 11.], [-21., -20.], [30., 31.]]));
    let (code, _, told) = run(&["a.csv", "--neutral", "a.c3d"]);
    assert_eq!(code, 2);
    assert!(told.contains("a.csv") && told.contains("--neutral"), "{told}");
    let (code, _, told) = run(&["a.csv", "--out", "a.csv"]);
    assert!(code == 2 && told.contains("a.csv would be replaced"), "{told}");
    assert_eq!(run(&["a.csv", "--unit", "inch"]).0, 2);
}

// Real data

fn data() -> PathBuf {
    let data = std::env::var_os("MODIOLUS_DATA").expect("MODIOLUS_DATA names the folder of the real data");
    PathBuf::from(data)
}

/// The TRC has three digits of a millimetre and five of a second.
#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn speech_is_the_same_in_c3d_and_trc() {
    let both = ["speech.c3d", "speech.trc"].map(|name| {
        let path = data().join("recording").join(name);
        read_recording(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    });
    let [a, b] = &both;
    let (a, b) = (&a.recording, &b.recording);
    assert_eq!((a.names(), a.n_frames(), a.names().len()), (b.names(), 900, 39));
    let (mut gaps, mut worst) = (0, 0f64);
    for f in 0..900 {
        assert!((a.times_s()[f] - b.times_s()[f]).abs() <= 0.51e-5);
        for (p, q) in a.frame(f).iter().zip(b.frame(f)) {
            assert_eq!(p.is_some(), q.is_some(), "frame {f}");
            gaps += usize::from(p.is_none());
            worst = p.zip(*q).map_or(worst, |(p, q)| worst.max((p - q).amax()));
        }
    }
    assert!(worst <= 0.000_51 + 0.000_07, "{worst} mm");
    assert!(gaps > 500, "{gaps}");
    for document in &both {
        for warning in &document.warnings {
            eprintln!("{warning}");
        }
    }
}

#[test]
#[ignore = "needs MODIOLUS_DATA"]
fn expressions_of_a_scan_come_in_over_their_neutral_positions() {
    let folder = data().join("ict_scan");
    let neutral = folder.join("markers_neutral.csv");
    let options = ReadOptions { neutral: Some(&neutral), ..ReadOptions::default() };
    let r =
        read_recording(&folder.join("expressions.csv"), &options).unwrap_or_else(|e| panic!("{e}")).recording;
    assert_eq!((r.names().len(), r.n_frames()), (202, 13));
    let funnel = r.frame_named("mouthFunnel").unwrap();
    let m0 = r.names().iter().position(|n| n == "m0").unwrap();
    let expected = Vec3::new(0., 8.791 + 6.068, 5.719 + 7.027);
    assert!((r.frame(funnel)[m0].unwrap() - expected).norm() < 1e-9);
    let speech =
        read_recording(&data().join("recording/speech_neutral.csv"), &ReadOptions::default()).unwrap();
    assert_eq!((speech.recording.names().len(), speech.recording.n_frames()), (39, 1));
}
