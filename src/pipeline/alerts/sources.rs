//! Which verdicts of a group the alerts follow: those on the newest figures of each gyro that it touches.

use super::body::Origin;
use super::cache::{AlertCache, AlertContext};
use crate::core::judge::overdue;
use crate::pipeline::ingest::judge::{Firing, Judge, Judged};
use crate::pipeline::ingest::submission::Calibration;
use crate::pipeline::prelude::*;
use crate::pipeline::queries::agreement::Agreement;
use crate::store::{AlertRow, HistoryRow};

/// Which item of a group has changed what is known of a gyro, and how that is told if it comes late.
#[derive(Debug, Default)]
pub(crate) struct Causes {
    items: HashMap<Id, Late>,
    gyros: HashMap<u32, Id>,
}

impl Causes {
    /// `items`: what was stored, by its identifier.
    pub fn of(items: HashMap<Id, Late>, changes: &Changes) -> Self {
        let rows = changes.history.iter().map(|row| (row.gyro, row.figures.record));
        let benches = changes.benches.iter().map(|bench| (bench.gyro, bench.id));
        let events = changes.events.iter().map(|event| (event.gyro, event.id));
        let gyros = events.chain(benches).chain(rows).collect();
        Self { items, gyros }
    }

    /// How the group is told if it comes late: as an import where one is in it.
    pub fn late(&self) -> Late {
        let all = || self.items.values().copied();
        all().find(|late| *late == Late::Digest).or_else(|| all().next()).unwrap_or_default()
    }

    /// The cause is the item that was judged itself, where it is of the group, else the last that is of the gyro.
    fn sign(&self, gyro: u32, item: Option<Id>, context: &mut AlertContext<'_>) {
        let item = item.filter(|item| self.items.contains_key(item)).or_else(|| self.gyros.get(&gyro).copied());
        context.cause = item;
        context.late = item.and_then(|item| self.items.get(&item)).copied().unwrap_or_default();
    }
}

/// Lets the alerts follow what a group's judging has found.
///
/// `sent` are the calibrations of the group by their identifiers: verdicts that need no history are with them.
pub(crate) fn follow_group<'a>(
    alerts: &mut AlertCache,
    judge: &Judge,
    judged: &'a Judged,
    sent: &HashMap<Id, &Calibration>,
    agreements: &[Agreement],
    causes: &Causes,
    context: &mut AlertContext<'a>,
) {
    for (gyro, undone) in &judged.undone {
        causes.sign(*gyro, None, context);
        let fires = undone.fires.as_ref();
        let still = |row: &AlertRow| match row.rule {
            Rule::Agreement => {
                let compared = agreements.iter().filter(|agreement| agreement.gyro == *gyro);
                let verdicts = compared.flat_map(|agreement| &agreement.verdicts);
                verdicts.filter(|verdict| verdict.coefficient == row.coefficient).filter_map(Verdict::severity).max()
            }
            // Where nothing is left, nothing can be overdue; else the clock says what is.
            Rule::Overdue if fires.is_some() && judged.newest.iter().all(|newest| newest.gyro != *gyro) => None,
            Rule::Overdue => Some(row.alert.severity),
            rule => fires.map_or(Some(row.alert.severity), |fires| {
                fires.get(&(row.coefficient, rule)).map(|left| left.severity)
            }),
        };
        let newest = judged.newest.iter().rfind(|newest| newest.gyro == *gyro);
        let naming = context.naming;
        let found_of = |row: &AlertRow| {
            let is_it = |verdict: &&Verdict| (verdict.coefficient, verdict.rule) == (row.coefficient, row.rule);
            let of_newest = || {
                let figures = &newest?.figures;
                let verdict = judged.verdicts.get(&(figures.record, *gyro))?.iter().find(is_it)?;
                Some(naming.finding(verdict, &Origin::from(figures)))
            };
            let mut compared = agreements.iter().filter(|agreement| agreement.gyro == *gyro);
            let of_methods = || compared.find_map(|a| Some(naming.finding(a.verdicts.iter().find(is_it)?, &a.origin)));
            of_newest().or_else(of_methods).map(|finding| finding.kept())
        };
        let is_followed =
            |newest: &HistoryRow| newest.gyro == *gyro && judged.verdicts.contains_key(&(newest.figures.record, *gyro));
        if judged.newest.iter().any(is_followed) {
            alerts.resume(*gyro, undone);
        }
        alerts.undo(*gyro, (still, found_of), undone, context);
        // The newest that counts may be older than before.
        if let Some(HistoryRow { figures, .. }) = newest {
            follow_clock(alerts, judge, *gyro, figures.at, figures.imu, context);
        }
    }
    for newest in &judged.newest {
        causes.sign(newest.gyro, Some(newest.figures.record), context);
        follow_newest(alerts, judge, judged, newest, sent, context);
    }
    for agreement in agreements {
        causes.sign(agreement.gyro, agreement.origin.item, context);
        for verdict in &agreement.verdicts {
            alerts.follow(agreement.gyro, verdict, &agreement.origin, context);
        }
        let judged = |row: &AlertRow| agreement.verdicts.iter().any(|verdict| verdict.coefficient == row.coefficient);
        alerts.reset(agreement.gyro, |row| row.rule == Rule::Agreement && !judged(row), context);
    }
}

