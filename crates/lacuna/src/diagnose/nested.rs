//! The same search on the first part of the data, scored on the rest: selection and score share nothing.

use super::answer::Nested;
use super::data::Data;
use super::entry::{self, Request};
use super::search::search;
use super::signals::Chosen;
use crate::error::{Error, Part, Result};
use crate::predict::{predict, prediction_errors};
use crate::report::finite;
use crate::signals::Run;

/// Searches in the rows before `until_s` and scores on those after.
pub(super) fn run(
    request: &Request<'_>,
    chosen: &Chosen,
    until_s: f64,
    say: &mut dyn FnMut(&str),
) -> Result<Nested> {
    let (early, late) = split(&chosen.runs, until_s)?;
    let data = Data::new(request.robot, early.clone(), (request.folds)(&early)?)?;
    say(&format!("the same search on the data before {until_s} s"));
    let mut ladder = entry::start(data, request, chosen, say)?;
    let before = ladder.parts.effects();
    search(&mut ladder, request, say)?;
    let after = ladder.parts.effects();
    let error = |effects| -> Result<Option<f64>> {
        let (model, found) = super::unseen::fitted(&ladder.data, effects)?;
        let runs = crate::identify::with_model_torque(&model, &found.x, &late)?;
        Ok(finite(prediction_errors(&runs, &predict(&model, &runs, &found.x)?).pooled_percent))
    };
    Ok(Nested {
        until_s,
        effects: ladder.rungs.iter().map(|r| ladder.parts.title(r.part, request.robot)).collect(),
        before_relative_error_percent: error(before)?,
        after_relative_error_percent: error(after)?,
    })
}

/// Rows before and after a time, run by run.
fn split(runs: &[Run], until_s: f64) -> Result<(Vec<Run>, Vec<Run>)> {
    let (mut early, mut late) = (Vec::new(), Vec::new());
    for run in runs {
        let Some(filter) = &run.row_filter else { continue };
        let cut = (libm::round((until_s - run.start) / run.dt).max(0.0) as usize)
            .clamp(filter.range.start, filter.range.end);
        // A second apart, so that the filter does not carry anything across.
        let gap = libm::round(0.5 / run.dt) as usize;
        let (a, b) = (
            filter.range.start..cut.saturating_sub(gap).max(filter.range.start),
            (cut + gap).min(filter.range.end)..filter.range.end,
        );
        for (range, list) in [(a, &mut early), (b, &mut late)] {
            if range.len() > 10 * filter.every {
                let mut part = run.clone();
                if let Some(filter) = &mut part.row_filter {
                    filter.range = range;
                }
                list.push(part);
            }
        }
    }
    if early.is_empty() || late.is_empty() {
        return Err(Error::new(format!("nothing lies on one side of {until_s} s"))
            .help("give a time in the middle of the log, in seconds on its own clock")
            .of_part(Part::Nested));
    }
    Ok((early, late))
}
