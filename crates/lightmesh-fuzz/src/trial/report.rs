//! What a process says about its target when it ends: one line of JSON.

use serde_json::{Value, json};

/// The numbers of a target.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Report {
    pub(super) executions: u64,
    pub(super) seconds: f64,
    /// Different outcomes.
    pub(super) outcomes: u64,
    /// The longest that one input took, milliseconds.
    pub(super) slowest_ms: u64,
    pub(super) faults: Vec<Fault>,
}

/// A kind of panic.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Fault {
    /// Place and words of the first.
    pub(super) panic: String,
    /// How many inputs made it.
    pub(super) count: u64,
    /// The file with the first.
    pub(super) file: String,
}

impl Report {
    pub(super) fn to_line(&self) -> String {
        let fault = |f: &Fault| json!({"panic": f.panic, "count": f.count, "file": f.file});
        json!({
            "executions": self.executions, "seconds": self.seconds, "outcomes": self.outcomes,
            "slowest_ms": self.slowest_ms, "faults": self.faults.iter().map(fault).collect::<Vec<_>>(),
        })
        .to_string()
    }

    pub(super) fn from_line(line: &str) -> Option<Self> {
        let value: Value = serde_json::from_str(line).ok()?;
        let fault = |f: &Value| {
            let text = |key: &str| f[key].as_str().map(str::to_owned);
            Some(Fault { panic: text("panic")?, count: f["count"].as_u64()?, file: text("file")? })
        };
        Some(Self {
            executions: value["executions"].as_u64()?,
            seconds: value["seconds"].as_f64()?,
            outcomes: value["outcomes"].as_u64()?,
            slowest_ms: value["slowest_ms"].as_u64()?,
            faults: value["faults"].as_array()?.iter().map(fault).collect::<Option<_>>()?,
        })
    }

    /// Adds what another process has done.
    pub(super) fn add(&mut self, other: Self) {
        self.executions += other.executions;
        self.seconds += other.seconds;
        self.outcomes = self.outcomes.max(other.outcomes);
        self.slowest_ms = self.slowest_ms.max(other.slowest_ms);
        for fault in other.faults {
            match self.faults.iter_mut().find(|own| own.panic == fault.panic) {
                Some(own) => own.count += fault.count,
                None => self.faults.push(fault),
            }
        }
    }

    /// Inputs with values that are not finite.
    pub(super) fn not_finite(&self) -> u64 {
        self.faults.iter().filter(|f| f.panic.contains(": not finite")).map(|f| f.count).sum()
    }

    /// Inputs with other panics.
    pub(super) fn panics(&self) -> u64 {
        self.faults.iter().map(|f| f.count).sum::<u64>() - self.not_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_it_all() {
        let fault = |panic: &str, count| Fault { panic: panic.into(), count, file: "f".into() };
        let faults = vec![fault("a.rs:1: index", 3), fault("b.rs:2: not finite: x", 4)];
        let report = Report { executions: 5, seconds: 1.5, outcomes: 7, slowest_ms: 9, faults };
        assert_eq!(Report::from_line(&report.to_line()), Some(report.clone()));
        assert_eq!((report.panics(), report.not_finite()), (3, 4));
    }
}
