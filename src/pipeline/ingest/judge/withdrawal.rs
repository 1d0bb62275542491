//! What would fire if what counts no more had never come: the verdicts on what is left, followed again from the first.

use super::judged::{Firing, Judged, Undone};
use crate::core::alert_decision::{self, Alert, Policy, Status};
use crate::core::correction::CorrectionItem;
use crate::core::judge::Coefficient;
use crate::pipeline::prelude::*;
use crate::store::HistoryRow;

/// Follows the alerts of a gyro again over what is left of its history.
pub(super) struct Replay<'a> {
    pub store: &'a Store,
    pub policy: &'a Policy,
}

impl Replay<'_> {
    /// Notes for each gyro of which something counts no more, or is stated anew, what fires now. To be asked once the
    /// new verdicts have been entered.
    pub async fn undo(&self, changes: &Changes, judged: &mut Judged) -> Result<(), StoreError> {
        for gyro in changes.withdrawn.gyros() {
            let fires = self.replay(gyro, changes).await?;
            let rows = changes.withdrawn.history.iter().filter(|row| row.gyro == gyro);
            let gone = rows.clone().map(|row| row.figures.at).collect();
            let rows = rows.map(|row| row.figures.record);
            if let Some(said) = said_of(rows.clone(), changes) {
                judged.undone.insert(gyro, Undone { gone, ..undone(Some(fires), said) });
            } else if let Some(aside) =
                rows.into_iter().find_map(|record| changes.set_aside.stored.iter().find(|aside| aside.record == record))
            {
                let (author, reason) = (aside.author.clone(), aside.reason.clone());
                judged.undone.insert(gyro, Undone { fires: Some(fires), gone, author, reason });
            }
        }
        for gyro in changes.rejudged.gyros_restated() {
            let fires = Some(self.replay(gyro, changes).await?);
            let said = changes.models.last().map(|model| (model.author.clone(), model.reason.clone()));
            let (author, reason) = said.unwrap_or_default();
            judged.undone.entry(gyro).or_insert(Undone { fires, gone: Vec::new(), author, reason });
        }
        for (bench, gyro) in &changes.withdrawn.benches {
            if let Some(said) = said_of([*bench].into_iter(), changes) {
                judged.undone.entry(*gyro).or_insert_with(|| undone(None, said));
            }
        }
        Ok(())
    }

    async fn replay(&self, gyro: u32, changes: &Changes) -> Result<Firing, StoreError> {
        let gone: HashSet<Id> = changes.withdrawn.records.iter().copied().collect();
        let stored = store::history::oldest(self.store, gyro, Span::EVER, usize::MAX).await?;
        let new = changes.history.iter().filter(|row| row.gyro == gyro).map(|row| row.figures);
        let left = stored.into_iter().filter(|figures| !gone.contains(&figures.record)).chain(new);
        let mut records: Vec<(UtcMicros, Id)> = left.map(|figures| (figures.at, figures.record)).collect();
        records.sort_unstable();
        let mut sheets = store::record::verdict_sheets(self.store, records.iter().map(|(_, id)| *id)).await?;
        sheets.extend(changes.rejudged.sheets.iter().map(|(record, again)| (*record, again.sheet.clone())));
        sheets.extend(changes.records.iter().map(|record| (record.id, record.verdicts.clone())));
        let mut alerts: HashMap<(Coefficient, Rule), Alert> = HashMap::new();
        for (at, id) in records {
            for verdict in sheets.get(&id).map_or(&[][..], |sheet| sheet.of(gyro)) {
                let key = (verdict.coefficient, verdict.rule);
                let decision = alert_decision::follow(alerts.get(&key), &verdict.without_words(), at, at, self.policy);
                alerts.extend(decision.alert.map(|alert| (key, alert)));
            }
        }
        alerts.retain(|_, alert| alert.status == Status::Firing);
        Ok(alerts)
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

fn said_of(mut items: impl Iterator<Item = Id>, changes: &Changes) -> Option<&CorrectionItem> {
    items.find_map(|item| changes.corrections.iter().find(|row| row.item == item))
}

fn undone(fires: Option<Firing>, said: &CorrectionItem) -> Undone {
    Undone { fires, gone: Vec::new(), author: said.author.clone(), reason: said.reason.clone() }
}
