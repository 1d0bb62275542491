//! What would fire if what counts no more had never come, and what came late had come in time: the verdicts on what there
//! is, followed again.

use super::gyro_window::GyroWindow;
use super::judged::{Firing, Judged, Undone};
use crate::core::alert_decision::{self, Alert, Policy, Status};
use crate::core::judge::{Coefficient, Mark, Severity};
use crate::pipeline::prelude::*;
use crate::store::{HistoryRow, StoredVerdict};

/// Follows the alerts of a gyro again over what is left of its history.
pub(super) struct Replay<'a> {
    pub store: &'a Store,
    pub policy: &'a Policy,
    pub lines: &'a HashMap<u32, GyroWindow>,
}

impl Replay<'_> {
    /// Notes for each gyro of which something counts no more, or is stated anew, what fires now. To be asked once the
    /// new verdicts have been entered.
    pub async fn undo(&self, changes: &Changes, judged: &mut Judged) -> Result<(), StoreError> {
        for gyro in changes.withdrawn.gyros() {
            let fires = self.fires(gyro, changes).await?;
            let rows = changes.withdrawn.history.iter().filter(|row| row.gyro == gyro);
            let gone = rows.clone().map(|row| row.figures.at).collect();
            if let Some((author, reason)) = said_of(rows.map(|row| row.figures.record), changes) {
                judged.undone.insert(gyro, Undone { fires: Some(fires), gone, author, reason });
            }
        }
        for gyro in changes.rejudged.gyros_restated() {
            let fires = Some(self.fires(gyro, changes).await?);
            let said = changes.models.last().map(|model| (model.author.clone(), model.reason.clone()));
            let (author, reason) = said.unwrap_or_default();
            judged.undone.entry(gyro).or_insert(Undone { fires, gone: Vec::new(), author, reason });
        }
        for (bench, gyro) in &changes.withdrawn.benches {
            if let Some((author, reason)) = said_of([*bench].into_iter(), changes) {
                judged.undone.entry(*gyro).or_insert(Undone { fires: None, gone: Vec::new(), author, reason });
            }
        }
        Ok(())
    }

    async fn fires(&self, gyro: u32, changes: &Changes) -> Result<Firing, StoreError> {
        Ok(self.replay(gyro, changes, usize::MAX).await?.unwrap_or_default())
    }

    /// What fires of a gyro by all its records that count. No more of them are read than tell: before a verdict that
    /// ends an alert, whatever it was, it does not matter what that was. None where more than `most` would tell.
    pub async fn replay(&self, gyro: u32, changes: &Changes, most: usize) -> Result<Option<Firing>, StoreError> {
        let gone: HashSet<Id> = changes.withdrawn.records.iter().copied().collect();
        let mut ahead = READ_AHEAD;
        loop {
            let stored = store::history::newest(self.store, gyro, Span::EVER, ahead).await?;
            let from = stored.first().map(|first| first.at).filter(|_| stored.len() == ahead);
            let new = changes.history.iter().filter(|row| row.gyro == gyro).map(|row| row.figures);
            let left = stored.into_iter().filter(|figures| !gone.contains(&figures.record)).chain(new);
            let left = left.filter(|figures| from.is_none_or(|from| figures.at >= from));
            let mut records: Vec<(UtcMicros, Id)> = left.map(|figures| (figures.at, figures.record)).collect();
            records.sort_unstable();
            let earlier = from.map(at_worst);
            let fires = self.follow(gyro, &records, earlier, changes).await?;
            if !fires.values().any(|alert| earlier.is_some_and(|earlier| alert.since == earlier.since)) {
                return Ok(Some(fires));
            }
            if ahead > most {
                return Ok(None);
            }
            ahead *= 4;
        }
    }

    /// What fires after these records, oldest first, where every alert was `earlier` before.
    async fn follow(
        &self,
        gyro: u32,
        records: &[(UtcMicros, Id)],
        earlier: Option<Alert>,
        changes: &Changes,
    ) -> Result<Firing, StoreError> {
        let mut sheets = store::record::record_verdicts(self.store, records.iter().map(|(_, id)| *id)).await?;
        let asked: HashSet<Id> = records.iter().map(|(_, id)| *id).collect();
        let rejudged = changes.rejudged.sheets.iter().map(|(record, again)| (*record, &again.sheet));
        let changed = rejudged.chain(changes.records.iter().map(|record| (record.id, &record.verdicts)));
        sheets.extend(changed.filter(|(id, _)| asked.contains(id)).map(|(id, sheet)| (id, sheet.clone())));
        let line = self.lines.get(&gyro);
        let mut alerts: HashMap<(Coefficient, Rule), Option<Alert>> = HashMap::new();
        let mut before = None;
        for (at, id) in records.iter().filter(|(at, _)| !line.is_some_and(|line| line.is_repeat(*at))) {
            let marks = line.map_or(&[][..], GyroWindow::marks);
            let marks: Vec<&Mark> =
                marks.iter().filter(|mark| before.is_some_and(|before| mark.at > before) && mark.at <= *at).collect();
            before = Some(*at);
            let verdicts = sheets.get(id).map_or(&[][..], |sheet| sheet.of(gyro)).iter();
            for verdict in verdicts.map(StoredVerdict::without_words) {
                let alert = alerts.entry((verdict.coefficient, verdict.rule)).or_insert(earlier);
                let goes_on = alert.filter(|_| !marks.iter().any(|mark| mark.event.resets(verdict.rule)));
                let followed = alert_decision::follow(goes_on.as_ref(), &verdict, *at, *at, self.policy);
                let exceeds = verdict.severity().is_some();
                *alert = followed.alert.map(|now| Alert { fired_at: if exceeds { *at } else { now.fired_at }, ..now });
            }
        }
        let firing = alerts.into_iter().filter_map(|(key, alert)| Some((key, alert?)));
        Ok(firing.filter(|(_, alert)| alert.status == Status::Firing).collect())
    }
}

