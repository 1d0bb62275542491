//! The gap against a reference: what parameters that have moved since make of it, what the model cannot say, and noise.
//!
//! With `X` the whitened columns of the model in use, `theta` the reference's parameters, `F` those columns that the
//! reference says nothing of (they are fitted), and `M` what the rest spans beside them,
//!
//! ```text
//! e = (1 - FF')(y - X theta) = MM'e + r,     |e|^2 = |MM'e|^2 + |r|^2
//! ```
//!
//! exactly: `MM'e` is what a new fit of the same model closes, `r` what it leaves. Noise alone makes `tr C` of the
//! first and the degrees of freedom of the second, `C = 1 + M'X cov(theta) X'M`; what is above that is parameters and
//! structure.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::core::augmented::Options;
use crate::core::calibrate::{GyroCalibration, calibrate_augmented, design};
use crate::core::campaign::{Campaign, TestKind};
use crate::core::diagnose::diagnosis::Residual;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::Refusal;
use crate::core::message::{Message, list, text};
use crate::core::model::{Term, Terms};
use crate::core::mounting::{Geometry, Slot};
use crate::core::numerics::basis::{Basis, axpy, dot};
use crate::core::numerics::tails::f_tail;
use crate::core::record::{GyroParameters, Name, Record};
use crate::core::time::UtcMicros;
use crate::message;

/// What a campaign is held against.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Fitted with the model in use.
    Campaign(Campaign),
    Record(Record),
}

/// Why something is no reference for a campaign.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NoReference {
    OtherImu {
        reference: Name,
        campaign: Name,
    },
    OtherGeometry,
    NoGyro {
        slot: Slot,
        serial: Name,
    },
    OtherGyro {
        slot: Slot,
        reference: Name,
        campaign: Name,
    },
    BenchTest,
    NothingInCommon,
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl NoReference {
    /// The refusal as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::OtherImu { reference, campaign } => {
                message!("reference_of_other_imu", reference = text(reference), campaign = text(campaign))
            }
            Self::OtherGeometry => message!("reference_of_other_geometry"),
            Self::NoGyro { slot, serial } => {
                message!("reference_without_gyro", slot = slot.name(), serial = text(serial))
            }
            Self::OtherGyro { slot, reference, campaign } => message!(
                "reference_with_other_gyro",
                slot = slot.name(),
                reference = text(reference),
                campaign = text(campaign)
            ),
            Self::BenchTest => message!("bench_test_has_no_reference"),
            Self::NothingInCommon => message!("nothing_in_common"),
            Self::Refused(why) => why.message(),
        }
    }
}

/// The gap in its three parts; mean squares add up to that of the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    pub imu: Name,
    pub station: Name,
    pub measured_at: UtcMicros,
    pub all: Parts,
    pub gyros: Vec<(Slot, Parts)>,
    pub moved: Vec<Moved>,
    pub notes: Vec<Message>,
}

/// Root mean squares over dwells, each dwell weighted by 1/sd^2, deg/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    pub whole: f64,
    pub parameters: f64,
    pub structure: f64,
    pub noise: f64,
    /// Probability that noise, the reference's own included, moves the parameters as far.
    pub p_value: f64,
}

/// One coefficient then and now, along the axes that the campaign shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    pub slot: Slot,
    pub coefficient: &'static str,
    pub reference: f64,
    pub now: f64,
    /// Of the difference; none where neither states its noise.
    pub sd: Option<f64>,
    pub unit: &'static str,
}

/// Parameters of model (6) of one gyro, pulse, and their covariance.
struct Known {
    serial: Name,
    terms: Terms,
    values: Vec<f64>,
    determined: Vec<bool>,
    covariance: Option<DMatrix<f64>>,
    e: Vector3<f64>,
}

