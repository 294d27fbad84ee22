//! A face ready to be drawn, and the drawing of it.

use rayon::prelude::*;

use super::bundles::{Bundles, colours};
use super::cavity::cavity;
use super::colour::{ColourMap, Rgb, mix, srgb, to_srgb};
use super::figures::muscle_stems;
use super::legend;
use super::occlusion::openness;
use super::shading::{ENAMEL, LIP, MATT, SKIN, shade};
use super::skin::Skin;
use super::solid::Solid;
use super::vermilion::Vermilion;
use super::{Camera, Hit, Image, LINE, Layer, Margins, Projected, Refined, RenderError, Show, View};
use crate::face::{Face, Pose, without_side};
use crate::mesh::Site;
use crate::units::Vec3;

/// Fewest pixels of a side.
pub const MIN_SIDE: usize = 16;
/// Most pixels of a side: nine samples a pixel of the largest picture still fit into some gigabytes.
pub const MAX_SIDE: usize = 4096;
/// Samples to a pixel along each side.
const SAMPLES: usize = 3;
/// Opacity of skin that is seen through, facing the viewer and edge on.
const VEIL: (f32, f32) = (0.30, 0.85);
/// The same over teeth and muscles, whose colours must be told apart.
const THIN_VEIL: (f32, f32) = (0.12, 0.7);

/// Colours of skin, red of the lips and mucosa.
fn tints() -> [Rgb; 3] {
    [srgb(229, 180, 156), srgb(199, 112, 106), srgb(150, 62, 62)]
}

/// What to draw and how.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    /// Where from.
    pub view: View,
    /// Width and height, pixels.
    pub size: (usize, usize),
    /// What.
    pub show: Show,
    /// Displacement (3n), mm; `None` is the face at rest.
    pub displacement: Option<&'a [f64]>,
    /// Where the bones are: teeth move with them.
    pub pose: Pose,
    /// Activations (m) for the colours of muscles and the sizes of forces.
    pub activation: Option<&'a [f64]>,
    /// Only muscles whose name without side is among these are drawn; empty is all.
    pub only: &'a [String],
    /// A length of each node (n), mm, that the colour map shows in place of how far the skin moves; where it is NaN the skin has
    /// its own colour.
    pub length_mm: Option<&'a [f64]>,
    /// Largest length of the colour map, mm; `None` is that of this drawing.
    pub largest_mm: Option<f64>,
    /// Pixels to the millimetre; `None` is as large as the picture allows.
    pub pixels_per_mm: Option<f64>,
    /// Only what surrounds these points (mm) is framed; empty is the whole face.
    pub focus: &'a [Vec3],
    /// Lines written above the face, the first in bold.
    pub title: &'a [String],
    /// Whether to draw scale bar and legends.
    pub legend: bool,
    /// Whether to trace the outline of the face at rest.
    pub rest_outline: bool,
    /// Another face whose outline is traced too, under its displacement (3n, mm) or at rest.
    pub outline_of: Option<(&'a Scene<'a>, Option<&'a [f64]>)>,
}

impl Default for Drawing<'_> {
    fn default() -> Self {
        Self {
            view: View::Front,
            size: (640, 600),
            show: Show::FACE,
            displacement: None,
            pose: Pose::rest(),
            activation: None,
            only: &[],
            length_mm: None,
            largest_mm: None,
            pixels_per_mm: None,
            focus: &[],
            title: &[],
            legend: true,
            rest_outline: false,
            outline_of: None,
        }
    }
}

/// A face with what does not depend on the drawing: its smooth skin and where its fibres are embedded.
#[derive(Clone, Debug)]
pub struct Scene<'f> {
    face: &'f Face,
    skin: Skin,
    bundles: Bundles,
    vermilion: Vermilion,
    stems: Vec<String>,
}

impl<'f> Scene<'f> {
    /// Prepares `face`.
    pub fn new(face: &'f Face) -> Self {
        Self {
            face,
            skin: Skin::new(face),
            bundles: Bundles::new(face),
            vermilion: Vermilion::new(face),
            stems: muscle_stems(face),
        }
    }

