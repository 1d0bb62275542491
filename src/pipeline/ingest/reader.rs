//! Reads what was sent: parsed, checked and separated before anything queues.

use crate::config::PlausibilityKeys;
use crate::core::at_reference::{AtReference, at_reference};
use crate::core::augmented::AugmentedModel;
use crate::core::fault::Fault;
use crate::core::history_note::is_unset;
use crate::core::record::{GyroParameters, Record};
use crate::core::separate::{CovarianceEg, Unseparable, separate, stated_covariance};
use crate::pipeline::diagnoses::models::{InForce, ModelCache};
use crate::pipeline::ingest::submission::{BenchTest, anything, check_names, kept};
use crate::pipeline::prelude::*;
use crate::pipeline::{CalibratedGyro, Calibration, Submission};
use crate::wire::answer::SeparationBody;
use crate::wire::bench::parse_bench_result;
use crate::wire::campaign::Form;
use crate::wire::document::DocumentKind;
use crate::wire::note::NoteBody;
use crate::wire::record::{parse_new_record, parse_record};
use crate::wire::time;

/// Reads records, campaigns and bench results, and what is stored of them. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Reader {
    pub(in crate::pipeline) store: Store,
    pub(in crate::pipeline) config: Arc<Config>,
    pub(in crate::pipeline) clock: Clock,
    pub(in crate::pipeline) models: ModelCache,
}

impl Reader {
    /// Reads, checks and separates a record.
    pub fn record(&self, bytes: &[u8]) -> Result<Calibration, Faults> {
        let record = parse_new_record(bytes, &self.config.plausibility.limits())?;
        self.check_time("/calibrated_at", record.calibrated_at)?;
        let in_force = self.in_force(record.imu.as_str());
        self.separated(record, bytes, &in_force)
    }

    /// Reads a stored record as a model states it: it was plausible once, whatever today's limits are.
    pub(super) fn reread_record(&self, body: &str, by: &InForce) -> Result<Calibration, Faults> {
        self.separated(parse_record(body.as_bytes(), &anything())?, body.as_bytes(), by)
    }

    fn separated(&self, record: Record, bytes: &[u8], by: &InForce) -> Result<Calibration, Faults> {
        let gyros = record.gyros.iter().enumerate().map(|(i, gyro)| {
            self.at_reference(&record, (i, gyro), &by.model).map_err(|why| {
                Fault { pointer: format!("/gyros/{i}/e_pulse_per_arcsec"), message: why.message() }.into()
            })
        });
        let gyros = gyros.collect::<Result<_, Faults>>()?;
        let Record { imu, station, calibrated_at, temperature_c, .. } = record;
        let (body, body_sha256) = kept(bytes)?;
        Ok(Calibration {
            kind: Kind::Record,
            imu,
            station,
            calibrated_at,
            ends_at: calibrated_at,
            model: by.of_records(),
            gyros,
            temperature_c,
            body,
            body_sha256,
            idempotency_key: None,
        })
    }

    /// One gyro of a record at the temperature of the model, and as measured where that is another.
    fn at_reference(
        &self,
        record: &Record,
        (place, gyro): (usize, &GyroParameters),
        model: &AugmentedModel,
    ) -> Result<CalibratedGyro, Unseparable> {
        let stated = stated_covariance(gyro);
        let measured = self.calibrated(record, (place, gyro), stated.as_ref())?;
        let AtReference { restated, unknown: not_restated } = at_reference(model, record, gyro, stated.as_ref());
        let Some((gyro, covariance)) = restated else { return Ok(CalibratedGyro { not_restated, ..measured }) };
        let restated = self.calibrated(record, (place, &gyro), covariance.as_ref())?;
        let as_measured = record.temperature_c.map(|celsius| Box::new((celsius, measured.separation)));
        let at_any_temperature = record.temperature_c.is_none();
        Ok(CalibratedGyro { as_measured, at_any_temperature, not_restated, ..restated })
    }

