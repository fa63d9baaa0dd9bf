"""What the library does in a second, from Rust and from NumPy, beside Radiance's own."""
