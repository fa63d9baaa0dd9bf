//! Variable-resolution BSDFs.
