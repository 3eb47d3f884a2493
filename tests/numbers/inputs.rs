//! Examples of files: robots, scenarios, experiments, column maps, models, published numbers, logs.

use std::path::PathBuf;

use lacuna::identify::BaseParameters;
use lacuna::log::{ColumnMap, Log};
use lacuna::model_file::ModelFile;
use lacuna::robot::Robot;
use lacuna::scenario::{Published, Scenario};
use lacuna::signals::{Settings, prepare};
use lacuna::simulate::Experiment;
use lacuna::text;

use super::plugins::{shipped, take_experiment};
use super::walk::{Input, Refused};

/// The repository.
pub fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The robot of two links.
pub fn robot() -> Robot {
    shipped("two_link.ron")
}

pub fn all() -> Vec<Input> {
    [scenarios(), experiments(), robots(), logs(), vec![settings(), model(), published()]]
        .into_iter()
        .flatten()
        .collect()
}

fn apart(text: &str) -> String {
    text.replace(", ", ",\n")
}

fn scenarios() -> Vec<Input> {
    let sources = [
        r#"poses: ReadOut(coefficients: "c.ron", count: 50, noise_percent: 0.03), gravity: (0, 0, -9.81),
            drop_above_percent: 30, intervals: (), choice: Nearest(), engines: [{"penalty": (runs: 2)}]"#,
        r#"logs: Simulated((motion: Random(harmonics: 3, period_s: 5, amplitude: 0.4), duration_s: 5,
            controller: (gains: (stiffness: [100], damping: [10]), torque_limits: [90]),
            sensors: (position_noise: [0.1], position_step: [0.1], velocity_noise: [0.1], torque_noise: [0.1],
            torque_wander: [0.1], reader: ()), effects: [{"backlash": (gaps: [0.1])}])),
            hold_out: SamePhase(period_s: 5, folds: 8), friction: (published: "p.ron", coefficients: "c.ron")"#,
        r#"logs: Simulated((motion: Fourier((period_s: 5, a: [[1, 2]], b: [[1, 2]], q0: [0, 0])), duration_s: 5)),
            hold_out: Contiguous(block_s: 1, folds: 8)"#,
        r#"logs: Simulated((motion: Sinusoidal((amplitudes: [1, 2], periods_s: [3, 4], q0: [0, 0])), duration_s: 5))"#,
    ];
    let take = |text: &str| Scenario::parse(text).map(|_| ()).map_err(Refused::Read);
    sources
        .iter()
        .map(|source| {
            let scenario = Scenario::parse(&format!("(robot: \"r.ron\", {source})"));
            let scenario = scenario.unwrap_or_else(|e| panic!("{source}: {e}"));
            let full = text::to_ron(&scenario).expect("scenarios are written");
            Input::new("scenario", "scenario", apart(&full), take)
        })
        .collect()
}

