//! What this campaign could not show, whatever its data: from the design alone.

use super::answer::NotIdentifiable;
use super::bank::{Bank, Kind};
use super::frame::Frame;
use crate::core::effects::{CATALOGUE, Effect, Entry};

/// Visible share of power below which an entry is listed: less than three per cent of its amplitude shows.
const LITTLE: f64 = 1e-3;

/// Entries that the campaign lacks a column for, or that the model in use absorbs.
pub(super) fn not_identifiable(frame: &Frame, bank: &Bank) -> Vec<NotIdentifiable> {
    CATALOGUE.iter().filter(|entry| !held(frame, entry)).filter_map(|entry| judged(frame, bank, entry)).collect()
}

/// Terms and effects of the model in use are fitted, not sought.
fn held(frame: &Frame, entry: &Entry) -> bool {
    frame.terms.iter().any(|term| term.name() == entry.id)
        || frame.adopted.iter().any(|adopted| adopted.effect == entry.effect)
}

fn judged(frame: &Frame, bank: &Bank, entry: &Entry) -> Option<NotIdentifiable> {
    let listed = |visible_fraction: f64, reason: String| {
        Some(NotIdentifiable { effect: entry.effect, visible_fraction, reason, needs: entry.needs.to_owned() })
    };
    if matches!(entry.effect, Effect::OutputAxisG | Effect::MountClocking) {
        return listed(0.0, "D_O a_O lies inside G; it shows in the closure of G only".to_owned());
    }
    if let Some(missing) = (entry.missing)(&frame.setting) {
        return listed(0.0, missing.to_owned());
    }
    let visible = visible(bank, entry.effect);
    if visible >= LITTLE {
        return None;
    }
    let share = if visible > 1e-12 { format!("all but {visible:.1e} of its power") } else { "it".to_owned() };
    listed(visible, format!("the model in use absorbs {share} in every dwell of this campaign"))
}

/// Largest visible share over shapes and gyros.
pub(super) fn visible(bank: &Bank, effect: Effect) -> f64 {
    let own = bank.hypotheses.iter().filter(|h| h.kind == Kind::Effect(effect));
    own.flat_map(|h| &h.blocks).map(|block| block.visible).fold(0.0, f64::max)
}
