//! A group on its way: admitted, judged and followed by alerts; then written; then answered.

use std::time::Instant;

use tokio::sync::watch;

use super::forecasts;
use super::state::{Item, Prepared, Tally, WriterState, items_of};
use crate::pipeline::alerts::Causes;
use crate::pipeline::ingest::admit::{Admission, Group, Lookup, Prefetched};
use crate::pipeline::ingest::judge::Verdicts;
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::StoreJob;
use crate::pipeline::{CalibratedGyro, Judged, Reply, Submission};
use crate::telemetry;

/// Admits and judges a group, and lets the alerts follow. What is remembered of its gyros is then ahead of what
/// is stored.
pub(super) async fn prepare(state: &mut WriterState, items: &[Item<'_>]) -> Result<Prepared, StoreError> {
    let mut replies = Vec::with_capacity(items.len());
    let (now, service) = (state.clock.now(), Actor::by_caller());
    read_histories(state, items).await?;
    let ahead = Prefetched::read(&state.store, &state.memory, items.iter().map(|item| item.sent)).await?;
    if !state.writer.is_one_of_many() {
        state.memory.take_in_marks(&ahead.marks);
    }
    let mut admission = Admission {
        known: Lookup {
            store: &state.store,
            memory: &mut state.memory,
            benched: &state.benched,
            ahead: &ahead,
            group: Group::default(),
        },
        ids: state.writer.ids(),
        config: &state.config,
        now,
        by: &service,
    };
    for item in items {
        admission.by = item.by;
        replies.push(admission.admit(item.sent).await);
    }
    let judging = Instant::now();
    let mut group = admission.known.group;
    group.audit_sendings(now);
    let mut changes = group.changes;
    let mut found = state.judge.judge(&mut changes).await?;
    let agreements = state.agreements(&changes).await?;
    let touched = found.newest.iter().map(|newest| newest.gyro).chain(found.undone.keys().copied());
    let touched = touched.chain(agreements.iter().map(|agreement| agreement.gyro));
    state.alerts.recall(&state.store, touched, now).await?;
    let fires = |gyro| state.alerts.firing(gyro).next().is_some();
    state.judge.follow_late(&changes, &mut found, fires).await?;
    let new = || items.iter().zip(&replies).filter_map(|(item, reply)| Some((stored_as(reply)?, item)));
    let sent = new().filter_map(|(id, item)| Some((id, item.sent.calibration()?))).collect();
    forecasts::withdraw(state, &changes, now).await?;
    let causes = Causes::of(new().map(|(id, item)| (id, item.late)).collect(), &changes);
    state.follow(&sent, &mut changes, (&found, &agreements), &causes, now).await?;
    metrics::histogram!(telemetry::JUDGING).record(judging.elapsed());
    let tally = Tally::of(&sent, &changes, &found.verdicts);
    if items.iter().any(|item| item.with_verdicts) {
        enter_verdicts(&state.store, items, &mut replies, &found.verdicts, &changes);
    }
    state.enter_heads(&mut changes).await?;
    Ok(Prepared { changes, replies, tally })
}

/// Reads ahead what is stored of the gyros of a group that are not remembered.
async fn read_histories(state: &mut WriterState, items: &[Item<'_>]) -> Result<(), StoreError> {
    let mut gyros: Vec<u32> = {
        let tables = state.store.names().read();
        let sent = items.iter().filter_map(|item| item.sent.calibration()).flat_map(|sent| &sent.gyros);
        let known = sent.filter_map(|gyro| tables.gyros.number(gyro.serial.as_str()));
        let WriterState { judge, memory, benched, .. } = &*state;
        let unknown = known.filter(|gyro| !judge.knows(*gyro) || !memory.knows(*gyro) || !benched.contains_key(gyro));
        unknown.collect::<BTreeSet<u32>>().into_iter().collect()
    };
    state.learn_benched(&gyros).await?;
    gyros.retain(|gyro| !state.judge.knows(*gyro) || !state.memory.knows(*gyro));
    let most = state.judge.read_ahead();
    let rows = store::histories::newest_ever(&state.store, &gyros, most).await?;
    let read: Vec<_> = gyros.into_iter().zip(rows).collect();
    state.memory.take_in(read.iter().map(|(gyro, rows)| (*gyro, rows.as_slice(), rows.len() < most)));
    let unknown: Vec<_> = read.into_iter().filter(|(gyro, _)| !state.judge.knows(*gyro)).collect();
    state.judge.take_in(&unknown).await
}

fn enter_verdicts(store: &Store, items: &[Item<'_>], replies: &mut [Reply], verdicts: &Verdicts, changes: &Changes) {
    let tables = store.names().read();
    // Names that nobody can look up before this group is stored.
    let new: HashMap<&str, u32> = changes.gyros.iter().map(|new| (new.name.as_str(), new.number)).collect();
    let number = |serial: &str| tables.gyros.number(serial).or_else(|| new.get(serial).copied());
    let judged = |id: Id, gyro: &CalibratedGyro| {
        let by_history = number(gyro.serial.as_str()).and_then(|number| verdicts.get(&(id, number)));
        let verdicts = by_history.into_iter().flatten().chain(gyro.requirements.iter().flatten());
        Judged { serial: gyro.serial.as_str().into(), verdicts: verdicts.copied().collect() }
    };
    for (item, reply) in items.iter().zip(replies).filter(|(item, _)| item.with_verdicts) {
        if let (Some(sent), Ok(Accepted::Stored { id, judged: entered, .. })) = (item.sent.calibration(), reply) {
            *entered = sent.gyros.iter().map(|gyro| judged(*id, gyro)).collect();
        }
    }
}
/// The answers to a group that has been written. `due` moves when diagnoses have become due.
pub(super) fn settle(items: &[Item<'_>], prepared: Prepared, due: &watch::Sender<u64>) -> Vec<Reply> {
    let Prepared { changes, replies, tally, .. } = prepared;
    if !changes.is_empty() {
        metrics::histogram!(telemetry::GROUP).record(items.len() as f64);
    }
    let is_campaign = |item: &Item<'_>| item.sent.calibration().is_some_and(|sent| sent.kind == Kind::Campaign);
    if items.iter().zip(&replies).any(|(item, reply)| is_campaign(item) && stored_as(reply).is_some()) {
        due.send_modify(|moved| *moved += 1);
    }
    tally.count();
    replies
}

/// Sends everyone their part of a group's answers.
pub(super) fn answer(jobs: Vec<StoreJob>, replies: Vec<Reply>) {
    count(jobs.iter().flat_map(items_of), &replies);
    let mut replies = replies.into_iter();
    for StoreJob { items, reply, .. } in jobs {
        // Who has gone away is answered when it sends the same again.
        let _gone = reply.send(replies.by_ref().take(items.len()).collect());
    }
}

/// The identifier that something new was given.
fn stored_as(reply: &Reply) -> Option<Id> {
    if let Ok(Accepted::Stored { id, .. }) = reply { Some(*id) } else { None }
}

/// Counts what has become of each item. Looking a counter up costs more than adding to it.
fn count<'a>(items: impl Iterator<Item = Item<'a>>, replies: &[Reply]) {
    let mut counts: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    for (item, reply) in items.zip(replies) {
        let kind = match item.sent {
            Submission::Calibration(_) => "calibration",
            Submission::Bench(_) => "bench_result",
            Submission::Event(_) => "event",
            Submission::Correction(_) => "correction",
            Submission::Confirmation(_) => "confirmation",
            Submission::SetAside(_) => "doubt",
            Submission::Window(_) => "window",
            Submission::Attributes(_) => "attributes",
        };
        let outcome = match reply {
            Ok(Accepted::Stored { .. }) => "stored",
            Ok(Accepted::There { .. }) => "there",
            Err(Refused::Storage(_)) => "failed",
            Err(_) => "refused",
        };
        *counts.entry((kind, outcome)).or_default() += 1;
    }
    for ((kind, outcome), count) in counts {
        metrics::counter!(telemetry::ITEMS, "kind" => kind, "outcome" => outcome).increment(count);
    }
}
