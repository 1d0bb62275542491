//! How gyros stand, written with what changes it: a row of the table `head` for each gyro that a transaction touches.

use super::state::WriterState;
use crate::core::judge::{BudgetProjection, Event};
use crate::pipeline::alerts::NameLookup;
use crate::pipeline::ingest::judge::gyro_window::GyroWindow;
use crate::pipeline::prelude::*;
use crate::pipeline::queries::gyro_status::{Alerted, Facts};
use crate::pipeline::queries::heads::{checksum, row_of, stations_of, stored_projections, stored_rows};
use crate::store::{HeadChanges, HeadRow, HeadsMade, HistoryRow, RecordVerdicts, Writer, all_cells};

/// Rows of one transaction where all are made.
const AT_ONCE: u32 = 1000;

/// How these gyros will stand once `changes` are stored: by what these change, what is remembered and what is stored.
/// Their alerts are in memory as they will be stored.
pub(super) async fn rows(state: &WriterState, gyros: &[u32], changes: &Changes) -> Result<Vec<HeadRow>, StoreError> {
    let newest = newest_after(state, gyros, changes).await?;
    let mut sheets: HashMap<Id, &RecordVerdicts> =
        changes.records.iter().map(|record| (record.id, &record.verdicts)).collect();
    sheets.extend(changes.rejudged.sheets.iter().map(|(record, again)| (*record, &again.sheet)));
    let records = newest.values().map(|figures| figures.record).filter(|record| !sheets.contains_key(record));
    let records: BTreeSet<Id> = records.collect();
    let stored = store::record::record_verdicts(&state.store, records.into_iter()).await?;
    sheets.extend(stored.iter().map(|(record, sheet)| (*record, sheet)));
    let out_of_use = out_of_use(state, gyros).await?;
    let projections = projections(state, &newest, changes).await?;
    let naming = NameLookup { tables: &state.store.names().read(), new: Some(changes) };
    let row = |gyro: &u32| {
        let newest = newest.get(gyro).copied();
        let facts = Facts {
            number: *gyro,
            serial: naming.gyro(*gyro).into(),
            newest,
            verdicts: newest.and_then(|figures| sheets.get(&figures.record)).map_or(&[], |sheet| sheet.of(*gyro)),
            alerted: &Alerted::of(state.alerts.firing(*gyro))?,
            out_of_use: out_of_use.get(gyro).copied(),
            projection: projections.get(gyro).copied().unwrap_or_default(),
        };
        Ok(row_of(&facts, &state.config.judging, &naming))
    };
    gyros.iter().map(row).collect()
}

/// How gyros with these newest calibrations lie to their budgets and where they go: by the verdicts of this
/// transaction; of what it does not judge, by what is remembered, or else by what is stored.
async fn projections(
    state: &WriterState,
    newest: &HashMap<u32, Figures>,
    changes: &Changes,
) -> Result<HashMap<u32, BudgetProjection>, StoreError> {
    let (mut projections, mut unknown) = (HashMap::with_capacity(newest.len()), Vec::new());
    for (gyro, figures) in newest {
        let judged = changes.heads.projections.get(&(figures.record, *gyro)).copied();
        match judged.or_else(|| state.judge.projection(*gyro, figures.imu, changes)) {
            Some(projection) => _ = projections.insert(*gyro, projection),
            None => unknown.push((*gyro, Some(*figures))),
        }
    }
    if unknown.is_empty() {
        return Ok(projections);
    }
    let gyros: Vec<u32> = unknown.iter().map(|(gyro, _)| *gyro).collect();
    for row in store::head::of_gyros(&state.store, &gyros).await? {
        let same = row.newest.map(|newest| newest.record) == newest.get(&row.gyro).map(|figures| figures.record);
        if same {
            projections.insert(row.gyro, row.projection);
        }
    }
    unknown.retain(|(gyro, _)| !projections.contains_key(gyro));
    projections.extend(stored_projections(&state.store, &state.config.judging, &unknown).await?);
    Ok(projections)
}

