//! The binary twin of the XML: `.bsdft` files, which hold all of a [`Bsdf`](crate::Bsdf) to the last bit. The format is `docs/bsdft.md`.
//!
//! What enters are the bytes of a file from anyone, hostile ones too; what leaves is a BSDF, or an error with the byte, what was
//! found and what was expected. A *raw* file is opened by mapping it: nothing but its head is looked at, so that it answers at once
//! whatever its size, and [`Bsdf::verify`](crate::Bsdf::verify) looks at the rest. No look-up leaves the map, whatever the file says. A *packed* file is
//! smaller and read as a whole. Memory stays within a multiple of the file, and what a file claims is never believed.
//!
//! The order of steps is `bytes` (numbers and text), `predict` (leaves by others), `head` (what the file says of itself), `values` (trees
//! and matrices), `read` and `write`; `zstandard` packs.

mod bytes;
mod error;
mod predict;
mod head;
mod read;
mod values;
mod write;
mod zstandard;

pub use error::{BinaryError, BinaryFault};
pub use read::{open, read};
pub use write::{Packing, write, write_file};

/// The first bytes of a file: a name, and line ends that a transfer as text would change.
const MAGIC: &[u8; 8] = b"BSDFT\r\n\x1a";

/// Of the format: the newest.
const VERSION: u32 = 2;

/// Of files that have no predicted values, so that older programs read them.
const FIRST_VERSION: u32 = 1;

/// Bytes before the head.
const PREAMBLE: usize = 64;

/// Heads and values begin at multiples of this, a cache line.
const ALIGNMENT: usize = 64;

/// A packed head may grow to this many times its length in the file, and so may all values together.
const MOST_GROWTH: usize = 256;

/// And by this much more: the head \[byte\].
const FREE_HEAD: usize = 1 << 20;

/// The values \[byte\].
const FREE_VALUES: usize = 1 << 28;

/// Whether a file that begins with these bytes is one of this format, whole or not.
pub fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}
