//! Formulas that are tried: the same shape over one variable, with its grid of places and widths.

use super::Search;
use super::variable::{Variable, periodic};
use crate::effects::{Curve, Formula, Own};

/// Places tried over the range of a variable.
const PLACES: usize = 24;
/// Widths of bumps tried \[rad\].
const BUMPS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Frequencies of something that comes and goes with time \[Hz\], tried in steps of a part of one over the log's length;
/// in a log of more than a minute only the lowest of them, up to 0.1 Hz and 120 over its length.
const CLOCK: [f64; 2] = [0.1, 2.0];
const CLOCK_STEP: f64 = 0.3;

impl Search<'_> {
    /// Families over one variable.
    pub(super) fn families(&self, variable: &Variable) -> Vec<Vec<Formula>> {
        let mut curves: Vec<Vec<Curve>> = vec![vec![Curve::Linear], vec![Curve::Square]];
        match variable {
            Variable::Position(_) => {
                curves.push((1..=12).map(|k| Curve::Wave { k: 0.5 + 0.5 * f64::from(k) }).collect());
            }
            Variable::Speed(_) | Variable::Acceleration(_) => {
                curves.extend([vec![Curve::Size], vec![Curve::SignedSquare]]);
                // A sign of the joint's own velocity is Coulomb friction; how sharp it is, is no physics.
                if !matches!(variable, Variable::Speed(i) if *i == self.joint) {
                    curves.push(vec![Curve::Sign]);
                }
            }
            Variable::Time | Variable::Channel(_) => {}
        }
        curves.extend(self.placed(variable));
        self.with_own(variable, &curves)
    }

    /// Curves over a variable, each with every factor of the joint's own velocity.
    fn with_own(&self, variable: &Variable, curves: &[Vec<Curve>]) -> Vec<Vec<Formula>> {
        let joint = &self.data.robot.joints[self.joint].name;
        let formula = |own: Own, shape: Curve| Formula {
            joint: joint.clone(),
            own,
            variable: variable.name(),
            shape,
            width: self.width,
        };
        // Waves over the joint's own position are torque ripple and position-dependent friction, as long as these may
        // still be found.
        let own_position = matches!(variable, Variable::Position(i) if *i == self.joint);
        let named = |own: &Own, family: &[Curve]| {
            let wave = matches!(family.first(), Some(Curve::Wave { .. }));
            let open = match own {
                Own::One => self.ripple_open,
                Own::Sign => self.friction_open,
                Own::Speed => false,
            };
            own_position && wave && open
        };
        [Own::One, Own::Speed, Own::Sign]
            .into_iter()
            .flat_map(|own| curves.iter().map(move |family| (own, family)))
            .filter(|(own, family)| !named(own, family))
            .map(|(own, family)| family.iter().map(|&curve| formula(own, curve)).collect())
            .collect()
    }

    /// Shapes that have a place in the variable's range.
    fn placed(&self, variable: &Variable) -> Vec<Vec<Curve>> {
        let (low, high) = variable.range(&self.data.runs);
        let inner = |part: f64| low + part * (high - low);
        let places: Vec<f64> =
            (0..PLACES).map(|k| inner(0.05 + 0.9 * k as f64 / (PLACES - 1) as f64)).collect();
        let each = |f: &dyn Fn(f64) -> Curve| -> Vec<Curve> { places.iter().map(|&a| f(a)).collect() };
        let wide = |f: &dyn Fn(f64, f64) -> Curve| -> Vec<Curve> {
            places.iter().flat_map(|&a| BUMPS.iter().map(move |&w| (a, w))).map(|(a, w)| f(a, w)).collect()
        };
        match variable {
            Variable::Position(_) => vec![
                each(&|a| Curve::Above { a }),
                each(&|a| Curve::Below { a }),
                each(&|a| Curve::Step { a }),
                wide(&|a, w| Curve::Bump { a, w }),
                wide(&|a, w| Curve::Detent { a, w }),
            ],
            Variable::Time | Variable::Channel(_) => vec![each(&|a| Curve::Step { a })],
            Variable::Speed(_) | Variable::Acceleration(_) => Vec::new(),
        }
    }

    /// Waves over time; none where the motion repeats itself, since everything that follows it looks like a clock then.
    pub(super) fn clocks(&self) -> Vec<Vec<Formula>> {
        if periodic(&self.data.runs) {
            return Vec::new();
        }
        let (_, seconds) = Variable::Time.range(&self.data.runs);
        let step = CLOCK_STEP / seconds.max(1.0);
        let count = ((CLOCK[1] - CLOCK[0]) / step) as usize;
        let wave = |i: usize| Curve::Wave { k: std::f64::consts::TAU * (CLOCK[0] + i as f64 * step) };
        self.with_own(&Variable::Time, &[(0..=count.min(400)).map(wave).collect()])
    }
}