/// The newest calibration of each of these gyros once `changes` are stored. Nearly always it is one of them.
async fn newest_after(
    state: &WriterState,
    gyros: &[u32],
    changes: &Changes,
) -> Result<HashMap<u32, Figures>, StoreError> {
    let mut newest: HashMap<u32, Figures> = HashMap::new();
    let changed = changes.history.iter().chain(&changes.rejudged.history);
    for HistoryRow { gyro, figures } in changed.filter(|row| !row.figures.voided) {
        // Of one instant the last holds.
        if newest.get(gyro).is_none_or(|known| figures.at >= known.at) {
            newest.insert(*gyro, *figures);
        }
    }
    let is_newest = |gyro: &u32| {
        let judged = state.judge.window(*gyro).and_then(GyroWindow::newest);
        judged.is_some() && judged == newest.get(gyro).map(|figures| figures.at)
    };
    let asked: Vec<u32> = gyros.iter().copied().filter(|gyro| !is_newest(gyro)).collect();
    // So many of them may count no more.
    let gone: usize = changes.withdrawn.history.len();
    let stored = store::histories::newest_ever(&state.store, &asked, 1 + gone).await?;
    for (gyro, rows) in asked.iter().zip(stored) {
        let counts = |figures: &&Figures| {
            let is_it = |row: &HistoryRow| row.gyro == *gyro && row.figures.record == figures.record;
            !changes.withdrawn.history.iter().any(is_it)
        };
        let stored = rows.iter().rfind(counts);
        let stored = stored.filter(|stored| newest.get(gyro).is_none_or(|known| stored.at > known.at));
        newest.extend(stored.map(|figures| (*gyro, *figures)));
    }
    Ok(newest)
}

/// When gyros were taken out of use last, by what has been judged or else by what is stored.
pub(super) async fn out_of_use(
    state: &WriterState,
    gyros: &[u32],
) -> Result<HashMap<u32, (UtcMicros, Event)>, StoreError> {
    let unknown: Vec<u32> = gyros.iter().copied().filter(|gyro| state.judge.window(*gyro).is_none()).collect();
    let mut all = store::event::out_of_use_of(&state.store, &unknown).await?;
    let ended = |gyro: &u32| {
        let ended = state.judge.window(*gyro)?.marks().iter().rfind(|mark| mark.event.ends_calibrations())?;
        Some((*gyro, (ended.at, ended.event)))
    };
    all.extend(gyros.iter().filter_map(ended));
    Ok(all)
}

/// The gyros of which something becomes different.
pub(super) fn touched(changes: &Changes) -> BTreeSet<u32> {
    let rows = changes.history.iter().chain(&changes.rejudged.history).chain(&changes.withdrawn.history);
    let benches = changes.withdrawn.benches.iter().map(|(_, gyro)| *gyro);
    rows.map(|row| row.gyro)
        .chain(benches)
        .chain(changes.gyros.iter().map(|new| new.number))
        .chain(changes.benches.iter().map(|bench| bench.gyro))
        .chain(changes.events.iter().map(|event| event.gyro))
        .chain(changes.alerts.iter().filter_map(|alert| alert.of.gyro()))
        .collect()
}

/// Makes the rows that an earlier version has not, and all anew where the limits are others than those in force when
/// they were made. Goes on where it was broken off.
pub(crate) async fn make_missing(store: &Store, writer: &mut Writer, config: &Config) -> Result<(), StoreError> {
    let limits = checksum(&config.judging);
    let is_made = |made: &HeadsMade| made.limits == limits && made.through.is_none();
    if is_made(&store::head::made(store).await?) {
        return Ok(());
    }
    let all = store.names().read().gyros.len();
    let mut done = 0;
    loop {
        writer.lock_cells(&all_cells()).await?;
        let made = store::head::made(store).await?;
        if is_made(&made) {
            // Another server has.
            writer.give_back().await;
            return Ok(());
        }
        let after = made.through.filter(|_| made.limits == limits).unwrap_or_default();
        let gyros = store::head::gyros_after(store, &after, AT_ONCE).await?;
        let through = gyros.last().filter(|_| gyros.len() == AT_ONCE as usize).map(|(_, serial)| serial.clone());
        done += gyros.len();
        let gyros: Vec<u32> = gyros.into_iter().map(|(gyro, _)| gyro).collect();
        let rows = stored_rows(store, &config.judging, &gyros).await?;
        let seen = stations_of(store, &gyros).await?;
        let is_last = through.is_none();
        let made = Some(HeadsMade { limits: limits.clone(), through });
        let heads = HeadChanges { rows, made, seen, ..HeadChanges::default() };
        writer.commit(&Changes { heads, ..Changes::default() }).await?;
        if all > AT_ONCE as usize {
            tracing::info!(gyros = done, of = all, "how gyros stand is entered into the table head");
        }
        if is_last {
            return Ok(());
        }
    }
}