/// Splits the gap of a campaign. `residuals` are those of its diagnosis with the same options: their standard
/// deviations are the noise.
///
/// # Errors
/// [`NoReference`], naming what does not fit.
pub fn split(
    campaign: &Campaign,
    options: &Options,
    residuals: &[Residual],
    reference: &Reference,
) -> Result<Split, NoReference> {
    may_be_split(campaign, reference)?;
    let frame = Frame::of(campaign, options)?;
    let (then, mut notes) = known(reference, &frame, options);
    let now = of_campaign(campaign, &frame, options);
    let mut gyros = Vec::new();
    let mut moved = Vec::new();
    let mut sums = Sums::default();
    for (j, gyro) in campaign.gyros.iter().enumerate() {
        let found = then.iter().find(|(slot, _)| *slot == gyro.slot);
        let (_, then) = found.ok_or_else(|| NoReference::NoGyro { slot: gyro.slot, serial: gyro.serial.clone() })?;
        if then.serial != gyro.serial {
            let (reference, campaign) = (then.serial.clone(), gyro.serial.clone());
            return Err(NoReference::OtherGyro { slot: gyro.slot, reference, campaign });
        }
        let sd: Vec<f64> = residuals.iter().filter(|r| r.slot == gyro.slot).map(|r| r.sd_deg_per_h).collect();
        let own = Sums::of(&frame, j, then, &sd);
        gyros.push((gyro.slot, own.parts()));
        sums.add(&own);
        moved.extend(moves(&frame, j, then, &now[j].1));
        if gyro.known_e.is_some() {
            notes.push(message!("e_is_held", slot = gyro.slot.name()));
        }
        let lost = lost(&frame, j, then);
        if !lost.is_empty() {
            notes.push(message!("not_determined_by_reference", slot = gyro.slot.name(), parameters = list(lost)));
        }
    }
    if sums.parameters == 0 {
        return Err(NoReference::NothingInCommon);
    }
    if !frame.adopted.is_empty() {
        notes.push(message!("effects_fitted_anew"));
    }
    let (imu, station, measured_at) = match reference {
        Reference::Campaign(c) => (c.imu.clone(), c.station.clone(), c.measured_at),
        Reference::Record(r) => (r.imu.clone(), r.station.clone(), r.calibrated_at),
    };
    Ok(Split { imu, station, measured_at, all: sums.parts(), gyros, moved, notes })
}

/// Whether a campaign can be held against a reference at all.
///
/// # Errors
/// [`NoReference`], where it is another IMU's, of another geometry or of a bench test.
pub fn may_be_split(campaign: &Campaign, reference: &Reference) -> Result<(), NoReference> {
    let (imu, geometry, test) = match reference {
        Reference::Campaign(c) => (&c.imu, &c.geometry, c.test),
        Reference::Record(r) => (&r.imu, &r.geometry, TestKind::Imu),
    };
    if campaign.test != TestKind::Imu || test != TestKind::Imu {
        return Err(NoReference::BenchTest);
    }
    if *imu != campaign.imu {
        return Err(NoReference::OtherImu { reference: imu.clone(), campaign: campaign.imu.clone() });
    }
    if !same(geometry, &campaign.geometry, campaign) {
        return Err(NoReference::OtherGeometry);
    }
    Ok(())
}

/// Whether both name the same axes for the campaign's gyros, however they name them.
fn same(a: &Geometry, b: &Geometry, campaign: &Campaign) -> bool {
    campaign.gyros.iter().all(|gyro| match (a.triad(gyro.slot), b.triad(gyro.slot)) {
        (Some(a), Some(b)) => (a.mat_gyro_body() - b.mat_gyro_body()).amax() < 1e-6,
        _ => false,
    })
}

fn known(reference: &Reference, frame: &Frame, options: &Options) -> (Vec<(Slot, Known)>, Vec<Message>) {
    match reference {
        Reference::Campaign(campaign) => (of_campaign(campaign, frame, options), Vec::new()),
        Reference::Record(record) => {
            let mut notes = vec![message!("reference_without_noise_of_d0")];
            if record.gyros.iter().any(|gyro| gyro.e_sd.is_none() || gyro.g_sd.is_none()) {
                notes.push(message!("reference_taken_as_exact"));
            }
            (record.gyros.iter().map(|gyro| (gyro.slot, of_record(gyro))).collect(), notes)
        }
    }
}

fn of_campaign(campaign: &Campaign, frame: &Frame, options: &Options) -> Vec<(Slot, Known)> {
    let fitted = calibrate_augmented(campaign, frame.terms, &options.adopted);
    fitted.gyros.iter().map(|gyro| (gyro.slot, of_fit(gyro))).collect()
}

