//! Whole runs into a folder.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use lightmesh_reproduce::{Error, NUMBERS, Options, PAGE, Report, SCHEMA, Verdict, Watcher, experiments, reproduce};

/// Counts pictures, and stops at one of them.
#[derive(Default)]
struct Counter {
    pictures: AtomicUsize,
    stop_at: Option<usize>,
}

impl Watcher for Counter {
    fn picture(&self, _: &str) {
        self.pictures.fetch_add(1, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.stop_at.is_some_and(|at| self.pictures.load(Ordering::Relaxed) >= at)
    }
}

fn quick(only: &[&str]) -> Options {
    Options { quick: true, only: only.iter().map(|&name| name.to_owned()).collect(), ..Options::default() }
}

fn numbers(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(folder.join(NUMBERS)).expect("numbers")).expect("JSON")
}

/// The quick run of everything: its numbers keep to the schema, every experiment is there, every claim is judged, and
/// the page needs nothing from elsewhere.
#[test]
fn all_experiments_make_a_page() {
    let folder = tempfile::tempdir().expect("folder");
    let report = reproduce(folder.path(), &quick(&[]), &()).expect("report");
    assert_eq!(report.sections.len(), experiments().count());

    let (mut schemas, mut compiler) = (boon::Schemas::new(), boon::Compiler::new());
    let schema = serde_json::from_str(SCHEMA).expect("the schema is JSON");
    compiler.add_resource("report.schema.json", schema).expect("the schema has a place");
    let schema = compiler.compile("report.schema.json", &mut schemas).expect("the schema is one");
    let numbers = numbers(folder.path());
    if let Err(error) = schemas.validate(&numbers, schema) {
        panic!("{error:#}");
    }
    let wrong = serde_json::json!({"version": "0", "date": "today"});
    assert!(schemas.validate(&wrong, schema).is_err());
    // Numbers may lose their last bits on the way.
    let read: Report = serde_json::from_value(numbers).expect("a report");
    let words = |report: &Report| -> Vec<_> {
        let claims = report.sections.iter().flat_map(|section| &section.claims);
        claims.map(|claim| (claim.claim.clone(), claim.verdict, (1e6 * claim.ours).round())).collect()
    };
    assert_eq!((read.date.as_str(), words(&read)), (report.date.as_str(), words(&report)));
    for table in report.sections.iter().flat_map(|section| &section.tables) {
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{}", table.caption);
    }

    // What the light mesh is about, whatever the machine.
    let claims = || report.sections.iter().flat_map(|section| &section.claims);
    assert!(claims().count() >= 15 && claims().all(|claim| claim.ours.is_finite()));
    for sure in [
        "The method of [4] blurs outward only.",
        "The light mesh blurs both ways.",
        "Small objects cast almost no shadow.",
    ] {
        let claim = claims().find(|claim| claim.claim == sure).expect(sure);
        assert_eq!(claim.verdict, Verdict::Holds, "{claim:?}");
    }

    let page = fs::read_to_string(folder.path().join(PAGE)).expect("page");
    assert!(!page.contains("<script") && !page.contains("src=\"http") && !page.contains("href=\"http"));
    assert_eq!(page.matches("<img").count(), page.matches("src=\"data:image/").count());
}

/// What is finished is kept: a run that is stopped goes on, and one that is repeated takes no picture.
#[test]
fn finished_experiments_are_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let options = quick(&["soft-shadows", "colour"]);
    let all = Counter::default();
    reproduce(tempfile::tempdir().expect("folder").path(), &options, &all).expect("report");
    let all = all.pictures.load(Ordering::Relaxed);
    let stopped = Counter { stop_at: Some(all - 1), ..Counter::default() };
    let error = reproduce(folder.path(), &options, &stopped).expect_err("stopped");
    assert!(error.is_cancelled() && !folder.path().join(PAGE).exists(), "{error}");

    let rest = Counter::default();
    reproduce(folder.path(), &options, &rest).expect("report");
    assert!(rest.pictures.load(Ordering::Relaxed) < all, "{all}");
    let again = Counter::default();
    let kept = reproduce(folder.path(), &options, &again).expect("report");
    assert_eq!(again.pictures.load(Ordering::Relaxed), 0);
    assert_eq!(kept.sections.len(), 2);
    // Results of another size, and spoilt ones, are none.
    fs::write(folder.path().join("experiments/colour.json"), "{").expect("file");
    reproduce(folder.path(), &options, &again).expect("report");
    assert!(again.pictures.load(Ordering::Relaxed) > 0);
    let forced = Counter::default();
    reproduce(folder.path(), &Options { force: true, ..options }, &forced).expect("report");
    assert_eq!(forced.pictures.load(Ordering::Relaxed), all);
}

#[test]
fn unknown_experiments_and_bad_folders_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let error = reproduce(folder.path(), &quick(&["alchemy"]), &()).expect_err("unknown");
    assert!(error.to_string().contains("lights, resolutions"), "{error}");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("file");
    assert!(matches!(reproduce(&file, &quick(&[]), &()), Err(Error::Io { .. })));
}
