//! Alerts follow the clock: what becomes overdue, is to be repeated or told of as one, and what gyros share.

use super::alerts::gyros_of;
use super::shared_shifts::{NothingShared, shared_and_explicable};
use super::state::WriterState;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, Cells, all_cells};

/// Gyros, stations and IMUs that one transaction of the clock is about.
const AT_ONCE: usize = 1000;

/// Lets the alerts follow the clock, and what a look has found that gyros share.
pub(super) async fn tick(state: &mut WriterState, nothing: Result<Option<NothingShared>, StoreError>) {
    let followed = try_tick(state, nothing).await;
    end(state, followed).await;
}

/// Lets the alerts of what is shared follow what has been written, whichever server the clock is on.
pub(super) async fn look_at_shared(state: &mut WriterState) {
    let now = state.clock.now();
    let nothing = state.shared_look(now).nothing().await;
    let followed = follow_shared(state, now, nothing).await;
    end(state, followed).await;
}

async fn end(state: &mut WriterState, followed: Result<(), StoreError>) {
    state.writer.give_back().await;
    if let Err(error) = followed {
        state.start_over();
        tracing::error!(%error, "alerts could not follow the clock; the next tick tries again");
    }
}

/// Transactions of each cell in which the clock changes something; in a file all is one cell.
async fn try_tick(
    state: &mut WriterState,
    nothing: Result<Option<NothingShared>, StoreError>,
) -> Result<(), StoreError> {
    let now = state.clock.now();
    follow_shared(state, now, nothing).await?;
    let overdue = state.may_be_overdue(now).await?;
    let repeated = now.plus_days(-state.config.alerts.repeat_days);
    let due = store::alerts::due(&state.store, now, repeated).await?;
    let moved = due.iter().filter(|row| state.alerts.is_moved_by_clock(row, now)).map(|row| row.of);
    let found: BTreeSet<AlertOf> = moved.chain(overdue.iter().map(|gyro| AlertOf::Gyro(*gyro))).collect();
    store::names::look_up_gyros(&state.store, gyros_of(&found).collect()).await?;
    let found = {
        let tables = state.store.names().read();
        let cell = |of: &AlertOf| of.gyro().and_then(|gyro| tables.gyros.cell(gyro)).unwrap_or_default();
        let mut found: Vec<(u8, AlertOf)> = found.iter().map(|of| (cell(of), *of)).collect();
        found.sort_unstable();
        found
    };
    for some in found.chunk_by(|(a, _), (b, _)| a == b).flat_map(|of_cell| of_cell.chunks(AT_ONCE)) {
        state.begin(&Cells::from([some[0].0])).await?;
        tick_in_turn(state, now, &some.iter().map(|(_, of)| *of).collect(), &overdue).await?;
        state.writer.give_back().await;
        state.tidy();
    }
    if store::alerts::digest_began(&state.store).await?.is_some_and(|since| now.days_since(since).abs() > BROKEN_OFF) {
        state.begin(&all_cells()).await?;
        let mut changes = Changes::default();
        state.digest(&mut changes, &BTreeSet::new(), now).await?;
        state.commit_with_heads(&mut changes).await?;
    }
    Ok(())
}

async fn tick_in_turn(
    state: &mut WriterState,
    now: UtcMicros,
    found: &BTreeSet<AlertOf>,
    overdue: &BTreeSet<u32>,
) -> Result<(), StoreError> {
    let mut changes = Changes::default();
    state.alerts.recall(&state.store, gyros_of(found), now).await?;
    let gyros: Vec<u32> = gyros_of(found).filter(|gyro| overdue.contains(gyro)).collect();
    state.follow_overdue(&gyros, Late::Clock, now).await?;
    state.change_alerts(now, Late::Clock, |alerts, context| alerts.tick(found, context));
    state.note(&mut changes, now).await?;
    state.commit_with_heads(&mut changes).await
}

/// Lets the alerts of what is shared follow the clock, and those of gyros that they explain.
async fn follow_shared(
    state: &mut WriterState,
    now: UtcMicros,
    nothing: Result<Option<NothingShared>, StoreError>,
) -> Result<(), StoreError> {
    state.nothing_shared = nothing?;
    if state.nothing_shared.is_some() {
        return Ok(());
    }
    state.begin(&all_cells()).await?;
    let done = follow_shared_in_turn(state, now).await;
    state.writer.give_back().await;
    done
}

async fn follow_shared_in_turn(state: &mut WriterState, now: UtcMicros) -> Result<(), StoreError> {
    let WriterState { store, config, alerts, .. } = &mut *state;
    let (found, rows) = shared_and_explicable(store, config, alerts, now).await?;
    let gyros: BTreeSet<u32> = rows.iter().filter_map(|row| row.of.gyro()).collect();
    state.alerts.recall(&state.store, gyros, now).await?;
    let mut changes = Changes::default();
    // What lies long ago is history, whenever it is found.
    state.change_alerts(now, Late::Quiet, |alerts, context| {
        let off: Vec<(AlertOf, Id)> = alerts.shared().not_judged(&found).map(|row| (row.of, row.id)).collect();
        off.into_iter().for_each(|(of, id)| alerts.reset(of, |row| row.id == id, context));
        found.iter().for_each(|one| alerts.follow_shared(one, context));
        let anew = alerts.shared().explained_anew(&rows, &context.naming);
        alerts.explain(&anew, context);
    });
    state.note(&mut changes, now).await?;
    state.commit_with_heads(&mut changes).await
}
/// An import of which nothing has come for so long was broken off: what it has found is told.
const BROKEN_OFF: f64 = 15.0 / (24.0 * 60.0);
