//! The fit of one gyro on the way: least squares done, its noise not yet judged.

use std::rc::Rc;

use nalgebra::{DMatrix, DVector, DVectorView, Vector3};

use super::calibration::{
    DriftResponse, EffectParameter, GAUGE, GyroCalibration, NullDirection, Parameter, ScaleSource,
};
use super::correlated_noise::{self, FittedGyro};
use super::design::{self, Design, WeightedDesign};
use super::growth::{Exposure, Unweighted};
use super::law::{DwellConditions, Law};
use super::noise::{Evidence, NoiseScale};
use super::uncertainty::{StationResponse, Uncertainty};
use crate::core::augmented::KnownCoefficient;
use crate::core::calibrate::effect_columns::{self, Retold};
use crate::core::calibrate::regressor::Regressor;
use crate::core::calibrate::shared_coefficients::{CommonFit, OwnFit};
use crate::core::campaign::repeats::PureError;
use crate::core::campaign::{Campaign, CampaignGyro, Dwell, StationPart};
use crate::core::effects::Effect;
use crate::core::model::{Term, Terms};
use crate::core::numerics::least_squares::{Factor, Fit};

/// Residuals over their own standard deviations, sigma sqrt(1 - leverage); zero where a dwell is fitted exactly because
/// nothing else speaks of it.
pub(super) fn standardised(residuals: &DVector<f64>, sigma: &DVector<f64>, leverage: &DVector<f64>) -> DVector<f64> {
    let own_sd = |k: usize| sigma[k] * (1.0 - leverage[k]).max(0.0).sqrt();
    DVector::from_fn(residuals.len(), |k, _| if own_sd(k) > 0.0 { residuals[k] / own_sd(k) } else { 0.0 })
}

/// Gyros with the same terms and the same standard errors share one factorisation of model (6).
#[derive(Default)]
pub(super) struct SharedDesigns(Vec<Rc<WeightedDesign>>);

impl SharedDesigns {
    fn of(&mut self, dwells: &[Dwell], terms: Terms, sd: Vec<f64>) -> Rc<WeightedDesign> {
        let mut of_terms = self.0.iter().filter(|known| known.design.terms == terms);
        if let Some(known) = of_terms.clone().find(|known| known.sd == sd) {
            return Rc::clone(known);
        }
        let design = of_terms.next().map_or_else(|| Design::new(dwells, terms), |known| known.design.clone());
        let new = WeightedDesign::new(design, sd);
        self.0.push(Rc::clone(&new));
        new
    }
}

pub(super) struct GyroFit {
    weighted: Rc<WeightedDesign>,
    scale_source: ScaleSource,
    known_e: Option<Vector3<f64>>,
    pub fit: Fit,
    /// What position and rate alone leave the same in repeats: what was fitted, less what the effects explain.
    pub of_position: DVector<f64>,
    /// Fitted effects, after model (6)'s columns; and those that could not be.
    regressors: Vec<Regressor>,
    pub hidden: Vec<Effect>,
    /// Those held as the model has them.
    held: Option<OtherCoefficients>,
    /// What this gyro shares with the others.
    common: Option<OtherCoefficients>,
    /// Variances over those of the weights; and the same without a growth with rate.
    pub variances: DVector<f64>,
    pub even: DVector<f64>,
    pub evidence: Evidence,
    /// What each stated rotation of the station makes of the fit.
    pub station: Vec<StationResponse>,
    /// Residuals that speak of the noise, and their degrees of freedom, where those of the fit hold more than that.
    net: Option<(DVector<f64>, usize)>,
}

/// Coefficients that are not the gyro's own to fit.
struct OtherCoefficients {
    effects: Vec<Regressor>,
    values: DVector<f64>,
    /// Of shared ones over the gyro's noise as weighted.
    covariance: DMatrix<f64>,
    /// What the gyro's own columns make of their regressors, q x m.
    into: DMatrix<f64>,
}

impl OtherCoefficients {
    /// What they add to the covariance of the gyro's own, where their own is to be scaled so.
    fn spread(&self, scale: f64) -> DMatrix<f64> {
        &self.into * &self.covariance * self.into.transpose() * scale
    }

    fn parameters(&self, scale: Option<f64>) -> impl Iterator<Item = EffectParameter> {
        let sd = move |m: usize| scale.map(|scale| (self.covariance[(m, m)] * scale).max(0.0).sqrt());
        self.effects.iter().enumerate().map(move |(m, regressor)| parameter(regressor, self.values[m], sd(m)))
    }
}

