//! Options as Python gives them, in the words of the command line.

use std::ffi::OsString;
use std::path::PathBuf;

use lightmesh_cli::Keywords;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::arrays;
use crate::error::{self, Raise};

/// Options of reading, which a scene that is there no longer has, and the camera, which is an argument of its own.
const OTHERS: [&str; 4] = ["units", "scene", "allow_outside", "camera"];

/// Options by name; those that are `None` are left out.
pub(crate) type Pairs = Vec<(String, OsString)>;

/// The name of every option of the command line that is not about its files, and its default there as text; `None`
/// where it depends on other options or is nothing.
#[pyfunction(name = "_option_defaults")]
pub(crate) fn option_defaults(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let defaults = PyDict::new(py);
    for keyword in lightmesh_cli::keywords() {
        defaults.set_item(keyword.name, keyword.default)?;
    }
    Ok(defaults)
}

/// What `function` was given as options of a render.
pub(crate) fn pairs(function: &str, options: Option<&Bound<'_, PyDict>>) -> PyResult<Pairs> {
    pairs_without(function, &[], options)
}

/// The same of a function that does not have these.
pub(crate) fn pairs_without(function: &str, missing: &[&str], options: Option<&Bound<'_, PyDict>>) -> PyResult<Pairs> {
    let known = lightmesh_cli::keywords();
    let is_other = |name: &str| OTHERS.contains(&name) || missing.contains(&name);
    let is_known = |name: &str| !is_other(name) && known.iter().any(|keyword| keyword.name == name);
    let mut pairs = Pairs::new();
    for (name, value) in options.into_iter().flatten() {
        let name: String = name.extract()?;
        if !is_known(&name) {
            let message = format!("{function}() got an unexpected keyword argument '{name}'");
            return Err(PyTypeError::new_err(message));
        }
        if !value.is_none() {
            let text = spell(&name, &value)?;
            pairs.push((name, text));
        }
    }
    // A list of no layers is none.
    pairs.retain(|(name, text)| name != "aov" || !text.is_empty());
    Ok(pairs)
}

/// `pairs` where both say something, else what one of them says.
pub(crate) fn over(base: &Pairs, pairs: &Pairs) -> Pairs {
    let mut merged = base.clone();
    merged.retain(|(name, _)| pairs.iter().all(|(other, _)| other != name));
    merged.extend(pairs.iter().cloned());
    merged
}

/// Parses them as the command line does, and checks what depends on several.
pub(crate) fn parse(py: Python<'_>, pairs: &Pairs) -> PyResult<Keywords> {
    let pairs = pairs.iter().map(|(name, value)| (name.as_str(), value.clone()));
    let keywords = Keywords::parse(pairs).map_err(|error| error.raise(py))?;
    keywords.mesh_options().validate().map_err(|error| error.raise(py))?;
    keywords.emitters().options().validate().map_err(|error| error.raise(py))?;
    Ok(keywords)
}

/// A value in the words of the command line.
pub(crate) fn spell(name: &str, value: &Bound<'_, PyAny>) -> PyResult<OsString> {
    let py = value.py();
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_str()?.into());
    }
    if value.is_instance_of::<PyBool>() {
        return Err(unfit(name, value));
    }
    match name {
        "size" => {
            let (width, height): (u64, u64) = value.extract().map_err(|_| unfit(name, value))?;
            return Ok(format!("{width}x{height}").into());
        }
        "aov" => {
            let names: Vec<String> = value.extract().map_err(|_| unfit(name, value))?;
            return Ok(names.join(",").into());
        }
        "environment" => {
            if let Ok(path) = value.extract::<PathBuf>() {
                return Ok(path.into());
            }
            if arrays::dimensions(value) == Some(3) {
                let message = "environment: a map that is an array belongs to the scene: Scene.set_environment";
                return Err(error::option(py, message));
            }
            let [r, g, b] = arrays::vec3(value, name).map_err(|_| unfit(name, value))?.to_array();
            return Ok(format!("{r},{g},{b}").into());
        }
        _ => {}
    }
    // A whole number or a real one, also of NumPy's.
    if let Ok(whole) = value.call_method0("__index__") {
        return Ok(whole.str()?.to_str()?.into());
    }
    let real: f64 = value.extract().map_err(|_| unfit(name, value))?;
    Ok(format!("{real:?}").into())
}

fn unfit(name: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let kind = value.get_type().name().map_or_else(|_| "that".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{name}: a value of type {kind} is none that it can have"))
}
