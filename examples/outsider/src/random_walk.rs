use lacuna::Result;
use lacuna::form::Form;
use lacuna::retrieval::catalogue::EngineAbout;
use lacuna::retrieval::{Problem, RetrievalEngine, Retrieved, Step, Watch};
use serde::{Deserialize, Serialize};

/// A random walk that only goes where violation, then objective, is less: the simplest engine there is.
/// It takes any form and needs no gradients; a few unknowns are all it can handle.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RandomWalk {
    /// The user's name for it.
    pub label: String,
    /// Steps to take.
    pub steps: u64,
}

impl Default for RandomWalk {
    fn default() -> Self {
        Self { label: "random_walk".into(), steps: 200_000 }
    }
}

#[typetag::serde(name = "random_walk")]
impl RetrievalEngine for RandomWalk {
    fn about(&self) -> EngineAbout {
        EngineAbout {
            name: "random_walk",
            title: "a random walk that only goes where it is better",
            text: "The simplest engine there is, for a few unknowns; it shows what an engine has to do.",
            takes: "every constraint",
            example: r#"{"random_walk": (steps: 200000)}"#,
            settings: &[EngineAbout::LABEL, ("steps", "steps to take")],
        }
    }

    fn label(&self) -> &str {
        &self.label
    }

    fn accepts(&self, _form: &Form) -> Result<(), String> {
        Ok(())
    }

    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
        let bounds = &problem.chart.space().parameters;
        let mut draw = Draw(problem.seed);
        let mut best: Vec<f64> = bounds.iter().map(|b| 0.5 * (b.lower + b.upper)).collect();
        let mut value = worth(problem, &best);
        let (mut width, mut taken, mut stopped) = (0.25, 0, false);
        while taken < self.steps && !stopped {
            taken += 1;
            let step = |(x, b): (&f64, &lacuna::space::Parameter)| {
                (x + width * (b.upper - b.lower) * draw.next()).clamp(b.lower, b.upper)
            };
            let next: Vec<f64> = best.iter().zip(bounds).map(step).collect();
            let found = worth(problem, &next);
            // Wider after a success, narrower after a failure, and wide again when it got stuck.
            width *= if found < value { 1.5 } else { 0.96 };
            if width < 1e-10 {
                width = 0.1;
            }
            if found < value {
                (best, value) = (next, found);
            }
            if taken % 1000 == 0 {
                let done = taken as f64 / self.steps as f64;
                stopped = watch(&Step { done, objective: value.1, violation: value.0 }).is_break();
            }
        }
        Ok(Retrieved {
            z: problem.chart.unknowns(&best),
            runs: 1,
            stages: 1,
            evaluations: taken,
            status: format!("{taken} steps"),
            stopped,
            lower_bound: None,
        })
    }
}

/// Violation first, objective second.
fn worth(problem: &Problem, p: &[f64]) -> (f64, f64) {
    let z = problem.chart.unknowns(p);
    let violation = problem.forms.iter().map(|form| form.violation(&z)).fold(0.0, f64::max);
    (violation, problem.objective.value(&z))
}

/// Uniform numbers from -1 to 1 (splitmix64): the same on every machine.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
