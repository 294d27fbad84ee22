//! Sheets of several pictures: where a muscle's force goes, and what it does.

use super::legend::BAR_SPACE;
use super::scene::panel;
use super::{Drawing, Image, LETTER, LINE, RenderError, Scene, Show, View};
use crate::face::{Face, Muscle, Pose, without_side};
use crate::units::Vec3;

/// The names of the face's muscles without sides, each once, in order.
pub fn muscle_stems(face: &Face) -> Vec<String> {
    let mut stems: Vec<String> = Vec::new();
    for muscle in &face.muscles {
        let name = without_side(&muscle.name);
        if !stems.iter().any(|s| s == name) {
            stems.push(name.to_owned());
        }
    }
    stems
}

/// What one muscle does on both sides.
#[derive(Clone, Debug)]
pub struct Action {
    /// The muscle's name without side.
    pub muscle: String,
    /// Activations (m).
    pub activation: Vec<f64>,
    /// Displacement (3n), mm.
    pub displacement: Vec<f64>,
    /// How it was computed, in a few words.
    pub conditions: String,
}

/// Pixels to the millimetre: of a muscle's sheet, and of the sheet of all.
const SCALE: f64 = 1.8;
const SMALL: f64 = 0.82;
/// The same of poses beside each other.
const BESIDE: f64 = 2.2;
/// Width and height of a panel of forces, pixels.
const FORCES: (usize, usize) = (316, 272);
/// Room around what a panel of forces frames, mm.
const AROUND_MM: f64 = 14.;

/// The seed's figure 4 for one muscle: its course, the face and the profile that it makes, with the rest's
/// outline, and how far the skin moves.
///
/// # Errors
/// As [`Scene::draw`].
pub fn action_sheet(scene: &Scene<'_>, action: &Action) -> Result<Image, RenderError> {
    let only = [action.muscle.clone()];
    let (front, profile) = (scene.panel(View::Front, SCALE), scene.panel(View::Profile, SCALE));
    let height = front.1.max(profile.1) + LINE;
    let base = Drawing {
        size: (front.0, height),
        pixels_per_mm: Some(SCALE),
        legend: false,
        activation: Some(&action.activation),
        ..Drawing::default()
    };
    let moved = Drawing { displacement: Some(&action.displacement), ..base.clone() };
    let course = Show { skin: true, muscles: true, ..Show::default() };
    let far = Show { displacement: true, ..Show::FACE };
    let panels = [
        Drawing { show: course, only: &only, ..base.clone() },
        moved.clone(),
        Drawing { view: View::Profile, rest_outline: true, size: (profile.0, height), ..moved.clone() },
        Drawing { show: far, legend: true, size: (front.0 + 64, height), ..moved },
    ];
    let mut sheet = Image::new(panels.iter().map(|p| p.size.0).sum(), height + 2 * LINE + 4);
    let mut x = 0;
    for panel in panels {
        sheet.place(x, 2 * LINE + 4, &scene.draw(&panel)?);
        x += panel.size.0;
    }
    let largest = scene.largest_mm(&action.displacement);
    sheet.write(8, 4, &action.muscle.replace('_', " "), true, [30; 3]);
    let line = format!("{}; largest movement of the skin {largest:.1} mm", action.conditions);
    sheet.write(8, 4 + LINE as i64, &line, false, [70; 3]);
    Ok(sheet)
}

/// The seed's figure 3: where the force of each of `muscles` (names without side) goes at full activation, from
/// the front and from the left front. Each arrow sums the forces of a short stretch of the bundle.
///
/// # Errors
/// As [`Scene::draw`].
pub fn force_sheet(scene: &Scene<'_>, muscles: &[&str]) -> Result<Image, RenderError> {
    let mut sheet = Image::new(FORCES.0 * 2, FORCES.1 * muscles.len());
    for (row, name) in muscles.iter().enumerate() {
        let all = &scene.face().muscles;
        let named: Vec<&Muscle> = all.iter().filter(|m| without_side(&m.name) == *name).collect();
        let Some(first) = named.first() else { continue };
        let side = if named.len() > 1 { " a side" } else { "" };
        let title =
            vec![name.replace('_', " "), format!("full activation, {:.1} N{side}", first.max_force_n)];
        let activation: Vec<f64> =
            all.iter().map(|m| f64::from(u8::from(without_side(&m.name) == *name))).collect();
        let points = named.iter().flat_map(|m| &m.fibres).flat_map(|f| &f.points);
        let corners = [Vec3::repeat(AROUND_MM), Vec3::repeat(-AROUND_MM)];
        let both: Vec<Vec3> = points.flat_map(|p| corners.map(|c| p + c)).collect();
        let left: Vec<Vec3> = both.iter().copied().filter(|p| p.x > 0.).collect();
        let views = [(View::Front, &both, title), (View::ThreeQuarter, &left, Vec::new())];
        for (column, (view, focus, title)) in views.iter().enumerate() {
            let drawing = Drawing {
                view: *view,
                size: FORCES,
                show: Show { skin: true, muscles: true, forces: true, ..Show::default() },
                activation: Some(&activation),
                only: &[(*name).to_owned()],
                focus,
                title,
                ..Drawing::default()
            };
            sheet.place(column * FORCES.0, row * FORCES.1, &scene.draw(&drawing)?);
        }
    }
    Ok(sheet)
}

