//! What is stored, as it is answered: separations made again from the stored body, verdicts as they were decided; the
//! names of what is stored, and whether an item counts.

use std::sync::RwLockReadGuard;

use crate::core::access::AuditEntry;
use crate::core::bench::BenchItem;
use crate::core::correction::CorrectionItem;
use crate::core::diagnose::{ClosureDiagnosis, closures};
use crate::core::judge::Older;
use crate::core::judge::history::Need;
use crate::core::kind::RecordEntry;
use crate::core::message::sent;
use crate::core::name::Name;
use crate::pipeline::ingest::admit::figures_of;
use crate::pipeline::ingest::campaign::CampaignFit;
use crate::pipeline::ingest::judge::gyro_window::GyroWindow;
use crate::pipeline::prelude::*;
use crate::pipeline::{Calibration, Reader};
use crate::store::{ConfirmationRow, RecordFilter, RecordRow, StoredVerdict, Tables};
use crate::system::sha256;
use crate::wire::answer::{RecordAnswer, VerdictBody};
use crate::wire::body::bodies;
use crate::wire::calibration::CampaignAnswer;
use crate::wire::note;
use crate::wire::reason::Reason;
use crate::wire::sender::SenderBody;
use crate::wire::table::nearest;

/// The names of what is stored, while it is looked at.
#[derive(Debug)]
pub struct Names<'a>(pub(super) RwLockReadGuard<'a, Tables>);

impl Names<'_> {
    /// A number that was never given out has no name.
    pub fn imu(&self, number: u32) -> &str {
        self.0.imus.text(number)
    }

    pub fn station(&self, number: u32) -> &str {
        self.0.stations.text(number)
    }

    pub fn gyro(&self, number: u32) -> &str {
        self.0.gyros.text(number)
    }

    /// That no IMU has the name, with the one that it most resembles where one is near.
    pub fn unknown_imu(&self, imu: &str) -> Message {
        match nearest(imu, self.0.imus.all(), 8) {
            Some(known) => message!("unknown_imu_like", imu = sent(imu), known = sent(known)),
            None => message!("unknown_imu", imu = sent(imu)),
        }
    }

    pub fn imu_number(&self, imu: &str) -> Option<u32> {
        self.0.imus.number(imu)
    }

    pub fn station_number(&self, station: &str) -> Option<u32> {
        self.0.stations.number(station)
    }

    pub fn gyro_number(&self, serial: &str) -> Option<u32> {
        self.0.gyros.number(serial)
    }
}

/// Whether an item counts, and what was said of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemStatus {
    /// Of it, and of what it stands in the place of.
    pub corrections: Vec<CorrectionItem>,
    /// It does not count until somebody confirms its time.
    pub set_aside: bool,
    pub confirmation: Option<ConfirmationRow>,
    pub is_corrected: bool,
}

impl ItemStatus {
    /// It has neither been voided nor revised, and is not set aside.
    pub fn counts(&self) -> bool {
        !self.is_corrected && !self.set_aside
    }
}

#[derive(Debug, Clone)]
pub struct StoredRecord {
    pub item: RecordRow,
    pub answer: RecordAnswer,
    /// What each rule saw, verdict by verdict of the answer; none where judging again finds other figures.
    pub seen: Vec<Option<Verdict>>,
    pub closures: ClosureDiagnosis,
}

#[derive(Debug, Clone)]
pub struct StoredCampaign {
    pub item: RecordRow,
    pub answer: CampaignAnswer,
    /// As of [`StoredRecord`].
    pub seen: Vec<Option<Verdict>>,
}

/// What a list of records is narrowed down to.
#[derive(Debug, Clone, Copy)]
pub struct ListFilter<'a> {
    pub kind: Option<Kind>,
    pub imu: Option<&'a str>,
    pub station: Option<&'a str>,
    pub calibrated: Span,
}

/// What a stored row says.
pub(crate) struct DecodedRecord {
    pub row: RecordRow,
    pub calibration: Calibration,
    pub fitted: Option<CampaignFit>,
}

bodies! {
    SenderBody of AuditEntry: name = who, token, address = source, agent;
}

/// What is stored of records, campaigns and bench results. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Records {
    pub(super) store: Store,
    pub(super) config: Arc<Config>,
    pub(super) reader: Reader,
}

impl Records {
    /// A stored record and what is answered to it.
    ///
    /// # Errors
    /// [`StoreError`], for one where the body is not what was hashed when it came.
    pub async fn record(&self, id: Id) -> Result<Option<StoredRecord>, StoreError> {
        let Some(DecodedRecord { row, calibration, .. }) = self.reread(id).await? else { return Ok(None) };
        let (verdicts, seen) = self.verdicts_in_words(&row, &calibration).await?;
        let closures = closures_of(&calibration);
        let separations = self.reader.separations(&calibration.gyros);
        let mut notes = self.reader.notes_of_model(&calibration);
        notes.extend(note::read(row.notes.as_deref()));
        let answer = RecordAnswer { id: Some(id.to_string()), separations, notes, verdicts };
        Ok(Some(StoredRecord { item: row, answer, seen, closures }))
    }

