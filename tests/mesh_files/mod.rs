//! One small mixed mesh, and its text in every format and encoding that is read.

#![allow(dead_code, missing_docs)]

use std::fmt::Write as _;
use std::io::Write as _;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use modiolus::mesh::{Cell, CellKind, Mesh};
use modiolus::units::Vec3;

/// A hexahedron with a wedge on top and two tetrahedra beside, on coordinates that f32 holds exactly;
/// node set `skin` is the top of the hexahedron, cell set `soft` the hexahedron.
pub(crate) fn mixed() -> Mesh {
    let mut points = Vec::new();
    for z in [0., 10.] {
        for [x, y] in [[0., 0.], [10., 0.], [10., 10.], [0., 10.]] {
            points.push(Vec3::new(x, y, z));
        }
    }
    // The ridge of the wedge, whose triangles are 4, 7, 8 and 5, 6, 9.
    points.extend([Vec3::new(0.5, 5., 17.25), Vec3::new(9.5, 5., 17.25)]);
    let shift = |v: [f64; 3]| Vec3::new(20., 0., 0.) + 8. * Vec3::from(v);
    let quadratic = CellKind::Tet10.node_positions();
    points.extend(quadratic.iter().map(|p| shift(*p)));
    points.push(Vec3::new(26., -7.5, 1.));
    let cells = vec![
        Cell::new(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]),
        Cell::new(CellKind::Wedge6, &[4, 7, 8, 5, 6, 9]),
        Cell::new(CellKind::Tet4, &[10, 11, 13, 20]),
        Cell::new(CellKind::Tet10, &[10, 11, 12, 13, 14, 15, 16, 17, 18, 19]),
    ];
    let mut mesh = Mesh::new(points, cells);
    mesh.node_sets.insert("skin".into(), vec![4, 5, 6, 7]);
    mesh.cell_sets.insert("soft".into(), vec![0]);
    mesh
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    Ascii,
    Inline,
    AppendedBase64,
    AppendedRaw,
}

/// How to write a VTU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vtu {
    pub(crate) place: Place,
    pub(crate) zlib: bool,
    pub(crate) wide_header: bool,
    pub(crate) big_endian: bool,
    pub(crate) float: &'static str,
    pub(crate) int: &'static str,
    /// Header and data in one base64 piece, or each with its padding.
    pub(crate) joint: bool,
}

impl Vtu {
    pub(crate) const ASCII: Self = Self {
        place: Place::Ascii,
        zlib: false,
        wide_header: false,
        big_endian: false,
        float: "Float64",
        int: "Int64",
        joint: false,
    };

