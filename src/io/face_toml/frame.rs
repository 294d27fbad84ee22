//! From the coordinates of the named files to those of the face.

use nalgebra::Matrix3;

use super::error::FaceFileErrorKind;
use super::file::FrameTable;
use crate::io::nearest::nearest;
use crate::units::{LengthUnit, Vec3};

const DIRECTIONS: [(&str, [f64; 3]); 6] = [
    ("left", [1., 0., 0.]),
    ("right", [-1., 0., 0.]),
    ("up", [0., 1., 0.]),
    ("down", [0., -1., 0.]),
    ("anterior", [0., 0., 1.]),
    ("posterior", [0., 0., -1.]),
];

/// A rotation and an origin: `p = R (x - o)`, in mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    rotation: Matrix3<f64>,
    origin_mm: Vec3,
    scale: f64,
}

impl Frame {
    /// The frame of `table`; the error goes with the field `frame.axes` or `frame.origin`.
    pub(super) fn new(
        table: Option<&FrameTable>,
        unit: LengthUnit,
    ) -> Result<Self, (&'static str, FaceFileErrorKind)> {
        let scale = unit.in_mm();
        let Some(table) = table else {
            return Ok(Self { rotation: Matrix3::identity(), origin_mm: Vec3::zeros(), scale });
        };
        let mut columns = [Vec3::zeros(); 3];
        for (column, name) in columns.iter_mut().zip(&table.axes) {
            let Some((_, direction)) = DIRECTIONS.iter().find(|(known, _)| known == name) else {
                let known = DIRECTIONS.map(|(known, _)| known);
                let kind = FaceFileErrorKind::UnknownName {
                    what: "direction",
                    name: name.clone(),
                    nearest: nearest(name, known).map(str::to_owned),
                    known: known.map(str::to_owned).to_vec(),
                };
                return Err(("frame.axes", kind));
            };
            *column = Vec3::from(*direction);
        }
        let rotation = Matrix3::from_columns(&columns);
        if rotation.determinant() < 0.5 {
            let accepted = "three axes at right angles that form a right-handed frame".to_owned();
            let kind = FaceFileErrorKind::Value { value: table.axes.join(", "), accepted };
            return Err(("frame.axes", kind));
        }
        if !table.origin.iter().all(|x| x.is_finite()) {
            let kind = FaceFileErrorKind::Value {
                value: format!("{:?}", table.origin),
                accepted: "finite coordinates".to_owned(),
            };
            return Err(("frame.origin", kind));
        }
        Ok(Self { rotation, origin_mm: scale * Vec3::from(table.origin), scale })
    }

    /// A point in the files' unit.
    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.point_in_mm(self.scale * p)
    }

    /// A point of the files that is in mm already.
    pub(super) fn point_in_mm(&self, p: Vec3) -> Vec3 {
        self.rotation * (p - self.origin_mm)
    }
}
