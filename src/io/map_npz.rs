//! Activation maps, `map.npz`: a zip of NumPy arrays.

use thiserror::Error;

use super::npz::Npz;
use crate::face::Landmark;
use crate::units::Vec3;

/// An activation map cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// Not one field a muscle, or a field that has not three values a point.
    #[error("{fields} fields of {values} values, but {points} points and {muscles} muscles need {muscles} of {}", 3 * points)]
    Shape {
        /// Number of fields.
        fields: usize,
        /// Values of the field that does not fit, or of the first.
        values: usize,
        /// Number of points.
        points: usize,
        /// Number of muscles.
        muscles: usize,
    },
    /// The bytes cannot be put together.
    #[error("map.npz cannot be put together: {0}")]
    Npz(#[from] std::io::Error),
}

/// An activation map: what each muscle alone does to each point at full activation, without contact,
/// at one fixed stiffness.
#[derive(Clone, Copy, Debug)]
pub struct MapNpz<'a> {
    /// Rest positions of the `n` points, mm.
    pub points: &'a [Vec3],
    /// The `l` landmarks, whose rows stand beside the whole field.
    pub landmarks: &'a [Landmark],
    /// Names of the `m` muscles.
    pub muscles: &'a [String],
    /// Columns of `K^-1 F`: for each of the `m` muscles the displacement (3n, node-major xyz), mm per
    /// unit activation.
    pub displacement: &'a [Vec<f64>],
    /// The activation at which every muscle's stiffness is held, 0 to 1.
    pub stiffness: f64,
}

impl MapNpz<'_> {
    /// The bytes of the file: `points` (n, 3) mm, `displacement` (m, n, 3) mm per unit activation,
    /// `landmarks` (l) names, `landmark_points` (l, 3) mm, `landmark_displacement` (m, l, 3) mm per unit activation,
    /// `muscles` (m) names, `stiffness` () activation at which the stiffness is held.
    ///
    /// The arrays are stored, not compressed, under a fixed date: the same map gives the same bytes.
    /// NumPy opens them with `allow_pickle=False`.
    ///
    /// # Errors
    /// [`MapFileError`] when the shapes do not fit.
    pub fn to_bytes(&self) -> Result<Vec<u8>, MapFileError> {
        let (n, m) = (self.points.len(), self.muscles.len());
        let wrong = self.displacement.iter().map(Vec::len).find(|len| *len != 3 * n);
        if self.displacement.len() != m || wrong.is_some() {
            let (fields, values) = (self.displacement.len(), wrong.unwrap_or(3 * n));
            return Err(MapFileError::Shape { fields, values, points: n, muscles: m });
        }
        let (rows, layers) = (n as u64, m as u64);
        let points = self.points.iter().flat_map(|p| [p.x, p.y, p.z]);
        let displacement = self.displacement.iter().flatten().copied();
        let mut file = Npz::new();
        file.numbers("points", &[rows, 3], points)?;
        file.numbers("displacement", &[layers, rows, 3], displacement)?;
        let fields: Vec<&[f64]> = self.displacement.iter().map(Vec::as_slice).collect();
        file.landmarks(self.landmarks, &[layers], &fields)?;
        file.names("muscles", self.muscles)?;
        file.numbers("stiffness", &[], [self.stiffness])?;
        Ok(file.finish()?)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::mesh::Site;

    fn map(displacement: &[Vec<f64>]) -> Result<Vec<u8>, MapFileError> {
        let points = [Vec3::new(1., 2., 3.), Vec3::new(4., 5., 6.)];
        let muscles = ["a".to_owned(), "mentalis_é".to_owned(), "c".to_owned()];
        let site = Site { position: points[0], weights: vec![(0, 0.25), (1, 0.75)] };
        let landmarks = [Landmark { name: "between".to_owned(), site }];
        MapNpz { points: &points, landmarks: &landmarks, muscles: &muscles, displacement, stiffness: 0.5 }
            .to_bytes()
    }

    fn entry(bytes: &[u8], name: &str) -> Vec<u8> {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("a zip");
        let mut out = Vec::new();
        std::io::Read::read_to_end(&mut archive.by_name(name).expect("an entry"), &mut out).expect("read");
        out
    }

    #[test]
    fn arrays_come_back_with_their_shapes() {
        let u: Vec<Vec<f64>> =
            (0..3).map(|muscle| (0..6).map(|i| f64::from(10 * muscle + i) + 0.1).collect()).collect();
        let bytes = map(&u).expect("written");
        let npy = entry(&bytes, "displacement.npy");
        let file = npyz::NpyFile::new(&npy[..]).expect("npy");
        assert_eq!(file.shape(), [3, 2, 3]);
        let values: Vec<f64> = file.into_vec().expect("numbers");
        assert_eq!(values, u.concat());
        let npy = entry(&bytes, "landmark_displacement.npy");
        let file = npyz::NpyFile::new(&npy[..]).expect("npy");
        assert_eq!(file.shape(), [3, 1, 3]);
        let rows: Vec<f64> = file.into_vec().expect("numbers");
        let expected = u.iter().flat_map(|u| (0..3).map(|k| 0.25 * u[k] + 0.75 * u[3 + k]));
        assert!(rows.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12));
        let npy = entry(&bytes, "muscles.npy");
        let names: Vec<String> = npyz::NpyFile::new(&npy[..]).expect("npy").into_vec().expect("names");
        assert_eq!(names, ["a", "mentalis_é", "c"]);
        assert_eq!(map(&u).expect("written"), bytes);
    }

    #[test]
    fn a_map_of_the_wrong_shape_is_refused() {
        assert!(matches!(
            map(&[vec![0.0; 6], vec![0.0; 5], vec![0.0; 6]]),
            Err(MapFileError::Shape { values: 5, .. })
        ));
        assert!(matches!(map(&[vec![0.0; 6], vec![0.0; 6]]), Err(MapFileError::Shape { fields: 2, .. })));
    }
}
