//! Raw campaigns: fitted and separated where they come in, and again from what is stored.

use crate::config::Stations;
use crate::core::augmented::AugmentedModel;
use crate::core::calibrate::outcome::{Outcome, evaluate_with};
use crate::core::campaign::{Campaign, Temperatures};
use crate::core::fault::Fault;
use crate::pipeline::diagnoses::models::{self, InForce};
use crate::pipeline::ingest::submission::{BenchTest, anything, check_names, kept};
use crate::pipeline::prelude::*;
use crate::pipeline::{CalibratedGyro, Calibration, Confirmation, Correction, Reader, Submission};
use crate::store::RecordRow;
use crate::wire::bench::BenchBody;
use crate::wire::calibration::CampaignAnswer;
use crate::wire::campaign::{self, Form};
use crate::wire::campaign_csv::parse_csv_as_sent;

/// A campaign that can be stored.
#[derive(Debug, Clone)]
pub struct ReadCampaign {
    /// Of an IMU a calibration, of a single gyro on a bench a bench test.
    pub submission: Submission,
    /// What its answer is made of.
    pub fit: CampaignFit,
    /// As it is kept: JSON, whichever form it came in.
    pub body: Arc<str>,
}

/// A campaign as it is fitted when it comes, and again whenever it is read.
#[derive(Debug, Clone)]
pub struct CampaignFit {
    pub(crate) campaign: Campaign,
    pub(crate) outcome: Outcome,
    /// The adopted model that it is fitted with.
    pub(crate) model: Option<Id>,
}

/// A stored campaign.
pub(crate) fn campaign_of(row: &RecordRow) -> Result<Campaign, StoreError> {
    campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(row.id, &faults))
}

pub(crate) fn damaged(id: Id, faults: &Faults) -> StoreError {
    StoreError::damaged(format_args!("the body of campaign {id} cannot be read: {faults}"))
}

impl Reader {
    /// Reads, checks, fits and separates a campaign in JSON or CSV. A raw bench test becomes a bench result.
    /// Computing, about a millisecond: not for a thread that serves others.
    pub fn campaign_document(&self, bytes: &[u8], form: Form) -> Result<ReadCampaign, Faults> {
        let (campaign, as_json) = match form {
            Form::Json => (campaign::parse_json_as_sent(bytes)?, None),
            Form::Csv => {
                let (body, campaign) = parse_csv_as_sent(bytes)?;
                (campaign, Some(serde_json::to_vec(&body).expect("strings and finite numbers always serialise")))
            }
        };
        let campaign = self.config.stations.complete(campaign);
        let serials = campaign.gyros.iter().map(|gyro| &gyro.serial);
        check_names(&[("/imu", &campaign.imu), ("/station", &campaign.station)], serials)?;
        self.check_time("/measured_at", campaign.measured_at)?;
        let in_force = self.in_force(campaign.imu.as_str());
        let options = in_force.model.options_as_asked(&campaign);
        let limits = self.config.plausibility.limits();
        campaign.check_known_scales(&limits)?;
        let outcome = evaluate_with(&campaign, &options, &limits)?;
        let fit = CampaignFit { campaign, outcome, model: in_force.id };
        let (body, body_sha256) = kept(as_json.as_deref().unwrap_or(bytes))?;
        let submission = match &fit.outcome {
            Outcome::Imu { .. } => {
                Submission::Calibration(Box::new(self.calibration_of(&fit, (body.clone(), body_sha256))))
            }
            Outcome::Bench(bench) => Submission::Bench(Box::new(BenchTest {
                result: bench.result(&fit.campaign),
                ends_at: fit.campaign.ends_at(),
                body: body.clone(),
                body_sha256,
                idempotency_key: None,
            })),
        };
        Ok(ReadCampaign { submission, fit, body })
    }

    /// A calibration that was read before another model came into force, as the one in force states it; none where
    /// that cannot be, or is not needed.
    pub(in crate::pipeline) fn restated_anew(&self, sent: &Calibration) -> Option<Calibration> {
        if !self.is_outdated(sent) {
            return None;
        }
        let calibration = match sent.kind {
            Kind::Record => self.reread_record(&sent.body, &self.in_force(sent.imu.as_str())).ok()?,
            Kind::Campaign => {
                let anew = self.fitted_with_model_in_force(sent.imu.as_str(), &sent.body)?;
                self.calibration_of(&anew, (Arc::clone(&sent.body), sent.body_sha256))
            }
        };
        Some(Calibration { idempotency_key: sent.idempotency_key.clone(), ..calibration })
    }