fn parameter(regressor: &Regressor, value: f64, sd: Option<f64>) -> EffectParameter {
    EffectParameter { effect: regressor.effect, coefficient: regressor.coefficient, value, sd }
}

/// What the gyro's dwells say of the effects that the model knows.
pub(super) fn retold(
    c: &Campaign,
    j: usize,
    terms: Terms,
    (regressors, known): (&[Regressor], &[KnownCoefficient]),
    sd: Vec<f64>,
    shared: &mut SharedDesigns,
) -> Vec<Retold> {
    let y = DVector::from_iterator(c.dwells.len(), c.free_outputs(j));
    let plain = shared.of(&c.dwells, own_terms(c, j, terms), sd);
    let of_noise = |fit: &Fit| match c.states_errors() {
        true => (1.0, f64::INFINITY),
        false => (fit.chi2 / fit.dof.max(1) as f64, fit.dof.max(1) as f64),
    };
    effect_columns::retold(&plain, &y, regressors, (c.gyros[j].slot, known), of_noise)
}

/// E alone is never taken off: nothing would be left to fit.
fn own_terms(c: &Campaign, j: usize, terms: Terms) -> Terms {
    if terms == Terms::of(&[Term::Scale]) { terms } else { c.gyros[j].fitted_terms(terms) }
}

/// Those effects that are `known` are held at that.
pub(super) fn fit_gyro(
    c: &Campaign,
    j: usize,
    terms: Terms,
    (regressors, known): (Vec<Regressor>, &[KnownCoefficient]),
    (sd, repeats): (Vec<f64>, &[Vec<usize>]),
    shared: &mut SharedDesigns,
) -> GyroFit {
    let known_e = c.gyros[j].known_e;
    let mut y = DVector::from_iterator(c.dwells.len(), c.free_outputs(j));
    let plain = shared.of(&c.dwells, own_terms(c, j, terms), sd);
    let (mut to_hold, mut to_fit) = (Vec::new(), Vec::new());
    for one in regressors {
        match known.iter().find(|known| effect_columns::is_of(known, c.gyros[j].slot, &one)) {
            Some(known) => to_hold.push((one, known)),
            None => to_fit.push(one),
        }
    }
    for (regressor, known) in &to_hold {
        y.axpy(-known.value, &regressor.column, 1.0);
    }
    let (regressors, hidden) = effect_columns::visible(&plain.factor, to_fit);
    let weighted = match regressors.as_slice() {
        [] => plain,
        some => WeightedDesign::new(effect_columns::extended(&plain.design, some), plain.sd.clone()),
    };
    let fit = weighted.factor.fit(&y);
    let held = (!to_hold.is_empty()).then(|| {
        let into: Vec<DVector<f64>> =
            to_hold.iter().map(|(regressor, _)| weighted.factor.fit(&regressor.column).estimate).collect();
        let variances = to_hold.iter().map(|(_, known)| known.sd * known.sd);
        OtherCoefficients {
            values: DVector::from_iterator(to_hold.len(), to_hold.iter().map(|(_, known)| known.value)),
            covariance: DMatrix::from_diagonal(&DVector::from_iterator(to_hold.len(), variances)),
            into: DMatrix::from_columns(&into),
            effects: to_hold.into_iter().map(|(regressor, _)| regressor).collect(),
        }
    });
    let further = fit.estimate.len() - regressors.len();
    let explained = regressors.iter().zip(fit.estimate.iter().skip(further)).map(|(r, k)| &r.column * *k);
    let of_position = explained.fold(y, |y, part| y - part);
    let pure_error = PureError::of(repeats, |k| of_position[k], |k| weighted.sd[k]);
    let evidence = Evidence::of(fit.chi2, fit.dof, pure_error);
    let scale_source = match (known_e, terms.contains(Term::Scale)) {
        (Some(_), _) => ScaleSource::Held,
        (None, true) => ScaleSource::Fitted,
        (None, false) => ScaleSource::Missing,
    };
    let variances = DVector::from_element(c.dwells.len(), 1.0);
    let even = variances.clone();
    GyroFit {
        weighted,
        scale_source,
        known_e,
        fit,
        of_position,
        regressors,
        hidden,
        held,
        common: None,
        variances,
        even,
        evidence,
        station: Vec::new(),
        net: None,
    }
}

impl GyroFit {
    /// The effects that are held as a model has them.
    pub fn held_effects(&self) -> Vec<Effect> {
        let mut effects: Vec<Effect> = self.held.iter().flat_map(|held| &held.effects).map(|one| one.effect).collect();
        effects.dedup();
        effects
    }

