//! A moved face for other programs in three dimensions: binary glTF 2.0.

use serde_json::{Value, json};

use super::Motion;
use crate::face::Face;
use crate::render::{Refined, Rgb, Scene};
use crate::units::Vec3;

/// Seconds from rest to the answer.
const LOADING_S: f32 = 2.;
/// What `bufferView.target` and `accessor.componentType` are called in the specification.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// Millimetres to the metres of glTF.
const METRES: f64 = 1e-3;
/// The morph target that the superposition of the muscles lacks at the answer.
const REMAINDER: &str = "remainder";

/// The binary part, as it grows, and what lies in it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, target: Option<u32>, bytes: impl Iterator<Item = u8>) -> usize {
        let from = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": from, "byteLength": self.bytes.len() - from });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Vectors of the vertices; with their bounds, which positions need.
    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let view = self.view(Some(ARRAY_BUFFER), vectors.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let bound = |start: f32, pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|c| f64::from(vectors.iter().fold(start, |bound, v| pick(bound, v[c]))))
        };
        let (min, max) = (bound(f32::MAX, f32::min), bound(f32::MIN, f32::max));
        let count = vectors.len();
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC3", "min": min, "max": max
        }))
    }

    fn triangles(&mut self, triangles: &[[usize; 3]]) -> usize {
        let bytes = triangles.iter().flatten().flat_map(|v| (*v as u32).to_le_bytes());
        let view = self.view(Some(ELEMENT_ARRAY_BUFFER), bytes);
        let count = 3 * triangles.len();
        self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"
        }))
    }

    /// Numbers of an animation; `bounded` where they are times.
    fn scalars(&mut self, values: &[f32], bounded: bool) -> usize {
        let view = self.view(None, values.iter().flat_map(|x| x.to_le_bytes()));
        let count = values.len();
        let mut accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": "SCALAR" });
        if let (true, [first, .., last]) = (bounded, values) {
            accessor["min"] = json!([f64::from(*first)]);
            accessor["max"] = json!([f64::from(*last)]);
        }
        self.accessor(accessor)
    }

    /// The surface `points` (mm) with these triangles as a primitive of `material`.
    fn primitive(
        &mut self,
        points: &[Vec3],
        triangles: &[[usize; 3]],
        tint: Option<&[Rgb]>,
        material: usize,
    ) -> Value {
        let mut normals = vec![Vec3::zeros(); points.len()];
        for t in triangles {
            let [a, b, c] = t.map(|v| points[v]);
            t.iter().for_each(|&v| normals[v] += (b - a).cross(&(c - a)));
        }
        let unit = |n: &Vec3| n.try_normalize(0.).unwrap_or_else(Vec3::z);
        let positions: Vec<[f32; 3]> = points.iter().map(|p| single(p * METRES)).collect();
        let normals: Vec<[f32; 3]> = normals.iter().map(|n| single(unit(n))).collect();
        let mut attributes =
            json!({ "POSITION": self.vectors(&positions), "NORMAL": self.vectors(&normals) });
        if let Some(tint) = tint {
            attributes["COLOR_0"] = self.vectors(tint).into();
        }
        json!({ "attributes": attributes, "indices": self.triangles(triangles), "material": material })
    }
}

fn single(v: Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// `face` moved by `motion` as a GLB file: the skin at rest with a morph target of each muscle's name, in weights of its
/// activation, and one called `remainder`, by which the superposition at the answer is the answer itself; teeth at the
/// answer's pose; and an animation `rest to answer` of the weights. Without a tangent there is one target, `remainder`.
///
/// Lengths are metres, as glTF has them; +x is the subject's left, +y up, +z forward. Normals are those at rest.
///
/// Source: Khronos Group, glTF 2.0 Specification (ISO/IEC 12113:2022).
pub fn glb(face: &Face, motion: &Motion) -> Vec<u8> {
    let scene = Scene::new(face);
    let Refined { sites, quads } = scene.surface();
    let mut buffer = Buffer::default();
    let points: Vec<Vec3> = sites.iter().map(|site| site.position).collect();
    let triangles: Vec<[usize; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut skin = buffer.primitive(&points, &triangles, Some(&scene.tint()), 0);

    let mut names: Vec<&str> = Vec::new();
    let mut weights: Vec<f32> = Vec::new();
    let mut targets: Vec<Value> = Vec::new();
    let mut target = |name, weight: f64, moved: &[Vec3]| {
        let moved: Vec<[f32; 3]> = moved.iter().map(|u| single(u * METRES)).collect();
        names.push(name);
        weights.push(weight as f32);
        targets.push(json!({ "POSITION": buffer.vectors(&moved) }));
    };
    let seen = |u: &[f64]| sites.iter().map(|site| site.displacement(u)).collect::<Vec<Vec3>>();
    let stored = motion.answer.displacement.as_deref();
    let mut remainder = stored.map_or_else(|| vec![Vec3::zeros(); sites.len()], seen);
    for ((muscle, field), a) in face.muscles.iter().zip(&motion.tangent).zip(&motion.answer.activation) {
        let moved = seen(field);
        remainder.iter_mut().zip(&moved).for_each(|(rest, u)| *rest -= *a * u);
        target(&muscle.name, *a, &moved);
    }
    target(REMAINDER, 1., &remainder);
    skin["targets"] = targets.into();

    let mut meshes = vec![json!({
        "name": "skin", "primitives": [skin], "weights": vec![0.; weights.len()], "extras": { "targetNames": names }
    })];
    let mut nodes = vec![json!({ "name": face.name, "mesh": 0 })];
    for teeth in face.teeth_at(&motion.answer.pose) {
        let name = if teeth.upper { "upper teeth" } else { "lower teeth" };
        let primitive = buffer.primitive(&teeth.surface.points, &teeth.surface.triangles, None, 1);
        nodes.push(json!({ "name": name, "mesh": meshes.len() }));
        meshes.push(json!({ "name": name, "primitives": [primitive] }));
    }
    let still = vec![0.; weights.len()];
    let input = buffer.scalars(&[0., LOADING_S], true);
    let output = buffer.scalars(&[still, weights].concat(), false);
    let material = |name: &str, colour: [f64; 4], roughness: f64, both_sides: bool| {
        json!({
            "name": name,
            "doubleSided": both_sides,
            "pbrMetallicRoughness": { "baseColorFactor": colour, "metallicFactor": 0., "roughnessFactor": roughness }
        })
    };
    let children: Vec<usize> = (0..nodes.len()).collect();
    let document = json!({
        "asset": { "version": "2.0", "generator": format!("modiolus {}", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": motion.answer.label, "nodes": children }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [
            material("skin", [1., 1., 1., 1.], 0.62, true),
            material("teeth", [0.9, 0.84, 0.69, 1.], 0.35, false)
        ],
        "animations": [{
            "name": "rest to answer",
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }]
        }],
        "buffers": [{ "byteLength": buffer.bytes.len() }],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors
    });
    container(&document.to_string(), buffer.bytes)
}

/// The two chunks with their headers, each padded to four bytes.
fn container(json: &str, mut binary: Vec<u8>) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut glb = Vec::with_capacity(28 + json.len() + binary.len());
    glb.extend(b"glTF");
    glb.extend(2u32.to_le_bytes());
    glb.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}
