//! The alerts of gyros that are looked at, and what is to be written about them.

use super::body::{NameLookup, Origin, finding_of};
use super::shared::{Explained, SharedAlerts, SharedVerdict};
use super::silences::Silences;
use crate::core::alert_decision::{self, Action, Arrival, Decision, Policy, Status};
use crate::core::judge::Severity;
use crate::pipeline::ingest::judge::{Firing, Undone};
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow, Remark, StepRow, Writer};
use crate::wire::alert::{AlertBody, AlertFindingBody};
use crate::wire::reason::Reason;

/// Gyros from which on everything is forgotten.
const MOST_GYROS: usize = 20_000;

/// The alerts of the gyros that have been looked at, and those that the transaction under construction changes.
#[derive(Debug)]
pub(crate) struct AlertCache {
    policy: Policy,
    /// With which something exceeds its limit.
    confidence: f64,
    /// A gyro that has none is known to have none.
    pub(super) alerts: BTreeMap<AlertOf, Vec<AlertRow>>,
    /// Gyro and place of what has changed since the last [`AlertCache::write`].
    pub(super) changed: BTreeSet<(AlertOf, usize)>,
    /// Those that go on after all, until that is followed.
    resumed: BTreeSet<(AlertOf, usize)>,
    steps: Vec<StepRow>,
    /// What hooks may have to be told, since the last [`AlertCache::updates`].
    pub(super) updates: Vec<AlertUpdate>,
    /// Those of many alerts that are in force.
    pub(super) silences: Silences,
    /// Gyros of batches that have an alert, and the gyro by which the batch goes.
    mates: BTreeMap<u32, u32>,
    /// They, and the alerts of stations, batches and IMUs, are to be read again before they are used.
    settings_moved: bool,
}

/// Who said something that became a step, and why.
type StepRemark = (Option<String>, Option<String>);

/// What it takes to write an entry: the time, identifiers, names; what caused it, and how it is told if it comes late.
pub(crate) struct AlertContext<'a> {
    pub now: UtcMicros,
    pub writer: &'a mut Writer,
    pub naming: NameLookup<'a>,
    pub cause: Option<Id>,
    pub late: Late,
    /// What fires by all records of the gyro, followed in the order of time, where not all came in that order.
    pub in_order: Option<&'a Firing>,
}

impl AlertContext<'_> {
    fn arrival(&self, record_at: UtcMicros, muted_until: Option<UtcMicros>, inhibited: bool) -> Arrival {
        Arrival { record_at, now: self.now, late: self.late, muted_until, inhibited }
    }
}

/// Something has become of an alert that hooks may have to be told, or how it stands.
#[derive(Debug, Clone)]
pub(crate) struct AlertUpdate {
    pub id: Id,
    /// As it then was.
    pub alert: alert_decision::Alert,
    pub action: Action,
    /// The step that says so, if there is one.
    pub step: Option<Id>,
    /// The alert as clients read it; none where what is stored of it is damaged.
    pub body: Option<AlertBody>,
    /// What one record has caused is one message.
    pub cause: Option<Id>,
}

impl AlertCache {
    pub fn new(policy: Policy, confidence: f64) -> Self {
        Self {
            policy,
            confidence,
            alerts: BTreeMap::new(),
            changed: BTreeSet::new(),
            resumed: BTreeSet::new(),
            steps: Vec::new(),
            updates: Vec::new(),
            silences: Silences::default(),
            mates: BTreeMap::new(),
            settings_moved: true,
        }
    }

    /// What was noted is not what was committed: all of it is read again before it is used.
    pub fn forget(&mut self) {
        (self.alerts, self.changed, self.resumed, self.steps, self.updates) = Default::default();
        self.settings_moved = true;
    }

    /// Others have written about the gyros that `lost` names.
    pub fn forget_where(&mut self, lost: impl Fn(u32) -> bool) {
        self.alerts.retain(|of, _| of.gyro().is_none_or(|gyro| !lost(gyro)));
    }

    /// Others have begun or ended silences, or alerts of what is no gyro have changed.
    pub fn forget_settings(&mut self) {
        self.settings_moved = true;
    }

    /// Keeps the memory within its bounds, when all that was noted is stored.
    pub fn tidy(&mut self) {
        if self.alerts.len() > MOST_GYROS {
            self.alerts.retain(|of, _| of.gyro().is_none());
        }
    }

