//! `--max-memory`.

/// The default of [`RenderOptions`](lightmesh::RenderOptions), as the user would write it; a test holds them together.
pub(crate) const DEFAULT: &str = "4GiB";

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

/// Parses a number with a unit, in any case; bytes where none is said.
pub(crate) fn parse(text: &str) -> Result<u64, String> {
    let lower = text.trim().to_ascii_lowercase();
    let with_unit =
        UNITS.iter().find_map(|(unit, bytes)| Some((lower.strip_suffix(&unit.to_ascii_lowercase())?, *bytes)));
    let (number, unit) = with_unit.unwrap_or((&lower, 1));
    let bytes = number.trim().parse::<f64>().ok().map(|n| n * unit as f64);
    match bytes.filter(|b| *b >= 1.0 && *b < u64::MAX as f64) {
        Some(bytes) => Ok(bytes as u64),
        None => Err("expected a size above 0 with a unit, as in 4GiB, 512MiB or 2GB".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use lightmesh::RenderOptions;

    use super::*;

    #[test]
    fn decimal_and_binary_units() {
        assert_eq!(parse("512MiB"), Ok(512 << 20));
        assert_eq!(parse("2GB"), Ok(2_000_000_000));
        assert_eq!(parse("1.5 gib"), Ok(3 << 29));
        assert_eq!(parse("4096"), Ok(4096));
        assert_eq!(parse("7B"), Ok(7));
        for bad in ["", "GiB", "0", "-1GiB", "1 XB", "nan", "inf", "1e30GiB"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_default_is_the_librarys() {
        assert_eq!(parse(DEFAULT), Ok(RenderOptions::default().max_memory));
    }
}
