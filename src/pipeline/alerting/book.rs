//! The alerts in memory, and what is to be written about them.

use std::collections::{BTreeMap, BTreeSet};

use super::body::{Naming, Origin, text};
use crate::core::judge::{Rule, Verdict};
use crate::core::notify::{self, Action, Decision, Policy, Status};
use crate::core::time::UtcMicros;
use crate::pipeline::judging::Undone;
use crate::store::{AlertRow, Changes, Id, Remark, StepRow, Store, StoreError, Writer};

/// Every alert by gyro, and those that the transaction under construction changes.
#[derive(Debug)]
pub(in crate::pipeline) struct AlertBook {
    policy: Policy,
    alerts: BTreeMap<u32, Vec<AlertRow>>,
    /// Gyro and place of what has changed since the last [`AlertBook::write`].
    changed: BTreeSet<(u32, usize)>,
    steps: Vec<StepRow>,
    /// What is in memory is ahead of what is stored.
    stale: bool,
}

/// Who said something that became a step, and why.
type Said = (Option<String>, Option<String>);

/// What it takes to write an entry: the time, identifiers, names.
pub(in crate::pipeline) struct Pen<'a> {
    pub now: UtcMicros,
    pub writer: &'a mut Writer,
    pub naming: Naming<'a>,
}

impl AlertBook {
    pub async fn load(store: &Store, policy: Policy) -> Result<Self, StoreError> {
        let mut book =
            Self { policy, alerts: BTreeMap::new(), changed: BTreeSet::new(), steps: Vec::new(), stale: true };
        book.refresh(store).await?;
        Ok(book)
    }

    /// What was noted is not what was committed: it is read again before it is used.
    pub fn forget(&mut self) {
        self.stale = true;
    }

    /// Reads everything again, where it was forgotten.
    pub async fn refresh(&mut self, store: &Store) -> Result<(), StoreError> {
        if self.stale {
            let rows = store.alerts().await?;
            (self.alerts, self.changed, self.steps) = Default::default();
            rows.into_iter().for_each(|row| self.alerts.entry(row.gyro).or_default().push(row));
            self.stale = false;
        }
        Ok(())
    }

    /// Puts what has changed into a transaction.
    pub fn write(&mut self, changes: &mut Changes) {
        let changed = std::mem::take(&mut self.changed);
        changes.alerts.extend(changed.into_iter().map(|(gyro, place)| self.alerts[&gyro][place].clone()));
        changes.alert_steps.append(&mut self.steps);
    }

    /// Whether a gyro has ever had an alert.
    pub fn knows(&self, gyro: u32) -> bool {
        self.alerts.contains_key(&gyro)
    }

    pub fn firing(&self, gyro: u32) -> impl Iterator<Item = &AlertRow> {
        self.alerts.get(&gyro).into_iter().flatten().filter(|row| row.alert.status == Status::Firing)
    }

    pub fn gyros(&self) -> Vec<u32> {
        self.alerts.keys().copied().collect()
    }

    /// Follows a verdict on the newest figures of a gyro.
    pub fn follow(&mut self, gyro: u32, verdict: &Verdict, origin: &Origin, pen: &mut Pen<'_>) {
        let place = self.place(gyro, |row| row.coefficient == verdict.coefficient && row.rule == verdict.rule);
        let earlier = place.map(|place| &self.alerts[&gyro][place]);
        let decision = notify::follow(earlier.map(|row| &row.alert), verdict, origin.at, pen.now, &self.policy);
        let Some(alert) = decision.alert else { return };
        let naming = pen.naming;
        let finding = || text(&naming.finding(verdict, origin));
        let (place, began) = match (place, earlier) {
            (Some(place), Some(row)) => {
                // How long a calibration is overdue changes by itself: that is no news.
                let same_finding =
                    || alert.status == Status::Resolved || verdict.rule == Rule::Overdue || row.finding == finding();
                if row.alert == alert && decision.action == Action::Silent && same_finding() {
                    return;
                }
                (place, false)
            }
            _ => {
                let row = AlertRow {
                    id: pen.writer.next_id(pen.now),
                    gyro,
                    coefficient: verdict.coefficient,
                    rule: verdict.rule,
                    alert,
                    acknowledged: None,
                    silenced: None,
                    finding: String::new(),
                };
                let rows = self.alerts.entry(gyro).or_default();
                rows.push(row);
                (rows.len() - 1, true)
            }
        };
        self.alerts.entry(gyro).or_default()[place].finding = finding();
        self.enter((gyro, place), decision, began, (None, None), pen);
    }

