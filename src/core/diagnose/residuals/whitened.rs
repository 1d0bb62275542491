//! A campaign with the model in use taken out: whitened residuals of each gyro in deg/h over their noise.

use nalgebra::Vector3;

use super::noise::{self, Noise};
use crate::core::campaign::{Campaign, CampaignGyro, CampaignNote, TestKind, temperature_outliers};
use crate::core::diagnose::residuals::augmented_fit;
use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::{Adopted, Options, Refusal};
use crate::core::effects::{GyroAxes, Scope, Setting};
use crate::core::model::{Term, Terms};
use crate::core::note::Note;
use crate::core::numerics::basis::{Basis, axpy, dot};

/// One gyro: everything whitened, that is divided by `sd`.
#[derive(Debug, Clone)]
pub(crate) struct GyroFrame {
    /// Standard uncertainty of each dwell, deg/h, up to a common factor that the search estimates.
    pub sd: Vec<f64>,
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
    pub gyros: Vec<GyroFrame>,
    pub noise: Noise,
    /// Output of each gyro, deg/h, less what the model in use says of all gyros together; and the raw columns of the rest of it.
    pub outputs: Vec<Vec<f64>>,
    pub designs: Vec<Vec<Vec<f64>>>,
    /// Whether E of each gyro is among the fitted columns.
    pub scale_fitted: Vec<bool>,
    pub notes: Vec<String>,
    /// What was noted of the campaign itself.
    pub of_campaign: Vec<Note>,
}

impl GyroFrame {
    pub fn rss(&self) -> f64 {
        dot(&self.residual, &self.residual)
    }

    /// Dwells over parameters.
    pub fn dof(&self) -> usize {
        self.sd.len() - self.basis.rank()
    }

    pub fn whiten(&self, mut column: Vec<f64>) -> Vec<f64> {
        column.iter_mut().zip(&self.sd).for_each(|(x, sd)| *x /= sd);
        column
    }
}

impl Frame {
    pub fn of(campaign: &Campaign, options: &Options) -> Result<Self, Refusal> {
        let terms = options.terms.unwrap_or_else(|| campaign.terms());
        if terms.is_empty() {
            return Err(Refusal::NoTerms);
        }
        let (setting, of_axes) = setting(campaign)?;
        let of_campaign = temperature_outliers(campaign).chain(of_axes.into_iter().map(Note::Campaign)).collect();
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
        let (gyros, adopted) = (Vec::new(), options.adopted.clone());
        let frame = Self { setting, terms, adopted, gyros, noise, outputs, designs, scale_fitted, notes, of_campaign };
        let frame = frame.whitened()?;
        if shared.is_empty() { Ok(frame) } else { frame.without(&shared) }
    }

    /// The same less effects whose coefficients all gyros share: as columns of each gyro they would be fitted once a gyro.
    fn without(mut self, shared: &[&Adopted]) -> Result<Self, Refusal> {
        let seen = shared.iter().filter(|adopted| (adopted.effect.entry().missing)(&self.setting).is_none());
        let part = |adopted: &&Adopted| Part {
            effect: adopted.effect,
            shape: adopted.shape,
            members: self.setting.gyros.iter().map(|gyro| adopted.slots.contains(&gyro.slot)).collect(),
        };
        let parts: Vec<Part> = seen.copied().map(|adopted| part(&adopted)).collect();
        let drift = augmented_fit::fit(&self, &parts).drift;
        for (output, drift) in self.outputs.iter_mut().zip(&drift) {
            axpy(-1.0, drift, output);
        }
        self.whitened()
    }

    /// The same campaign with another growth of noise with rate.
    pub fn with_growth(&self, growth: f64) -> Result<Self, Refusal> {
        let noise = self.noise.with_growth(&self.setting, &self.outputs, &self.designs, growth);
        Self { noise, ..self.clone() }.whitened()
    }

    fn whitened(mut self) -> Result<Self, Refusal> {
        let gyro = |j: usize| whitened(&self.noise.sd[j], &self.outputs[j], &self.designs[j]);
        self.gyros = (0..self.outputs.len()).map(gyro).collect();
        match self.gyros.iter().find(|gyro| gyro.dof() == 0) {
            Some(gyro) => Err(Refusal::TooFewDwells { dwells: self.dwells(), parameters: gyro.basis.rank() }),
            None => Ok(self),
        }
    }

    pub fn dwells(&self) -> usize {
        self.setting.dwells()
    }
}