    /// Reads the alerts of those of these gyros that have not been looked at.
    pub async fn recall(
        &mut self,
        store: &Store,
        gyros: impl IntoIterator<Item = u32>,
        now: UtcMicros,
    ) -> Result<(), StoreError> {
        let mut rows = Vec::new();
        if self.settings_moved {
            self.silences = Silences::load(store, now).await?;
            self.alerts.retain(|of, _| of.gyro().is_some());
            rows = store::alerts::of_no_gyro(store).await?;
            let firing = rows.iter().filter(|row| row.alert.status == Status::Firing);
            let batches: Vec<u32> = firing.filter_map(|row| row.of.batch()).collect();
            self.mates = store::gyro_attribute::mates(store, &batches).await?;
            self.settings_moved = false;
        }
        let is_unknown = |gyro: &u32| !self.alerts.contains_key(&AlertOf::Gyro(*gyro));
        let unknown: BTreeSet<u32> = gyros.into_iter().filter(is_unknown).collect();
        if !unknown.is_empty() {
            let unknown: Vec<u32> = unknown.into_iter().collect();
            rows.extend(store::alerts::of_gyros(store, &unknown).await?);
            self.alerts.extend(unknown.into_iter().map(|gyro| (gyro.into(), Vec::new())));
        }
        rows.into_iter().for_each(|row| self.alerts.entry(row.of).or_default().push(row));
        Ok(())
    }

    /// What the clock makes of an alert, where that changes anything.
    pub fn is_moved_by_clock(&self, row: &AlertRow, now: UtcMicros) -> bool {
        alert_decision::tick(&row.alert, now, &self.policy).alert.is_some_and(|after| after != row.alert)
    }

    /// Puts what has changed into a transaction; returns what hooks may have to be told.
    pub fn write(&mut self, changes: &mut Changes) -> Vec<AlertUpdate> {
        self.resumed.clear();
        let changed = std::mem::take(&mut self.changed);
        changes.alerts.extend(changed.into_iter().map(|(of, place)| self.alerts[&of][place].clone()));
        changes.alert_steps.append(&mut self.steps);
        std::mem::take(&mut self.updates)
    }

    /// Whether a gyro has ever had an alert.
    pub fn knows(&self, gyro: u32) -> bool {
        self.alerts.get(&gyro.into()).is_some_and(|rows| !rows.is_empty())
    }

    pub fn firing(&self, gyro: u32) -> impl Iterator<Item = &AlertRow> {
        self.alerts.get(&gyro.into()).into_iter().flatten().filter(|row| row.alert.status == Status::Firing)
    }

    /// Follows a verdict on the newest figures of a gyro, on what a station does, or on the newest campaign of an IMU.
    pub fn follow(
        &mut self,
        of: impl Into<AlertOf>,
        verdict: &Verdict,
        origin: &Origin,
        context: &mut AlertContext<'_>,
    ) {
        let of = of.into();
        let is_it = |row: &AlertRow| row.coefficient == verdict.coefficient && row.rule == verdict.rule;
        let place = self.alerts.get(&of).and_then(|rows| rows.iter().position(is_it));
        let earlier = place.map(|place| &self.alerts[&of][place]);
        let naming = context.naming;
        let muting = self.silences.of(of, verdict, origin, &naming, context.now);
        let (muted, muted_until) = muting.map(|(muted, until)| (Some(muted), Some(until))).unwrap_or_default();
        let left = context.in_order.map(|fires| fires.get(&(verdict.coefficient, verdict.rule)));
        let began = left.flatten().map_or(origin.at, |left| left.since);
        let since = earlier.filter(|row| row.alert.status == Status::Firing).map_or(began, |row| row.alert.since);
        let fires = earlier.filter(|row| row.alert.status == Status::Firing);
        let held = (fires, context.writer.is_one_of_many());
        let explained = of.gyro().map(|gyro| self.shared().explaining(gyro, verdict, origin, since, held));
        let Explained { by: inhibited_by, with_imu } = explained.unwrap_or_default();
        let inhibited = inhibited_by.is_some();
        let (arrival, known) = (context.arrival(origin.at, muted_until, inhibited), earlier.map(|row| &row.alert));
        let decision = match left {
            None => alert_decision::follow_arrival(known, verdict, &arrival, &self.policy),
            Some(left) => alert_decision::hear_again(known, left, verdict, &arrival, &self.policy),
        };
        let Some(alert) = decision.alert else { return };
        let is_held = alert.status == Status::Firing && verdict.severity().is_none();
        let Policy { resolve_below, resolve_after, .. } = self.policy;
        let reason = || {
            if is_held { Reason(verdict.messages_of_held(resolve_below, resolve_after)) } else { Reason::of(verdict) }
        };
        let finding = || AlertFindingBody { with_imu, reason: reason(), ..naming.finding(verdict, origin) }.kept();
        let (place, began) = match (place, earlier) {
            (Some(place), Some(row)) => {
                // How long a calibration is overdue changes by itself: that is no news.
                let same_finding =
                    || alert.status == Status::Resolved || verdict.rule == Rule::Overdue || row.finding == finding();
                let same_cause = !alert.inhibited || inhibited_by.is_none() || row.inhibited_by == inhibited_by;
                let resumed = self.resumed.contains(&(of, place));
                if !resumed && row.alert == alert && decision.action == Action::Silent && same_cause && same_finding() {
                    return;
                }
                (place, resumed)
            }
            _ => {
                let row = AlertRow {
                    id: context.writer.next_id(context.now),
                    of,
                    coefficient: verdict.coefficient,
                    rule: verdict.rule,
                    alert,
                    acknowledged: None,
                    silenced: None,
                    muted: None,
                    inhibited_by: None,
                    finding: String::new(),
                };
                let rows = self.alerts.entry(of).or_default();
                rows.push(row);
                (rows.len() - 1, true)
            }
        };
        let row = &mut self.alerts.entry(of).or_default()[place];
        (row.finding, row.muted) = (finding(), muted);
        row.inhibited_by = inhibited_by.or(row.inhibited_by).filter(|_| alert.inhibited);
        self.resumed.remove(&(of, place));
        self.enter((of, place), decision, began, (None, None), context);
    }

