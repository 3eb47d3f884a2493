//! Kinds of files, and where their problems stand.

use std::path::Path;

use lacuna::check::{Kind, Options, file};
use lacuna::{Error, Result};

#[test]
fn files_are_recognised_and_problems_have_their_place() -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let none = Options::default();
    for (name, kind) in [
        ("robots/panda.ron", Kind::DenavitHartenberg),
        ("robots/six_axis.urdf", Kind::Urdf),
        ("scenarios/panda.ron", Kind::Scenario),
        ("scenarios/panda_table3.ron", Kind::Coefficients),
        ("scenarios/panda_bounds.ron", Kind::Constraints),
        ("columns/ur_rtde.ron", Kind::ColumnMap),
        ("tests/fixtures/logs/two_link.csv", Kind::Log),
        ("tests/mystery_plants/one.ron", Kind::Experiment),
    ] {
        let report = file(&root.join(name), &none);
        println!("{}", report.text());
        assert_eq!(report.kind, Some(kind), "{name}");
        assert!(report.is_sound(), "{name}: {:?}", report.problems);
        assert!(
            report.text().lines().all(|l| l.chars().count() <= 80 || l.contains(name)),
            "{name} is too wide"
        );
    }
    let folder = tempfile::tempdir().map_err(|e| Error::new(e.to_string()))?;
    let bad = folder.path().join("bad.ron");
    let text = "(\n    robot: \"none.ron\",\n    logs: Files(fit: [\"a.csv\", \"b.csv\"]),\n)\n";
    std::fs::write(&bad, text).map_err(|e| Error::new(e.to_string()))?;
    let report = file(&bad, &none);
    assert_eq!(report.problems.len(), 3, "robot and both logs: {:?}", report.problems);
    assert!(report.unusable().is_none() && !report.is_sound());
    std::fs::write(&bad, text.replace("logs:", "log:")).map_err(|e| Error::new(e.to_string()))?;
    let report = file(&bad, &none);
    assert_eq!(report.problems[0].line, Some(3), "{:?}", report.problems);
    assert!(report.unusable().is_some());
    Ok(())
}
