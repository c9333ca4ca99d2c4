//! Options as Python gives them: read from its objects into the values of the table of options.

use std::path::PathBuf;

use lightmesh::schema::{About, Kind, Value, closest};
use lightmesh::{Camera, RenderOptions};
use lightmesh_cli::{Chosen, EmitterArgs, choice, choices, height_for};
use pyo3::exceptions::{PyDeprecationWarning, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::arrays;
use crate::error::{self, Raise};

/// Options that were chosen, checked and ready: of a picture, of what lights the scene, and of the machine.
#[derive(Clone)]
pub(crate) struct Keywords {
    options: RenderOptions,
    emitters: EmitterArgs,
    threads: Option<usize>,
    has_size: bool,
}

impl Keywords {
    /// Checks what depends on several options.
    pub(crate) fn new(py: Python<'_>, chosen: &Chosen) -> PyResult<Self> {
        let options = chosen.render_options().map_err(|error| error.raise(py))?;
        let surroundings = chosen.surroundings();
        Ok(Self {
            options,
            emitters: surroundings.emitters,
            threads: surroundings.threads.map(|threads| threads as usize),
            has_size: chosen.get("size").is_some(),
        })
    }

    /// Returns them with the method that they stand for in this scene.
    pub(crate) fn for_scene(mut self, scene: &lightmesh::Scene) -> Self {
        self.options = self.options.for_scene(scene);
        self
    }

    /// Returns the library's options for a picture by this camera, whose aspect makes the height if no size was given.
    pub(crate) fn options(&self, camera: &Camera) -> RenderOptions {
        let width = self.options.picture.width;
        let options = self.options.clone();
        if self.has_size { options } else { options.with(|o| o.picture.height = height_for(camera, width)) }
    }

    /// Returns the library's options for all that does not depend on a picture's size.
    pub(crate) fn mesh_options(&self) -> RenderOptions {
        self.options.clone()
    }

    /// Returns what lights the scene beside its own lights.
    pub(crate) fn emitters(&self) -> &EmitterArgs {
        &self.emitters
    }

    /// Returns the number of threads, if it was given.
    pub(crate) fn threads(&self) -> Option<usize> {
        self.threads
    }
}

/// The table of options, for tests, stubs and the farm: a dictionary for each, in the order of `--help`, with name (as
/// Python spells it), default, help, methods and old_name. The default is text; None: it depends on other options, or is
/// nothing.
#[pyfunction(name = "_options")]
pub(crate) fn options(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let describe = |choice: lightmesh_cli::Choice| {
        let About { kind, help, methods, old_name, .. } = choice.about;
        let about = PyDict::new(py);
        about.set_item("name", choice.about.python_name())?;
        about.set_item("default", choice.default.map(|default| default.to_string()))?;
        about.set_item("type", python_type(kind))?;
        about.set_item("help", help)?;
        about.set_item("methods", methods.to_vec())?;
        about.set_item("old_name", old_name.map(|name| name.replace('-', "_")))?;
        Ok(about)
    };
    choices().into_iter().map(describe).collect()
}

/// Returns the kind of objects that an option takes from Python, in a word.
fn python_type(kind: Kind) -> &'static str {
    match kind {
        Kind::Whole(..) => "int",
        Kind::Real(_) => "float",
        Kind::Word { .. } => "word",
        Kind::Words(_) => "words",
        Kind::Size => "size",
        Kind::Syntax { numbers: true, .. } => "number or text",
        Kind::Syntax { numbers: false, .. } => "text",
    }
}

/// Returns what `function` was given as options of a render.
pub(crate) fn chosen(function: &str, options: Option<&Bound<'_, PyDict>>) -> PyResult<Chosen> {
    chosen_without(function, &[], options)
}

