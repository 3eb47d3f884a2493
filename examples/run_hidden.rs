//! dev only
use lacuna::diagnose::{Limits, Request, Start, diagnose};
use lacuna::scenario::HoldOut;
use lacuna::signals::{Mode, Run, Settings};
use lacuna::simulate::hidden::{Choice, Draw, Family, hidden};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let seed: u64 = a[1].parse().unwrap();
    let choices: Vec<Choice> = a[2..]
        .chunks(3)
        .map(|c| Choice { family: Family::named(&c[0]).unwrap(), joint: c[1].parse::<usize>().unwrap() - 1, strength: c[2].parse().unwrap() })
        .collect();
    let Draw::Data(data) = hidden(&choices, seed).unwrap() else { panic!("excluded") };
    println!("noise {:?}", data.noise);
    for s in &data.secrets {
        println!("{} {:?} {} size {}", s.family, s.joint, s.strength, s.size);
    }
    let request = Request {
        robot: &data.robot,
        logs: data.fit.clone(),
        reference: data.reference.clone(),
        validate: vec![data.unseen.clone()],
        start: Start::Effects(data.baseline.clone()),
        settings: Settings { mode: Mode::Parallel, band_hz: 8.0, trim_s: 1.0, ..Settings::default() },
        choose_signals: true,
        folds: &|runs: &[Run]| HoldOut::Auto.folds(runs),
        add: Vec::new(),
        auto: true,
        nested: None,
        extra: Vec::new(),
        limits: Limits::default(),
        seed,
    };
    let start = std::time::Instant::now();
    let outcome = diagnose(request, &mut |s| println!("{:6.1} {s}", start.elapsed().as_secs_f64())).unwrap();
    let d = outcome.diagnosis;
    println!("signals {:?} {:?} {:?} {:?}", d.signals.source_of_velocity, d.signals.position_cutoff_hz, d.signals.friction_cutoff_hz, d.signals.sign_width);
    println!("gate {:?} stop {}", d.gate, d.stop_reason);
    println!("first {:?}", d.first);
    for m in d.missing.iter().chain(&d.minor) {
        println!("{} {:?} z {:.1} gain {:.1} also {:?} {:?}", m.effect, m.joints, m.z, m.gain_percent, m.also_possible, m.parameters.iter().map(|p| format!("{}={:.5}+-{:?}", p.name, p.value, p.standard_error)).collect::<Vec<_>>());
    }
    for u in &d.unexplained {
        println!("UNKNOWN {} {:?} {:?} z {:.1} nearest {:?}", u.joint, u.depends_on, u.formula, u.z, u.nearest);
    }
    for r in &d.refused {
        println!("refused {} {:?} {}", r.effect, r.joints, r.reason);
    }
    for j in &d.joints {
        println!("{} {:.4} -> {:.4}", j.name, j.held_out_rms, j.held_out_rms_after);
    }
    if let Some(v) = &d.validation {
        println!("validation {:?}", v.rms);
    }
}
