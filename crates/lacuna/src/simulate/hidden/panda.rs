//! The robot that effects are hidden in.

use super::{Choice, noise_seed};
use crate::error::Result;
use crate::plant::{CoulombFriction, Method, PerJoint, Plant, Sensors, TorqueOffset, ViscousFriction};
use crate::random::Stream;
use crate::robot::Robot;

/// Friction of the size that the public log of a Panda shows (rounded): viscous [N m s/rad], Coulomb [N m],
/// offset [N m].
const VISCOUS: [f64; 7] = [0.07, 0.20, 0.04, 0.23, 0.10, 0.04, 0.06];
const COULOMB: [f64; 7] = [0.25, 0.20, 0.18, 0.36, 0.27, 0.17, 0.21];
const OFFSET: [f64; 7] = [-0.11, -0.16, -0.07, -0.25, 0.005, 0.09, -0.01];

/// Torque noise per sample at 500 Hz and slow torque noise [N m]: in a band of 8 Hz about what does not repeat
/// between two rounds of the public log.
const WHITE: [f64; 7] = [0.20, 0.18, 0.14, 0.12, 0.056, 0.035, 0.025];
const WANDER: [f64; 7] = [0.045, 0.060, 0.040, 0.035, 0.012, 0.010, 0.007];

/// Steps between two samples: a quarter of a millisecond each, which leaves errors of a thousandth of a N m, far
/// below the noise.
const SUB_STEPS: usize = 8;

/// The shipped Panda, which this library carries with it.
pub(super) fn robot() -> Result<Robot> {
    Robot::from_dh(include_str!("../../../../../robots/panda.ron"))
}

/// What is drawn of the plant itself.
pub(super) struct Ground {
    viscous: [f64; 7],
    coulomb: [f64; 7],
    offset: [f64; 7],
    /// How sharp Coulomb friction is [rad/s].
    pub(super) width: f64,
}

impl Ground {
    /// Friction near the usual one; what is hidden itself is not in it.
    pub(super) fn draw(choices: &[Choice], seed: u64) -> Self {
        let mut stream = Stream::new(noise_seed(seed, 3000), 0);
        let mut near = |usual: [f64; 7], family: &str| {
            let mut drawn = usual.map(|x| x * stream.between(0.7, 1.3));
            for choice in choices.iter().filter(|c| c.family.name == family) {
                drawn[choice.joint] = 0.0;
            }
            drawn
        };
        let viscous = near(VISCOUS, ViscousFriction::TWIN.name);
        let coulomb = near(COULOMB, CoulombFriction::TWIN.name);
        let offset = near(OFFSET, TorqueOffset::TWIN.name);
        // From sharper to softer than a model's usual sign, evenly in the logarithm.
        let width = 2e-3 * libm::pow(10.0, stream.uniform());
        Self { viscous, coulomb, offset, width }
    }

    /// The plant with its sensors.
    pub(super) fn plant(&self, robot: Robot) -> Result<Plant> {
        let sensors = Sensors {
            sampling_time_s: 2e-3,
            position_noise: PerJoint::all(1e-4),
            position_step: PerJoint::all(2.4e-5),
            velocity_noise: PerJoint::all(1e-3),
            torque_noise: WHITE.into(),
            torque_wander: WANDER.into(),
            ..Sensors::default()
        };
        let mut plant = Plant::new(robot)?
            .with_effect(ViscousFriction { coefficients: self.viscous.into() })
            .with_effect(CoulombFriction { levels: self.coulomb.into(), width: self.width })
            .with_effect(TorqueOffset { offsets: self.offset.into() })
            .with_sensors(sensors);
        plant.method = Method::Implicit;
        plant.sub_steps = Some(SUB_STEPS);
        Ok(plant)
    }
}
