//! Flexible columns of one variable or two, which show whether an error depends on them at all.

use std::sync::Arc;

use super::Search;
use super::variable::Variable;
use crate::diagnose::data::Column;
use crate::diagnose::score::Ridge;
use crate::effects::Own;

/// Bends of a coarse curve over a position, and of a fine one; one group with all of them would fit noise.
const BENDS: [usize; 2] = [7, 21];
/// Bends along each of two positions.
const BENDS_OF_TWO: usize = 6;
/// Groups of many columns are held back by this part of their size.
const RIDGE: f64 = 0.02;
/// Factors of the joint's own velocity.
const OWN: [Own; 3] = [Own::One, Own::Speed, Own::Sign];

/// A function of one variable and of the joint's own velocity.
type Function = Box<dyn Fn(f64, f64) -> f64 + Sync>;

/// Columns that belong together.
pub(super) struct Group {
    /// What they are functions of.
    pub variables: Vec<String>,
    pub columns: Vec<Arc<Column>>,
    pub ridge: Ridge,
}

impl Search<'_> {
    /// Groups of one variable; several of them for a position.
    pub(super) fn groups_of(&self, variable: &Variable) -> Vec<Group> {
        let (low, high) = variable.range(&self.data.runs);
        let unit = move |x: f64| (x - low) / (high - low).max(1e-12);
        let width = self.width;
        let sign = move |v: f64| libm::tanh(v / width);
        let sets: Vec<Vec<Function>> = match variable {
            Variable::Position(_) => {
                let one = |own: Own, bends: usize| -> Vec<Function> {
                    let hat_of = |h: usize| -> Function {
                        Box::new(move |x, v| own_factor(own, v, width) * hat(unit(x), h, bends))
                    };
                    (0..=bends).map(hat_of).collect()
                };
                OWN.into_iter().flat_map(|own| BENDS.map(|bends| one(own, bends))).collect()
            }
            Variable::Speed(_) => vec![vec![
                Box::new(|x, _| x * x.abs()),
                Box::new(|x, _| x * x * x),
                Box::new(|x, _| x.abs()),
                Box::new(move |x, _| sign(x)),
                Box::new(|x, _| x),
                Box::new(move |x, v| x * sign(v)),
            ]],
            Variable::Acceleration(_) => {
                vec![vec![Box::new(|x, _| x), Box::new(|x, _| x.abs()), Box::new(move |x, v| x * sign(v))]]
            }
            Variable::Time | Variable::Channel(_) => {
                let centred = move |x: f64| unit(x) - 0.5;
                let mut set: Vec<Function> = Vec::new();
                for power in 1..=3 {
                    set.push(Box::new(move |x, _| centred(x).powi(power)));
                    set.push(Box::new(move |x, v| sign(v) * centred(x).powi(power)));
                }
                set.push(Box::new(move |x, v| v * centred(x)));
                vec![set]
            }
        };
        // Bends are pieces of one curve; the others are functions of different sizes.
        let ridge = match variable {
            Variable::Position(_) => Ridge::OfAll(RIDGE),
            _ => Ridge::OfEach(RIDGE),
        };
        let variables = || vec![variable.name()];
        let group = |set: Vec<Function>| Group {
            variables: variables(),
            columns: self.columns_of(variable, &set),
            ridge,
        };
        sets.into_iter().map(group).collect()
    }

    fn columns_of(&self, variable: &Variable, functions: &[Function]) -> Vec<Arc<Column>> {
        let column = |f: &Function| {
            let column = self.data.column_of(self.joint, |run, out| {
                let (x, v) = (variable.of(run), run.friction_dq(self.joint));
                for (k, y) in out.iter_mut().enumerate() {
                    *y = f(x.at(k), v[k]);
                }
            });
            Arc::new(column)
        };
        functions.iter().map(column).collect()
    }

    /// Groups of two positions together: products of curves over either.
    pub(super) fn groups_of_two(&self, a: usize, b: usize) -> Vec<Group> {
        let (one, two) = (Variable::Position(a), Variable::Position(b));
        let unit = |variable: &Variable| {
            let (low, high) = variable.range(&self.data.runs);
            move |x: f64| (x - low) / (high - low).max(1e-12)
        };
        let (first, second) = (unit(&one), unit(&two));
        let column = |own: Own, h: usize, k: usize| {
            let column = self.data.column_of(self.joint, |run, out| {
                let (x, z, v) = (one.of(run), two.of(run), run.friction_dq(self.joint));
                for (i, y) in out.iter_mut().enumerate() {
                    let bends = hat(first(x.at(i)), h, BENDS_OF_TWO) * hat(second(z.at(i)), k, BENDS_OF_TWO);
                    *y = own_factor(own, v[i], self.width) * bends;
                }
            });
            Arc::new(column)
        };
        let places = || (0..=BENDS_OF_TWO).flat_map(|h| (0..=BENDS_OF_TWO).map(move |k| (h, k)));
        let group = |own: Own| Group {
            variables: vec![one.name(), two.name()],
            columns: places().map(|(h, k)| column(own, h, k)).collect(),
            ridge: Ridge::OfAll(RIDGE),
        };
        OWN.map(group).into()
    }
}

fn own_factor(own: Own, v: f64, width: f64) -> f64 {
    match own {
        Own::One => 1.0,
        Own::Speed => v,
        Own::Sign => libm::tanh(v / width),
    }
}

/// Linear spline number `h` of `count` over 0 to 1.
fn hat(x: f64, h: usize, count: usize) -> f64 {
    (1.0 - (x * count as f64 - h as f64).abs()).max(0.0)
}
