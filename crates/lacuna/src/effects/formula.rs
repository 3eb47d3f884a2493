use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Shape, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::signals::Run;

/// A product of a factor of the joint's own velocity and a shape of any one variable: what a diagnosis
/// proposes where no effect of the catalogue explains a joint. It describes, it does not name a cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Formula {
    /// The joint whose torque it is.
    pub joint: String,
    /// Factor of the joint's own velocity.
    #[serde(default)]
    pub own: Own,
    /// Variable: `q3`, `dq3`, `ddq3` (joints by number), `time`, or the name of a channel.
    pub variable: String,
    /// Shape over the variable.
    pub shape: Curve,
    /// Width of the smoothed sign [rad/s, m/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

/// Factor of a joint's own velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Own {
    /// None: a torque whatever the velocity.
    #[default]
    One,
    /// The velocity, like damping.
    Speed,
    /// Its sign, like dry friction.
    Sign,
}

/// Shape over a variable `x`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Curve {
    /// `sin(k x)` and `cos(k x)`.
    Wave {
        /// Waves per 2 pi.
        k: f64,
    },
    /// `max(x - a, 0)`.
    Above {
        /// Where it begins.
        a: f64,
    },
    /// `max(a - x, 0)`.
    Below {
        /// Where it ends.
        a: f64,
    },
    /// 1 from `a` on, else 0.
    Step {
        /// Where it steps.
        a: f64,
    },
    /// `exp(-((x - a) / w)^2)`.
    Bump {
        /// Centre.
        a: f64,
        /// Half width.
        w: f64,
    },
    /// `(x - a) / w exp(-((x - a) / w)^2)`: a detent.
    Detent {
        /// Centre.
        a: f64,
        /// Half width.
        w: f64,
    },
    /// `x`.
    Linear,
    /// `x^2`.
    Square,
    /// `|x|`.
    Size,
    /// `x |x|`.
    SignedSquare,
    /// Sign of `x`.
    Sign,
}

/// ` + 0.500` or ` - 0.500`.
fn plus(x: f64) -> String {
    format!(" {} {:.3}", if x < 0.0 { '-' } else { '+' }, x.abs())
}

impl Curve {
    /// Names, units and limits of its numbers, with the values they have; `low..high` is the variable's range.
    fn numbers(self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Wave { k } => vec![("k", k)],
            Self::Above { a } | Self::Below { a } | Self::Step { a } => vec![("a", a)],
            Self::Bump { a, w } | Self::Detent { a, w } => vec![("a", a), ("w", w)],
            Self::Linear | Self::Square | Self::Size | Self::SignedSquare | Self::Sign => Vec::new(),
        }
    }

    fn with(self, values: &[f64]) -> Self {
        match (self, values) {
            (Self::Wave { .. }, &[k]) => Self::Wave { k },
            (Self::Above { .. }, &[a]) => Self::Above { a },
            (Self::Below { .. }, &[a]) => Self::Below { a },
            (Self::Step { .. }, &[a]) => Self::Step { a },
            (Self::Bump { .. }, &[a, w]) => Self::Bump { a, w },
            (Self::Detent { .. }, &[a, w]) => Self::Detent { a, w },
            _ => self,
        }
    }

    /// Value at `x`; `second` is the cosine of a wave.
    fn at(self, x: f64, second: bool) -> f64 {
        match self {
            Self::Wave { k } if second => libm::cos(k * x),
            Self::Wave { k } => libm::sin(k * x),
            Self::Above { a } => (x - a).max(0.0),
            Self::Below { a } => (a - x).max(0.0),
            Self::Step { a } => f64::from(u8::from(x >= a)),
            Self::Bump { a, w } => libm::exp(-((x - a) / w) * ((x - a) / w)),
            Self::Detent { a, w } => (x - a) / w * libm::exp(-((x - a) / w) * ((x - a) / w)),
            Self::Linear => x,
            Self::Square => x * x,
            Self::Size => x.abs(),
            Self::SignedSquare => x * x.abs(),
            Self::Sign => super::parts::sign(x, 0.0),
        }
    }

    /// The shape as text, `x` being the variable's name.
    fn text(self, x: &str) -> Vec<String> {
        match self {
            Self::Wave { k } => vec![format!("sin({k:.3}*{x})"), format!("cos({k:.3}*{x})")],
            Self::Above { a } => vec![format!("max({x}{}, 0)", plus(-a))],
            Self::Below { a } => vec![format!("max({a:.3} - {x}, 0)")],
            Self::Step { a } => vec![format!("[{x} >= {a:.3}]")],
            Self::Bump { a, w } => vec![format!("exp(-(({x}{})/{w:.3})^2)", plus(-a))],
            Self::Detent { a, w } => {
                vec![format!("({x}{a})/{w:.3}*exp(-(({x}{a})/{w:.3})^2)", a = plus(-a))]
            }
            Self::Linear => vec![x.to_string()],
            Self::Square => vec![format!("{x}^2")],
            Self::Size => vec![format!("|{x}|")],
            Self::SignedSquare => vec![format!("{x}*|{x}|")],
            Self::Sign => vec![format!("sign({x})")],
        }
    }
}