    pub(crate) fn write(&self, mesh: &Mesh) -> Vec<u8> {
        let mut appended: Vec<u8> = Vec::new();
        let mut xml =
            String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"");
        let order = if self.big_endian { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide_header { "UInt64" } else { "UInt32" };
        write!(xml, " byte_order=\"{order}\" header_type=\"{header}\"").expect("text");
        if self.zlib {
            xml += " compressor=\"vtkZLibDataCompressor\"";
        }
        xml += ">\n<UnstructuredGrid>\n";
        let (n, e) = (mesh.points.len(), mesh.cells.len());
        writeln!(xml, "<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{e}\">").expect("text");
        let mut array = |name: &str, kind: &str, components: usize, values: &[f64]| {
            let mut out =
                format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
            match self.place {
                Place::Ascii => {
                    let words: Vec<String> = values
                        .chunks(components)
                        .map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
                        .collect();
                    write!(out, " format=\"ascii\">\n{}\n</DataArray>\n", words.join("\n")).expect("text");
                }
                Place::Inline => {
                    let text = String::from_utf8(self.encode(kind, values)).expect("base64");
                    write!(out, " format=\"binary\">\n  {text}\n</DataArray>\n").expect("text");
                }
                Place::AppendedBase64 | Place::AppendedRaw => {
                    writeln!(out, " format=\"appended\" offset=\"{}\"/>", appended.len()).expect("text");
                    appended.extend(self.encode(kind, values));
                }
            }
            out
        };
        let numbers = |v: Vec<usize>| v.into_iter().map(|x| x as f64).collect::<Vec<_>>();
        let flags =
            |n: usize, set: &[usize]| numbers((0..n).map(|k| usize::from(set.contains(&k))).collect());
        let points: Vec<f64> = mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        xml += &format!("<Points>\n{}</Points>\n", array("Points", self.float, 3, &points));
        let nodes = numbers(mesh.cells.iter().flat_map(|c| c.nodes().to_vec()).collect());
        let mut end = 0;
        let ends = mesh.cells.iter().map(|c| {
            end += c.nodes().len();
            end
        });
        let offsets = numbers(ends.collect());
        let types = numbers(mesh.cells.iter().map(|c| vtk_type(c.kind())).collect());
        xml += &format!(
            "<Cells>\n{}{}{}</Cells>\n",
            array("connectivity", self.int, 1, &nodes),
            array("offsets", self.int, 1, &offsets),
            array("types", "UInt8", 1, &types)
        );
        xml += "<PointData>\n";
        for (name, set) in &mesh.node_sets {
            xml += &array(name, "Int8", 1, &flags(n, set));
        }
        xml += "</PointData>\n<CellData>\n";
        for (name, set) in &mesh.cell_sets {
            xml += &array(name, self.float, 1, &flags(e, set));
        }
        xml += "</CellData>\n</Piece>\n</UnstructuredGrid>\n";
        let mut bytes = xml.into_bytes();
        if matches!(self.place, Place::AppendedBase64 | Place::AppendedRaw) {
            let encoding = if self.place == Place::AppendedRaw { "raw" } else { "base64" };
            bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").into_bytes());
            bytes.extend(appended);
            bytes.extend(b"\n</AppendedData>\n");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }

    fn word(&self, value: u64, bytes: usize) -> Vec<u8> {
        if self.big_endian {
            value.to_be_bytes()[8 - bytes..].to_vec()
        } else {
            value.to_le_bytes()[..bytes].to_vec()
        }
    }

    fn encode(&self, kind: &str, values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values
            .iter()
            .flat_map(|&v| match kind {
                "Float32" => self.word(u64::from((v as f32).to_bits()), 4),
                "Float64" => self.word(v.to_bits(), 8),
                "Int8" | "UInt8" => self.word(v as u64, 1),
                "Int16" | "UInt16" => self.word(v as u64, 2),
                "Int32" | "UInt32" => self.word(v as u64, 4),
                _ => self.word(v as u64, 8),
            })
            .collect();
        let head = if self.wide_header { 8 } else { 4 };
        let (header, body) = if self.zlib {
            let blocks: Vec<Vec<u8>> = data
                .chunks(64)
                .map(|block| {
                    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                    encoder.write_all(block).expect("memory");
                    encoder.finish().expect("memory")
                })
                .collect();
            let mut header = vec![blocks.len() as u64, 64, data.len() as u64 % 64];
            header.extend(blocks.iter().map(|b| b.len() as u64));
            (header.iter().flat_map(|h| self.word(*h, head)).collect::<Vec<u8>>(), blocks.concat())
        } else {
            (self.word(data.len() as u64, head), data)
        };
        match self.place {
            Place::AppendedRaw => [header, body].concat(),
            _ if self.joint => BASE64_STANDARD.encode([header, body].concat()).into_bytes(),
            _ => (BASE64_STANDARD.encode(header) + &BASE64_STANDARD.encode(body)).into_bytes(),
        }
    }
}

fn vtk_type(kind: CellKind) -> usize {
    match kind {
        CellKind::Tet4 => 10,
        CellKind::Hex8 => 12,
        CellKind::Wedge6 => 13,
        CellKind::Tet10 => 24,
    }
}

/// Gmsh's type and the nodes from 1 in Gmsh's order.
fn gmsh(cell: &Cell) -> (i32, Vec<usize>) {
    let mut nodes: Vec<usize> = cell.nodes().iter().map(|n| n + 1).collect();
    match cell.kind() {
        CellKind::Tet4 => (4, nodes),
        CellKind::Hex8 => (5, nodes),
        CellKind::Wedge6 => (6, nodes),
        CellKind::Tet10 => {
            nodes.swap(8, 9);
            (11, nodes)
        }
    }
}

/// Numbers for an MSH file, as text in rows or as bytes.
struct Msh {
    binary: Option<bool>,
    out: Vec<u8>,
}

impl Msh {
    fn text(&mut self, text: &str) {
        self.out.extend(text.bytes());
    }

    fn put(&mut self, text: &str, bytes: &[u8]) {
        match self.binary {
            None => self.out.extend(format!("{text} ").bytes()),
            Some(false) => self.out.extend(bytes),
            Some(true) => self.out.extend(bytes.iter().rev()),
        }
    }

    fn int(&mut self, v: usize) {
        self.put(&v.to_string(), &(v as i32).to_le_bytes());
    }

    fn size(&mut self, v: usize) {
        self.put(&v.to_string(), &(v as u64).to_le_bytes());
    }

    fn double(&mut self, v: f64) {
        self.put(&format!("{v:e}"), &v.to_le_bytes());
    }

    fn row(&mut self) {
        if self.binary.is_none() {
            self.text("\n");
        }
    }

    fn point(&mut self, p: Vec3) {
        p.iter().for_each(|x| self.double(*x));
    }