    /// The face.
    pub fn face(&self) -> &'f Face {
        self.face
    }

    /// The smooth skin: what carries each vertex, and the quadrilaterals.
    pub fn surface(&self) -> &Refined {
        &self.skin.surface
    }

    /// Colour of each vertex of the smooth skin, before any light falls on it: skin, lips and mucosa.
    pub fn tint(&self) -> Vec<Rgb> {
        let [skin, lip, mucosa] = tints();
        let of = |(site, inside): (&Site, &f32)| {
            mix(mix(skin, lip, self.vermilion.share(site.position)), mucosa, inside.clamp(0., 1.))
        };
        self.skin.surface.sites.iter().zip(&self.skin.mucosa).map(of).collect()
    }

    /// What carries the points of each fibre of each muscle.
    pub fn fibres(&self) -> &[Vec<Vec<Site>>] {
        &self.bundles.sites
    }

    /// The points of the smooth skin at rest, mm.
    pub(super) fn rest_points(&self) -> Vec<Vec3> {
        self.skin.surface.sites.iter().map(|s| s.position).collect()
    }

    /// The points of the smooth skin under `u` (3n), or at rest, mm.
    pub(super) fn points(&self, u: Option<&[f64]>) -> Vec<Vec3> {
        self.rest_points().iter().zip(self.skin.displacement(u)).map(|(p, u)| p + u).collect()
    }

    /// Greatest displacement of the smooth skin under `u` (3n), mm.
    pub fn largest_mm(&self, u: &[f64]) -> f64 {
        self.skin.displacement(Some(u)).iter().map(Vec3::norm).fold(0., f64::max)
    }

    /// Width and height of a picture without legends that holds the face at rest from `view` at a scale, pixels.
    pub fn panel(&self, view: View, pixels_per_mm: f64) -> (usize, usize) {
        panel(view, &self.rest_points(), pixels_per_mm)
    }

    /// Whether the drawing names the muscles by colour.
    fn names(&self, drawing: &Drawing<'_>) -> bool {
        let active = drawing.activation.is_some_and(|a| a.iter().any(|a| *a > 0.));
        drawing.legend && drawing.show.muscles && drawing.only.is_empty() && !active
    }

    /// The camera of a drawing: it frames the face at rest, so that a moved face is seen to move; where bones are moved,
    /// such as an open jaw, what goes with them is framed, too.
    fn camera(&self, drawing: &Drawing<'_>) -> Camera {
        let head = 8. + (drawing.title.len() * LINE) as f64;
        // Panels of one figure stand on one line, with legends or without.
        let legend = if drawing.legend || drawing.pixels_per_mm.is_some() { 24. } else { 8. };
        let right = if drawing.legend && drawing.show.displacement { legend::BAR_SPACE } else { 8. };
        let left = if self.names(drawing) { legend::names_space(&self.stems) } else { 8. };
        let margins = Margins { left, top: head, right, bottom: legend };
        let points: Vec<Vec3> = match drawing.focus {
            [] if drawing.pose.is_rest() => self.rest_points(),
            [] => {
                let moved = self.points(drawing.displacement);
                self.rest_points().into_iter().chain(moved).collect()
            }
            focus => focus.to_vec(),
        };
        let camera = Camera::fit(drawing.view, &points, drawing.size, margins);
        drawing.pixels_per_mm.map_or(camera, |scale| camera.at_scale(scale))
    }

    /// Draws the picture; the same whatever the number of threads.
    ///
    /// # Errors
    /// [`RenderError::Size`], and [`RenderError::Length`] or [`RenderError::NotFinite`] for a displacement,
    /// activation or length that is not this face's.
    pub fn draw(&self, drawing: &Drawing<'_>) -> Result<Image, RenderError> {
        self.check(drawing)?;
        let show = drawing.show;
        let camera = self.camera(drawing);
        let fine = camera.enlarged(SAMPLES as f64);
        let size = (drawing.size.0 * SAMPLES, drawing.size.1 * SAMPLES);

        let mut solid = Solid::default();
        let muscle_colours = colours(self.face, &self.stems, drawing.activation);
        let veil = show.sees_through();
        let mut n_teeth = 0;
        if show.teeth {
            let teeth = self.face.teeth_at(&drawing.pose);
            teeth.iter().for_each(|t| solid.surface(&t.surface, srgb(246, 240, 226)));
            n_teeth = solid.corners.len();
            // Lips that part show the inside of the mouth; behind skin that is seen through it would hide the rest.
            if show.skin && !veil {
                cavity(&teeth, |outward| camera.turn(outward).z > 0., &mut solid);
            }
        }
        let wanted = |m: usize| {
            let stem = without_side(&self.face.muscles[m].name);
            drawing.only.is_empty() || drawing.only.iter().any(|o| o == stem)
        };
        if show.muscles {
            let colour = |m: usize| wanted(m).then_some(muscle_colours[m]);
            self.bundles.tubes(self.face, drawing.displacement, colour, &mut solid);
        }
        let mut mm_per_n = None;
        let mut arrows = Solid::default();
        if show.forces {
            let given = drawing.activation.filter(|a| a.iter().any(|a| *a > 0.));
            let activation: Vec<f64> = (0..self.face.muscles.len())
                .map(|m| if wanted(m) { given.map_or(1., |a| a[m]) } else { 0. })
                .collect();
            mm_per_n = self.bundles.arrows(self.face, drawing.displacement, &activation, &mut arrows);
        }

        let moved = self.skin.displacement(drawing.displacement);
        let points: Vec<Vec3> =
            self.skin.surface.sites.iter().zip(&moved).map(|(s, u)| s.position + u).collect();
        let lengths: Vec<f64> = match drawing.length_mm {
            Some(length) => self.skin.surface.sites.iter().map(|site| site.value(length)).collect(),
            None => moved.iter().map(Vec3::norm).collect(),
        };
        let largest = drawing
            .largest_mm
            .unwrap_or_else(|| legend::round_up(lengths.iter().copied().fold(0., f64::max)));
        let corners = |points: &[Vec3]| -> Vec<[Vec3; 3]> {
            self.skin.triangles.iter().map(|t| t.map(|v| points[v])).collect()
        };
        let solid_layer = layer(size, &fine, solid.corners.iter().copied());
        let skin_layer = if show.skin {
            layer(size, &fine, corners(&points).into_iter())
        } else {
            Layer::new(size.0, size.1, &[])
        };
        let solid_normals = seen_normals(&solid_layer, &fine, |t| solid.normals[t]);
        let solid_open = openness(&solid_layer, &skin_layer, &solid_normals, fine.pixels_per_mm());
        let lit = |index: usize| -> Option<Rgb> {
            let t = solid_layer.hits[index]?.triangle as usize;
            let finish = if t < n_teeth { ENAMEL } else { MATT };
            // Skin that is seen through throws no shade.
            let open = if veil { 1. } else { solid_open[index].powi(2) };
            Some(shade(solid.colours[t], finish, solid_normals[index], open))
        };
        let mut samples: Vec<Rgb>;
        if show.skin {
            let normals = self.skin.normals(&points);
            let seen = seen_normals(&skin_layer, &fine, |t| self.skin.triangles[t].map(|v| normals[v]));
            let open = openness(&skin_layer, &skin_layer, &seen, fine.pixels_per_mm());
            let (map, tints) = (ColourMap::new(), tints());
            let paint = |hit: &Hit, n: Vec3, open: f32| -> Rgb {
                let t = self.skin.triangles[hit.triangle as usize];
                let mucosa: f32 = (0..3).map(|k| hit.weights[k] * self.skin.mucosa[t[k]]).sum();
                let far = match drawing.length_mm {
                    Some(_) => (0..3).map(|k| f64::from(hit.weights[k]) * lengths[t[k]]).sum(),
                    None => blend(t.map(|v| moved[v]), hit).norm(),
                };
                if show.displacement && !far.is_nan() {
                    return shade(map.at(far / largest.max(1e-9)), MATT, n, open);
                }
                let [a, b, c] = t.map(|v| points[v]);
                if fine.turn((b - a).cross(&(c - a))).z < 0. {
                    // The far side, as of a mask: of the mucosa within the mouth, of the skin past its border.
                    return shade(mix(tints[0], tints[2], mucosa.clamp(0., 1.)), MATT, n, 0.5 * open);
                }
                let rest = blend(t.map(|v| self.skin.surface.sites[v].position), hit);
                let red = self.vermilion.share(rest);
                let skin = shade(tints[0], SKIN, n, open);
                let lip = shade(tints[1], LIP, n, open);
                let inside = shade(tints[2], LIP, n, 0.6 * open);
                mix(mix(skin, lip, red), inside, mucosa.clamp(0., 1.))
            };
            samples = (0..size.0 * size.1)
                .into_par_iter()
                .map(|index| {
                    let behind = lit(index);
                    let Some(hit) = skin_layer.hits[index] else { return behind.unwrap_or([1.; 3]) };
                    if let (Some(colour), Some(solid)) = (behind, solid_layer.hits[index])
                        && solid.depth > hit.depth
                    {
                        return colour;
                    }
                    let n = seen[index];
                    let colour = paint(&hit, n, open[index]);
                    if !veil {
                        return colour;
                    }
                    let edge = (1. - n.z.abs() as f32).powi(2);
                    let veil = if behind.is_some() { THIN_VEIL } else { VEIL };
                    mix(behind.unwrap_or([1.; 3]), colour, veil.0 + edge * (veil.1 - veil.0))
                })
                .collect();
        } else {
            samples = (0..size.0 * size.1).into_par_iter().map(|k| lit(k).unwrap_or([1.; 3])).collect();
        }
        if mm_per_n.is_some() {
            // Over everything: an arrow that the tissue hides says nothing.
            let over = layer(size, &fine, arrows.corners.iter().copied());
            let normals = seen_normals(&over, &fine, |t| arrows.normals[t]);
            samples.par_iter_mut().enumerate().for_each(|(k, sample)| {
                if let Some(hit) = over.hits[k] {
                    *sample = shade(arrows.colours[hit.triangle as usize], MATT, normals[k], 1.);
                }
            });
        }
        let own = drawing.rest_outline.then_some((self, None));
        for (other, u) in own.into_iter().chain(drawing.outline_of) {
            let points = other.points(u);
            let corners = other.skin.triangles.iter().map(|t| t.map(|v| points[v]));
            outline(&layer(size, &fine, corners), &mut samples);
        }
        let mut image = shrink(&samples, size);
        if drawing.legend {
            legend::scale_bar(&mut image, camera.pixels_per_mm());
            if show.displacement {
                legend::colour_bar(&mut image, largest);
            }
            if let Some(mm_per_n) = mm_per_n {
                legend::force_bar(&mut image, camera.pixels_per_mm() * mm_per_n);
            }
            if drawing.view == View::Front {
                legend::sides(&mut image, if show.displacement { legend::BAR_SPACE } else { 8. });
            }
            if show.muscles && drawing.activation.is_some_and(|a| a.iter().any(|a| *a > 0.)) {
                legend::activation_bar(&mut image, drawing.title.len());
            }
            if self.names(drawing) {
                legend::names(&mut image, &self.stems, drawing.title.len());
            }
        }
        for (k, line) in drawing.title.iter().enumerate() {
            image.write(8, (6 + k * LINE) as i64, line, k == 0, [30; 3]);
        }
        Ok(image)
    }

    fn check(&self, drawing: &Drawing<'_>) -> Result<(), RenderError> {
        let (width, height) = drawing.size;
        let side = |n: usize| (MIN_SIDE..=MAX_SIDE).contains(&n);
        if !side(width) || !side(height) {
            return Err(RenderError::Size { width, height, least: MIN_SIDE, most: MAX_SIDE });
        }
        let (n, m) = (3 * self.face.mesh.n_nodes(), self.face.muscles.len());
        if let Some(length) = drawing.length_mm {
            let (what, found, expected) = ("length", length.len(), n / 3);
            if found != expected {
                return Err(RenderError::Length { what, found, expected });
            }
            // What is NaN is none.
            if let Some(index) = length.iter().position(|v| v.is_infinite()) {
                return Err(RenderError::NotFinite { what, index });
            }
        }
        for (what, values, expected) in
            [("displacement", drawing.displacement, n), ("activation", drawing.activation, m)]
        {
            let Some(values) = values else { continue };
            if values.len() != expected {
                return Err(RenderError::Length { what, found: values.len(), expected });
            }
            if let Some(index) = values.iter().position(|v| !v.is_finite()) {
                return Err(RenderError::NotFinite { what, index });
            }
        }
        Ok(())
    }
}

