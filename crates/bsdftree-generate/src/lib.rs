//! Ray-traces a device into a variable-resolution BSDF.