fn of_fit(gyro: &GyroCalibration) -> Known {
    Known {
        serial: gyro.serial.clone(),
        terms: gyro.terms,
        values: gyro.parameters.iter().map(|p| p.value).collect(),
        determined: gyro.parameters.iter().map(|p| p.determined).collect(),
        covariance: gyro.covariance.clone(),
        e: gyro.e().unwrap_or_default(),
    }
}

fn of_record(gyro: &GyroParameters) -> Known {
    let values: Vec<f64> =
        [gyro.bias].into_iter().chain(gyro.g.iter().chain(&gyro.p).chain(&gyro.e).copied()).collect();
    let none = Vector3::zeros();
    let (g_sd, e_sd) = (gyro.g_sd.unwrap_or(none), gyro.e_sd.unwrap_or(none));
    let sds = [0.0].into_iter().chain(g_sd.iter().chain(&none).chain(&e_sd).copied());
    let variances = DVector::from_iterator(values.len(), sds.map(|sd| sd * sd));
    Known {
        serial: gyro.serial.clone(),
        terms: Terms::MODEL_6,
        determined: vec![true; values.len()],
        values,
        covariance: Some(DMatrix::from_diagonal(&variances)),
        e: gyro.e,
    }
}

impl Known {
    /// Place of column `c` of a term.
    fn place(&self, term: Term, c: usize) -> Option<usize> {
        let place = design::first_column(self.terms, term) + c;
        (self.terms.contains(term) && self.determined[place]).then_some(place)
    }

    fn vector(&self, term: Term) -> Option<Vector3<f64>> {
        let places = [self.place(term, 0)?, self.place(term, 1)?, self.place(term, 2)?];
        Some(Vector3::from(places.map(|place| self.values[place])))
    }

    /// Variance along `axis` of a term of three columns.
    fn variance(&self, term: Term, axis: &Vector3<f64>) -> Option<f64> {
        let (covariance, first) = (self.covariance.as_ref()?, self.place(term, 0)?);
        Some((covariance.fixed_view::<3, 3>(first, first) * axis).dot(axis))
    }
}

/// Terms of gyro `j`'s columns, in their order; what follows them are effects.
fn columns(frame: &Frame, j: usize) -> Vec<(Term, usize)> {
    let fitted = |term: &Term| *term != Term::Scale || frame.scale_fitted[j];
    frame.terms.iter().filter(fitted).flat_map(|term| (0..term.columns()).map(move |c| (term, c))).collect()
}

/// Parameters of the model in use that the reference does not determine.
fn lost(frame: &Frame, j: usize, then: &Known) -> Vec<&'static str> {
    let names = design::parameter_names(frame.terms);
    let lost = columns(frame, j).into_iter().zip(names).filter(|((term, c), _)| then.place(*term, *c).is_none());
    lost.map(|(_, name)| name).collect()
}

/// Whitened sums of squares of one gyro or of all, and in (deg/h)^2 where they are to be added.
#[derive(Debug, Default)]
struct Sums {
    gyros: usize,
    parameters: usize,
    dof: f64,
    /// Over its covariance under noise alone.
    statistic: f64,
    mean_squares: [f64; 3],
}

impl Sums {
    fn of(frame: &Frame, j: usize, then: &Known, sd: &[f64]) -> Self {
        let n = frame.dwells();
        let scale = frame.setting.gyros[j].scale;
        let whiten = |column: &[f64]| -> Vec<f64> { column.iter().zip(sd).map(|(x, sd)| x / sd).collect() };
        let mut error = frame.outputs[j].clone();
        let (mut free, mut told) = (Basis::default(), Vec::new());
        let terms = columns(frame, j);
        for (c, column) in frame.designs[j].iter().enumerate() {
            match terms.get(c).and_then(|(term, part)| then.place(*term, *part)) {
                Some(place) => {
                    axpy(-then.values[place] / scale, column, &mut error);
                    told.push((place, whiten(column)));
                }
                None => {
                    free.push(whiten(column));
                }
            }
        }
        let mut error = whiten(&error);
        free.project_out(&mut error);
        let mut whole = free.clone();
        told.iter().for_each(|(_, column)| {
            whole.push(column.clone());
        });
        let spanned = whole.clone().split_off(free.rank());
        let along = DVector::from_iterator(spanned.rank(), spanned.vectors().iter().map(|q| dot(q, &error)));
        let left = (dot(&error, &error) - along.norm_squared()).max(0.0);
        let under_noise = covariance(&spanned, &told, then, scale);
        let (expected, statistic) =
            (under_noise.trace(), under_noise.cholesky().map_or(0.0, |c| along.dot(&c.solve(&along))));
        let dof = (n - whole.rank()) as f64;
        let unit = 1.0 / sd.iter().map(|sd| sd.powi(-2)).sum::<f64>();
        let parameters = (along.norm_squared() - expected).max(0.0);
        let structure = (left - dof).max(0.0);
        let noise = along.norm_squared() + left - parameters - structure;
        let mean_squares = [parameters, structure, noise].map(|sum| sum * unit);
        Self { gyros: 1, parameters: spanned.rank(), dof, statistic, mean_squares }
    }

