//! The compressors of VTK.

use std::io::Read;

use flate2::read::ZlibDecoder;
use lzma_rust2::XzReader;

/// Most memory that a block of LZMA may ask for, KiB: what its strongest preset takes, and a little more.
const LZMA_KIB: u32 = 100 * 1024;

/// How the blocks of an array are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    Zlib,
    Lz4,
    Lzma,
}

impl Compression {
    /// The names that VTK gives them.
    pub(super) const NAMES: [(&str, Self); 3] = [
        ("vtkZLibDataCompressor", Self::Zlib),
        ("vtkLZ4DataCompressor", Self::Lz4),
        ("vtkLZMADataCompressor", Self::Lzma),
    ];

    /// Appends the content of `block` to `all`, of which there is no more than `most` bytes and one; returns how
    /// much there is, or what is wrong with the block.
    pub(super) fn unpack(self, block: &[u8], most: usize, all: &mut Vec<u8>) -> Result<usize, String> {
        let limit = most as u64 + 1;
        let read = match self {
            Self::Zlib => ZlibDecoder::new(block).take(limit).read_to_end(all),
            Self::Lzma => XzReader::new_mem_limit(block, false, LZMA_KIB).take(limit).read_to_end(all),
            Self::Lz4 => {
                let start = all.len();
                all.resize(start + most, 0);
                let unpacked = lz4_flex::block::decompress_into(block, &mut all[start..]);
                all.truncate(start + unpacked.as_ref().map_or(0, |n| *n));
                return unpacked.map_err(|e| e.to_string());
            }
        };
        read.map_err(|e| e.to_string())
    }

    /// What the content is, for messages.
    pub(super) fn data(self) -> &'static str {
        match self {
            Self::Zlib => "zlib data",
            Self::Lz4 => "LZ4 data",
            Self::Lzma => "LZMA data",
        }
    }
}