/// The same of a function that does not have these.
pub(crate) fn chosen_without(
    function: &str,
    missing: &[&str],
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Chosen> {
    let mut chosen = Chosen::default();
    for (name, value) in options.into_iter().flatten() {
        let name: String = name.extract()?;
        let about = choice(&name).filter(|about| spells(about, &name) && !missing.contains(&name.as_str()));
        let about = about.ok_or_else(|| unknown(function, missing, &name))?;
        if about.python_name() != name {
            let new = about.python_name();
            let message =
                format!("{function}(): '{name}' is now called '{new}'; the old name goes with the next version");
            let message = std::ffi::CString::new(message).unwrap_or_default();
            PyErr::warn(value.py(), &value.py().get_type::<PyDeprecationWarning>(), &message, 1)?;
        }
        if !value.is_none() {
            choose(&mut chosen, &about, &value)?;
        }
    }
    Ok(chosen)
}

/// Returns whether an option, or its old name, is spelled so in Python.
fn spells(about: &About, name: &str) -> bool {
    about.python_name() == name || about.old_name.is_some_and(|old| old.replace('-', "_") == name)
}

/// Returns the error for a name that is no option, with the one that was most likely meant.
fn unknown(function: &str, missing: &[&str], name: &str) -> PyErr {
    let names: Vec<String> = choices().iter().map(|choice| choice.about.python_name()).collect();
    let others = ["camera", "mesh", "progress"].into_iter().chain((function == "render").then_some("denoise"));
    let known = names.iter().map(String::as_str).chain(others).filter(|name| !missing.contains(name));
    let meant = closest(name, known).map_or(String::new(), |name| format!("; did you mean '{name}'?"));
    PyTypeError::new_err(format!("{function}() got an unexpected keyword argument '{name}'{meant}"))
}

/// Reads a value of Python as that of an option.
pub(crate) fn choose(chosen: &mut Chosen, about: &About, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let read = read(about, value)?;
    chosen.choose(about, &read).map_err(|error| error.raise(value.py()))
}

fn read(about: &About, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let unfit = || unfit(about, value);
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::text(text.to_str()?));
    }
    if value.is_instance_of::<PyBool>() {
        return Err(unfit());
    }
    match about.kind {
        Kind::Size => {
            let sides: Option<Vec<i64>> = value.try_iter().ok().and_then(|sides| {
                sides.map(|side| side.and_then(|side| side.extract::<i64>())).collect::<PyResult<_>>().ok()
            });
            let Some([width, height]) = sides.as_deref() else { return Err(unfit()) };
            Ok(Value::Text(format!("{width}x{height}")))
        }
        Kind::Words(_) => {
            let names: Vec<String> = value.extract().map_err(|_| unfit())?;
            Ok(Value::Text(names.join(",")))
        }
        _ if about.name == "environment" => environment(value).map_err(|error| error.unwrap_or_else(unfit)),
        Kind::Word { .. } | Kind::Syntax { numbers: false, .. } => Err(unfit()),
        Kind::Whole(..) | Kind::Real(_) | Kind::Syntax { .. } => number(value).ok_or_else(unfit),
    }
}

/// Reads a whole number or a real one, also of NumPy's.
pub(crate) fn number(value: &Bound<'_, PyAny>) -> Option<Value> {
    let whole = value.call_method0("__index__").ok().and_then(|whole| whole.extract().ok());
    whole.map(Value::Whole).or_else(|| value.extract().ok().map(Value::Real))
}

/// Reads a path or a colour; `None` for what is neither.
fn environment(value: &Bound<'_, PyAny>) -> Result<Value, Option<PyErr>> {
    if let Ok(path) = value.extract::<PathBuf>() {
        return Ok(Value::text(path.display()));
    }
    if arrays::dimensions(value) == Some(3) {
        let message = "environment: a map that is an array belongs to the scene: Scene.set_environment";
        return Err(Some(error::option(value.py(), message)));
    }
    let [r, g, b] = arrays::vec3(value, "environment").map_err(|_| None)?.to_array();
    Ok(Value::Text(format!("{r},{g},{b}")))
}

/// Returns the error for an object of a type that the option does not take.
fn unfit(about: &About, value: &Bound<'_, PyAny>) -> PyErr {
    let kind = value.get_type().name().map_or_else(|_| "that".to_owned(), |name| name.to_string());
    let expected = match about.kind {
        Kind::Whole(..) => "a whole number",
        Kind::Real(_) => "a number",
        Kind::Word { .. } => "a string",
        Kind::Words(_) => "a string or a list of strings",
        Kind::Size => "(width, height) or a string as '640x480'",
        Kind::Syntax { .. } if about.name == "environment" => "a file, a colour or a string",
        Kind::Syntax { numbers: true, .. } => "a number or a string",
        Kind::Syntax { numbers: false, .. } => "a string",
    };
    PyTypeError::new_err(format!("{}: must be {expected}, not {kind}", about.python_name()))
}
