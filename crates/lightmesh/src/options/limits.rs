//! What a render may take of the machine.

/// What a render may take of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Limit of what a render may hold in memory, bytes.
    pub max_memory: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_memory: 4 << 30 }
    }
}

/// Units and their bytes; the longer names first, as they end in the shorter.
const UNITS: [(&str, u64); 9] = [
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
    ("TiB", 1 << 40),
    ("KB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("TB", 1_000_000_000_000),
    ("B", 1),
];

pub(super) const EXPECTED_BYTES: &str = "a size above 0 with a unit, as in 4GiB, 512MiB or 2GB";

/// Returns the bytes that a text names: a number with a unit, in any case; bytes where it has no unit. `None` where it
/// names none, or less than one.
pub fn parse_bytes(text: &str) -> Option<u64> {
    if let Ok(bytes) = text.trim().parse::<u64>() {
        return Some(bytes).filter(|&bytes| bytes > 0);
    }
    let lower = text.trim().to_ascii_lowercase();
    let with_unit =
        UNITS.iter().find_map(|(unit, bytes)| Some((lower.strip_suffix(&unit.to_ascii_lowercase())?, *bytes)));
    let (number, unit) = with_unit.unwrap_or((&lower, 1));
    let bytes = number.trim().parse::<f64>().ok().map(|n| n * unit as f64);
    bytes.filter(|b| *b >= 1.0 && *b < u64::MAX as f64).map(|bytes| bytes as u64)
}

/// Returns a number of bytes as a user would write it: in the largest binary unit that divides it.
pub fn spell_bytes(bytes: u64) -> String {
    let unit = UNITS[..4].iter().rev().find(|(_, size)| bytes >= *size && bytes.is_multiple_of(*size));
    unit.map_or_else(|| bytes.to_string(), |(unit, size)| format!("{}{unit}", bytes / size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_and_binary_units() {
        assert_eq!(parse_bytes("512MiB"), Some(512 << 20));
        assert_eq!(parse_bytes("2GB"), Some(2_000_000_000));
        assert_eq!(parse_bytes("1.5 gib"), Some(3 << 29));
        assert_eq!(parse_bytes("4096"), Some(4096));
        assert_eq!(parse_bytes("7B"), Some(7));
        for bad in ["", "GiB", "0", "-1GiB", "1 XB", "nan", "inf", "1e30GiB"] {
            assert_eq!(parse_bytes(bad), None, "{bad}");
        }
    }

    #[test]
    fn sizes_are_spelled_in_the_largest_unit() {
        for (bytes, text) in
            [(4 << 30, "4GiB"), (3 << 19, "1536KiB"), (1000, "1000"), (u64::MAX, "18446744073709551615")]
        {
            assert_eq!(spell_bytes(bytes), text);
            assert_eq!(parse_bytes(text), Some(bytes));
        }
    }
}