/// Width and height of a picture without legends that holds `points` (mm) from `view` at a scale, pixels.
pub(super) fn panel(view: View, points: &[Vec3], pixels_per_mm: f64) -> (usize, usize) {
    let camera = Camera::fit(view, points, (1, 1), Margins::default()).at_scale(pixels_per_mm);
    let seen: Vec<_> = points.iter().map(|p| camera.project(*p)).collect();
    let span = |along: &dyn Fn(&Projected) -> f64| {
        let (lo, hi) =
            seen.iter().map(along).fold((f64::MAX, f64::MIN), |(lo, hi), t| (lo.min(t), hi.max(t)));
        (hi - lo).clamp(0., MAX_SIDE as f64 - 16.).ceil() as usize + 16
    };
    (span(&|p| p.x), span(&|p| p.y))
}

fn layer(size: (usize, usize), camera: &Camera, corners: impl Iterator<Item = [Vec3; 3]>) -> Layer {
    let triangles: Vec<_> = corners.map(|t| t.map(|p| camera.project(p))).collect();
    Layer::new(size.0, size.1, &triangles)
}

fn blend(corners: [Vec3; 3], hit: &Hit) -> Vec3 {
    corners.iter().zip(hit.weights).map(|(v, w)| v * f64::from(w)).sum()
}