impl Formula {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "formula",
        title: "a shape over one variable, without a named cause",
        text: "What a diagnosis proposes where it knows on which variable a joint's error depends, but no \
               effect of the catalogue explains it. It predicts; the cause is for people to find.",
        equation: "tau_j = c own(dq_j) shape(x), own = 1, dq_j or sign(dq_j)",
        parameters: &[Parameter::new("c", "N m per unit of the shape", "amplitude; two of them for a wave")],
        cause: "for people to find",
        confused_with: "any effect of the catalogue on the same variable",
        separation: Separation::OTHER,
        example: r#"{"formula": (joint: "2", variable: "q2", shape: Bump(a: 0.3, w: 0.1))}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Given,
        imitated_by: &[],
        special: Special::NONE,
    };

    fn joint_index(&self, robot: &Robot) -> Result<usize> {
        Ok(super::Joints::Only(vec![self.joint.clone()]).indices(robot)?[0])
    }

    fn terms_of_shape(&self) -> usize {
        if matches!(self.shape, Curve::Wave { .. }) { 2 } else { 1 }
    }

    /// The formula with numbers: `0.2100*dq4*sin(3.000*q3 + 0.80)`.
    pub fn written(&self, robot: &Robot, values: &[f64]) -> String {
        let number = self.joint_index(robot).map_or(0, |j| j + 1);
        let own = match self.own {
            Own::One => String::new(),
            Own::Speed => format!("*dq{number}"),
            Own::Sign => format!("*sign(dq{number})"),
        };
        if let (Curve::Wave { k }, &[s, c]) = (self.shape, values) {
            let (size, phase) = ((s * s + c * c).sqrt(), libm::atan2(c, s));
            return format!("{size:.4}{own}*sin({k:.3}*{}{})", self.variable, plus(phase));
        }
        let shapes = self.shape.text(&self.variable);
        let terms = shapes.iter().zip(values).map(|(shape, value)| format!("{value:.4}{own}*{shape}"));
        terms.collect::<Vec<_>>().join(" + ")
    }

    /// The variable at every sample of a run.
    ///
    /// # Errors
    /// When the run has no such variable.
    fn variable<'a>(&self, at: &Stretch<'a>) -> Result<std::borrow::Cow<'a, [f64]>> {
        let run: &'a Run = at.run;
        if self.variable == "time" {
            let seconds = at.range.clone().map(|k| k as f64 * run.dt).collect();
            return Ok(std::borrow::Cow::Owned(seconds));
        }
        let column = if let Some(channel) = run.channels.get(&self.variable) {
            Some(channel)
        } else {
            let named = |prefix: &str| -> Option<usize> {
                self.variable.strip_prefix(prefix)?.parse::<usize>().ok()?.checked_sub(1)
            };
            match (named("ddq"), named("dq"), named("q")) {
                (Some(j), _, _) => run.ddq.get(j),
                (_, Some(j), _) => run.dq.get(j),
                (_, _, Some(j)) => run.q.get(j),
                _ => None,
            }
        };
        column.map(|c| std::borrow::Cow::Borrowed(&c[at.range.clone()])).ok_or_else(|| {
            let channels: Vec<&str> = run.channels.keys().map(String::as_str).collect();
            Error::new(format!("no variable `{}` in {}", self.variable, run.name))
                .help(format!("known are q1.., dq1.., ddq1.., time, {}", channels.join(", ")))
        })
    }
}

#[typetag::serde(name = "formula")]
impl Effect for Formula {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let joint = self.joint_index(robot)?;
        let numbers: Vec<String> = self.shape.numbers().iter().map(|(_, v)| format!("{v:.3}")).collect();
        let kind = format!("{:?}", self.shape);
        let kind = kind.split([' ', '{']).next().unwrap_or_default().to_lowercase();
        let own = format!("{:?}", self.own).to_lowercase();
        let stem = format!("c{}_{own}_{kind}_{}{}", joint + 1, self.variable, numbers.join("_"));
        let symbol =
            |k: usize| if self.terms_of_shape() == 2 { format!("{stem}_{}", k + 1) } else { stem.clone() };
        Ok((0..self.terms_of_shape())
            .map(|k| Term { symbol: symbol(k), unit: self.unit(), joints: vec![joint] })
            .collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let joint = self.joint_index(at.robot)?;
        let x = self.variable(at)?;
        for term in 0..self.terms_of_shape() {
            out.column(term, joint, |slot| {
                let own = at.friction_dq(joint);
                for ((y, &x), &v) in slot.iter_mut().zip(x.iter()).zip(own) {
                    let factor = match self.own {
                        Own::One => 1.0,
                        Own::Speed => v,
                        Own::Sign => super::parts::sign(v, self.width),
                    };
                    *y = factor * self.shape.at(x, term == 1);
                }
            });
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let limits = |symbol: &str, value: f64| match symbol {
            "k" => (0.5, 40.0),
            "w" => (0.3 * value, 3.0 * value),
            _ => (value - 1.0, value + 1.0),
        };
        let shape = |(symbol, value): (&'static str, f64)| {
            let (low, high) = limits(symbol, value);
            Shape { symbol, unit: "1", value, low, high, trials: vec![value] }
        };
        self.shape.numbers().into_iter().map(shape).collect()
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { shape: self.shape.with(values), ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn formula(&self) -> Option<&Formula> {
        Some(self)
    }
}