    /// As [`Self::restated_anew`], of what brings a calibration, or lets one count.
    pub(super) async fn read_anew(&self, sent: &Submission) -> Result<Option<Submission>, StoreError> {
        if let Submission::Confirmation(confirmation) = sent {
            let restated = self.stored_anew(confirmation.id).await?.map(Box::new);
            return Ok(Some(Submission::Confirmation(Confirmation { restated, ..confirmation.clone() })));
        }
        let Some(anew) = sent.calibration().and_then(|sent| self.restated_anew(sent)) else { return Ok(None) };
        Ok(Some(match sent {
            Submission::Correction(correction) => Submission::Correction(Box::new(Correction {
                replacement: Some(anew),
                ..Correction::clone(correction)
            })),
            _ => Submission::Calibration(Box::new(anew)),
        }))
    }

    /// A stored calibration as the model in force states it, and that model: also one that was set aside when an
    /// earlier version of this program stated it by the same model.
    async fn stored_anew(&self, id: Id) -> Result<Option<(Calibration, Id)>, StoreError> {
        let Some(row) = store::record::get(&self.store, id).await? else { return Ok(None) };
        let Ok((stated, _)) = self.again(&row).await? else { return Ok(None) };
        let gyros = stated.gyros.iter().map(|gyro| gyro.serial.as_str()).collect();
        store::names::look_up(&self.store, [vec![stated.imu.as_str()], Vec::new(), gyros]).await?;
        Ok(match self.restated_anew(&stated) {
            Some(anew) => Some(anew).zip(self.in_force(stated.imu.as_str()).id),
            None => stated.model.map(|model| (stated, model)),
        })
    }

    /// Whether a calibration is stated by another model than the one in force.
    pub(super) fn is_outdated(&self, sent: &Calibration) -> bool {
        let in_force = self.in_force(sent.imu.as_str());
        match sent.kind {
            Kind::Record => sent.model != in_force.of_records(),
            Kind::Campaign => sent.model != in_force.id,
        }
    }

    fn fitted_with_model_in_force(&self, imu: &str, body: &str) -> Option<CampaignFit> {
        evaluated(&self.config.stations, body, &self.in_force(imu)).ok()
    }

    /// What is answered to a campaign that was just stored: another model may have come into force since it was read.
    pub fn answer_as_stored(&self, fit: &CampaignFit, body: &str) -> CampaignAnswer {
        let imu = fit.campaign.imu.as_str();
        let outdated = fit.model != self.in_force(imu).id;
        let anew = outdated.then(|| self.fitted_with_model_in_force(imu, body)).flatten();
        self.campaign_answer(anew.as_ref().unwrap_or(fit))
    }

    /// What is answered to a campaign, but for its id and verdicts.
    pub fn campaign_answer(&self, fit: &CampaignFit) -> CampaignAnswer {
        let mut answer = CampaignAnswer::of(&fit.campaign, &fit.outcome, self.config.judging.method);
        answer.imu_model = fit.model.map(|id| id.to_string());
        answer
    }

    /// A stored calibration as the model states it that it was stored by; a campaign, fitted again on a thread for that,
    /// with its fit.
    pub(crate) async fn again(
        &self,
        row: &RecordRow,
    ) -> Result<Result<(Calibration, Option<CampaignFit>), Faults>, StoreError> {
        let model = self.fitted_with(row.id).await?;
        if row.kind == Kind::Record {
            return Ok(self.reread_record(&row.body, &model).map(|calibration| (calibration, None)));
        }
        let (config, body) = (Arc::clone(&self.config), Arc::clone(&row.body));
        let failed = format!("campaign {} could not be fitted", row.id);
        let fitted = computed(failed, move || evaluated(&config.stations, &body, &model)).await?;
        let kept = || (Arc::clone(&row.body), row.body_sha256);
        Ok(fitted.map(|fit| (self.calibration_of(&fit, kept()), Some(fit))))
    }

