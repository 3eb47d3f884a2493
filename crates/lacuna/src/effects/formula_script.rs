//! A formula as an effect script, for people to read, change, name and add.

use super::{Curve, Effect, Formula, Own};

impl Curve {
    /// Lines before the columns, and the shape as script text; `x` is the variable, `with` has the numbers.
    fn script(self) -> (&'static str, Vec<(&'static str, &'static str)>) {
        let u = "    let u = (x - with.a) / with.w;\n";
        match self {
            Self::Wave { .. } => ("", vec![("_sin", "sin(with.k * x)"), ("_cos", "cos(with.k * x)")]),
            Self::Above { .. } => ("", vec![("", "max(x - with.a, 0.0)")]),
            Self::Below { .. } => ("", vec![("", "max(with.a - x, 0.0)")]),
            Self::Step { .. } => {
                ("    let step = if x >= with.a { 1.0 } else { 0.0 };\n", vec![("", "step")])
            }
            Self::Bump { .. } => (u, vec![("", "exp(-(u * u))")]),
            Self::Detent { .. } => (u, vec![("", "u * exp(-(u * u))")]),
            Self::Linear => ("", vec![("", "x")]),
            Self::Square => ("", vec![("", "x * x")]),
            Self::Size => ("", vec![("", "abs(x)")]),
            Self::SignedSquare => ("", vec![("", "x * abs(x)")]),
            Self::Sign => ("", vec![("", "sign(x)")]),
        }
    }
}

impl Formula {
    /// Unit of its amplitudes; `x` is the variable's own unit.
    pub(super) fn unit(&self) -> &'static str {
        let power = match self.shape {
            Curve::Linear | Curve::Size | Curve::Above { .. } | Curve::Below { .. } => 1,
            Curve::Square | Curve::SignedSquare => 2,
            _ => 0,
        };
        match (&self.own, power) {
            (Own::Speed, 0) => "N m s/rad",
            (Own::Speed, 1) => "N m s/rad/x",
            (Own::Speed, _) => "N m s/rad/x^2",
            (_, 0) => "N m",
            (_, 1) => "N m/x",
            (_, _) => "N m/x^2",
        }
    }

    /// The formula as an effect script. `rank` keeps the symbols of several scripts of one joint apart;
    /// `found` says what it was with its numbers.
    pub fn script(&self, rank: usize, found: &str) -> String {
        let (before, shapes) = self.shape.script();
        let (mark, unit) = ("_another".repeat(rank), self.unit());
        let parameters: Vec<String> = shapes
            .iter()
            .map(|(tail, shape)| {
                format!(
                    "#{{ symbol: \"c{mark}{tail}\", unit: \"{unit}\", meaning: \"amplitude of {shape}\" }}"
                )
            })
            .collect();
        let (own, factor) = match self.own {
            Own::One => (String::new(), ""),
            Own::Speed => ("    let own = now.dq_sharp;\n".into(), "own * "),
            Own::Sign if self.width > 0.0 => {
                (format!("    let own = tanh(now.dq_sharp / {:?});\n", self.width), "own * ")
            }
            Own::Sign => ("    let own = sign(now.dq_sharp);\n".into(), "own * "),
        };
        let columns: Vec<String> = shapes.iter().map(|(_, shape)| format!("{factor}{shape}")).collect();
        let (joint, variable) = (&self.joint, &self.variable);
        format!(
            "// Proposed by `lacuna diagnose`: what is left on {joint} depends on {variable}, and this shape fits it:\n\
             //   {found}\n\
             // It predicts, it does not name a cause. Read it, change it, give it a name; `--add` takes it as it is.\n\n\
             fn about() {{\n    #{{\n        title: \"unknown on {joint}, depends on {variable}\",\n        \
             text: \"A shape that a diagnosis proposed where no known effect explains the joint.\",\n        \
             equation: \"{found}\",\n        confused_with: \"any effect of the catalogue on the same variable\",\n        \
             joints: [{joint:?}],\n        parameters: [\n            {},\n        ],\n{}    }}\n}}\n\n\
             fn columns(joint, now, memory, with) {{\n    let x = {};\n{own}{before}    [{}]\n}}\n",
            parameters.join(",\n            "),
            self.script_shapes(),
            self.script_variable(),
            columns.join(", ")
        )
    }

    /// The numbers of the shape, with the values they have.
    fn script_shapes(&self) -> String {
        let shape = |s: super::Shape| {
            format!(
                "            #{{\n                symbol: \"{}\", unit: \"1\", meaning: \"number of the shape\",\n                \
                 value: {:?}, min: {:?}, max: {:?},\n            }},\n",
                s.symbol, s.value, s.low, s.high
            )
        };
        let all: String = self.shapes().into_iter().map(shape).collect();
        if all.is_empty() { all } else { format!("        shapes: [\n{all}        ],\n") }
    }

    /// The variable at one moment.
    fn script_variable(&self) -> String {
        let name = &self.variable;
        let of = |kind: &str| -> Option<String> {
            let number: usize = name.strip_prefix(kind)?.parse().ok()?;
            Some(format!("now.joint({number}).{kind}"))
        };
        if name == "time" {
            return "now.t".into();
        }
        of("ddq").or_else(|| of("dq")).or_else(|| of("q")).unwrap_or_else(|| format!("now.channel({name:?})"))
    }
}