    /// The gyro as its own columns leave it; without standard errors its residuals say how it weighs against the
    /// others.
    pub fn own(&self, has_sem: bool) -> OwnFit<'_> {
        let scatter = || self.fit.chi2 / self.fit.dof.max(1) as f64;
        let variance = if has_sem { 1.0 } else { scatter().max(f64::MIN_POSITIVE) };
        OwnFit { factor: self.factor(), residuals: &self.fit.residuals, variance }
    }

    /// Takes the shared coefficients out, which cost this gyro `dof` degrees of freedom.
    pub fn take_out(&mut self, common: &CommonFit, j: usize, dof: usize, repeats: &[Vec<usize>]) {
        let WeightedDesign { sd, factor, .. } = &*self.weighted;
        let own = self.fit.estimate.len() - self.regressors.len();
        let of_effects = |estimate: &DVector<f64>, into: &mut DVector<f64>, sign: f64| {
            for (regressor, k) in self.regressors.iter().zip(estimate.iter().skip(own)) {
                into.axpy(sign * k, &regressor.column, 1.0);
            }
        };
        of_effects(&self.fit.estimate, &mut self.of_position, 1.0);
        let (mut into, mut effects) = (DMatrix::zeros(self.fit.estimate.len(), common.kept.len()), Vec::new());
        for (m, regressor) in common.kept.iter().enumerate() {
            let Some(regressor) = &regressor[j] else { continue };
            let (k, seen) = (common.estimate[m], factor.fit(&regressor.column));
            self.fit.residuals.axpy(-k, &seen.residuals, 1.0);
            self.fit.estimate.axpy(-k, &seen.estimate, 1.0);
            self.of_position.axpy(-k, &regressor.column, 1.0);
            into.set_column(m, &seen.estimate);
            effects.push((m, regressor.clone()));
        }
        of_effects(&self.fit.estimate, &mut self.of_position, -1.0);
        self.fit.chi2 = self.fit.residuals.component_mul(factor.weights()).norm_squared();
        self.fit.leverage += &common.leverage[j];
        self.fit.dof = self.fit.dof.saturating_sub(dof);
        let pure_error = PureError::of(repeats, |k| self.of_position[k], |k| sd[k]);
        self.evidence = Evidence::of(self.fit.chi2, self.fit.dof, pure_error);
        let (places, effects): (Vec<usize>, Vec<Regressor>) = effects.into_iter().unzip();
        self.common = Some(OtherCoefficients {
            effects,
            values: common.estimate.select_rows(&places),
            covariance: common.covariance.select_rows(&places).select_columns(&places) / common.variances[j],
            into: into.select_columns(&places),
        });
    }

    /// The factor of the whitened design that this gyro shares with those of the same weights.
    pub fn factor(&self) -> &Factor {
        &self.weighted.factor
    }

    /// Residuals that speak of the noise, pulse/s, and their degrees of freedom.
    pub fn left(&self) -> (&DVector<f64>, usize) {
        self.net.as_ref().map_or((&self.fit.residuals, self.fit.dof), |(net, dof)| (net, *dof))
    }

    /// Leaves `net` (over the standard errors) of the residuals to speak of the noise, `dof` degrees of freedom fewer.
    pub fn leave(&mut self, net: DVector<f64>, dof: usize) {
        let dof = self.fit.dof.saturating_sub(dof);
        self.evidence = Evidence::of(net.norm_squared(), dof, self.evidence.pure_error);
        self.net = Some((net.component_div(self.factor().weights()), dof));
    }

    /// E (pulse/arcsec), held or determined, and G (pulse/(s g0); zero where it is not fitted), both in body axes. None
    /// where the design does not determine E.
    pub fn e_and_g(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let WeightedDesign { design, factor, .. } = &*self.weighted;
        let values = &design.expand * &self.fit.estimate;
        let of = |term| {
            let first = design::first_column(design.terms, term);
            let rows = first..first + term.columns();
            let are_told = design.terms.contains(term)
                && rows.clone().all(|i| factor.determines(&design.expand.row(i).transpose()));
            are_told.then(|| values.fixed_rows::<3>(first).into_owned())
        };
        let e = self.known_e.or_else(|| of(Term::Scale)).filter(|e| e.norm() > 0.0)?;
        Some((e, of(Term::GLinear).unwrap_or_default()))
    }

    /// What a drift that goes with these `hours` by one pulse/s an hour makes of the fit.
    pub fn by_drift(&self, hours: &DVector<f64>) -> DriftResponse {
        let WeightedDesign { design, factor, .. } = &*self.weighted;
        let taken = factor.fit(hours);
        let values = &design.expand * &taken.estimate;
        let of = |term| {
            let first = design::first_column(design.terms, term);
            if design.terms.contains(term) { values.fixed_rows::<3>(first).into_owned() } else { Vector3::zeros() }
        };
        let squares = hours.component_mul(factor.weights()).norm_squared();
        DriftResponse { e: of(Term::Scale), g: of(Term::GLinear), squares, left: taken.chi2 }
    }

    /// Residuals (pulse/s) with their leverages, for what the noise may depend on.
    pub fn unweighted<'a>(&'a self, dwells: &'a Exposure) -> Unweighted<'a> {
        Unweighted { residuals: self.left().0, leverage: &self.fit.leverage, dwells }
    }

    /// Durations of the dwells and their rates about this gyro's input axis.
    pub fn exposure(&self, campaign: &Campaign) -> Exposure {
        let input = self.fitted_e().map(|e| e.normalize());
        let rates: Vec<Vector3<f64>> = campaign.dwells.iter().map(|d| d.rate_arcsec_s).collect();
        let durations: Vec<f64> = campaign.dwells.iter().map(|d| d.duration_s).collect();
        Exposure::of(&rates, &durations, input.as_ref())
    }

    /// E, held or among the estimates (model (6)'s end with it), unless it is zero.
    fn fitted_e(&self) -> Option<Vector3<f64>> {
        let last = self.fit.estimate.len().checked_sub(3 + self.regressors.len());
        let e = match (self.scale_source, last) {
            (ScaleSource::Fitted, Some(first)) => Some(self.fit.estimate.fixed_rows::<3>(first).into_owned()),
            _ => self.known_e,
        };
        e.filter(|e| e.norm() > 0.0)
    }

    /// What the search for a memory of the noise needs.
    pub fn fitted(&self) -> FittedGyro<'_> {
        let Self { variances, even, .. } = self;
        let (basis, weights) = (self.factor().basis(), self.factor().weights());
        let (residuals, dof) = self.left();
        FittedGyro { basis, weights, variances, even, residuals, dof }
    }

    /// What the fit and its repeats say where the noise goes by a law.
    pub fn evidence_under(
        &self,
        law: Law,
        course: &DwellConditions,
        (has_sem, repeats): (bool, &[Vec<usize>]),
    ) -> Option<Evidence> {
        let (chi2, variances) = self.fitted().squares_under(law, course, has_sem)?;
        let sd = |k: usize| self.weighted.sd[k] * variances[k].sqrt();
        Some(Evidence::of(chi2, self.left().1, PureError::of(repeats, |k| self.of_position[k], sd)))
    }

    /// Covariance of the coordinates on the design's basis without a memory of the noise.
    pub fn coordinates(&self, noise: &NoiseScale) -> Option<DMatrix<f64>> {
        Some(correlated_noise::scaled(self.factor().basis(), &self.variances) * noise.covariance_scale()?)
    }

    /// Covariance of the fit's parameters in white noise as stated.
    fn white(&self, noise: &NoiseScale) -> Option<DMatrix<f64>> {
        let own = self.factor().covariance_of(&self.coordinates(noise)?);
        let scale = noise.covariance_scale()?;
        Some(self.common.iter().fold(own, |sum, common| sum + common.spread(scale)))
    }

    /// Covariance of the fit's parameters: `own`, and what comes in with coefficients that are shared or held.
    fn covariance(&self, own: DMatrix<f64>, scale: f64) -> DMatrix<f64> {
        let with_common = self.common.iter().fold(own, |sum, common| sum + common.spread(scale));
        self.held.iter().fold(with_common, |sum, held| sum + held.spread(1.0))
    }

    /// Coefficients of effects: fitted, with values and standard deviations, held, and shared.
    fn effects(
        &self,
        (values, sds): (DVectorView<'_, f64>, Option<DVector<f64>>),
        scale: Option<f64>,
    ) -> Vec<EffectParameter> {
        let sd = |m: usize| sds.as_ref().map(|sds| sds[m]);
        let own = self.regressors.iter().enumerate().map(|(m, regressor)| parameter(regressor, values[m], sd(m)));
        let held = self.held.iter().flat_map(|held| held.parameters(Some(1.0)));
        let common = self.common.iter().flat_map(|common| common.parameters(scale));
        own.chain(held).chain(common).collect()
    }

    /// Covariance of model (6)'s parameters by what is stated of the station, and by what is not: with a rate of
    /// `vertical` along the specific force in all dwells, G is off by vertical E.
    fn of_station(&self, design: &Design, vertical: f64) -> (Vec<(StationPart, DMatrix<f64>)>, Option<DMatrix<f64>>) {
        let p = design.terms.columns();
        let expand = design.expand.rows(0, p).into_owned();
        let contradicted = StationResponse::contradicted(&self.station, &expand);
        let has_g = vertical > 0.0 && design.terms.contains(Term::GLinear);
        let rounded = self.fitted_e().filter(|_| has_g).map(|e| {
            let mut off = DVector::zeros(p);
            off.fixed_rows_mut::<3>(design::first_column(design.terms, Term::GLinear)).copy_from(&(e * vertical));
            &off * off.transpose()
        });
        let unstated = contradicted.into_iter().chain(rounded).reduce(|sum, one| sum + one);
        (StationResponse::by_part(&self.station, &expand), unstated)
    }

    /// `coordinates` are the covariance on the design's basis, of which `white` noise as stated has its part;
    /// `vertical` as of [`rounded_vertical`](crate::core::campaign::rounded_vertical).
    pub fn finish(
        self,
        (gyro, vertical): (&CampaignGyro, f64),
        noise: NoiseScale,
        (coordinates, white): (Option<DMatrix<f64>>, f64),
        is_other_noise: bool,
    ) -> GyroCalibration {
        let WeightedDesign { design, sd, factor } = &*self.weighted;
        let p = design.terms.columns();
        let values = &design.expand * &self.fit.estimate;
        let scale = noise.covariance_scale();
        let expanded = |reduced: DMatrix<f64>| &design.expand * reduced * design.expand.transpose();
        let covariance = coordinates
            .zip(scale)
            .map(|(coordinates, scale)| expanded(self.covariance(factor.covariance_of(&coordinates), scale)));
        let sds = covariance.as_ref().map(|c| c.diagonal().map(|variance| variance.max(0.0).sqrt()));
        let effects = self.effects((values.rows_range(p..), sds.map(|sds| sds.rows_range(p..).into_owned())), scale);
        let (station, unstated) = self.of_station(design, vertical);
        let uncertainty = covariance.map(|c| Uncertainty {
            fit: c.view((0, 0), (p, p)).into_owned(),
            white: self.white(&noise).map_or(c, |own| expanded(own) * white).view((0, 0), (p, p)).into_owned(),
            share: noise.share(&self.evidence, is_other_noise),
            station,
            unstated,
        });
        let covariance = uncertainty.as_ref().map(Uncertainty::covariance);
        let parameters = parameters(design, factor, &values, covariance.as_ref());
        let left = self.left();
        let left = (left.0.clone(), left.1);
        let Self { scale_source, known_e, fit, variances, evidence, regressors, .. } = self;
        let gauge = design.gauge.iter().map(|d| NullDirection { direction: d.clone(), gauge: Some(GAUGE) });
        let cut = fit
            .null_directions
            .column_iter()
            .map(|d| NullDirection { direction: (&design.expand * d).normalize(), gauge: None });
        let sigma = noise.factor.map(|f| DVector::from_fn(sd.len(), |k, _| sd[k] * f * variances[k].sqrt()));
        let standardised = sigma.as_ref().map(|sigma| standardised(&fit.residuals, sigma, &fit.leverage));
        GyroCalibration {
            slot: gyro.slot,
            serial: gyro.serial.clone(),
            terms: design.terms,
            scale_source,
            parameters,
            effects,
            covariance,
            uncertainty,
            rank: fit.rank.saturating_sub(regressors.len()),
            null_directions: gauge.chain(cut).collect(),
            chi2: fit.chi2,
            dof: fit.dof,
            p_value: noise.p_value(&evidence),
            noise,
            sigma,
            residuals: fit.residuals,
            left,
            standardised,
            leverage: fit.leverage,
            holds_untold_field: false,
            known_e,
        }
    }
}

/// Model (6)'s parameters; a standard deviation only of what the design determines.
fn parameters(
    design: &Design,
    factor: &Factor,
    values: &DVector<f64>,
    covariance: Option<&DMatrix<f64>>,
) -> Vec<Parameter> {
    let terms = design.terms.iter().flat_map(|t| std::iter::repeat_n(t, t.columns()));
    let one = |(i, (name, term)): (usize, (_, _))| {
        let determined = factor.determines(&design.expand.row(i).transpose());
        let sd = covariance.filter(|_| determined).map(|c| c[(i, i)].max(0.0).sqrt());
        Parameter { name, term, value: values[i], sd, determined }
    };
    design::parameter_names(design.terms).into_iter().zip(terms).enumerate().map(one).collect()
}

#[cfg(test)]
mod tests;