    /// Follows what has been found that gyros share.
    pub fn follow_shared(&mut self, found: &SharedVerdict, context: &mut AlertContext<'_>) {
        let SharedVerdict { of, verdict, origin, since, .. } = found;
        let fires = |row: &AlertRow| row.coefficient == verdict.coefficient && row.alert.status == Status::Firing;
        let place =
            self.alerts.get(of).and_then(|rows| rows.iter().position(|row| row.rule == verdict.rule && fires(row)));
        let (Some(since), Some(place)) = (since, place) else { return self.follow(*of, verdict, origin, context) };
        if let Some(row) = self.alerts.get_mut(of).and_then(|rows| rows.get_mut(place)) {
            row.alert.since = *since;
            self.changed.insert((*of, place));
        }
    }

    /// Ends what fires where `ends` says so: a rule that does not judge any more, or whose history an event has cut
    /// off.
    pub fn reset(&mut self, of: impl Into<AlertOf>, ends: impl Fn(&AlertRow) -> bool, context: &mut AlertContext<'_>) {
        for at in self.places([of.into()]) {
            let row = &self.alerts[&at.0][at.1];
            if row.alert.status == Status::Firing && ends(row) {
                let decision = alert_decision::reset(&row.alert, context.now);
                self.enter(at, decision, false, (None, None), context);
            }
        }
    }

    /// Ends or lowers what fires, because of what somebody has said of a record or bench result. `still`: how grave an
    /// alert is by what is left; none where nothing bears it out. `newest`: what is then found of it, as it is kept.
    pub fn undo(
        &mut self,
        of: impl Into<AlertOf>,
        (still, newest): (impl Fn(&AlertRow) -> Option<Severity>, impl Fn(&AlertRow) -> Option<String>),
        undone: &Undone,
        context: &mut AlertContext<'_>,
    ) {
        for at in self.places([of.into()]) {
            let row = &self.alerts[&at.0][at.1];
            let decision = match still(row) {
                _ if row.alert.status == Status::Resolved => continue,
                Some(severity) if severity >= row.alert.severity => continue,
                Some(severity) => alert_decision::lower(&row.alert, severity, context.now),
                None => alert_decision::reset(&row.alert, context.now),
            };
            let said = (Some(undone.author.clone()), Some(undone.reason.clone()));
            if let Some(finding) = newest(row) {
                self.alerts.entry(at.0).or_default()[at.1].finding = finding;
            }
            self.enter(at, decision, false, said, context);
        }
    }

    /// Lets what fires of a gyro, and follows its records, come to what all of them say, followed in the order of time.
    pub fn settle(&mut self, gyro: u32, fires: &Firing, context: &mut AlertContext<'_>) {
        for at in self.places([gyro.into()]) {
            let AlertRow { coefficient, rule, alert, .. } = self.alerts[&at.0][at.1];
            let follows_records = !matches!(rule, Rule::Agreement | Rule::Overdue);
            let left = fires.get(&(coefficient, rule));
            let stands = || alert_decision::settled(&alert, left, context.now) == alert;
            if follows_records && alert.status == Status::Firing && !stands() {
                let arrival = context.arrival(alert.record_at, alert.muted_until, alert.inhibited);
                let decision = alert_decision::settle(&alert, rule, left, &arrival, &self.policy);
                self.enter(at, decision, false, (None, None), context);
            }
        }
    }

