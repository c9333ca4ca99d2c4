//! Parts of pictures as Python's dicts and tuples, which processes hand each other.

use std::ops::Range;

use lightmesh::RenderStats;
use lightmesh::distributed::{EmitterEdges, PartialImage, PictureSamples};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::{arrays, error, json};

/// Converts a part of a picture into a dict.
pub(crate) fn to_dict(py: Python<'_>, part: PartialImage) -> PyResult<Bound<'_, PyDict>> {
    let PartialImage { waves, values, emitter_seen, stats } = part;
    let dict = PyDict::new(py);
    dict.set_item("first", waves.start)?;
    dict.set_item("last", waves.end)?;
    dict.set_item("values", values.into_pyarray(py))?;
    dict.set_item("seen", emitter_seen.into_pyarray(py))?;
    dict.set_item("stats", json::written(serde_json::to_string(&stats))?)?;
    Ok(dict)
}

/// Converts the dict that [`to_dict`] made back.
pub(crate) fn from_dict(dict: &Bound<'_, PyDict>) -> PyResult<PartialImage> {
    let item = |name: &str| {
        let missing = || error::option(dict.py(), format!("portions: one has no {name:?}"));
        dict.get_item(name)?.ok_or_else(missing)
    };
    let waves: Range<u64> = item("first")?.extract()?..item("last")?.extract()?;
    let text: String = item("stats")?.extract()?;
    let stats: RenderStats =
        serde_json::from_str(&text).map_err(|error| error::option(dict.py(), format!("portions: stats: {error}")))?;
    let values = arrays::floats(&item("values")?, "values")?.values;
    Ok(PartialImage { waves, values, emitter_seen: arrays::bytes(&item("seen")?, "seen")?, stats })
}

/// Converts the tuple that PictureJob.outlines returned.
pub(crate) fn outlines_of(value: &Bound<'_, PyTuple>) -> PyResult<EmitterEdges> {
    let (seen, waves): (Bound<'_, PyAny>, u64) = value.extract()?;
    Ok(EmitterEdges { emitter_seen: arrays::bytes(&seen, "outlines")?, waves })
}

/// Selects the samples of the outlines, or all samples where there are none.
pub(crate) fn samples(outlines: Option<&EmitterEdges>) -> PictureSamples<'_> {
    outlines.map_or(PictureSamples::All, PictureSamples::EmitterEdges)
}