fn experiments() -> Vec<Input> {
    let robot = here().join("robots/two_link.ron");
    let write = |more: &str, motion: &str| {
        let text = format!(
            "(robot: {robot:?}, gravity: (0, 0, -9.81), {more}
            controller: (), sensors: (sampling_time_s: 0.005, reader: ()),
            logs: [(name: \"a\", duration_s: 0.1, ramp_s: 0.02, seed: 3, motion: {motion})])"
        );
        let experiment: Experiment = text::from_ron(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
        let full = text::to_ron(&experiment).expect("experiments are written");
        Input::new("simulate", "experiment", apart(&full), take_experiment)
    };
    vec![
        write("", "Random(harmonics: 2, period_s: 1, amplitude: 0.2)"),
        write("", "Fourier((period_s: 5, a: [[0.1, 0.2]], b: [[0.1, 0.2]], q0: [0, 0]))"),
        write("method: RungeKutta,", "Sinusoidal((amplitudes: [0.1, 0.2], periods_s: [3, 4], q0: [0, 0]))"),
        write(
            "parameters: [(8, 0, -6, 0, 6, 0, 0, 0.5, 0, 6), (3, -0.3, 0, 0, 0.1, 0, 0, 0.2, 0, 0.2)],",
            "Random(harmonics: 2, period_s: 1, amplitude: 0.2)",
        ),
    ]
}

fn robots() -> Vec<Input> {
    let take = |robot: Result<Robot, lacuna::Error>| {
        let base = BaseParameters::new(&robot.map_err(Refused::Read)?);
        let sound = base.map.iter().all(|x| x.is_finite());
        if sound { Ok(()) } else { Err(Refused::Broken("base parameters are not finite".into())) }
    };
    let table = r#"(name: "r", convention: Modified, gravity: (0, 0, -9.81), rows: [
        (a: 0, alpha: 1.5, d: 0.3, theta: 0.1, limits: (lower: -1, upper: 1, velocity: 2, effort: 87),
        inertia: (mass: 2, com: (0.1, 0.2, 0.3), tensor: (xx: 0.3, xy: 0, xz: 0, yy: 0.3, yz: 0, zz: 0.3)))],
        frames: [(name: "flange", a: 0, alpha: 0, d: 0.1, theta: 0, link: 1)])"#;
    let urdf = r#"<robot name="r">
        <link name="base"/>
        <link name="arm"><inertial>
            <origin xyz="0.1 0.2 0.3" rpy="0 0.1 0"/>
            <mass value="2.5"/>
            <inertia ixx="0.3" ixy="0.1" ixz="0" iyy="0.3" iyz="0" izz="0.3"/>
        </inertial></link>
        <joint name="turn" type="revolute">
            <origin xyz="0 0 0.16" rpy="0.1 0 0"/>
            <parent link="base"/><child link="arm"/>
            <axis xyz="0 0.5 1"/>
            <limit lower="-2.2" upper="2.2" effort="150" velocity="3.5"/>
            <dynamics damping="0.7" friction="0.2"/>
        </joint></robot>"#;
    vec![
        Input::new("robot", "table", apart(table), move |text| take(Robot::from_dh(text))),
        Input {
            quoted: true,
            ..Input::new("robot", "urdf", urdf.to_owned(), move |text| take(Robot::from_urdf(text)))
        },
    ]
}

/// A log of the robot of two links, as text: half a minute at 20 Hz.
fn csv() -> String {
    let row = |k: i32| {
        let t = 0.05 * f64::from(k);
        let (q, dq) = ([(0.7 * t).sin(), (1.1 * t).cos()], [0.7 * (0.7 * t).cos(), -1.1 * (1.1 * t).sin()]);
        format!("{t:.2},{:.6},{:.6},{:.6},{:.6},{:.3},{:.3}\n", q[0], q[1], dq[0], dq[1], dq[0], 3.0 * q[1])
    };
    let rows: String = (0..600).map(row).collect();
    format!("t,q1,q2,dq1,dq2,tau1,tau2\n{rows}")
}

fn log(text: &str, map: Option<&ColumnMap>) -> Result<Log, lacuna::Error> {
    Log::from_reader(std::io::Cursor::new(text.as_bytes().to_vec()), "log.csv", &robot(), map)
}

/// The signal step, on a log.
fn prepared(log: &Log, settings: &Settings) -> Result<(), Refused> {
    let (run, _) = prepare(log, settings).map_err(Refused::Use)?;
    let all = [&run.q, &run.dq, &run.ddq, &run.tau];
    let sound = all.into_iter().flatten().flatten().all(|x| x.is_finite());
    if sound { Ok(()) } else { Err(Refused::Broken("what comes of the log is not finite".into())) }
}

/// Parts of a log whose numbers are replaced: two rows in the middle, and a map with every field.
fn logs() -> Vec<Input> {
    let csv = csv();
    let lines: Vec<&str> = csv.split_inclusive('\n').collect();
    let rows = Input {
        around: (lines[..300].concat(), lines[302..].concat()),
        ..Input::new("log", "rows", lines[300..302].concat(), |text| {
            let log = log(text, None).map_err(Refused::Read)?;
            prepared(&log, &Settings { trim_s: 1.0, ..Settings::default() })
        })
    };
    let maps = [
        r#"(time: (column: 1, unit: Seconds), position: (columns: [2, 3], sign: [1, -1], offset: [0.1, 0.2]),
            velocity: (columns: [4, 5], sign: [1, -1]), torque: (columns: [6, 7], sign: [1, -1]))"#,
        r#"(time: (rate_hz: 20), position: (columns: "q{1}"), torque: (current: "tau{1}", gains: [2, 3]))"#,
    ];
    let take = move |text: &str| {
        let map = ColumnMap::parse(text).map_err(Refused::Read)?;
        let log = log(&csv, Some(&map)).map_err(Refused::Use)?;
        prepared(&log, &Settings { trim_s: 1.0, ..Settings::default() })
    };
    let map = |text: &&str| Input::new("log", "column map", apart(text), take.clone());
    maps.iter().map(map).chain([rows]).collect()
}

fn settings() -> Input {
    let log = log(&csv(), None).expect("the log is sound");
    let settings = Settings { mode: lacuna::signals::Mode::Parallel, band_hz: 4.0, ..Settings::default() };
    let text = text::to_ron(&settings).expect("settings are written");
    Input::new("signals", "settings", text, move |text| {
        let settings: Settings = text::from_ron(text).map_err(Refused::Read)?;
        prepared(&log, &settings)
    })
}

fn model() -> Input {
    let text = r#"(lacuna: "0.1.0", robot: "two_link", origin: "a test", signals: (),
        effects: [{"rigid_body": ()}, {"viscous_friction": ()}], parameters: [
        (symbol: "Jzz2", value: 1.5, unit: "kg m^2", standard_error: 0.1),
        (symbol: "fv1", value: 0.5, unit: "N m s/rad"), (symbol: "fv2", value: 0.5, unit: "N m s/rad")])"#;
    let model = ModelFile::parse(text).unwrap_or_else(|e| panic!("{e}"));
    let full = text::to_ron(&model).expect("models are written");
    Input::new("model_file", "model", apart(&full), |text| {
        let model = ModelFile::parse(text).map_err(Refused::Read)?;
        let (_, x) = model.on(&robot()).map_err(Refused::Use)?;
        let sound = x.iter().all(|x| x.is_finite());
        if sound { Ok(()) } else { Err(Refused::Broken("the parameters are not finite".into())) }
    })
}

fn published() -> Input {
    let text = std::fs::read_to_string(here().join("scenarios/two_link_coefficients.ron")).expect("shipped");
    Input::new("scenario", "published coefficients", text, |text| {
        Published::parse(text).map(|_| ()).map_err(Refused::Read)
    })
}
