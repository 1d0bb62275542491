//! The writer's part in alerts of IMUs: they follow what the rule `forecast` says of an IMU's newest campaign, from the
//! transaction that keeps its diagnosis on. Another model in force ends them, and so does the withdrawal of what they
//! rest on.

use super::state::{Tally, WriterState};
use crate::core::judge::Finding;
use crate::core::kind::RecordEntry;
use crate::pipeline::Adoption;
use crate::pipeline::alerts::{AlertCache, AlertContext, Origin};
use crate::pipeline::diagnoses::{FinishedDiagnosis, newest_verdict};
use crate::pipeline::ingest::judge::Undone;
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow};

/// Keeps a diagnosis, and lets the alert of its IMU follow the forecast that is kept with it.
pub(super) async fn keep(state: &mut WriterState, made: &FinishedDiagnosis) -> Result<(), Refused> {
    let Some(mut changes) = made.changes(&state.after.models) else { return Ok(()) };
    let followed = follow_forecast(state, made, &mut changes).await;
    if let Some(verdict) = state.commit_or_forget(followed, &mut changes).await? {
        let mut tally = Tally::default();
        tally.add([&verdict]);
        tally.count();
    }
    Ok(())
}

/// The verdict on the campaign, where it is the newest of its IMU.
async fn follow_forecast(
    state: &mut WriterState,
    made: &FinishedDiagnosis,
    changes: &mut Changes,
) -> Result<Option<Verdict>, StoreError> {
    let Some((campaign, imu, point)) = made.forecast() else { return Ok(None) };
    let now = state.clock.now();
    let in_force = state.after.models.of(Some(imu));
    let found = newest_verdict(&state.store, (imu, &in_force), &[], Some((campaign, point))).await?;
    let Some((head, verdict)) = found else { return Ok(None) };
    state.alerts.recall(&state.store, [], now).await?;
    state.change_alerts(now, Late::Quiet, |alerts, context| {
        context.cause = Some(head.id);
        alerts.follow(AlertOf::Imu(imu), &verdict, &origin(imu, &head, &verdict), context);
    });
    state.note(changes, now).await?;
    Ok((head.id == campaign).then_some(verdict))
}

/// Another model comes into force: what the one before had foretold is over.
pub(super) async fn end(
    state: &mut WriterState,
    imu: u32,
    adoption: &Adoption,
    now: UtcMicros,
) -> Result<(), StoreError> {
    state.alerts.recall(&state.store, [], now).await?;
    let undone =
        Undone { fires: None, gone: Vec::new(), author: adoption.author.clone(), reason: adoption.reason.clone() };
    undo(state, (imu, None), &undone, now);
    Ok(())
}

/// Campaigns of a group count no more: alerts that fire by them end, or are lowered to what is left.
pub(super) async fn withdraw(state: &mut WriterState, changes: &Changes, now: UtcMicros) -> Result<(), StoreError> {
    let gone = &changes.withdrawn.records;
    let mut imus: BTreeMap<u32, Undone> = BTreeMap::new();
    for record in gone {
        let said = changes.corrections.iter().find(|said| said.item == *record);
        let (Some(said), Some((imu, _))) = (said, store::record::whose(&state.store, *record).await?) else {
            continue;
        };
        let (author, reason) = (said.author.clone(), said.reason.clone());
        imus.insert(imu, Undone { fires: None, gone: Vec::new(), author, reason });
    }
    for (imu, undone) in &imus {
        state.alerts.recall(&state.store, [], now).await?;
        if !state.alerts.is_off_forecast(*imu) {
            continue;
        }
        let in_force = state.after.models.of(Some(*imu));
        let left = newest_verdict(&state.store, (*imu, &in_force), gone, None).await?;
        undo(state, (*imu, left.map(|(_, verdict)| verdict)), undone, now);
    }
    Ok(())
}

fn undo(state: &mut WriterState, (imu, left): (u32, Option<Verdict>), undone: &Undone, now: UtcMicros) {
    let still = |row: &AlertRow| match row.rule {
        Rule::Forecast => left.and_then(|verdict| verdict.severity()),
        _ => Some(row.alert.severity),
    };
    let undo = |alerts: &mut AlertCache, context: &mut AlertContext<'_>| {
        alerts.undo(AlertOf::Imu(imu), (still, |_| None), undone, context);
    };
    state.change_alerts(now, Late::Quiet, undo);
}
fn origin(imu: u32, head: &RecordEntry, verdict: &Verdict) -> Origin {
    let slot = match verdict.finding {
        Finding::Forecast { slot, .. } => Some(slot),
        _ => None,
    };
    let (item, imu, station) = (Some(head.id), Some(imu), Some(head.station));
    Origin { item, imu, slot, station, ..Origin::at(head.calibrated_at) }
}
