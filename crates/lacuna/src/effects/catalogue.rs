//! The effects that ship.

use super::*;

/// One effect of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// What it says about itself.
    pub about: About,
    /// What a diagnosis tries on a robot: usually the effect once per joint.
    pub candidates: fn(&Robot) -> Vec<Box<dyn Effect>>,
}

/// The effects that ship, one line each, simplest first: among explanations that data cannot tell apart the earlier wins.
/// Those without candidates are looked for in other ways or belong to every model.
pub const CATALOGUE: &[Entry] = &[
    Entry { about: RigidBody::ABOUT, candidates: none },
    Entry { about: TorqueOffset::ABOUT, candidates: TorqueOffset::candidates },
    Entry { about: ViscousFriction::ABOUT, candidates: ViscousFriction::candidates },
    Entry { about: CoulombFriction::ABOUT, candidates: CoulombFriction::candidates },
    Entry { about: JointZeroError::ABOUT, candidates: JointZeroError::candidates },
    Entry { about: TorqueGain::ABOUT, candidates: |r| per_joint(r, |joints| TorqueGain { joints }) },
    Entry { about: BaseTilt::ABOUT, candidates: BaseTilt::candidates },
    Entry { about: Payload::ABOUT, candidates: Payload::candidates },
    Entry { about: JointSpring::ABOUT, candidates: JointSpring::candidates },
    Entry { about: RotorInertia::ABOUT, candidates: RotorInertia::candidates },
    Entry { about: TimeDelay::ABOUT, candidates: TimeDelay::candidates },
    Entry { about: TorqueDrift::ABOUT, candidates: TorqueDrift::candidates },
    Entry { about: NonlinearViscousFriction::ABOUT, candidates: NonlinearViscousFriction::candidates },
    Entry { about: AsymmetricFriction::ABOUT, candidates: AsymmetricFriction::candidates },
    Entry { about: LoadDependentFriction::ABOUT, candidates: LoadDependentFriction::candidates },
    Entry { about: FrictionDrift::ABOUT, candidates: FrictionDrift::candidates },
    Entry { about: ThermalFriction::ABOUT, candidates: ThermalFriction::candidates },
    Entry { about: SigmoidFriction::ABOUT, candidates: SigmoidFriction::candidates },
    Entry { about: StribeckFriction::ABOUT, candidates: StribeckFriction::candidates },
    Entry { about: PreslidingHysteresis::ABOUT, candidates: PreslidingHysteresis::candidates },
    Entry { about: JointElasticity::ABOUT, candidates: JointElasticity::candidates },
    Entry { about: Backlash::ABOUT, candidates: Backlash::candidates },
    Entry { about: CoupledFriction::ABOUT, candidates: CoupledFriction::candidates },
    Entry { about: TorqueRipple::ABOUT, candidates: TorqueRipple::candidates },
    Entry { about: PositionDependentFriction::ABOUT, candidates: PositionDependentFriction::candidates },
    Entry { about: ContactForce::ABOUT, candidates: none },
    Entry { about: ScriptedEffect::ABOUT, candidates: none },
];

fn none(_robot: &Robot) -> Vec<Box<dyn Effect>> {
    Vec::new()
}

/// One instance per joint of `robot`.
pub(super) fn per_joint<E: Effect + 'static>(
    robot: &Robot,
    make: impl Fn(Joints) -> E,
) -> Vec<Box<dyn Effect>> {
    robot
        .joints
        .iter()
        .map(|joint| Box::new(make(Joints::Only(vec![joint.name.clone()]))) as Box<dyn Effect>)
        .collect()
}
