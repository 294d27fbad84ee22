//! Writes VTU files.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::super::escaped::escaped;
use super::super::mesh_file_error::{MeshFileError, MeshFileErrorKind};
use super::super::{Location, write_atomically};
use crate::mesh::{CellKind, Mesh, WEDGE_OTHER_ORDER};

/// Bytes to a compressed block, as VTK chooses them.
const BLOCK: usize = 32_768;

/// Named fields to write beside a mesh of n nodes and e cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VtuData {
    /// Vectors at nodes, 3n, node-major xyz.
    pub point_vectors: BTreeMap<String, Vec<f64>>,
    /// Scalars at nodes, n.
    pub point_scalars: BTreeMap<String, Vec<f64>>,
    /// Scalars of cells, e.
    pub cell_scalars: BTreeMap<String, Vec<f64>>,
    /// Whole numbers of cells, e.
    pub cell_labels: BTreeMap<String, Vec<i64>>,
}

/// Writes `mesh` (mm), its sets as arrays of zeros and ones, and `data` to `path`: zlib, base64, little
/// endian, byte-identical for equal input, through a temporary file and a rename.
///
/// # Errors
/// If a field has not one value (three for vectors) a node or cell, or the file system refuses.
pub fn write_vtu(path: &Path, mesh: &Mesh, data: &VtuData) -> Result<(), MeshFileError> {
    let text = vtu_text(path, mesh, data)?;
    write_atomically(path, text.as_bytes()).map_err(|e| {
        let reason = e.kind.to_string();
        MeshFileError::new(Location::file(path), MeshFileErrorKind::Io { reason })
    })
}

/// What [`write_vtu`] writes; `path` is only named in messages.
///
/// # Errors
/// If a field has not one value (three for vectors) a node or cell.
pub fn vtu_text(path: &Path, mesh: &Mesh, data: &VtuData) -> Result<String, MeshFileError> {
    let (n, e) = (mesh.n_nodes(), mesh.cells.len());
    let fields = [(&data.point_vectors, 3 * n), (&data.point_scalars, n), (&data.cell_scalars, e)];
    let floats = fields.iter().flat_map(|(map, len)| map.iter().map(|(k, v)| (k, v.len(), *len)));
    let labels = data.cell_labels.iter().map(|(k, v)| (k, v.len(), e));
    for (name, found, declared) in floats.chain(labels) {
        if found != declared {
            let what = format!("values of {name}");
            let (declared, found) = (declared as u64, found as u64);
            return Err(MeshFileError::new(
                Location::file(path).in_field(name.clone()),
                MeshFileErrorKind::CountMismatch { what, declared, found },
            ));
        }
    }
    let io = |e: std::io::Error| {
        MeshFileError::new(Location::file(path), MeshFileErrorKind::Io { reason: e.to_string() })
    };
    document(mesh, data).map_err(io)
}

fn document(mesh: &Mesh, data: &VtuData) -> std::io::Result<String> {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt32\" compressor=\"vtkZLibDataCompressor\">\n\
         <UnstructuredGrid>\n",
    );
    let (n, e) = (mesh.n_nodes(), mesh.cells.len());
    out += &format!("<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{e}\">\n<Points>\n");
    let points: Vec<f64> = mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    array(&mut out, "Points", 3, &points, f64::to_le_bytes, "Float64")?;
    out += "</Points>\n<Cells>\n";
    let mut nodes: Vec<i64> = Vec::new();
    for cell in &mesh.cells {
        let of_cell = cell.nodes();
        match cell.kind() {
            CellKind::Wedge6 => nodes.extend(WEDGE_OTHER_ORDER.map(|k| of_cell[k] as i64)),
            _ => nodes.extend(of_cell.iter().map(|&node| node as i64)),
        }
    }
    array(&mut out, "connectivity", 1, &nodes, i64::to_le_bytes, "Int64")?;
    let mut end = 0;
    let offsets: Vec<i64> = mesh
        .cells
        .iter()
        .map(|c| {
            end += c.nodes().len() as i64;
            end
        })
        .collect();
    array(&mut out, "offsets", 1, &offsets, i64::to_le_bytes, "Int64")?;
    let types: Vec<u8> = mesh.cells.iter().map(|c| vtk_type(c.kind())).collect();
    array(&mut out, "types", 1, &types, u8::to_le_bytes, "UInt8")?;
    out += "</Cells>\n<PointData>\n";
    for (name, v) in &data.point_vectors {
        array(&mut out, name, 3, v, f64::to_le_bytes, "Float64")?;
    }
    for (name, v) in &data.point_scalars {
        array(&mut out, name, 1, v, f64::to_le_bytes, "Float64")?;
    }
    sets(&mut out, &mesh.node_sets, n)?;
    out += "</PointData>\n<CellData>\n";
    for (name, v) in &data.cell_scalars {
        array(&mut out, name, 1, v, f64::to_le_bytes, "Float64")?;
    }
    for (name, v) in &data.cell_labels {
        array(&mut out, name, 1, v, i64::to_le_bytes, "Int64")?;
    }
    sets(&mut out, &mesh.cell_sets, e)?;
    out += "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
    Ok(out)
}

fn sets(out: &mut String, sets: &BTreeMap<String, Vec<usize>>, n: usize) -> std::io::Result<()> {
    for (name, members) in sets {
        let mut flags = vec![0_u8; n];
        for &member in members {
            if let Some(flag) = flags.get_mut(member) {
                *flag = 1;
            }
        }
        array(out, name, 1, &flags, u8::to_le_bytes, "UInt8")?;
    }
    Ok(())
}

fn array<T: Copy, const N: usize>(
    out: &mut String,
    name: &str,
    components: usize,
    values: &[T],
    to_bytes: fn(T) -> [u8; N],
    kind: &str,
) -> std::io::Result<()> {
    let bytes: Vec<u8> = values.iter().flat_map(|v| to_bytes(*v)).collect();
    let blocks = bytes.chunks(BLOCK);
    let last = bytes.len() % BLOCK;
    let mut header: Vec<usize> = vec![blocks.len(), BLOCK, last];
    let mut packed = Vec::new();
    for block in blocks {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
        encoder.write_all(block)?;
        let block = encoder.finish()?;
        header.push(block.len());
        packed.extend(block);
    }
    let header: Vec<u8> = header.iter().flat_map(|&h| (h as u32).to_le_bytes()).collect();
    *out += &format!(
        "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{components}\" format=\"binary\">\n\
         {}{}\n</DataArray>\n",
        escaped(name),
        BASE64_STANDARD.encode(header),
        BASE64_STANDARD.encode(packed),
    );
    Ok(())
}

fn vtk_type(kind: CellKind) -> u8 {
    match kind {
        CellKind::Tet4 => 10,
        CellKind::Hex8 => 12,
        CellKind::Wedge6 => 13,
        CellKind::Tet10 => 24,
    }
}