    fn start(binary: Option<bool>, version: &str) -> Self {
        let mut msh = Self { binary, out: Vec::new() };
        msh.text(&format!("$MeshFormat\n{version} {} 8\n", u8::from(binary.is_some())));
        if binary.is_some() {
            msh.int(1);
            msh.text("\n");
        }
        msh.text("$EndMeshFormat\n$PhysicalNames\n2\n2 7 \"skin\"\n3 9 \"soft\"\n$EndPhysicalNames\n");
        msh
    }
}

/// MSH 2.2; the face that names the skin comes first, as Gmsh writes it.
pub(crate) fn msh_2(mesh: &Mesh, binary: Option<bool>) -> Vec<u8> {
    let mut msh = Msh::start(binary, "2.2");
    msh.text(&format!("$Nodes\n{}\n", mesh.points.len()));
    for (k, p) in mesh.points.iter().enumerate() {
        msh.int(k + 1);
        msh.point(*p);
        msh.row();
    }
    msh.text(&format!("\n$EndNodes\n$Elements\n{}\n", mesh.cells.len() + 1));
    let quad: Vec<usize> = mesh.node_sets["skin"].iter().map(|n| n + 1).collect();
    let cells = mesh.cells.iter().enumerate().map(|(k, c)| {
        let (kind, nodes) = gmsh(c);
        (k + 2, kind, if mesh.cell_sets["soft"].contains(&k) { 9 } else { 0 }, nodes)
    });
    for (id, kind, group, nodes) in std::iter::once((1, 3, 7, quad)).chain(cells) {
        let head = [kind as usize, 1, 2];
        if binary.is_some() {
            head.iter().for_each(|v| msh.int(*v));
            msh.int(id);
        } else {
            [id, head[0], head[2]].iter().for_each(|v| msh.int(*v));
        }
        [group, 1].iter().chain(&nodes).for_each(|v| msh.int(*v));
        msh.row();
    }
    msh.text("\n$EndElements\n");
    msh.out
}

/// MSH 4.1: surface 1 is the skin, volume 1 the soft hexahedron, volume 2 the rest.
pub(crate) fn msh_4(mesh: &Mesh, binary: Option<bool>) -> Vec<u8> {
    let mut msh = Msh::start(binary, "4.1");
    msh.text("$Entities\n");
    [0, 0, 1, 2].iter().for_each(|v| msh.size(*v));
    msh.row();
    for (tag, groups) in [(1, vec![7]), (1, vec![9]), (2, vec![])] {
        msh.int(tag);
        (0..6).for_each(|k| msh.double(f64::from(k)));
        msh.size(groups.len());
        groups.iter().for_each(|g| msh.int(*g));
        msh.size(0);
        msh.row();
    }
    msh.text("\n$EndEntities\n$Nodes\n");
    let n = mesh.points.len();
    [2, n, 1, n].iter().for_each(|v| msh.size(*v));
    msh.row();
    for (dimension, range) in [(2, 0..5), (3, 5..n)] {
        [dimension, 1, 0].iter().for_each(|v| msh.int(*v));
        msh.size(range.len());
        msh.row();
        for k in range.clone() {
            msh.size(k + 1);
            msh.row();
        }
        for k in range {
            msh.point(mesh.points[k]);
            msh.row();
        }
    }
    msh.text("\n$EndNodes\n$Elements\n");
    let e = mesh.cells.len() + 1;
    [e, e, 1, e].iter().for_each(|v| msh.size(*v));
    msh.row();
    let quad: Vec<usize> = mesh.node_sets["skin"].iter().map(|n| n + 1).collect();
    let cells = mesh.cells.iter().enumerate().map(|(k, c)| {
        let (kind, nodes) = gmsh(c);
        (3, if mesh.cell_sets["soft"].contains(&k) { 1 } else { 2 }, kind, k + 2, nodes)
    });
    for (dimension, entity, kind, id, nodes) in std::iter::once((2, 1, 3, 1, quad)).chain(cells) {
        [dimension, entity, kind as usize].iter().for_each(|v| msh.int(*v));
        msh.size(1);
        msh.row();
        [id].iter().chain(&nodes).for_each(|v| msh.size(*v));
        msh.row();
    }
    msh.text("\n$EndElements\n");
    msh.out
}

/// Abaqus INP with the sets given by a range and by a list.
pub(crate) fn inp(mesh: &Mesh) -> Vec<u8> {
    let mut out = String::from("*HEADING\nsmall\n** comment\n*Node, nset=all\n");
    for (k, p) in mesh.points.iter().enumerate() {
        writeln!(out, "{}, {:?}, {:?}, {:?}", k + 1, p.x, p.y, p.z).expect("text");
    }
    for (k, cell) in mesh.cells.iter().enumerate() {
        let name = match cell.kind() {
            CellKind::Hex8 => "C3D8RH",
            CellKind::Wedge6 => "C3D6",
            CellKind::Tet4 => "C3D4",
            CellKind::Tet10 => "C3D10M",
        };
        writeln!(out, "*ELEMENT, TYPE={name}").expect("text");
        let nodes: Vec<String> = cell.nodes().iter().map(|n| (n + 1).to_string()).collect();
        let (first, rest) = nodes.split_at(4);
        let more = if rest.is_empty() { String::new() } else { format!(",\n {}", rest.join(", ")) };
        writeln!(out, "{}, {}{more}", k + 1, first.join(", ")).expect("text");
    }
    out += "*NSET, NSET=skin, GENERATE\n5, 8, 1\n*ELSET, ELSET=soft\n1,\n*STEP\n1., 2.\n";
    out.into_bytes()
}
