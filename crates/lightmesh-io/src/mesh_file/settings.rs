//! The settings that a file keeps, as options.

use lightmesh::RenderOptions;
use lightmesh::schema::{RENDER, Value};
use serde_json::Map;

/// Returns a value of a settings object as options read it; `None` where there is none.
pub fn setting(settings: &Map<String, serde_json::Value>, key: &str) -> Option<Value> {
    match settings.get(key)? {
        serde_json::Value::String(text) => Some(Value::Text(text.clone())),
        serde_json::Value::Number(number) => {
            number.as_u64().map(Value::Whole).or_else(|| number.as_f64().map(Value::Real))
        }
        _ => None,
    }
}

/// Returns the options that a settings object describes; `None` where one of them cannot be used.
pub(super) fn render_options(json: &str) -> Option<RenderOptions> {
    let settings: Map<String, serde_json::Value> = serde_json::from_str(json).ok()?;
    let mut values = Vec::new();
    for entry in &RENDER {
        if let Some(value) = setting(&settings, entry.about.key()) {
            values.push((entry.about.name, entry.about.read(&value).ok()?));
        }
    }
    RenderOptions::chosen(|name| values.iter().find(|(key, _)| *key == name).map(|(_, value)| value)).ok()
}
