//! A campaign with the model in use taken out: whitened residuals of each gyro in deg/h over their noise.

use nalgebra::{DMatrix, DVector};

use super::noise::{self, Noise};
use crate::core::augmented::{Adopted, Options, PlausibleSizes};
use crate::core::calibrate::design::Design;
use crate::core::campaign::{Campaign, CampaignGyro, TestKind, notes};
use crate::core::effects::{CATALOGUE, Effect, Entry, Refusal, Scope, Setting, axes};
use crate::core::message::Message;
use crate::core::model::Terms;
use crate::core::note::Note;
use crate::core::numerics::basis::Basis;

/// One gyro: everything whitened, that is divided by `sd`.
#[derive(Debug, Clone)]
pub(crate) struct GyroFrame {
    /// Standard uncertainty of each dwell, deg/h, up to a common factor that the search estimates.
    pub sd: Vec<f64>,
    /// The inverse of the Cholesky factor L of the dwells' correlation, where they are not independent: what is
    /// divided by `sd` is multiplied by it.
    pub unlike: Option<DMatrix<f64>>,
    /// ln of the determinant of what columns are divided by: the sum of ln(sd L_kk) over the dwells.
    pub log_scale: f64,
    /// Columns of the model in use.
    pub basis: Basis,
    pub residual: Vec<f64>,
}

#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub setting: Setting,
    pub terms: Terms,
    /// Effects in the model in use.
    pub adopted: Vec<Adopted>,
    /// Hypotheses of one's own that compete with the catalogue.
    pub hypotheses: Vec<Effect>,
    pub plausible_sizes: PlausibleSizes,
    pub gyros: Vec<GyroFrame>,
    pub noise: Noise,
    /// Output of each gyro, deg/h, less what the model in use says of all gyros together; and the raw columns of the
    /// rest of it.
    pub outputs: Vec<Vec<f64>>,
    pub designs: Vec<Vec<Vec<f64>>>,
    /// Whether E of each gyro is among the fitted columns.
    pub scale_fitted: Vec<bool>,
    pub notes: Vec<Message>,
    /// What was noted of the campaign itself.
    pub of_campaign: Vec<Note>,
}

impl GyroFrame {
    /// Dwells over parameters.
    pub fn dof(&self) -> usize {
        self.sd.len() - self.basis.rank()
    }

    /// A column of one value per dwell, deg/h, over the noise: dimensionless, with unit variance where the model is
    /// complete.
    pub fn whiten(&self, mut column: Vec<f64>) -> Vec<f64> {
        column.iter_mut().zip(&self.sd).for_each(|(x, sd)| *x /= sd);
        match &self.unlike {
            Some(unlike) => (unlike * DVector::from_vec(column)).data.into(),
            None => column,
        }
    }
}

impl Frame {
    /// Outputs in deg/h, the noise of each dwell, and the model in use, ready for the search.
    ///
    /// # Errors
    /// A model without terms, an output that is constant, a slot without axes, or too few dwells for the parameters.
    pub fn of(campaign: &Campaign, options: &Options) -> Result<Self, Refusal> {
        let terms = options.terms.unwrap_or_else(|| campaign.terms());
        if terms.is_empty() {
            return Err(Refusal::NoTerms);
        }
        too_few(campaign, terms)?;
        let (setting, of_axes) = axes::setting(campaign)?;
        let of_campaign = notes(campaign).into_iter().chain(of_axes.into_iter().map(Note::Campaign)).collect();
        let outputs: Vec<Vec<f64>> = (0..campaign.gyros.len()).map(|j| drift_output(campaign, &setting, j)).collect();
        let designs = |adopted: &[Adopted]| -> Vec<Vec<Vec<f64>>> {
            (0..campaign.gyros.len()).map(|j| design(&setting, j, terms, &campaign.gyros[j], adopted)).collect()
        };
        let noise = noise::of(campaign, &setting, &outputs, &designs(&options.adopted));
        let notes = noise.notes.clone();
        let scale_fitted = campaign.gyros.iter().map(|gyro| gyro.known_e.is_none()).collect();
        let common = |adopted: &&Adopted| adopted.effect.entry().scope == Scope::Common;
        let (shared, own): (Vec<&Adopted>, Vec<&Adopted>) = options.adopted.iter().partition(common);
        let designs = designs(&own.into_iter().cloned().collect::<Vec<_>>());
        let frame = Self {
            setting,
            terms,
            adopted: options.adopted.clone(),
            hypotheses: options.hypotheses.clone(),
            plausible_sizes: options.plausible_sizes.clone(),
            gyros: Vec::new(),
            noise,
            outputs,
            designs,
            scale_fitted,
            notes,
            of_campaign,
        };
        let frame = frame.whitened()?;
        if shared.is_empty() { Ok(frame) } else { frame.without(&shared) }
    }

