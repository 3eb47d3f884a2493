//! A look along a motion before it is simulated: what the controller and the step size depend on.

use super::controller::{Reference, Tuned};
use super::effect::{Moment, PlantEffect};
use super::{ForwardDynamics, Kinematics, WorldFrame};
use lacuna_base::excitation::Motion;

/// Instants looked at.
const LOOKS: usize = 64;

/// What a motion asks of a robot.
#[derive(Debug, Clone)]
pub(super) struct Survey {
    /// Mean inertia of every joint [kg m², kg].
    pub(super) inertia: Vec<f64>,
    /// Largest load of effects on every joint, their states at zero [N m, N].
    pub(super) friction: Vec<f64>,
    /// Diagonal of the inverse mass matrix at every instant looked at.
    mobility: Vec<Vec<f64>>,
    /// Steepest slopes of the effects over velocity, and over position.
    slope: Vec<f64>,
    stiffness: Vec<f64>,
    /// How fast the effects' own states forget \[1/s\].
    own_rate: f64,
}

impl Survey {
    /// Looks along the first `duration` seconds of `motion`.
    pub(super) fn along(
        motion: &dyn Motion,
        duration: f64,
        effects: &[&dyn PlantEffect],
        arm: &Kinematics,
        dynamics: &mut ForwardDynamics,
        world: &mut WorldFrame,
    ) -> Self {
        let n = motion.dof();
        let zero = vec![0.0; n];
        let [inertia, friction, slope, stiffness] = std::array::from_fn(|_| zero.clone());
        let mut survey = Self { inertia, friction, mobility: vec![], slope, stiffness, own_rate: 0.0 };
        for effect in effects {
            effect.add_steepest_slope(&mut survey.slope);
            effect.add_stiffness(&mut survey.stiffness);
            survey.own_rate = survey.own_rate.max(effect.fastest_own_rate());
        }
        let mut at = Reference::new(n);
        for k in 0..LOOKS {
            let t = duration * k as f64 / (LOOKS - 1) as f64;
            motion.at(t, &mut at.q, &mut at.dq, &mut at.ddq);
            let mut load = zero.clone();
            for effect in effects {
                let own = vec![0.0; effect.states(n)];
                let now = Moment { t, q: &at.q, dq: &at.dq, tau: &zero, own: &own, arm };
                effect.add_load(&now, &mut load);
            }
            let inertia = world.joint_inertia(&at.q);
            for j in 0..n {
                survey.inertia[j] += inertia[j] / LOOKS as f64;
                survey.friction[j] = survey.friction[j].max(load[j].abs());
            }
            survey.mobility.push(dynamics.mobility(&at.q));
        }
        survey
    }

    /// An upper bound of how fast the controlled robot can change [1/s].
    ///
    /// The damping matrix in front of the inverse mass matrix has eigenvalues below the trace of their
    /// product, and the trace needs only diagonals since damping and stiffness act joint by joint.
    pub(super) fn fastest_rate(&self, control: &Tuned) -> f64 {
        let rate = |mobility: &Vec<f64>| {
            let (mut damping, mut stiffness) = (0.0, 0.0);
            for (j, m) in mobility.iter().enumerate() {
                damping += m * (control.loops[j].damping + self.slope[j]);
                stiffness += m * (control.loops[j].stiffness + self.stiffness[j]);
            }
            f64::max(damping, stiffness.sqrt())
        };
        self.mobility.iter().map(rate).fold(self.own_rate, f64::max)
    }
}
