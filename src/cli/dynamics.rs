use std::fmt::Write;
use std::path::PathBuf;

use lacuna::check::{Kind, misplaced};
use lacuna::export::Parameters;
use lacuna::kernels::{Chain, State, Workspace, inverse_dynamics, lagrangian_torque, wrench};
use lacuna::log::Log;
use lacuna::robot::Robot;
use lacuna::{Error, Result};

use super::{Global, open_model, open_robot, print_document, say};

/// Arguments of `lacuna dynamics`.
#[derive(Debug, clap::Args)]
pub(super) struct Dynamics {
    /// Robot file: URDF, or a Denavit-Hartenberg table in RON.
    #[arg(long, value_name = "FILE")]
    robot: PathBuf,
    /// Model file (RON) whose link parameters replace the robot file's inertias: model.ron of a study that retrieved
    /// them. Its friction is left out: inverse dynamics are those of the links.
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// States (CSV): columns q1..qn, dq1..dqn, ddq1..ddqn, or with joint names.
    #[arg(long, value_name = "CSV")]
    states: PathBuf,
    /// Add the force and moment that each joint carries, in and about its link frame.
    #[arg(long)]
    wrenches: bool,
    /// How the torque is computed; the two agree to rounding.
    #[arg(long, value_enum, default_value_t = Form::NewtonEuler)]
    form: Form,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<String>,
}

/// Ways to the same torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Form {
    /// Recursive Newton-Euler.
    NewtonEuler,
    /// M(q) ddq + c(q, dq) + g(q) from the static regressor and Christoffel symbols (eq. 23).
    Lagrangian,
}

impl Dynamics {
    pub(super) fn run(self, global: &Global) -> Result<bool> {
        if self.wrenches && self.form == Form::Lagrangian {
            return Err(Error::new("--wrenches: the Lagrangian form knows no joint wrenches")
                .help("leave out --form lagrangian"));
        }
        if global.json {
            return Err(Error::new("--json: `dynamics` prints CSV").help("leave out --json"));
        }
        let mut robot = open_robot(&self.robot, self.gravity.as_deref())?;
        if let Some(path) = &self.model {
            let file = open_model(path)?;
            let parameters = Parameters::read(&file, &robot).map_err(|e| e.in_file(path))?;
            for (link, inertia) in robot.links.iter_mut().zip(parameters.links) {
                link.inertia = Some(inertia);
            }
        }
        let massless: Vec<&str> =
            robot.links.iter().filter(|l| l.inertia.is_none()).map(|l| l.name.as_str()).collect();
        if massless.len() == robot.dof() {
            return Err(Error::new("no link of the robot has an inertia")
                .in_file(&self.robot)
                .help("inverse dynamics needs masses and inertias in the robot file"));
        }
        if !massless.is_empty() && !global.quiet {
            say(&format!("note: no inertia in the file, taken as massless: {}", massless.join(", ")));
        }
        let states =
            Log::open_states(&self.states, &robot).map_err(|e| misplaced(e, &self.states, &[Kind::Log]))?;
        if let Some((reason, dropped)) = states.dropped.iter().next() {
            return Err(Error::new(format!("{} rows cannot be used: {reason}", dropped.rows))
                .in_file(&self.states)
                .at(dropped.first_line, dropped.first_column)
                .help("every state needs numbers in all q, dq and ddq columns"));
        }
        let table = table(&robot, &states, self.wrenches, self.form).map_err(|e| e.in_file(&self.states))?;
        print_document(&table)?;
        Ok(true)
    }
}

fn table(robot: &Robot, states: &Log, wrenches: bool, form: Form) -> Result<String> {
    let n = robot.dof();
    let label = |j: usize| {
        if states.named_joints { format!("_{}", robot.joints[j].name) } else { (j + 1).to_string() }
    };
    let mut header: Vec<String> = (0..n).map(|j| format!("tau{}", label(j))).collect();
    if wrenches {
        for j in 0..n {
            header.extend(["fx", "fy", "fz", "nx", "ny", "nz"].map(|c| format!("{c}{}", label(j))));
        }
    }
    let mut text = header.join(",") + "\n";
    let (chain, parameters) = (Chain::new(robot), robot.inertial_parameters_or_zero());
    let (Some(dq), Some(ddq)) = (&states.dq, &states.ddq) else { return Ok(text) };
    let mut ws = Workspace::new(&chain, 0.0);
    let mut tau = vec![0.0; n];
    for k in 0..states.q[0].len() {
        let at = |columns: &[Vec<f64>]| -> Vec<f64> { columns.iter().map(|c| c[k]).collect() };
        let (q, dq, ddq) = (at(&states.q), at(dq), at(ddq));
        let state = State::new(&q, &dq, &ddq);
        match form {
            Form::NewtonEuler => inverse_dynamics(&chain, &mut ws, state, &parameters, &mut tau),
            Form::Lagrangian => tau = lagrangian_torque(&chain, state, &parameters),
        }
        let mut numbers = tau.clone();
        if wrenches {
            for j in 0..n {
                let (force, moment) = wrench(&ws, j);
                numbers.extend(force.into_iter().chain(moment));
            }
        }
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(Error::new(format!("the torque of state {} is too large for a number", k + 1))
                .help("check units and exponents of this row: rad, rad/s and rad/s²"));
        }
        for (i, x) in numbers.iter().enumerate() {
            // Seventeen significant digits bring every number back exactly.
            let _ = write!(text, "{}{x:.16e}", if i > 0 { "," } else { "" });
        }
        text.push('\n');
    }
    Ok(text)
}
