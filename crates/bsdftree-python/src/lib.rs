//! The extension module `bsdftree._core`: arrays in, arrays out, no logic. `python/bsdftree` is what people import.

mod arrays;
mod bsdf;
mod check;
mod component;
mod convert;
mod device;
mod fit;
mod from_function;
mod generate;
mod layout;
mod matrices;
mod measurement;
mod peaks;
mod reduce;

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
    module.add_class::<measurement::Measurement>()?;
    module.add_class::<device::Device>()?;
    module.add_class::<generate::Generation>()?;
    module.add_class::<fit::Fit>()?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(bsdftree::color::xyz_from_rgb);
    module
        .add("MEASUREMENT_FORMATS", bsdftree_fit::read::Format::ALL.map(bsdftree_fit::read::Format::name))?;
    module.add("XYZ_FROM_RGB", [0, 1, 2].map(|row| columns.map(|column| column[row])))?;
    module.add_function(wrap_pyfunction!(device::device_families, module)?)?;
    module.add_function(wrap_pyfunction!(generate::generate, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_class::<reduce::PyGoal>()?;
    module.add_function(wrap_pyfunction!(reduce::tree_of_grid, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::tree_of_noisy_grid, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::reduced, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::reduced_bsdf, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::reduced_bsdf_to, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::all_trees, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::with_trees, module)?)?;
    module.add_function(wrap_pyfunction!(reduce::loss, module)?)?;
    module.add_function(wrap_pyfunction!(check::repaired, module)?)?;
    module.add_function(wrap_pyfunction!(check::faults, module)?)?;
    module.add_function(wrap_pyfunction!(peaks::peaks, module)?)?;
    module.add_function(wrap_pyfunction!(convert::to_klems, module)?)?;
    module.add_function(wrap_pyfunction!(convert::to_tree, module)?)?;
    module.add_function(wrap_pyfunction!(convert::relative_l1, module)?)?;
    module.add_function(wrap_pyfunction!(convert::turned, module)?)?;
    module.add_function(wrap_pyfunction!(convert::mirrored, module)?)?;
    module.add_function(wrap_pyfunction!(convert::flipped, module)?)?;
    module.add_function(wrap_pyfunction!(convert::chosen, module)?)?;
    module.add_function(wrap_pyfunction!(convert::merge, module)?)?;
    module.add_function(wrap_pyfunction!(convert::stack, module)?)?;
    module.add_function(wrap_pyfunction!(convert::layer_absorptances, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::matrix, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::patch_areas, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::read_radiance_matrix, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::write_radiance_matrix, module)?)?;
    module.add_function(wrap_pyfunction!(from_function::from_callable, module)?)?;
    module.add_function(wrap_pyfunction!(from_function::from_cal, module)?)?;
    Ok(())
}