    /// Takes up again what ended by what counts no more and is borne out by what is left, for the verdict on the newest
    /// record to be followed as though that had never ended: it is no new alert, and who knew of it knows of it. What
    /// began with what counts no more dates from what is left.
    pub fn resume(&mut self, gyro: u32, undone: &Undone) {
        for at in self.places([gyro.into()]) {
            let row = &mut self.alerts.entry(at.0).or_default()[at.1];
            let Some(left) = undone.fires.as_ref().and_then(|fires| fires.get(&(row.coefficient, row.rule))) else {
                continue;
            };
            let resumed = alert_decision::resume(&row.alert, left, undone.gone.contains(&row.alert.since));
            if resumed == row.alert {
                continue;
            }
            if row.alert.status == Status::Resolved {
                self.resumed.insert(at);
            }
            row.alert = resumed;
            self.changed.insert(at);
        }
    }

    /// Whether the newest campaign of an IMU is told to be off its forecast.
    pub fn is_off_forecast(&self, imu: u32) -> bool {
        let rows = self.alerts.get(&AlertOf::Imu(imu)).into_iter().flatten();
        rows.into_iter().any(|row| row.rule == Rule::Forecast && row.alert.status == Status::Firing)
    }

    /// Those of what gyros share among them.
    pub fn shared(&self) -> SharedAlerts<'_> {
        SharedAlerts { alerts: &self.alerts, mates: &self.mates, confidence: self.confidence }
    }

    /// Learns which gyros the batches hold that were judged.
    pub fn learn_mates(&mut self, found: &[SharedVerdict]) {
        let batches: BTreeMap<u32, &Vec<u32>> =
            found.iter().filter_map(|one| Some((one.of.batch()?, &one.gyros))).collect();
        self.mates.retain(|_, batch| !batches.contains_key(batch));
        self.mates.extend(batches.iter().flat_map(|(batch, gyros)| gyros.iter().map(|gyro| (*gyro, *batch))));
    }

    /// Lets the alerts of these gyros follow those of what they share: of what is explained nobody is told; of what is
    /// not any more everybody is told what was held back.
    pub fn explain(&mut self, gyros: &BTreeSet<u32>, context: &mut AlertContext<'_>) {
        for at in self.places(gyros.iter().map(|gyro| AlertOf::Gyro(*gyro))) {
            let row = &self.alerts[&at.0][at.1];
            let Explained { by, with_imu } = self.shared().explaining_row(row, &context.naming);
            if by == row.inhibited_by {
                continue;
            }
            let decision = alert_decision::inhibit(&row.alert, by.is_some(), context.now);
            if let Some(row) = self.alerts.get_mut(&at.0).and_then(|rows| rows.get_mut(at.1)) {
                row.inhibited_by = by;
                if let Ok(finding) = finding_of(row) {
                    row.finding = AlertFindingBody { with_imu, ..finding }.kept();
                }
            }
            self.enter(at, decision, false, (None, None), context);
            // A hook that came meanwhile has not heard of it.
            if by.is_none() && decision.action == Action::Silent {
                self.push_current(at, context);
            }
        }
    }

    /// Lets these alerts follow the clock: repeats, and tells what a silence has held back.
    pub fn tick(&mut self, all: &BTreeSet<AlertOf>, context: &mut AlertContext<'_>) {
        self.silences.pass(context.now);
        for at in self.places(all.iter().copied()) {
            let before = self.alerts[&at.0][at.1].alert;
            let decision = alert_decision::tick(&before, context.now, &self.policy);
            let Some(after) = decision.alert.filter(|after| *after != before) else { continue };
            self.enter(at, decision, false, (None, None), context);
            let silence_ended =
                (before.silenced_until, before.muted_until) != (after.silenced_until, after.muted_until);
            // The world was told before the silence; a hook that came during it was not.
            if silence_ended && decision.action == Action::Silent {
                self.push_current(at, context);
            }
        }
    }

    /// Tells those who have not heard how an alert stands.
    fn push_current(&mut self, at: (AlertOf, usize), context: &AlertContext<'_>) {
        let row = self.alerts[&at.0][at.1].clone();
        let body = context.naming.alert(&row, context.now).ok();
        self.push_update(&row, Action::Silent, None, body, context);
    }

    /// What waits of these gyros for the digest of an import is told.
    pub fn notify_digest(&mut self, all: &BTreeSet<AlertOf>, context: &mut AlertContext<'_>) {
        for at in self.places(all.iter().copied()) {
            let Some(decision) = alert_decision::digest(&self.alerts[&at.0][at.1].alert, context.now) else { continue };
            self.enter(at, decision, false, (None, None), context);
            if decision.action != Action::Silent
                && let Some(step) = self.steps.last_mut()
            {
                step.action = "digest".to_owned();
            }
        }
    }

    pub(super) fn places(&self, all: impl IntoIterator<Item = AlertOf>) -> Vec<(AlertOf, usize)> {
        let of = |of: AlertOf| (0..self.alerts.get(&of).map_or(0, Vec::len)).map(move |place| (of, place));
        all.into_iter().flat_map(of).collect()
    }

    /// What a person said of an alert: applies `change`, and notes it as a step. None where there is no such alert.
    pub fn say(
        &mut self,
        id: Id,
        action: &str,
        remark: &Remark,
        change: impl FnOnce(&mut AlertRow),
        context: &mut AlertContext<'_>,
    ) -> Option<AlertRow> {
        let at = self.find(id)?;
        let row = &mut self.alerts.get_mut(&at.0)?[at.1];
        change(row);
        let row = row.clone();
        self.changed.insert(at);
        let said = (Some(remark.by.clone()), Some(remark.reason.clone()));
        self.step(&row, action, false, said, context);
        Some(row)
    }

    pub fn alert(&self, id: Id) -> Option<&AlertRow> {
        self.find(id).map(|(of, place)| &self.alerts[&of][place])
    }

    fn find(&self, id: Id) -> Option<(AlertOf, usize)> {
        let within =
            |(of, rows): (&AlertOf, &Vec<AlertRow>)| rows.iter().position(|row| row.id == id).map(|place| (*of, place));
        self.alerts.iter().find_map(within)
    }

    /// Makes a decision the alert's state, and a step of it, where it changes how the alert stands or tells somebody.
    fn enter(
        &mut self,
        at: (AlertOf, usize),
        decision: Decision,
        began: bool,
        said: StepRemark,
        context: &mut AlertContext<'_>,
    ) {
        let Some(alert) = decision.alert else { return };
        let row = &mut self.alerts.entry(at.0).or_default()[at.1];
        let earlier = (!began).then_some(row.alert);
        row.alert = alert;
        if !alert.acknowledged {
            row.acknowledged = None;
        }
        if alert.muted_until.is_none() {
            row.muted = None;
        }
        row.inhibited_by = row.inhibited_by.filter(|_| alert.inhibited);
        let row = row.clone();
        self.changed.insert(at);
        let action = if decision.action == Action::Silent {
            pending_notification(earlier, alert)
        } else {
            Some(decision.action)
        };
        if let Some(action) = action {
            let (step, body) = self.step(&row, action.name(), decision.action != Action::Silent, said, context);
            self.push_update(&row, action, Some(step), body, context);
        }
    }

    fn push_update(
        &mut self,
        row: &AlertRow,
        action: Action,
        step: Option<Id>,
        body: Option<AlertBody>,
        context: &AlertContext<'_>,
    ) {
        self.updates.push(AlertUpdate { id: row.id, alert: row.alert, action, step, body, cause: context.cause });
    }

    fn step(
        &mut self,
        row: &AlertRow,
        action: &str,
        told: bool,
        (author, reason): StepRemark,
        context: &mut AlertContext<'_>,
    ) -> (Id, Option<AlertBody>) {
        // The finding was written by this program, in this run or an earlier one; the next look at the alert names
        // the damage.
        let body = context.naming.alert(row, context.now).ok();
        let id = context.writer.next_id(context.now);
        self.steps.push(StepRow {
            id,
            alert: row.id,
            at: context.now,
            action: action.to_owned(),
            told,
            author,
            reason,
            body: body.as_ref().map(AlertBody::kept).unwrap_or_default(),
        });
        (id, body)
    }
}

/// What has become of an alert of which nobody is told.
fn pending_notification(earlier: Option<alert_decision::Alert>, alert: alert_decision::Alert) -> Option<Action> {
    let was_firing = earlier.is_some_and(|earlier| earlier.status == Status::Firing);
    let severity = earlier.map_or(alert.severity, |earlier| earlier.severity);
    match (was_firing, alert.status) {
        (false, Status::Firing) => Some(Action::Fire),
        (true, Status::Resolved) => Some(Action::Resolve),
        (true, Status::Firing) if alert.severity > severity => Some(Action::Escalate),
        (true, Status::Firing) if alert.severity < severity => Some(Action::Lower),
        _ => None,
    }
}
