//! The order of the search: contacts, climbing, looking back, calibrating, doubting.

use super::data::Data;
use super::doubts;
use super::entry::Request;
use super::ladder::Ladder;
use super::signals::{Chosen, prepared};
use crate::error::Result;
use crate::log::Log;
use crate::signals::Settings;

/// Rounds of climbing and looking back at most.
const ROUNDS: usize = 3;

/// Searches, and drops what is noise of the acceleration.
pub(super) fn climb_honestly(
    request: &Request<'_>,
    chosen: &Chosen,
    ladder: &mut Ladder,
    logs: &[Log],
    say: &mut dyn FnMut(&str),
) -> Result<()> {
    search(ladder, request.seed, say)?;
    if doubts::drop_artefacts(ladder, smoother(request, chosen, logs)?)? {
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
pub(super) fn search(ladder: &mut Ladder, seed: u64, say: &mut dyn FnMut(&str)) -> Result<()> {
    ladder.look_for_contact(say)?;
    for _ in 0..ROUNDS {
        ladder.climb(say)?;
        let dropped = ladder.look_back(say)?;
        if !ladder.gather(say)? && !dropped {
            break;
        }
    }
    if ladder.limits.stop.asked() {
        return Ok(());
    }
    ladder.calibrate(seed, say);
    if ladder.gates.range().1 > ladder.limits.least_z {
        ladder.look_back(say)?;
        ladder.climb(say)?;
        ladder.look_back(say)?;
    }
    Ok(())
}

/// The same data with the position filter at half its cut-off.
fn smoother(request: &Request<'_>, chosen: &Chosen, logs: &[Log]) -> Result<Data> {
    let settings =
        Settings { position_cutoff_hz: 0.5 * chosen.settings.position_cutoff_hz, ..chosen.settings.clone() };
    request.data(chosen, prepared(logs, &settings)?.0)
}