    /// A stored campaign: fitted again from its dwells, the verdicts as they were decided.
    ///
    /// # Errors
    /// [`StoreError`], for one where the body is not what was hashed when it came.
    pub async fn campaign(&self, id: Id) -> Result<Option<StoredCampaign>, StoreError> {
        let Some(DecodedRecord { row, calibration, fitted: Some(fitted) }) = self.reread(id).await? else {
            return Ok(None);
        };
        let (verdicts, seen) = self.verdicts_in_words(&row, &calibration).await?;
        let mut answer = self.reader.campaign_answer(&fitted);
        answer.id = Some(id.to_string());
        answer.notes.extend(note::read(row.notes.as_deref()));
        answer.verdicts = verdicts;
        Ok(Some(StoredCampaign { item: row, answer, seen }))
    }

    /// Who sent an item, by the line of the audit trail about it.
    pub async fn sender(&self, line: Option<Id>) -> Result<Option<SenderBody>, StoreError> {
        let Some(line) = line else { return Ok(None) };
        Ok(store::access::audit_line(&self.store, line).await?.as_ref().map(SenderBody::from))
    }

    /// The closures of a stored record's gyros; none where there is no such record.
    pub async fn closures(&self, id: Id) -> Result<Option<ClosureDiagnosis>, StoreError> {
        Ok(self.reread(id).await?.map(|it| closures_of(&it.calibration)))
    }

    /// A stored record or campaign, read and separated again; it was plausible once, whatever today's limits are.
    pub(crate) async fn reread(&self, id: Id) -> Result<Option<DecodedRecord>, StoreError> {
        let Some(row) = store::record::get(&self.store, id).await? else { return Ok(None) };
        if sha256(row.body.as_bytes()) != row.body_sha256 {
            return Err(StoreError::damaged(format_args!("the body of record {id} does not have its hash")));
        }
        let unreadable =
            |faults: Faults| StoreError::damaged(format_args!("the body of record {id} cannot be read: {faults}"));
        let (calibration, fitted) = self.reader.again(&row).await?.map_err(unreadable)?;
        Ok(Some(DecodedRecord { row, calibration, fitted }))
    }

    pub async fn sent(&self, id: Id) -> Result<Option<RecordRow>, StoreError> {
        store::record::get(&self.store, id).await
    }

    /// Records and campaigns, the last to arrive first, from the one before `before` on.
    pub async fn listed(&self, filter: &ListFilter<'_>, before: Id, most: u32) -> Result<Vec<RecordEntry>, StoreError> {
        let [imus, stations] = [filter.imu, filter.station].map(|name| name.into_iter().collect());
        store::names::look_up(&self.store, [imus, stations, Vec::new()]).await?;
        let numbers = {
            let names = Names(self.store.names().read());
            let imu = filter.imu.map(|imu| names.imu_number(imu));
            (imu, filter.station.map(|station| names.station_number(station)))
        };
        let (None | Some(Some(_)), None | Some(Some(_))) = numbers else { return Ok(Vec::new()) };
        let (imu, station) = (numbers.0.flatten(), numbers.1.flatten());
        let filter = RecordFilter { kind: filter.kind, imu, station, calibrated: filter.calibrated };
        store::record::listed(&self.store, filter, before, most).await
    }

    /// Records and campaigns of an IMU, newest first.
    pub async fn of_imu(&self, imu: u32, most: u32) -> Result<Vec<RecordEntry>, StoreError> {
        store::record::of_imu(&self.store, imu, most).await
    }

    pub async fn bench(&self, id: Id) -> Result<Option<BenchItem>, StoreError> {
        store::bench::get(&self.store, id).await
    }

    /// Whether a record, campaign or bench result counts, and what was said of it.
    pub async fn status(&self, id: Id) -> Result<ItemStatus, StoreError> {
        let corrections = store::correction::of_item(&self.store, id).await?;
        Ok(ItemStatus {
            is_corrected: corrections.iter().any(|correction| correction.item == id),
            corrections,
            set_aside: store::set_aside::is_set_aside(&self.store, id).await?,
            confirmation: store::set_aside::confirmation(&self.store, id).await?,
        })
    }

    /// The stored verdicts; the words come from judging again. Where that finds other figures than were decided on
    /// (the limits have changed since), the figures stand and say so. What does not count any more is judged as it
    /// was when it counted.
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
            let serial = self.store.names().read().gyros.name(*number).map(str::to_owned);
            let Some(serial) = serial else {
                return Err(StoreError::damaged(format_args!("gyro number {number} has no name")));
            };
            let limits = self.config.judging.limits(calibration.imu.as_str(), &serial);
            let (need, method) = (Need::of(&limits), self.config.judging.method);
            let named = |name: &Name| self.store.names().read().gyros.number(name.as_str());
            let gyro = calibration.gyros.iter().find(|gyro| named(&gyro.serial) == Some(*number));
            let serial = gyro.map_or_else(|| serial.to_string(), |gyro| gyro.serial.to_string());
            let line = match gyro {
                Some(gyro) if !counts => {
                    let figures = figures_of(&gyro.separation, row.id, row.calibrated_at, row.imu, row.station);
                    GyroWindow::load_as_it_was(&self.store, *number, figures, method).await?
                }
                _ => GyroWindow::load(&self.store, *number, row.calibrated_at, need, method).await?,
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
        None => {
            let reason = Reason(vec![message!("decided_before")]);
            VerdictBody { limit_from: None, reason, ..VerdictBody::of(serial, &stored.without_words()) }
        }
    };
    (body, seen)
}