/// Every action on one sheet: face, and profile over the outline of the rest.
///
/// # Errors
/// As [`Scene::draw`].
pub fn contact_sheet(scene: &Scene<'_>, actions: &[Action]) -> Result<Image, RenderError> {
    let columns = 3;
    let sizes = [View::Front, View::Profile].map(|view| (view, scene.panel(view, SMALL)));
    let longest = actions.iter().map(|a| a.muscle.chars().count()).max().unwrap_or(0);
    let width = sizes.iter().map(|(_, size)| size.0).sum::<usize>().max(longest * LETTER + 12);
    let height = sizes.iter().map(|(_, size)| size.1).max().unwrap_or(0);
    let mut sheet = Image::new(columns * width, actions.len().div_ceil(columns) * (height + LINE + 4));
    for (k, action) in actions.iter().enumerate() {
        let (left, y) = (k % columns * width, k / columns * (height + LINE + 4));
        let mut x = left;
        for (view, size) in sizes {
            let drawing = Drawing {
                view,
                size: (size.0, height),
                pixels_per_mm: Some(SMALL),
                displacement: Some(&action.displacement),
                legend: false,
                rest_outline: view == View::Profile,
                ..Drawing::default()
            };
            sheet.place(x, y + LINE + 4, &scene.draw(&drawing)?);
            x += size.0;
        }
        sheet.write(left as i64 + 6, y as i64 + 3, &action.muscle.replace('_', " "), true, [30; 3]);
    }
    Ok(sheet)
}

/// One pose from the front, the left front and the left, at one scale.
///
/// # Errors
/// As [`Scene::draw`].
pub fn three_views(scene: &Scene<'_>, drawing: &Drawing<'_>) -> Result<Image, RenderError> {
    let views = [View::Front, View::ThreeQuarter, View::Profile].map(|view| {
        let (width, height) = scene.panel(view, SCALE);
        let has_bar = view == View::Front && drawing.show.displacement;
        (view, (width + if has_bar { BAR_SPACE as usize } else { 0 }, height))
    });
    let height = views.iter().map(|(_, size)| size.1).max().unwrap_or(0) + LINE;
    let mut sheet = Image::new(views.iter().map(|(_, size)| size.0).sum(), height);
    let mut x = 0;
    for (view, size) in views {
        let legend = view == View::Front;
        let panel =
            Drawing { view, size: (size.0, height), pixels_per_mm: Some(SCALE), legend, ..drawing.clone() };
        sheet.place(x, 0, &scene.draw(&panel)?);
        x += size.0;
    }
    Ok(sheet)
}

