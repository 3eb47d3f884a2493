//! The order of the search: contacts, climbing, looking back, calibrating, doubting.

use super::data::Data;
use super::doubts;
use super::entry::Request;
use super::ladder::Ladder;
use super::sharpness::sharpen_again;
use super::signals::{Chosen, prepared};
use crate::error::Result;
use crate::log::Log;
use crate::signals::Settings;

/// Rounds of climbing and looking back at most.
const ROUNDS: usize = 3;
/// Robots move below this frequency \[Hz\].
const OF_A_MOTION: f64 = 1.5;

/// Searches, and drops what is noise of the acceleration.
pub(super) fn climb_honestly(
    request: &Request<'_>,
    chosen: &Chosen,
    ladder: &mut Ladder,
    logs: &[Log],
    say: &mut dyn FnMut(&str),
) -> Result<()> {
    search(ladder, request, say)?;
    // A lower cut-off than this would take part of the motion away.
    let halved = 0.5 * chosen.settings.position_cutoff_hz;
    if halved >= OF_A_MOTION && doubts::drop_artefacts(ladder, filtered_at(halved, request, chosen, logs)?)? {
        ladder.look_back(say)?;
    }
    ladder.settle_ties();
    if !ladder.limits.stop.asked() {
        ladder.settle_unknowns();
    }
    Ok(())
}

/// Contacts first; then forward, backward, and one cause for several findings, until nothing changes. The threshold is
/// calibrated where the residual holds least structure: at the end; what then fails it is dropped again.
pub(super) fn search(ladder: &mut Ladder, request: &Request<'_>, say: &mut dyn FnMut(&str)) -> Result<()> {
    ladder.look_for_contact(say)?;
    rounds(ladder, say)?;
    // What was missing may have bent the choice of the signs' widths.
    if request.choose_signals
        && !ladder.rungs.is_empty()
        && !ladder.limits.stop.asked()
        && sharpen_again(ladder, &request.extra)?
    {
        say("signs are sharper or softer than it seemed: looking again");
        ladder.look_back(say)?;
        rounds(ladder, say)?;
    }
    if ladder.limits.stop.asked() {
        return Ok(());
    }
    ladder.calibrate(request.seed, say);
    if ladder.gates.range().1 > ladder.limits.least_z {
        ladder.look_back(say)?;
        ladder.climb(say)?;
        ladder.look_back(say)?;
    }
    Ok(())
}

/// Forward, backward, and one cause for several findings, until nothing changes.
fn rounds(ladder: &mut Ladder, say: &mut dyn FnMut(&str)) -> Result<()> {
    for _ in 0..ROUNDS {
        ladder.climb(say)?;
        let dropped = ladder.look_back(say)?;
        if !ladder.gather(say)? && !dropped {
            break;
        }
    }
    Ok(())
}

/// The same data with the position filter at this cut-off.
fn filtered_at(hz: f64, request: &Request<'_>, chosen: &Chosen, logs: &[Log]) -> Result<Data> {
    let settings = Settings { position_cutoff_hz: hz, ..chosen.settings.clone() };
    request.data(chosen, prepared(logs, &settings)?.0)
}