    /// Ends what fires where `ends` says so: a rule that does not judge any more, or whose history an event has cut off.
    pub fn reset(&mut self, gyro: u32, ends: impl Fn(&AlertRow) -> bool, pen: &mut Pen<'_>) {
        for place in 0..self.alerts.get(&gyro).map_or(0, Vec::len) {
            let row = &self.alerts[&gyro][place];
            if row.alert.status == Status::Firing && ends(row) {
                let decision = notify::reset(&row.alert, pen.now);
                self.enter((gyro, place), decision, false, (None, None), pen);
            }
        }
    }

    /// Ends what fires where `ends` says so, because of what somebody has said of a record or bench result.
    pub fn undo(&mut self, gyro: u32, ends: impl Fn(&AlertRow) -> bool, undone: &Undone, pen: &mut Pen<'_>) {
        for place in 0..self.alerts.get(&gyro).map_or(0, Vec::len) {
            let row = &self.alerts[&gyro][place];
            if row.alert.status == Status::Firing && ends(row) {
                let decision = notify::reset(&row.alert, pen.now);
                let said = (Some(undone.author.clone()), Some(undone.reason.clone()));
                self.enter((gyro, place), decision, false, said, pen);
            }
        }
    }

    /// Follows the clock: repeats, and tells what a silence has held back.
    pub fn tick(&mut self, pen: &mut Pen<'_>) {
        for gyro in self.gyros() {
            for place in 0..self.alerts[&gyro].len() {
                let row = &self.alerts[&gyro][place];
                let decision = notify::tick(&row.alert, pen.now, &self.policy);
                if decision.alert != Some(row.alert) {
                    self.enter((gyro, place), decision, false, (None, None), pen);
                }
            }
        }
    }

    /// What a person said of an alert: applies `change`, and notes it as a step. None where there is no such alert.
    pub fn say(
        &mut self,
        id: Id,
        action: &str,
        remark: &Remark,
        change: impl FnOnce(&mut AlertRow),
        pen: &mut Pen<'_>,
    ) -> Option<AlertRow> {
        let (gyro, place) = self.find(id)?;
        let row = &mut self.alerts.get_mut(&gyro)?[place];
        change(row);
        let row = row.clone();
        self.changed.insert((gyro, place));
        let said = (Some(remark.by.clone()), Some(remark.reason.clone()));
        self.step(&row, action, false, said, pen);
        Some(row)
    }

    pub fn alert(&self, id: Id) -> Option<&AlertRow> {
        self.find(id).map(|(gyro, place)| &self.alerts[&gyro][place])
    }

    fn find(&self, id: Id) -> Option<(u32, usize)> {
        let in_gyro =
            |(gyro, rows): (&u32, &Vec<AlertRow>)| rows.iter().position(|row| row.id == id).map(|place| (*gyro, place));
        self.alerts.iter().find_map(in_gyro)
    }

    fn place(&self, gyro: u32, is_it: impl FnMut(&AlertRow) -> bool) -> Option<usize> {
        self.alerts.get(&gyro)?.iter().position(is_it)
    }

    /// Makes a decision the alert's state, and a step of it, where it changes how the alert stands or tells somebody.
    fn enter(&mut self, (gyro, place): (u32, usize), decision: Decision, began: bool, said: Said, pen: &mut Pen<'_>) {
        let Some(alert) = decision.alert else { return };
        let row = &mut self.alerts.entry(gyro).or_default()[place];
        let earlier = (!began).then_some(row.alert);
        row.alert = alert;
        if !alert.acknowledged {
            row.acknowledged = None;
        }
        let row = row.clone();
        self.changed.insert((gyro, place));
        let action = if decision.action == Action::Silent { untold(earlier, alert) } else { Some(decision.action) };
        if let Some(action) = action {
            self.step(&row, action.name(), decision.action != Action::Silent, said, pen);
        }
    }

    fn step(&mut self, row: &AlertRow, action: &str, told: bool, (author, reason): Said, pen: &mut Pen<'_>) {
        // The finding was written by this program, in this run or an earlier one; the next look at the alert names the damage.
        let body = pen.naming.alert(row, pen.now).map(|body| text(&body)).unwrap_or_default();
        let id = pen.writer.next_id(pen.now);
        self.steps.push(StepRow {
            id,
            alert: row.id,
            at: pen.now,
            action: action.to_owned(),
            told,
            author,
            reason,
            body,
        });
    }
}

/// What has become of an alert of which nobody is told.
fn untold(earlier: Option<notify::Alert>, alert: notify::Alert) -> Option<Action> {
    let was_firing = earlier.is_some_and(|earlier| earlier.status == Status::Firing);
    match (was_firing, alert.status) {
        (false, Status::Firing) => Some(Action::Fire),
        (true, Status::Resolved) => Some(Action::Resolve),
        (true, Status::Firing) if earlier.is_some_and(|earlier| alert.severity > earlier.severity) => {
            Some(Action::Escalate)
        }
        _ => None,
    }
}
