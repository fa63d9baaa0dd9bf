//! Numbers and text as bytes: little-endian, text as its length and UTF-8.

use super::error::BinaryError;

/// A number in its bytes.
pub(super) trait Number: Sized {
    /// Appends it.
    fn put(self, out: &mut Vec<u8>);
    /// The one that comes next.
    fn take(bytes: &mut Bytes<'_>) -> Result<Self, BinaryError>;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Number for $number {
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn take(bytes: &mut Bytes<'_>) -> Result<$number, BinaryError> {
                const LEN: usize = size_of::<$number>();
                let taken = bytes.array::<LEN>(stringify!($number))?;
                Ok(<$number>::from_le_bytes(taken))
            }
        }
    )*};
}

numbers!(u8, u16, u32, u64, f32, f64);

/// Appends a text.
pub(super) fn put_text(text: &str, out: &mut Vec<u8>) -> Result<(), String> {
    let length = u32::try_from(text.len());
    length.map_err(|_| format!("a text of {} bytes; a .bsdft file holds up to 4 GiB", text.len()))?.put(out);
    out.extend_from_slice(text.as_bytes());
    Ok(())
}

/// Bytes that are taken one after the other.
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Those that begin at a byte of the file.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Bytes<'a> {
        Bytes { rest: bytes, at }
    }

    /// Where the next one is.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// How many are left.
    pub(super) fn left(&self) -> usize {
        self.rest.len()
    }

    /// The next `n`.
    pub(super) fn take(&mut self, n: usize, what: &str) -> Result<&'a [u8], BinaryError> {
        let Some((taken, rest)) = self.rest.split_at_checked(n) else {
            let found = format!("the end after {} bytes", self.rest.len());
            return Err(BinaryError::damaged(self.at, found, format!("{what} of {n} bytes")));
        };
        (self.rest, self.at) = (rest, self.at + n);
        Ok(taken)
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], BinaryError> {
        Ok(*self.take(N, what)?.first_chunk().expect("as many were taken"))
    }

    /// The next text.
    pub(super) fn text(&mut self) -> Result<String, BinaryError> {
        let length = u32::take(self)? as usize;
        let at = self.at;
        let text = std::str::from_utf8(self.take(length, "a text")?);
        text.map(str::to_owned).map_err(|e| BinaryError::damaged(at, format!("text with {e}"), "UTF-8"))
    }
}