    /// Separates one gyro and holds it to the requirements.
    fn calibrated(
        &self,
        Record { geometry, imu, .. }: &Record,
        (place, gyro): (usize, &GyroParameters),
        covariance: Option<&CovarianceEg>,
    ) -> Result<CalibratedGyro, Unseparable> {
        let separation = separate(geometry, gyro.slot, &gyro.e, &gyro.g, covariance)?;
        let (whose, sds) = ((gyro.slot, imu, &gyro.serial), (gyro.e_sd.as_ref(), gyro.g_sd.as_ref()));
        let requirements = self.config.judging.of_parameters(geometry, whose, (&gyro.e, &gyro.g), sds);
        Ok(CalibratedGyro::new((place, gyro.slot, &gyro.serial), separation, requirements))
    }

    /// Reads and checks a bench result.
    pub fn bench_result(&self, bytes: &[u8]) -> Result<BenchTest, Faults> {
        let result = parse_bench_result(bytes, self.config.plausibility.max_drift_deg_per_h_g0)?;
        check_names(&[("/serial", &result.serial), ("/station", &result.station)], [].into_iter())?;
        self.check_time("/measured_at", result.measured_at)?;
        let (body, body_sha256) = kept(bytes)?;
        Ok(BenchTest { ends_at: result.measured_at, result, body, body_sha256, idempotency_key: None })
    }

    /// Refuses a time that cannot be: the sender's clock is wrong, or its year. What lies too far ahead of the clock
    /// would stay the newest for as long, what lies long before all else would become the baseline.
    pub fn check_time(&self, pointer: &str, at: UtcMicros) -> Result<(), Faults> {
        let PlausibilityKeys { max_future_hours: hours, earliest, clock_epochs, .. } = &self.config.plausibility;
        let message = if at > self.clock.now().plus_days(hours / 24.0) {
            message!("time_in_future", hours = text(hours))
        } else if at < *earliest {
            message!("before_earliest", earliest = text(time::format(*earliest)))
        } else if is_unset(at) && clock_epochs.contains(&UtcMicros(0)) {
            message!("clock_never_set")
        } else {
            return Ok(());
        };
        Err(Fault { pointer: pointer.to_owned(), message }.into())
    }

    /// Reads a record, a campaign or a bench result, whichever the JSON holds.
    pub fn document(&self, bytes: &[u8]) -> Result<Submission, Faults> {
        let kind = DocumentKind::of(bytes);
        self.read_as(kind, bytes).or_else(|faults| match DocumentKind::instead_of(kind, bytes) {
            // What it lacks is the time by which its kind is told at a glance.
            Some(other) => self.read_as(other, bytes),
            None => Err(faults),
        })
    }

    fn read_as(&self, kind: DocumentKind, bytes: &[u8]) -> Result<Submission, Faults> {
        match kind {
            DocumentKind::Record => Ok(Submission::Calibration(Box::new(self.record(bytes)?))),
            DocumentKind::Campaign => Ok(self.campaign_document(bytes, Form::Json)?.submission),
            DocumentKind::Bench => Ok(Submission::Bench(Box::new(self.bench_result(bytes)?))),
        }
    }

    pub fn separations(&self, gyros: &[CalibratedGyro]) -> Vec<SeparationBody> {
        let method = self.config.judging.method;
        let body = |gyro: &CalibratedGyro| {
            let body = SeparationBody::of(gyro.serial.as_str(), &gyro.separation, method);
            match gyro.as_measured.as_deref() {
                Some((celsius, measured)) => body.measured_at(*celsius, measured),
                None => body,
            }
        };
        gyros.iter().map(body).collect()
    }

    /// What is to be noted of a record beside the model that it is stated by.
    pub fn notes_of_model(&self, record: &Calibration) -> Vec<NoteBody> {
        let is_unknown = record.gyros.iter().any(|gyro| gyro.at_any_temperature);
        let of_gyro = |gyro: &CalibratedGyro| {
            let slot = gyro.slot;
            gyro.not_restated.clone().into_iter().map(move |effect| Note::NotRestated { slot, effect })
        };
        let notes = is_unknown.then_some(Note::AnyTemperature).into_iter().chain(record.gyros.iter().flat_map(of_gyro));
        notes.map(|note| NoteBody::of(&note)).collect()
    }

    /// The model that the next campaign of an IMU is fitted with.
    pub(super) fn in_force(&self, imu: &str) -> InForce {
        self.models.of(self.store.names().read().imus.number(imu))
    }
}
