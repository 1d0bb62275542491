//! What is stored, as it is answered: separations made again from the stored body, verdicts as they were decided.

use crate::core::diagnose::{ClosureDiagnosis, closures};
use crate::core::fault::Faults;
use crate::core::judge::history::Need;
use crate::core::judge::{Older, Verdict};
use crate::core::name::Name;
use crate::message;
use crate::pipeline::Pipeline;
use crate::pipeline::ingest::admit::figures_of;
use crate::pipeline::ingest::campaign::CampaignFit;
use crate::pipeline::ingest::judge::gyro_window::Line;
use crate::pipeline::ingest::submission::{CalibratedGyro, Calibration};
use crate::store;
use crate::store::{AuditRow, Id, Kind, RecordRow, StoreError, StoredVerdict};
use crate::system::sha256;
use crate::wire::answer::{RecordAnswer, SeparationBody, VerdictBody};
use crate::wire::history_note;
use crate::wire::reason::Reason;
use crate::wire::sender::SenderBody;

/// A stored record with its answer.
#[derive(Debug, Clone)]
pub struct StoredRecord {
    pub row: RecordRow,
    pub answer: RecordAnswer,
    /// What each rule saw, verdict by verdict of the answer; none where judging again finds other figures.
    pub seen: Vec<Option<Verdict>>,
    pub closures: ClosureDiagnosis,
}

/// What a stored row says.
pub(crate) struct Reread {
    pub row: RecordRow,
    pub calibration: Calibration,
    /// Of a campaign.
    pub fitted: Option<CampaignFit>,
}

impl Pipeline {
    pub fn separations(&self, gyros: &[CalibratedGyro]) -> Vec<SeparationBody> {
        let method = self.method();
        gyros.iter().map(|gyro| SeparationBody::of(gyro.serial.as_str(), &gyro.separation, method)).collect()
    }

    /// A stored record and what is answered to it.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] where the body is not what was hashed when it came.
    pub async fn stored_record(&self, id: Id) -> Result<Option<StoredRecord>, StoreError> {
        let Some(Reread { row, calibration, .. }) = self.reread(id).await? else { return Ok(None) };
        let (verdicts, seen) = self.verdicts_in_words(&row, &calibration).await?;
        let closures = closures_of(&calibration);
        let separations = self.separations(&calibration.gyros);
        let notes = history_note::read(row.notes.as_deref());
        let answer = RecordAnswer { id: Some(id.to_string()), separations, notes, verdicts };
        Ok(Some(StoredRecord { row, answer, seen, closures }))
    }

