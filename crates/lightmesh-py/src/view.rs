//! Arrays that are views of memory which Rust keeps.

#![allow(unsafe_code)]

use numpy::ndarray::{ArrayViewD, IxDyn};
use numpy::{Element, PyArrayDyn, PyArrayMethods};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;

/// A class that keeps values unchanged as long as its object lives: it is frozen, and the values have no interior
/// mutability.
pub(crate) trait Keeps<E: Element = f32>: Sync {
    /// Returns the values with this number; `None` if there are none.
    fn values(&self, which: usize) -> Option<&[E]>;
}

/// Makes an array of this shape over the values `which` of `owner`, without a copy. It cannot be written to, and keeps
/// the owner alive.
///
/// # Errors
/// If there are no such values, or not as many as the shape says.
pub(crate) fn of<'py, E, T>(owner: &Bound<'py, T>, which: usize, shape: &[usize]) -> PyResult<Bound<'py, PyAny>>
where
    E: Element,
    T: PyClass<Frozen = True> + Keeps<E>,
{
    let values = owner.get().values(which).unwrap_or_default();
    let view = ArrayViewD::from_shape(IxDyn(shape), values)
        .map_err(|error| crate::error::internal(&format!("{error} of {} values", values.len())))?;
    // SAFETY: `values` belongs to the frozen object `owner`, which by the contract of `Keeps` neither moves nor changes
    // it, and which the array keeps alive as its base.
    let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner.clone().into_any()) };
    array.try_readwrite().map_err(PyErr::from)?.make_nonwriteable();
    Ok(array.into_any())
}
