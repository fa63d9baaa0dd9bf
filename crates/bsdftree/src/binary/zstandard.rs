//! Packed bytes, in Zstandard: by its C library, or in WebAssembly, where there is none, in Rust.
//!
//! In: bytes, and how many they are unpacked. Out: bytes. Invariant: either unpacks what the other packed.

use std::io::{self, Read};

/// Packs bytes at a level from 1 to 22.
#[cfg(not(target_family = "wasm"))]
pub(super) fn packed(bytes: &[u8], level: i32) -> io::Result<Vec<u8>> {
    zstd::bulk::compress(bytes, level)
}

/// Packs bytes. Deviation: whatever the level, as fast as can be; what is written is larger than elsewhere, and no less right.
#[cfg(target_family = "wasm")]
pub(super) fn packed(bytes: &[u8], _level: i32) -> io::Result<Vec<u8>> {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    Ok(compress_to_vec(bytes, CompressionLevel::Fastest))
}

/// Exactly `length` bytes out of packed ones; memory grows with what is really there.
pub(super) fn unpacked(bytes: &[u8], length: usize) -> io::Result<Vec<u8>> {
    #[cfg(not(target_family = "wasm"))]
    let decoder = zstd::stream::read::Decoder::with_buffer(bytes)?;
    #[cfg(target_family = "wasm")]
    let decoder = in_rust(bytes)?;
    exactly(decoder, length)
}

#[cfg(any(test, target_family = "wasm"))]
fn in_rust(bytes: &[u8]) -> io::Result<impl Read> {
    ruzstd::decoding::StreamingDecoder::new(bytes).map_err(io::Error::other)
}

fn exactly(decoder: impl Read, length: usize) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    decoder.take(length as u64 + 1).read_to_end(&mut out)?;
    match out.len() == length {
        true => Ok(out),
        false if out.len() > length => Err(io::Error::other(format!("more than {length} bytes"))),
        false => Err(io::Error::other(format!("only {} bytes", out.len()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rust_unpacks_what_the_library_packed_and_refuses_the_rest() {
        let bytes: Vec<u8> = (0..200_000u32).map(|k| (k.wrapping_mul(k) >> 9) as u8).collect();
        for level in [1, 9, 22] {
            let packed = packed(&bytes, level).unwrap();
            assert_eq!(exactly(in_rust(&packed).unwrap(), bytes.len()).unwrap(), bytes);
            assert_eq!(unpacked(&packed, bytes.len()).unwrap(), bytes);
            for length in [bytes.len() - 1, bytes.len() + 1] {
                assert!(exactly(in_rust(&packed).unwrap(), length).is_err());
            }
            assert!(exactly(in_rust(&packed[..packed.len() / 2]).unwrap(), bytes.len()).is_err());
        }
        assert!(in_rust(&bytes).is_err());
    }

    #[test]
    fn the_library_unpacks_what_rust_packed() {
        use ruzstd::encoding::{CompressionLevel, compress_to_vec};
        let bytes: Vec<u8> = (0..200_000u32).map(|k| (k >> 5) as u8).collect();
        let packed = compress_to_vec(&bytes[..], CompressionLevel::Fastest);
        assert_eq!(unpacked(&packed, bytes.len()).unwrap(), bytes);
    }
}