    fn calibration_of(
        &self,
        CampaignFit { campaign, outcome, model }: &CampaignFit,
        (body, body_sha256): (Arc<str>, [u8; 32]),
    ) -> Calibration {
        let gyros = match outcome {
            Outcome::Imu { calibration, separations, .. } => {
                let pairs = calibration.gyros.iter().zip(&campaign.gyros).zip(separations).enumerate();
                let separated = pairs.filter_map(|(place, ((fitted, gyro), separation))| {
                    let separation = separation.as_ref().ok()?;
                    let (e, g) = (fitted.e()?, fitted.g()?);
                    let sd = fitted.covariance_eg().map(|c| c.diagonal().map(|v| v.max(0.0).sqrt()));
                    let [e_sd, g_sd] = [0, 3].map(|row| sd.map(|sd| sd.fixed_rows::<3>(row).into_owned()));
                    let whose = (gyro.slot, &campaign.imu, &gyro.serial);
                    let (sds, judging) = ((e_sd.as_ref(), g_sd.as_ref()), &self.config.judging);
                    let requirements = judging.of_parameters(&campaign.geometry, whose, (&e, &g), sds);
                    let seat = (place, gyro.slot, &gyro.serial);
                    Some(CalibratedGyro::new(seat, separation.clone(), requirements))
                });
                separated.collect()
            }
            Outcome::Bench(_) => Vec::new(),
        };
        let of_dwells = || {
            let filled = Temperatures::of(campaign).filled?;
            Some(filled.iter().sum::<f64>() / filled.len() as f64)
        };
        Calibration {
            kind: Kind::Campaign,
            imu: campaign.imu.clone(),
            station: campaign.station.clone(),
            calibrated_at: campaign.measured_at,
            ends_at: campaign.ends_at(),
            model: *model,
            gyros,
            temperature_c: campaign.temperature_c.or_else(of_dwells),
            body,
            body_sha256,
            idempotency_key: None,
        }
    }

    /// The campaigns of an IMU that count, fitted with a model, and its records, where that or the one in force states
    /// them at a temperature; those of `known` as they are there.
    pub(crate) async fn restated(
        &self,
        imu: &str,
        model: &Arc<AugmentedModel>,
        known: Restated,
    ) -> Result<Restated, StoreError> {
        let mut restated = Restated::new();
        let Some(number) = self.store.names().read().imus.number(imu) else { return Ok(restated) };
        let models = [&self.in_force(imu).model, model];
        let of_records = models.iter().any(|model| model.restates_at().is_some());
        for head in store::record::of_imu(&self.store, number, u32::MAX).await? {
            if head.kind == Kind::Record && !of_records {
                continue;
            }
            if let Some(known) = known.get(&head.id) {
                restated.insert(head.id, known.clone());
                continue;
            }
            let Some(row) = store::record::get(&self.store, head.id).await? else { continue };
            let (reader, model) = (self.clone(), InForce { id: None, model: Arc::clone(model) });
            let failed = format!("campaign {} could not be fitted", head.id);
            restated.insert(head.id, computed(failed, move || reader.stated_by(&row, &model).ok()).await?);
        }
        Ok(restated)
    }

    /// A stored calibration as a model states it, a campaign without its dwells. Computing, about a millisecond.
    pub(super) fn stated_by(&self, row: &RecordRow, model: &InForce) -> Result<Calibration, Faults> {
        match row.kind {
            Kind::Record => self.reread_record(&row.body, model),
            Kind::Campaign => {
                let fit = evaluated(&self.config.stations, &row.body, model)?;
                Ok(self.calibration_of(&fit, ("".into(), row.body_sha256)))
            }
        }
    }

    pub fn fitted_bench(&self, body: &str) -> Result<BenchBody, Faults> {
        let CampaignFit { campaign, outcome, .. } = evaluated(&self.config.stations, body, &InForce::default())?;
        match outcome {
            Outcome::Bench(bench) => Ok(BenchBody::from(&bench.result(&campaign))),
            Outcome::Imu { .. } => {
                Err(Fault { pointer: "/test".to_owned(), message: message!("is_no_bench_test") }.into())
            }
        }
    }

    /// The model that a stored campaign was fitted with, or a record restated by.
    async fn fitted_with(&self, id: Id) -> Result<InForce, StoreError> {
        let row = store::model::of_campaign(&self.store, id).await?;
        row.as_ref().map_or_else(|| Ok(InForce::default()), models::read)
    }
}

/// Stored calibrations stated by another model than they were; none where one cannot be.
pub(crate) type Restated = HashMap<Id, Option<Calibration>>;

/// Fitted as it was when it came: it was plausible once, whatever today's limits are. What the station left unsaid of
/// itself is what the configuration says today.
fn evaluated(stations: &Stations, body: &str, fitted_with: &InForce) -> Result<CampaignFit, Faults> {
    let campaign = stations.complete(campaign::parse_json(body.as_bytes())?);
    let outcome = evaluate_with(&campaign, &fitted_with.model.options_as_asked(&campaign), &anything())?;
    Ok(CampaignFit { campaign, outcome, model: fitted_with.id })
}
