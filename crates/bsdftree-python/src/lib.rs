//! The extension module `bsdftree._core`: arrays in, arrays out, no logic. `python/bsdftree` is what people import.

mod arrays;
mod bsdf;
mod check;
mod component;
mod generate;
mod peaks;

use pyo3::prelude::*;

/// Adds everything to the module.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bsdf::Bsdf>()?;
    module.add_class::<component::Tree>()?;
    module.add_class::<component::Matrix>()?;
    module.add_class::<generate::Device>()?;
    module.add_class::<generate::Generation>()?;
    module.add_function(wrap_pyfunction!(generate::device_families, module)?)?;
    module.add_function(wrap_pyfunction!(generate::generate, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_function(wrap_pyfunction!(peaks::peaks, module)?)?;
    Ok(())
}
