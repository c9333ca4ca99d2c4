//! What `--error` says at the end: whether the bound is kept, what is wrong if not, and what would help.

use lightmesh::ErrorEstimate;

/// Caustics below this part of the light, or of the error, are not worth a word.
const FEW_CAUSTICS: f64 = 0.005;

/// Returns whether the estimate is within the bound, as it is printed: to a tenth of a percent.
pub(crate) fn is_kept(bound: f32, estimate: &ErrorEstimate) -> bool {
    estimate.all <= f64::from(bound) + 5e-4
}

/// Returns whether light by way of mirrors and glass is much of the light, or of the error.
pub(crate) fn lacks_caustics(estimate: &ErrorEstimate) -> bool {
    estimate.caustics > FEW_CAUSTICS.max(0.2 * estimate.all)
}

/// Says in one sentence how large the error is, and whether that is within the bound.
pub(crate) fn verdict(bound: f32, estimate: &ErrorEstimate) -> String {
    let error = 100.0 * estimate.all;
    if estimate.all == 0.0 {
        return "every light is traced at every hit: the light is exact".into();
    }
    if is_kept(bound, estimate) {
        return format!("the picture's error is about {error:.1}%, verified by paths");
    }
    let asked = (1e4 * f64::from(bound)).round() / 100.0;
    format!("the picture's error is about {error:.1}%, more than the {asked}% asked for")
}

/// Says it, then what the light lacks and what would help where the bound is not kept; a line each.
pub(crate) fn lines(bound: f32, estimate: &ErrorEstimate) -> Vec<String> {
    let mut lines = vec![verdict(bound, estimate)];
    let ErrorEstimate { all, direct, bias, caustics, path_spp, .. } = *estimate;
    if lacks_caustics(estimate) {
        lines.push(format!(
            "{:.1}% of the light comes by way of mirrors or glass, which gather rays find only by chance (caustics)",
            100.0 * caustics
        ));
    }
    if !is_kept(bound, estimate) {
        let part = if 2.0 * direct.powi(2) > all.powi(2) { "direct" } else { "indirect" };
        let brightness = match 100.0 * bias {
            percent if percent >= 0.05 => format!("; the picture is {percent:.1}% too bright"),
            percent if percent <= -0.05 => format!("; the picture is {:.1}% too dark", -percent),
            _ => String::new(),
        };
        lines.push(format!("most of the error is in the {part} light{brightness}"));
        if path_spp > 0 {
            let spp = path_spp.next_power_of_two();
            lines.push(format!("by the noise of the paths, --method path --spp {spp} would keep it"));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_that_is_kept_is_one_line() {
        let estimate = ErrorEstimate { all: 0.031, direct: 0.03, path_spp: 900, ..ErrorEstimate::default() };
        assert_eq!(lines(0.05, &estimate), ["the picture's error is about 3.1%, verified by paths"]);
        assert_eq!(lines(0.05, &ErrorEstimate::default()).len(), 1);
    }

    /// Half the light comes by way of a mirror and is missing.
    #[test]
    fn what_is_missing_is_named() {
        let estimate =
            ErrorEstimate { all: 0.6, direct: 0.1, bias: -0.5, caustics: 0.5, path_spp: 900, uncertainty: 0.01 };
        let said = lines(0.05, &estimate).join("\n");
        for part in ["60.0%", "more than the 5%", "50.0% of the light", "indirect", "50.0% too dark", "--spp 1024"] {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
}