fn follow_newest<'a>(
    alerts: &mut AlertCache,
    judge: &Judge,
    judged: &'a Judged,
    newest: &HistoryRow,
    sent: &HashMap<Id, &Calibration>,
    context: &mut AlertContext<'a>,
) {
    let HistoryRow { gyro, figures } = newest;
    let by_history = judged.verdicts.get(&(figures.record, *gyro)).map(Vec::as_slice);
    let calibrated = sent.get(&figures.record).and_then(|sent| sent.gyros.iter().find(|g| g.slot == figures.slot));
    let verdicts = || {
        by_history
            .into_iter()
            .flatten()
            .chain(calibrated.into_iter().flat_map(|gyro| gyro.requirements.iter().flatten()))
    };
    let in_order = judged.in_order(*gyro);
    let is_quiet = || in_order.is_none_or(Firing::is_empty) && verdicts().all(|verdict| verdict.severity().is_none());
    if !alerts.knows(*gyro) && is_quiet() {
        return;
    }
    let origin = Origin::from(figures);
    // An event since the newest record has cut it off from what comes: its verdict is of the past.
    let is_past = |rule: Rule| rule != Rule::Overdue && judge.is_reset_since(*gyro, figures.at, rule);
    context.in_order = in_order;
    for verdict in verdicts().filter(|verdict| !is_past(verdict.rule)) {
        alerts.follow(*gyro, verdict, &origin, context);
    }
    // Requirements need no history: those on what has come late are with it alone.
    let new = context.naming.new.into_iter().flat_map(|changes| &changes.history);
    for HistoryRow { figures, .. } in new.filter(|row| row.gyro == *gyro && in_order.is_some()) {
        let calibrated = sent.get(&figures.record).and_then(|sent| sent.gyros.iter().find(|g| g.slot == figures.slot));
        for verdict in calibrated.into_iter().flat_map(|gyro| gyro.requirements.iter().flatten()) {
            let (coefficient, rule) = (verdict.coefficient, verdict.rule);
            let left = in_order.and_then(|fires| fires.get(&(coefficient, rule)));
            let is_known = alerts.firing(*gyro).any(|row| (row.coefficient, row.rule) == (coefficient, rule));
            if !is_known && !is_past(rule) && left.is_some_and(|left| left.fired_at == figures.at) {
                alerts.follow(*gyro, verdict, &Origin::from(figures), context);
            }
        }
    }
    context.in_order = None;
    let is_switched_off = |row: &AlertRow| {
        let was_asked = match row.rule {
            Rule::Agreement | Rule::Overdue => false,
            Rule::Requirement => calibrated.is_some(),
            _ => by_history.is_some(),
        };
        was_asked && !verdicts().any(|verdict| (verdict.coefficient, verdict.rule) == (row.coefficient, row.rule))
    };
    alerts.reset(*gyro, |row| is_past(row.rule) || is_switched_off(row), context);
    if let Some(fires) = in_order {
        alerts.settle(*gyro, fires, context);
    }
    follow_clock(alerts, judge, *gyro, figures.at, figures.imu, context);
}

/// Judges by the clock whether a gyro, calibrated last at `last` in `imu`, is overdue.
pub(crate) fn follow_clock(
    alerts: &mut AlertCache,
    judge: &Judge,
    gyro: u32,
    last: UtcMicros,
    imu: u32,
    context: &mut AlertContext<'_>,
) {
    let fires = alerts.firing(gyro).any(|row| row.rule == Rule::Overdue);
    let interval = judge.interval_days(gyro, last, imu, &context.naming);
    match interval {
        Some(days) if fires || context.now.days_since(last) > days.value => {
            let origin = Origin { imu: Some(imu), ..Origin::at(last) };
            alerts.follow(gyro, &overdue(last, context.now, days), &origin, context);
        }
        None if fires => alerts.reset(gyro, |row| row.rule == Rule::Overdue, context),
        _ => {}
    }
}