/// Unit normal that each sample sees, in the picture's axes; zero where it sees nothing.
fn seen_normals(layer: &Layer, camera: &Camera, normals: impl Fn(usize) -> [Vec3; 3] + Sync) -> Vec<Vec3> {
    let seen = |hit: &Option<Hit>| match hit {
        None => Vec3::zeros(),
        Some(hit) => {
            let n = camera.turn(blend(normals(hit.triangle as usize), hit));
            n.try_normalize(0.).unwrap_or_else(Vec3::z)
        }
    };
    layer.hits.par_iter().map(seen).collect()
}

/// Darkens the samples along the border of what `layer` covers.
fn outline(layer: &Layer, samples: &mut [Rgb]) {
    let (width, height) = (layer.width, layer.height);
    let covered = |x: usize, y: usize| layer.hits[y * width + x].is_some();
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            if around.iter().any(|&(u, v)| covered(u, v) != covered(x, y)) {
                samples[y * width + x] = [0.03, 0.05, 0.12];
            }
        }
    }
}

/// The mean of the samples of each pixel, in linear light.
fn shrink(samples: &[Rgb], size: (usize, usize)) -> Image {
    let mut image = Image::new(size.0 / SAMPLES, size.1 / SAMPLES);
    let width = image.width;
    image.pixels.par_iter_mut().enumerate().for_each(|(k, pixel)| {
        let (x, y) = (SAMPLES * (k % width), SAMPLES * (k / width));
        let mut sum = [0.; 3];
        for row in y..y + SAMPLES {
            for sample in &samples[row * size.0 + x..][..SAMPLES] {
                (0..3).for_each(|c| sum[c] += sample[c].clamp(0., 1.));
            }
        }
        // Odd values only: a step that nobody sees, and files a quarter smaller.
        *pixel = to_srgb(sum.map(|c| c / (SAMPLES * SAMPLES) as f32)).map(|c| c | 1);
    });
    image
}
