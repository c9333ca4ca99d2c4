//! Material extensions that are not read: only whether they would change the surface.

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// The factors that switch an extension on. Each is 0 or absent where the surface is the same without the extension.
const FACTORS: [&str; 7] = [
    "clearcoatFactor",
    "sheenColorFactor",
    // Of KHR_materials_volume, whose glass is clear without it.
    "attenuationDistance",
    "iridescenceFactor",
    "anisotropyStrength",
    "dispersion",
    "diffuseTransmissionFactor",
];

/// Whether an extension's object, of whatever shape, has one of [`FACTORS`] that is not zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Effect(pub(crate) bool);

impl<'de> Deserialize<'de> for Effect {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EffectVisitor)
    }
}

/// Takes any JSON: what is not read cannot be wrong.
struct EffectVisitor;

impl<'de> Visitor<'de> for EffectVisitor {
    type Value = Effect;

    fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("anything")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Effect, E> {
        Ok(Effect(value != 0.0))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Effect, E> {
        Ok(Effect(value != 0))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Effect, E> {
        Ok(Effect(value != 0))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Effect, E> {
        Ok(Effect(false))
    }

    fn visit_str<E>(self, _: &str) -> Result<Effect, E> {
        Ok(Effect(false))
    }

    fn visit_unit<E>(self) -> Result<Effect, E> {
        Ok(Effect(false))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Effect, A::Error> {
        let mut any = false;
        while let Some(Effect(item)) = items.next_element()? {
            any |= item;
        }
        Ok(Effect(any))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Effect, A::Error> {
        let mut any = false;
        while let Some(key) = entries.next_key::<String>()? {
            if FACTORS.contains(&key.as_str()) {
                any |= entries.next_value::<Effect>()?.0;
            } else {
                entries.next_value::<IgnoredAny>()?;
            }
        }
        Ok(Effect(any))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_factors_count_whatever_the_rest_is() {
        for (json, effect) in [
            (r#"{"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 3}}"#, true),
            (r#"{"clearcoatFactor": 0, "clearcoatRoughnessFactor": 1}"#, false),
            (r#"{"sheenColorFactor": [0, 0, 0.1]}"#, true),
            (r#"{"sheenColorFactor": [0, 0.0, -0.0], "sheenRoughnessFactor": 1}"#, false),
            (r#"{"anisotropyStrength": -1}"#, true),
            (r#"{"thicknessFactor": 1, "attenuationColor": [1, 1, 1]}"#, false),
            (r#"{"dispersion": "much"}"#, false),
            ("{}", false),
            ("null", false),
            (r#"[true, {"a": [{}]}]"#, false),
        ] {
            assert_eq!(serde_json::from_str::<Effect>(json).unwrap(), Effect(effect), "{json}");
        }
    }
}