    fn add(&mut self, other: &Self) {
        self.gyros += other.gyros;
        self.parameters += other.parameters;
        self.dof += other.dof;
        self.statistic += other.statistic;
        (0..3).for_each(|i| self.mean_squares[i] += other.mean_squares[i]);
    }

    fn parts(&self) -> Parts {
        let [parameters, structure, noise] = self.mean_squares.map(|sum| sum / self.gyros as f64);
        let q = self.parameters as f64;
        Parts {
            whole: (parameters + structure + noise).sqrt(),
            parameters: parameters.sqrt(),
            structure: structure.sqrt(),
            noise: noise.sqrt(),
            p_value: if q > 0.0 { f_tail(self.statistic / q, q, self.dof.max(1.0)) } else { 1.0 },
        }
    }
}

/// Covariance of the coordinates on `spanned` under noise: this campaign's, and that of the reference's parameters.
fn covariance(spanned: &Basis, told: &[(usize, Vec<f64>)], then: &Known, scale: f64) -> DMatrix<f64> {
    let q = spanned.rank();
    let own = DMatrix::identity(q, q);
    let Some(all) = &then.covariance else { return own };
    let into = DMatrix::from_fn(q, told.len(), |i, c| dot(&spanned.vectors()[i], &told[c].1) / scale);
    let covariance = DMatrix::from_fn(told.len(), told.len(), |a, b| all[(told[a].0, told[b].0)]);
    own + &into * covariance * into.transpose()
}

/// D0, D_I, D_S, D_O and |E|, where both determine them.
fn moves(frame: &Frame, j: usize, then: &Known, now: &Known) -> Vec<Moved> {
    let axes = &frame.setting.gyros[j];
    let slot = axes.slot;
    let mut list = Vec::new();
    let both = |of: &dyn Fn(&Known) -> Option<f64>| Some((of(then)?, of(now)?));
    let sd = |of: &dyn Fn(&Known) -> Option<f64>| -> Option<f64> {
        // A record that states nothing of it counts as exact.
        Some((of(then)?.max(0.0) + of(now)?.max(0.0)).sqrt())
    };
    let bias = |known: &Known| Some(known.values[known.place(Term::Bias, 0)?] / known.e.norm());
    let bias_variance = |known: &Known| {
        let place = known.place(Term::Bias, 0)?;
        Some(known.covariance.as_ref()?[(place, place)] / known.e.norm_squared())
    };
    if let Some((reference, now)) = both(&bias) {
        list.push(Moved { slot, coefficient: "D0", reference, now, sd: sd(&bias_variance), unit: "deg/h" });
    }
    for (coefficient, axis) in [("D_I", axes.input), ("D_S", axes.spin), ("D_O", axes.output)] {
        let along = |known: &Known| Some(known.vector(Term::GLinear)?.dot(&axis) / known.e.norm());
        let variance = |known: &Known| Some(known.variance(Term::GLinear, &axis)? / known.e.norm_squared());
        if let Some((reference, now)) = both(&along) {
            list.push(Moved { slot, coefficient, reference, now, sd: sd(&variance), unit: "deg/(h g0)" });
        }
    }
    let length = |known: &Known| Some(known.vector(Term::Scale)?.norm());
    let variance = |known: &Known| known.variance(Term::Scale, &axes.input);
    if let Some((reference, now)) = both(&length) {
        list.push(Moved { slot, coefficient: "|E|", reference, now, sd: sd(&variance), unit: "pulse/arcsec" });
    }
    list.retain(|moved| moved.reference.is_finite() && moved.now.is_finite());
    list
}
