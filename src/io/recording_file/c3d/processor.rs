//! How the numbers of a C3D file are stored.

/// The processor whose numbers a C3D file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Processor {
    /// Little-endian, IEEE 754.
    Intel,
    /// Little-endian, VAX F floating.
    Dec,
    /// Big-endian, IEEE 754.
    Mips,
}

impl Processor {
    /// What `byte` of the parameter section stands for.
    pub(super) fn of(byte: u8) -> Option<Self> {
        match byte {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Mips),
            _ => None,
        }
    }

    pub(super) fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
            Self::Mips => u16::from_be_bytes(bytes),
        }
    }

    pub(super) fn i16(self, bytes: [u8; 2]) -> i16 {
        self.u16(bytes) as i16
    }

    /// A number of four bytes; what VAX reserves is NaN.
    pub(super) fn float(self, bytes: [u8; 4]) -> f64 {
        match self {
            Self::Intel => f64::from(f32::from_le_bytes(bytes)),
            Self::Mips => f64::from(f32::from_be_bytes(bytes)),
            Self::Dec => vax(bytes),
        }
    }
}

/// VAX F floating: the words swapped, `(-1)^s 0.1f 2^(e - 128)` with sign s, 8 bits e and 23 bits f (VAX Architecture
/// Reference Manual, `F_floating`); e = 0 is zero, or reserved with a sign.
fn vax([a, b, c, d]: [u8; 4]) -> f64 {
    let bits = u32::from_be_bytes([b, a, d, c]);
    let (negative, e, f) = (bits >> 31 == 1, (bits >> 23 & 0xFF) as i32, bits & 0x7F_FFFF);
    match (e, negative) {
        (0, false) => 0.,
        (0, true) => f64::NAN,
        _ => {
            let size = (1. + f64::from(f) / f64::from(1 << 23)) * 2f64.powi(e - 129);
            if negative { -size } else { size }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bit patterns of the VAX Architecture Reference Manual: 1 is 0x00004080, -1.5 is 0x0000C0C0.
    #[test]
    fn vax_numbers() {
        for (bits, expected) in [
            (0x0000_4080u32, 1.),
            (0x0000_C0C0, -1.5),
            (0x0000_4000, 0.5),
            (0x0FD0_4149, 3.141_590_118_408_203),
            (0, 0.),
        ] {
            assert_eq!(Processor::Dec.float(bits.to_le_bytes()), expected, "{bits:x}");
        }
        assert!(Processor::Dec.float(0x8000u32.to_le_bytes()).is_nan());
        assert_eq!(Processor::Mips.float(1.5f32.to_be_bytes()), 1.5);
        assert_eq!(Processor::Intel.float(1.5f32.to_le_bytes()), 1.5);
        assert_eq!([Processor::Intel, Processor::Mips].map(|p| p.i16([0xFE, 0xFF])), [-2, -257]);
    }
}