fn whitened(sd: &[f64], output: &[f64], design: &[Vec<f64>]) -> GyroFrame {
    let mut gyro = GyroFrame { sd: sd.to_vec(), basis: Basis::default(), residual: Vec::new() };
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
    let terms = if gyro.known_e.is_some() { terms.without(Term::Scale) } else { terms };
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
    let gyro = &campaign.gyros[j];
    let per_pulse = match campaign.test {
        // A servo table's output is its own rate, in arcsec/s already.
        TestKind::TurntableServo => 1.0,
        TestKind::Imu | TestKind::TorqueFeedback => 1.0 / s.gyros[j].scale,
    };
    campaign
        .dwells
        .iter()
        .map(|d| (d.output_pulse_s[j] - gyro.known_e.map_or(0.0, |e| e.dot(&d.rate_arcsec_s))) * per_pulse)
        .collect()
}

/// The columns of a campaign with the axes of its gyros as its own dwells show them, and notes on those axes.
pub(crate) fn setting(campaign: &Campaign) -> Result<(Setting, Vec<CampaignNote>), Refusal> {
    let mut notes = Vec::new();
    let axes = (0..campaign.gyros.len()).map(|j| axes_of(campaign, j, &mut notes)).collect::<Result<Vec<_>, _>>()?;
    Ok((Setting::of(campaign, axes), notes))
}

/// Largest angle between the fitted and the nominal input axis that is believed, rad.
const BELIEVED_MISALIGNMENT: f64 = 0.1;

/// |E|, axes and G of one gyro: from the E that is held, else from a fit of model (6), else nominal.
fn axes_of(campaign: &Campaign, j: usize, notes: &mut Vec<CampaignNote>) -> Result<GyroAxes, Refusal> {
    let gyro = &campaign.gyros[j];
    let slot = gyro.slot;
    let nominal = campaign.geometry.triad(slot).ok_or(Refusal::NoAxes(slot.name()))?.mat_gyro_body();
    let first = campaign.dwells.first().map_or(0.0, |d| d.output_pulse_s[j]);
    if campaign.dwells.iter().all(|d| d.output_pulse_s[j] == first) {
        return Err(Refusal::NoOutput(slot.name()));
    }
    let (g, e) = rough_fit(campaign, j);
    if let Some(e) = gyro.known_e {
        return Ok(GyroAxes::carried(slot, nominal, e, g));
    }
    let input = nominal.row(0).transpose();
    if e.iter().all(|x| x.is_finite()) && e.norm() > 0.0 && e.angle(&input) < BELIEVED_MISALIGNMENT {
        return Ok(GyroAxes::carried(slot, nominal, e, g));
    }
    let along = e.dot(&input);
    let size = if along.is_finite() && along > 1e-6 { along } else { 1.0 };
    notes.push(CampaignNote::NominalAxis { slot, scale: size });
    Ok(GyroAxes::carried(slot, nominal, size * input, g))
}

/// G and E, in pulse, by plain least squares over what rank the campaign has (minimum norm).
fn rough_fit(campaign: &Campaign, j: usize) -> (Vector3<f64>, Vector3<f64>) {
    let known = campaign.gyros[j].known_e;
    let terms = if known.is_some() { Terms::MODEL_6.without(Term::Scale) } else { Terms::MODEL_6 };
    let (n, m) = (campaign.dwells.len(), terms.columns());
    let mut rows = Vec::with_capacity(n * m);
    for d in &campaign.dwells {
        terms.push_row(&d.specific_force_g0, &d.rate_arcsec_s, &mut rows);
    }
    let mut design = nalgebra::DMatrix::from_row_slice(n, m, &rows);
    let norms: Vec<f64> = (0..m).map(|c| design.column(c).norm().max(f64::MIN_POSITIVE)).collect();
    for (c, norm) in norms.iter().enumerate() {
        design.column_mut(c).scale_mut(1.0 / norm);
    }
    let output = nalgebra::DVector::from_iterator(
        n,
        campaign.dwells.iter().map(|d| d.output_pulse_s[j] - known.map_or(0.0, |e| e.dot(&d.rate_arcsec_s))),
    );
    let Ok(fit) = design.svd(true, true).solve(&output, 1e-7) else { return (Vector3::zeros(), Vector3::zeros()) };
    let value = |c: usize| fit[c] / norms[c];
    let g = Vector3::new(value(1), value(2), value(3));
    let e = known.unwrap_or_else(|| Vector3::new(value(7), value(8), value(9)));
    (g, e)
}