    /// The same campaign with another growth of noise with rate.
    pub fn with_growth(&self, growth: f64) -> Result<Self, Refusal> {
        let noise = self.noise.with_growth(&self.setting, &self.outputs, &self.designs, growth);
        Self { noise, ..self.clone() }.whitened()
    }

    /// The same campaign with the standard deviation of each dwell times a factor.
    pub fn with_factors(&self, factors: &[f64]) -> Result<Self, Refusal> {
        let times = |sd: &Vec<f64>| sd.iter().zip(factors).map(|(sd, factor)| sd * factor).collect();
        let noise = Noise { sd: self.noise.sd.iter().map(times).collect(), ..self.noise.clone() };
        Self { noise, ..self.clone() }.whitened()
    }

    /// The same campaign with what dwells have in common: their covariance is sd^2 + power s^2 K, s the median of sd.
    /// K is constant in deg/h: what a bias does between dwells asks for no dwell's own noise.
    pub fn with_memory(&self, kernel: &DMatrix<f64>, power: f64) -> Option<Self> {
        let n = self.dwells();
        let mut frame = self.clone();
        for (j, gyro) in frame.gyros.iter_mut().enumerate() {
            let mut sorted = gyro.sd.clone();
            sorted.sort_by(f64::total_cmp);
            let usual = sorted[n / 2];
            let share = |a: usize, b: usize| power * usual * usual / (gyro.sd[a] * gyro.sd[b]) * kernel[(a, b)];
            let covariance = DMatrix::from_fn(n, n, |a, b| share(a, b) + if a == b { 1.0 } else { 0.0 });
            let factor = covariance.cholesky()?.unpack();
            let unlike = factor.solve_lower_triangular(&DMatrix::identity(n, n))?;
            let log_det: f64 = factor.diagonal().iter().map(|x| x.ln()).sum();
            *gyro = whitened(&gyro.sd, Some((unlike, log_det)), &self.outputs[j], &self.designs[j]);
        }
        Some(frame)
    }

    pub(super) fn whitened(mut self) -> Result<Self, Refusal> {
        let gyro = |j: usize| whitened(&self.noise.sd[j], None, &self.outputs[j], &self.designs[j]);
        self.gyros = (0..self.outputs.len()).map(gyro).collect();
        match self.gyros.iter().find(|gyro| gyro.dof() == 0) {
            Some(gyro) => Err(Refusal::TooFewDwells { dwells: self.dwells(), parameters: gyro.basis.rank() }),
            None => Ok(self),
        }
    }

    /// Number of dwells.
    pub fn dwells(&self) -> usize {
        self.setting.dwells()
    }

    /// All that may be named: hypotheses of one's own, and the catalogue.
    pub fn nameable(&self) -> impl Iterator<Item = &'static Entry> {
        self.hypotheses.iter().map(|own| own.entry()).chain(CATALOGUE)
    }
}

/// Refuses a campaign with no more dwells than parameters, whatever of these it determines: what so few make of E is
/// nothing to measure the outputs by.
fn too_few(campaign: &Campaign, terms: Terms) -> Result<(), Refusal> {
    let dwells = campaign.dwells.len();
    let parameters = |gyro: &CampaignGyro| Design::new(&campaign.dwells, gyro.fitted_terms(terms)).reduced.ncols();
    match campaign.gyros.iter().map(parameters).max().filter(|parameters| dwells <= *parameters) {
        Some(parameters) => Err(Refusal::TooFewDwells { dwells, parameters }),
        None => Ok(()),
    }
}