/// Whether a verdict on the newest record, made at `at`, may leave an alert firing that fired before it.
pub(super) fn leaves_firing(verdict: &Verdict, at: UtcMicros, policy: &Policy) -> bool {
    let followed = alert_decision::follow(Some(&at_worst(at)), verdict, at, at, policy);
    followed.alert.is_some_and(|alert| alert.status == Status::Firing)
}

/// Records that are read at first; nearly always all that tell.
const READ_AHEAD: usize = 64;

/// An alert before a record of `from` that ends no sooner than any other.
fn at_worst(from: UtcMicros) -> Alert {
    let since = UtcMicros(from.0 - 1);
    Alert {
        status: Status::Firing,
        severity: Severity::Critical,
        since,
        fired_at: since,
        resolved_at: None,
        record_at: since,
        within: 0,
        acknowledged: false,
        silenced_until: None,
        muted_until: None,
        inhibited: false,
        suppressed: None,
        last_notification: None,
    }
}

/// Marks the rows that count no more, but where another has come in their place.
pub(super) fn mark(changes: &mut Changes) {
    for HistoryRow { gyro, figures } in &changes.withdrawn.history {
        let is_there = |row: &HistoryRow| row.gyro == *gyro && row.figures.at == figures.at;
        if !changes.history.iter().any(is_there) {
            let figures = Figures { voided: true, ..*figures };
            changes.rejudged.history.push(HistoryRow { gyro: *gyro, figures });
        }
    }
}

/// Who said that the first of these counts no more that somebody said it of, and why.
fn said_of(items: impl Iterator<Item = Id> + Clone, changes: &Changes) -> Option<(String, String)> {
    let corrected = items.clone().find_map(|item| changes.corrections.iter().find(|row| row.item == item));
    let aside = || items.clone().find_map(|item| changes.set_aside.stored.iter().find(|row| row.record == item));
    let corrected = corrected.map(|row| (row.author.clone(), row.reason.clone()));
    corrected.or_else(|| aside().map(|row| (row.author.clone(), row.reason.clone())))
}
