//! `--time-limit`.

use std::time::Duration;

/// Parses seconds above 0; a nanosecond is the least.
pub(crate) fn parse(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s: &f64| *s > 0.0);
    let limit = seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    limit.filter(|limit| !limit.is_zero()).ok_or_else(|| "expected seconds above 0, as in 10 or 0.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_above_zero() {
        assert_eq!(parse("10"), Ok(Duration::from_secs(10)));
        assert_eq!(parse("0.25"), Ok(Duration::from_millis(250)));
        for bad in ["", "0", "-1", "1e-20", "nan", "inf", "1e30", "10s"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}
