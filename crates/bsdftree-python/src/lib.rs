//! The extension module `bsdftree._core`: arrays in, arrays out, no logic. `python/bsdftree` is what people import.

mod arrays;
mod bsdf;
mod check;
mod component;
mod convert;
mod device;
mod generate;
mod layout;
mod peaks;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

fn value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Adds everything to the module.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bsdf::Bsdf>()?;
    module.add_class::<component::Tree>()?;
    module.add_class::<component::Matrix>()?;
    module.add_class::<layout::Layout>()?;
    module.add_class::<device::Device>()?;
    module.add_class::<generate::Generation>()?;
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(bsdftree::color::xyz_from_rgb);
    module.add("XYZ_FROM_RGB", [0, 1, 2].map(|row| columns.map(|column| column[row])))?;
    module.add_function(wrap_pyfunction!(device::device_families, module)?)?;
    module.add_function(wrap_pyfunction!(generate::generate, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_function(wrap_pyfunction!(peaks::peaks, module)?)?;
    module.add_function(wrap_pyfunction!(convert::to_klems, module)?)?;
    module.add_function(wrap_pyfunction!(convert::to_tree, module)?)?;
    module.add_function(wrap_pyfunction!(convert::relative_l1, module)?)?;
    Ok(())
}