fn whitened(sd: &[f64], unlike: Option<(DMatrix<f64>, f64)>, output: &[f64], design: &[Vec<f64>]) -> GyroFrame {
    let (unlike, log_det) = unlike.map_or((None, 0.0), |(unlike, log_det)| (Some(unlike), log_det));
    let log_scale = sd.iter().map(|sd| sd.ln()).sum::<f64>() + log_det;
    let mut gyro = GyroFrame { sd: sd.to_vec(), unlike, log_scale, basis: Basis::default(), residual: Vec::new() };
    for column in design {
        let column = gyro.whiten(column.clone());
        gyro.basis.push(column);
    }
    let mut residual = gyro.whiten(output.to_vec());
    gyro.basis.project_out(&mut residual);
    gyro.residual = residual;
    gyro
}

/// Columns of the terms in use, less a held E, plus those of the effects that the model holds already.
fn design(s: &Setting, j: usize, terms: Terms, gyro: &CampaignGyro, adopted: &[Adopted]) -> Vec<Vec<f64>> {
    let terms = gyro.fitted_terms(terms);
    let mut columns = vec![Vec::with_capacity(s.dwells()); terms.columns()];
    let mut row = Vec::new();
    for (a, w) in s.force.iter().zip(&s.rate) {
        row.clear();
        terms.push_row(a, w, &mut row);
        columns.iter_mut().zip(&row).for_each(|(column, x)| column.push(*x));
    }
    for effect in adopted.iter().filter(|effect| effect.slots.contains(&gyro.slot)) {
        let entry = effect.effect.entry();
        if (entry.missing)(s).is_none() {
            columns.extend((entry.columns)(s, j, effect.shape));
        }
    }
    columns
}

/// Output over |E|, deg/h, less what a held E makes of the rate.
fn drift_output(campaign: &Campaign, s: &Setting, j: usize) -> Vec<f64> {
    let per_pulse = match campaign.test {
        // A servo table's output is its own rate, in arcsec/s already.
        TestKind::TurntableServo => 1.0,
        TestKind::Imu | TestKind::TorqueFeedback => 1.0 / s.gyros[j].scale,
    };
    campaign.free_outputs(j).map(|output| output * per_pulse).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::core::campaign::made_for_tests::{self, name};
    use crate::core::campaign::{Dwell, Phase};
    use crate::core::mounting::Slot;

    /// The first `dwells` of some in which the force and the rate go round all axes.
    fn campaign(dwells: usize) -> Campaign {
        let dwell = |k: usize| {
            let (axis, sign) = (k % 3, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
            let force: Vector3<f64> = sign * Vector3::ith(axis, 1.0);
            let rate: Vector3<f64> = Vector3::ith((axis + k / 6) % 3, 600.0 + k as f64);
            let output = 1.5 * rate.x + 2.0 * force.x - force.y + 0.01 * (k as f64).sin();
            Dwell {
                phase: Phase::Rate,
                temperature_c: Some(318.15),
                ..made_for_tests::dwell(k, force, rate, vec![output])
            }
        };
        let gyro = CampaignGyro { slot: Slot::G1, serial: name("A"), known_e: None };
        made_for_tests::campaign(vec![gyro], (0..dwells).map(dwell).collect())
    }

    #[test]
    fn a_diagnosis_notes_of_the_campaign_what_a_calibration_notes_of_it() {
        let campaign = campaign(24);
        let frame = Frame::of(&campaign, &Options::default()).expect("it has dwells to spare");
        let codes: Vec<&str> = frame.of_campaign.iter().map(Note::code).collect();
        assert!(codes.contains(&"temperature_unit") && codes.contains(&"no_site"), "{codes:?}");
        assert!(notes(&campaign).iter().all(|note| frame.of_campaign.contains(note)), "{codes:?}");
    }

    #[test]
    fn few_dwells_are_refused_for_their_number() {
        for dwells in [1, 2, 5, 9] {
            let found = Frame::of(&campaign(dwells), &Options::default()).map(|frame| frame.dwells());
            assert_eq!(found, Err(Refusal::TooFewDwells { dwells, parameters: 9 }));
        }
        assert!(Frame::of(&campaign(14), &Options::default()).is_ok());
    }
}