    /// Who sent an item, by the line of the audit trail about it.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn sender(&self, line: Option<Id>) -> Result<Option<SenderBody>, StoreError> {
        let Some(line) = line else { return Ok(None) };
        let body = |line: AuditRow| SenderBody {
            name: line.who,
            token: line.token.map(|token| token.to_string()),
            address: line.source,
            agent: line.agent,
        };
        Ok(store::access::audit_line(&self.store, line).await?.map(body))
    }

    /// The closures of a stored record's gyros; none where there is no such record.
    ///
    /// # Errors
    /// As [`Pipeline::stored_record`].
    pub async fn closures(&self, id: Id) -> Result<Option<ClosureDiagnosis>, StoreError> {
        Ok(self.reread(id).await?.map(|it| closures_of(&it.calibration)))
    }

    /// A stored record or campaign, read and separated again; it was plausible once, whatever today's limits are.
    ///
    /// # Errors
    /// As [`Pipeline::stored_record`].
    pub(crate) async fn reread(&self, id: Id) -> Result<Option<Reread>, StoreError> {
        let Some(row) = store::record::get(&self.store, id).await? else { return Ok(None) };
        if sha256(row.body.as_bytes()) != row.body_sha256 {
            return Err(StoreError::Damaged(format!("the body of record {id} does not have its hash")));
        }
        let unreadable =
            |faults: Faults| StoreError::Damaged(format!("the body of record {id} cannot be read: {faults}"));
        let (calibration, fitted) = match row.kind {
            Kind::Record => (self.reread_record(&row.body).map_err(unreadable)?, None),
            Kind::Campaign => {
                let fitted = self.fitted_again(&row).await?.map_err(unreadable)?;
                (self.calibration_again(&row, &fitted), Some(fitted))
            }
        };
        Ok(Some(Reread { row, calibration, fitted }))
    }

    /// Whether a record, campaign or bench result counts: it has neither been voided nor revised, and is not set aside.
    ///
    /// # Errors
    /// [`StoreError`], where what was said of it cannot be read.
    pub async fn counts(&self, id: Id) -> Result<bool, StoreError> {
        let corrected =
            store::correction::of_item(&self.store, id).await?.iter().any(|correction| correction.item == id);
        Ok(!corrected && !store::set_aside::is_set_aside(&self.store, id).await?)
    }

    /// The stored verdicts; the words come from judging again. Where that finds other figures than were decided on
    /// (the limits have changed since), the figures stand and say so. What does not count any more is judged as it was when it
    /// counted.
    pub(crate) async fn verdicts_in_words(
        &self,
        row: &RecordRow,
        calibration: &Calibration,
    ) -> Result<(Vec<VerdictBody>, Vec<Option<Verdict>>), StoreError> {
        let mut bodies = Vec::new();
        let counts = !row.voided;
        let why = match counts {
            false if store::set_aside::is_set_aside(&self.store, row.id).await? => message!("does_not_count_yet"),
            _ => message!("does_not_count"),
        };
        let uncounted = |body: VerdictBody| VerdictBody { reason: body.reason.and(why.clone()), ..body };
        for (number, stored) in &row.verdicts.0 {
            let serial = self.store.names().read().gyros.name(*number).cloned();
            let Some(serial) = serial else {
                return Err(StoreError::Damaged(format!("gyro number {number} has no name")));
            };
            let limits = self.config.judging.limits(calibration.imu.as_str(), &serial);
            let (need, method) = (Need::of(&limits), self.config.judging.method);
            let named = |name: &Name| self.store.names().read().gyros.number(name.as_str());
            let gyro = calibration.gyros.iter().find(|gyro| named(&gyro.serial) == Some(*number));
            let serial = gyro.map_or_else(|| serial.to_string(), |gyro| gyro.serial.to_string());
            let line = match gyro {
                Some(gyro) if !counts => {
                    let figures = figures_of(&gyro.separation, row.id, row.calibrated_at, row.imu, row.station);
                    Line::load_as_it_was(&self.store, *number, figures, method).await?
                }
                _ => Line::load(&self.store, *number, row.calibrated_at, need, method).await?,
            };
            let mut again = line.judge_newest(&limits, Older::NONE);
            again.extend(gyro.iter().flat_map(|gyro| gyro.requirements.iter().flatten()));
            let in_words = stored.iter().map(|verdict| in_words(&serial, verdict, &again));
            bodies.extend(in_words.map(|(body, seen)| (if counts { body } else { uncounted(body) }, seen)));
        }
        Ok(bodies.into_iter().unzip())
    }
}

fn closures_of(calibration: &Calibration) -> ClosureDiagnosis {
    closures(calibration.gyros.iter().map(|gyro| (gyro.slot, &gyro.separation)))
}

fn in_words(serial: &str, stored: &StoredVerdict, again: &[Verdict]) -> (VerdictBody, Option<Verdict>) {
    let seen = again.iter().find(|verdict| StoredVerdict::from(*verdict) == *stored).copied();
    let body = match &seen {
        Some(verdict) => VerdictBody::of(serial, verdict),
        None => VerdictBody {
            serial: serial.to_owned(),
            coefficient: stored.coefficient.name().into(),
            rule: stored.rule.name().into(),
            state: stored.state.name().into(),
            status: stored.status().name().into(),
            value: stored.value,
            limit: stored.limit,
            limit_from: None,
            sd: stored.sd,
            probability: stored.probability,
            confirmed: stored.confirmed,
            reason: Reason(vec![message!("decided_before")]),
        },
    };
    (body, seen)
}