/// A face before and after surgery, side by side from the front and the left: at rest, with the outline of the face before
/// over both profiles, and in a row below for each of `moved`, what it is called and the displacements (3n, mm) of the two.
///
/// # Errors
/// As [`Scene::draw`].
pub fn before_and_after(
    faces: [&Scene<'_>; 2],
    moved: &[(&str, [Option<&[f64]>; 2])],
) -> Result<Image, RenderError> {
    let views = [View::Front, View::Profile].map(|view| (view, faces[0].panel(view, SCALE)));
    let height = views.iter().map(|(_, size)| size.1).max().unwrap_or(0) + LINE;
    let width: usize = views.iter().map(|(_, size)| size.0).sum();
    // Every panel frames the face before, so that what moved is seen to.
    let framed = faces[0].rest_points();
    let head = LINE + 4;
    let rows = [("rest", [None; 2])].into_iter().chain(moved.iter().copied());
    let mut sheet = Image::new(2 * width, (1 + moved.len()) * (height + head));
    for (row, (name, fields)) in rows.enumerate() {
        let (mut x, y) = (0, row * (height + head));
        for ((scene, u), when) in faces.into_iter().zip(fields).zip(["before", "after"]) {
            sheet.write(x as i64 + 8, y as i64 + 3, &format!("{when}, {name}"), true, [30; 3]);
            for (view, size) in views {
                let drawing = Drawing {
                    view,
                    size: (size.0, height),
                    pixels_per_mm: Some(SCALE),
                    legend: view == View::Front,
                    displacement: u,
                    focus: &framed,
                    outline_of: (view == View::Profile && row == 0).then_some((faces[0], None)),
                    ..Drawing::default()
                };
                sheet.place(x, y + head, &scene.draw(&drawing)?);
                x += size.0;
            }
        }
    }
    Ok(sheet)
}

/// A pose of a sheet; without a displacement its place stays empty.
#[derive(Clone, Debug)]
pub struct TitledPose<'a> {
    /// What is written above it.
    pub title: String,
    /// Displacement (3n), mm.
    pub displacement: Option<&'a [f64]>,
    /// Where the bones are.
    pub pose: Pose,
}

/// Poses of one face beside each other, each from the front and in profile over the outline of the rest, at one scale.
///
/// # Errors
/// As [`Scene::draw`].
pub fn front_and_profile(scene: &Scene<'_>, poses: &[TitledPose<'_>]) -> Result<Image, RenderError> {
    // Framed alike, with whatever moves farthest.
    let mut framed = scene.rest_points();
    for pose in poses {
        framed.extend(scene.points(pose.displacement));
    }
    let sizes = [View::Front, View::Profile].map(|view| (view, panel(view, &framed, BESIDE)));
    let height = sizes.iter().map(|(_, size)| size.1).max().unwrap_or(0) + LINE;
    let width: usize = sizes.iter().map(|(_, size)| size.0).sum();
    let head = LINE + 4;
    let mut sheet = Image::new(poses.len() * width, height + head);
    for (k, pose) in poses.iter().enumerate() {
        let mut x = k * width;
        let title: String = pose.title.chars().take((width / LETTER).saturating_sub(2)).collect();
        sheet.write(x as i64 + 8, 3, &title, true, [30; 3]);
        let Some(displacement) = pose.displacement else { continue };
        for (view, size) in sizes {
            let drawing = Drawing {
                view,
                size: (size.0, height),
                pixels_per_mm: Some(BESIDE),
                legend: view == View::Front,
                displacement: Some(displacement),
                pose: pose.pose.clone(),
                focus: &framed,
                rest_outline: view == View::Profile,
                ..Drawing::default()
            };
            sheet.place(x, head, &scene.draw(&drawing)?);
            x += size.0;
        }
    }
    Ok(sheet)
}

/// A face under its displacement (3n, mm), with its bones at a pose.
#[derive(Clone, Debug)]
pub struct MovedScene<'a> {
    /// The face.
    pub scene: &'a Scene<'a>,
    /// Displacement (3n), mm.
    pub displacement: &'a [f64],
    /// Where the bones are.
    pub pose: Pose,
    /// What is written above it.
    pub title: String,
}

/// Two moved faces side by side from one view, at one scale and framed alike, the outline of the first over the second.
///
/// # Errors
/// As [`Scene::draw`].
pub fn side_by_side(faces: &[MovedScene<'_>; 2], view: View) -> Result<Image, RenderError> {
    let first = &faces[0];
    let size = first.scene.panel(view, SCALE);
    let height = size.1 + LINE;
    let framed = first.scene.rest_points();
    let head = LINE + 4;
    let mut sheet = Image::new(2 * size.0, height + head);
    for (k, face) in faces.iter().enumerate() {
        let drawing = Drawing {
            view,
            size: (size.0, height),
            pixels_per_mm: Some(SCALE),
            displacement: Some(face.displacement),
            pose: face.pose.clone(),
            focus: &framed,
            outline_of: (k == 1).then_some((first.scene, Some(first.displacement))),
            ..Drawing::default()
        };
        let most = (size.0 / LETTER).saturating_sub(2);
        let title: String = face.title.chars().take(most).collect();
        sheet.write((k * size.0) as i64 + 8, 3, &title, true, [30; 3]);
        sheet.place(k * size.0, head, &face.scene.draw(&drawing)?);
    }
    Ok(sheet)
}
