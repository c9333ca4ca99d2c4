//! Changes of a JSON document as a tree.

use fastrand::Rng;
use serde_json::{Map, Value, json};

use super::numbers;

/// The beginning of a text that stands for a number which JSON's values cannot hold; [`to_text`] writes it bare.
const BARE: &str = "bare number ";

/// Changes one thing.
pub(super) fn change(root: &mut Value, rng: &mut Rng) {
    let count = count(root);
    let target = rng.usize(0..count);
    match rng.u8(0..16) {
        0 => *node(root, target) = hostile(rng),
        1 => *node(root, target) = node(root, rng.usize(0..count)).clone(),
        2 => {
            // Swap two subtrees.
            let taken = std::mem::take(node(root, target));
            let other = rng.usize(0..self::count(root));
            let swapped = std::mem::replace(node(root, other), taken);
            let hole = nodes(root).position(|value| value.is_null());
            if let Some(hole) = hole {
                *node(root, hole) = swapped;
            }
        }
        3 | 4 => match node(root, container(root, rng)) {
            Value::Object(map) => {
                if let Some(key) = pick_key(map, rng) {
                    map.remove(&key);
                }
            }
            Value::Array(list) if !list.is_empty() => drop(list.remove(rng.usize(0..list.len()))),
            _ => {}
        },
        5 | 6 => repeat(root, rng),
        7 => {
            // A member of one object in another one.
            let from = container(root, rng);
            let found = match node(root, from) {
                Value::Object(map) => pick_key(map, rng).and_then(|key| map.get_key_value(&key)),
                _ => None,
            };
            if let Some((key, value)) = found.map(|(key, value)| (key.clone(), value.clone())) {
                let to = container(root, rng);
                if let Value::Object(map) = node(root, to) {
                    map.insert(key, value);
                }
            }
        }
        _ => {
            // A number, text or truth value: most faults are there.
            let leaves = nodes(root).enumerate().filter(|(_, v)| !v.is_object() && !v.is_array()).map(|(i, _)| i);
            let leaves: Vec<usize> = leaves.collect();
            if !leaves.is_empty() {
                let leaf = node(root, leaves[rng.usize(0..leaves.len())]);
                change_leaf(leaf, rng);
            }
        }
    }
}

/// Repeats an element of a list, now and then very often.
fn repeat(root: &mut Value, rng: &mut Rng) {
    let at = container(root, rng);
    if let Value::Array(list) = node(root, at)
        && !list.is_empty()
    {
        let element = list[rng.usize(0..list.len())].clone();
        let most = if rng.u8(0..32) == 0 { 200 } else { 4 };
        let times = rng.usize(1..most).min(2000 / (1 + count(&element)));
        for _ in 0..times {
            list.push(element.clone());
        }
    }
}

fn change_leaf(leaf: &mut Value, rng: &mut Rng) {
    *leaf = match leaf {
        Value::Number(number) => match rng.u8(0..8) {
            0 => json!(number.as_i64().unwrap_or(0).wrapping_add(1)),
            1 => json!(number.as_i64().unwrap_or(0).wrapping_sub(1)),
            2 => json!(-number.as_f64().unwrap_or(0.0)),
            3 => json!(rng.u32(0..8)),
            4 => json!(5120 + rng.u32(0..7)),
            5 => json!(format!("{BARE}{}", numbers::text(rng))),
            _ => hostile_number(rng),
        },
        Value::String(text) => match rng.u8(0..4) {
            0 => hostile(rng),
            1 => json!(
                ["OPAQUE", "MASK", "BLEND", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "point", "spot"]
                    [rng.usize(0..10)]
            ),
            _ => {
                let mut bytes = std::mem::take(text).into_bytes();
                super::bytes::change(&mut bytes, rng);
                json!(String::from_utf8_lossy(&bytes))
            }
        },
        Value::Bool(truth) => json!(!*truth),
        _ => hostile(rng),
    };
}

fn hostile_number(rng: &mut Rng) -> Value {
    match rng.u8(0..3) {
        0 => json!(numbers::whole(rng)),
        1 => json!(numbers::double(rng)),
        _ => json!(numbers::float(rng)),
    }
}

fn hostile(rng: &mut Rng) -> Value {
    match rng.u8(0..10) {
        0 => Value::Null,
        1 => json!([]),
        2 => json!({}),
        3 => json!(""),
        4 => json!(["../x", "/etc/passwd", "data:,", "a\u{0}b", "\u{1f600}\n", "file:///x", "C:\\x"][rng.usize(0..7)]),
        5 => json!(true),
        6 => json!([0, 0, 0]),
        7 => json!(format!("{BARE}{}", numbers::text(rng))),
        _ => hostile_number(rng),
    }
}

/// The text of a document. Now and then a member is there twice, or the text is cut.
pub(super) fn to_text(root: &Value, rng: &mut Rng) -> Vec<u8> {
    let mut text = root.to_string();
    // Numbers that are no JSON, or beyond its values.
    let quoted = format!("\"{BARE}");
    while let Some(start) = text.find(&quoted) {
        let inner = start + quoted.len();
        let end = inner + text[inner..].find('"').unwrap_or(0);
        let number = text[inner..end].to_owned();
        text.replace_range(start..(end + 1).min(text.len()), &number);
    }
    if rng.u8(0..32) == 0
        && let Some(from) = find_from(&text, ",\"", rng)
        && let Some(colon) = text[from..].find(':')
        && let Some(to) = find_from(&text, "{\"", rng)
    {
        let member =
            format!("{}{},", &text[from + 1..=from + colon], ["0", "[]", "{}", "\"\"", "null"][rng.usize(0..5)]);
        text.insert_str(to + 1, &member);
    }
    text.into_bytes()
}

/// Where a text is found at or after a random place.
fn find_from(text: &str, wanted: &str, rng: &mut Rng) -> Option<usize> {
    let start = (rng.usize(0..=text.len())..=text.len()).find(|&at| text.is_char_boundary(at))?;
    text[start..].find(wanted).map(|at| start + at)
}

/// How many values a tree has, itself among them.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(list) => list.iter().map(count).sum::<usize>(),
        Value::Object(map) => map.values().map(count).sum(),
        _ => 0,
    }
}

/// All values of a tree, itself first.
fn nodes(root: &Value) -> impl Iterator<Item = &Value> {
    let mut waiting = vec![root];
    std::iter::from_fn(move || {
        let value = waiting.pop()?;
        match value {
            Value::Array(list) => waiting.extend(list.iter().rev()),
            Value::Object(map) => waiting.extend(map.values().rev()),
            _ => {}
        }
        Some(value)
    })
}

/// The value of this index among [`nodes`].
fn node(root: &mut Value, index: usize) -> &mut Value {
    fn find<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
        if *left == 0 {
            return Some(value);
        }
        *left -= 1;
        match value {
            Value::Array(list) => list.iter_mut().find_map(|value| find(value, left)),
            Value::Object(map) => map.values_mut().find_map(|value| find(value, left)),
            _ => None,
        }
    }
    find(root, &mut { index }).expect("an index below the count")
}

/// The index of an object or a list.
fn container(root: &Value, rng: &mut Rng) -> usize {
    let all: Vec<usize> =
        nodes(root).enumerate().filter(|(_, value)| value.is_object() || value.is_array()).map(|(i, _)| i).collect();
    if all.is_empty() { 0 } else { all[rng.usize(0..all.len())] }
}

fn pick_key(map: &Map<String, Value>, rng: &mut Rng) -> Option<String> {
    if map.is_empty() {
        return None;
    }
    map.keys().nth(rng.usize(0..map.len())).cloned()
}
