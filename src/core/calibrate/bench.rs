//! A raw single-gyro test: eq. (5) fitted along the gyro's own axes.
//!
//! y_k = E.w_k + K (D_F + D_I a_I + D_S a_S + D_II a_I^2 + D_SS a_S^2), K = |E|, a on the gyro's axes. The torque
//! feedback test counts pulses; in the servo test the table's rate in arcsec/s is itself the answer, so there E is
//! the input axis with K = 1. The table may be driven so that its rate cancels the gyro's; the sign shows in the
//! Earth's rate. Where it does not show it has to be stated: with the other sign every coefficient is negated.
//!
//! Where the positions show it, D_O a_O is fitted too: the clocking of S about I on the fixture.
//!
//! Where a_I^2 + a_S^2 is the same in all dwells (a tumble about the output axis), D_F, D_II and D_SS are one rank
//! short: D_II + D_SS = 0 is then imposed.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::bench_form::{BenchForm, Squares};
use super::calibration::remembers;
use super::correlated_noise::{self, FittedGyro, Weighed};
use super::drift::LEAST_SCALE_TO_NOISE;
use super::gyro_fit::standardised;
use super::law::DwellConditions;
use super::noise::{Evidence, NoiseScale, noise, overstated};
use super::noise_found::NoiseFound;
use super::noise_report;
use super::shrunken_errors::{ScatteringErrors, ShrunkenErrors};
use super::station::{self, OfOne};
use super::uncertainty::{StationResponse, Uncertainty, UncertaintyBudget};
use super::{ScaleSource, exceeds_noise, sem_scatter, weights_sd};
use crate::core::bench::{Alias, BenchMethod, BenchResult};
use crate::core::campaign::repeats::{PureError, repeats};
use crate::core::campaign::{Campaign, CampaignNote, TestKind};
use crate::core::effects::GyroAxes;
use crate::core::message::{Message, figure, list};
use crate::core::model::Term;
use crate::core::mounting::{Slot, Triad};
use crate::core::numerics::least_squares::{Factor, Fit};
use crate::message;

/// Condition that makes D_F, D_II and D_SS unique in a tumble about the output axis.
pub const GAUGE: &str = "D_II + D_SS = 0";

/// Largest departures from 1 that pass for 1, of a servo test's fitted scale, and of one that is stated: terms that are
/// left out may feed the latter.
const SERVO_SCALE: f64 = 0.02;
const STATED_SCALE: f64 = 0.2;
/// Rate along E, arcsec/s (root mean square of what is left of it beside the other columns), from which on the Earth's
/// tells what a stated E is: in a polar tumble what is left is of the mounting.
const LEAST_RATE: f64 = 1.0;
/// Standard deviations from which on a scale is not zero, or not 1.
const SIGNIFICANT: f64 = 5.0;

/// Force along an axis, g0 (root mean square of what is left of it beside the other columns), below which its coefficient
/// is not determined: a gyro stands off its fixture by minutes of arc, and that times D of another axis goes into it.
const LEAST_EXCITED: f64 = 0.01;

/// One coefficient of eq. (5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchCoefficient {
    pub name: &'static str,
    pub unit: &'static str,
    pub value: f64,
    pub sd: Option<f64>,
    /// What that is made of.
    pub uncertainty: Option<UncertaintyBudget>,
}

/// Terms of the third degree that eq. (5) leaves out, by their powers of a_I and a_S.
const CUBIC_TERMS: [(&str, i32, i32); 4] = [("D_III", 3, 0), ("D_IIS", 2, 1), ("D_ISS", 1, 2), ("D_SSS", 0, 3)];

/// The size of such a term that is told of, deg/(h g0^3).
const CUBIC_SIZE: f64 = 0.01;

/// A product that moves a coefficient by less than this share of itself is told from it well enough.
const LEAST_MOVED: f64 = 0.05;

/// Share of the squares of time below which positions follow it, and the drift that is then told where it moves D_I or
/// D_S by this part of their standard deviation, deg/h an hour.
const FOLLOWED: f64 = 0.3;
const DRIFT: f64 = 1e-3;
const TOLD_FROM: f64 = 0.3;

/// Share of a product's squares from which on residuals show it.
const LEAST_SEEN: f64 = 0.01;

/// A bench test, fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchCalibration {
    slot: Slot,
    /// Whether standard errors are stated.
    has_sem: bool,
    pub method: BenchMethod,
    /// E, pulse/arcsec (arcsec per arcsec in the servo test), fixture axes.
    pub e: Vector3<f64>,
    pub scale_source: ScaleSource,
    /// Whether the direction of E is held, at what is stated or nominal.
    pub holds_direction: bool,
    /// Axes on which drift was resolved: the stated ones, carried along with the measured input axis.
    pub axes: Matrix3<f64>,
    /// D_F, D_I, D_S and, where the positions allow, D_II, D_SS and D_O.
    pub coefficients: Vec<BenchCoefficient>,
    pub gauge: Option<&'static str>,
    /// Products that eq. (5) leaves out here and that these positions do not tell from a coefficient.
    pub aliases: Vec<Alias>,
    /// The same of terms of the third degree and D_I and D_S.
    cubic_aliases: Vec<Alias>,
    /// Where the positions follow time: by how much a drift of one deg/h an hour moves D_I and D_S, deg/(h g0).
    by_drift: Option<[f64; 2]>,
    /// Mean of a_I^2 + a_S^2, g0^2.
    squared_force: f64,
    pub chi2: f64,
    pub dof: usize,
    /// Chance of residuals as large as these if eq. (5) and the noise scale are right; none where nothing tells.
    pub p_value: Option<f64>,
    pub rank: usize,
    pub noise: NoiseScale,
    /// Scatter of the stated standard errors, where they are shrunk to the law that they scatter about.
    pub errors_scatter: Option<f64>,
    /// What the noise is beyond white and as stated.
    pub noise_found: NoiseFound,
    /// What is left out of the standard deviations.
    pub notes: Vec<CampaignNote>,
    /// Standard deviation of each output, none without a noise scale.
    pub sigma: Option<DVector<f64>>,
    /// Residuals over their own standard deviations, sigma sqrt(1 - leverage).
    pub standardised: Option<DVector<f64>>,
    /// Pulse/s (arcsec/s in the servo test), by dwell.
    pub residuals: DVector<f64>,
    pub leverage: DVector<f64>,
    pub repeats: Vec<Vec<usize>>,
}

/// Why a bench test yields no D_I and D_S.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NotFitted {
    NotABench,
    NoAxes(&'static str),
    Undetermined(Vec<&'static str>),
    NoScale,
    /// With E there are too few positions for D_II and D_SS.
    ScaleOrSquares,
    NotATableRate {
        found: f64,
    },
    /// The Earth's rate shows another E than the stated one.
    NotAsStated {
        found: f64,
    },
    NoServoSign,
}

impl NotFitted {
    /// The refusal as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::NotABench => message!("not_a_bench_test"),
            Self::NoAxes(slot) => message!("no_fixture_axes", slot = *slot),
            Self::Undetermined(parameters) => {
                message!("bench_undetermined", parameters = list(parameters.iter().copied()))
            }
            Self::NoScale => message!("bench_no_scale"),
            Self::ScaleOrSquares => message!("bench_scale_or_squares"),
            Self::NoServoSign => message!("no_servo_sign"),
            Self::NotAsStated { found } => message!("bench_not_as_stated", found = figure(*found, 3)),
            Self::NotATableRate { found } => message!("not_a_table_rate", found = figure(*found, 4)),
        }
    }
}

/// What is fitted besides the drift, and the axes that follow from it.
struct BenchScale {
    /// Held E, or none where columns of w are fitted.
    held: Option<Vector3<f64>>,
    /// Directions on which the rate is fitted: the body axes, the input axis alone, or none.
    fitted: Vec<Vector3<f64>>,
}

struct BenchProblem<'a> {
    campaign: &'a Campaign,
    method: BenchMethod,
    triad: Triad,
    /// Standard deviations that weigh the dwells; `shrunken` where residuals do not follow the stated ones.
    sd: Vec<f64>,
    shrunken: Option<ShrunkenErrors>,
    squares: bool,
}

/// Fits a campaign of one gyro with `test` other than `imu`.
///
/// # Errors
/// [`NotFitted`] with the reason.
pub fn calibrate_bench(campaign: &Campaign) -> Result<BenchCalibration, NotFitted> {
    let method = match campaign.test {
        TestKind::Imu => return Err(NotFitted::NotABench),
        TestKind::TorqueFeedback => BenchMethod::TorqueFeedback,
        TestKind::TurntableServo => BenchMethod::TurntableServo,
    };
    let gyro = campaign.gyros.first().ok_or(NotFitted::NotABench)?;
    let triad = campaign.geometry.triad(gyro.slot).ok_or(NotFitted::NoAxes(gyro.slot.name()))?;
    let squares = campaign.terms().contains(Term::GSquared);
    let sd = weights_sd(campaign, 0);
    let mut problem = BenchProblem { campaign, method, triad, sd, shrunken: None, squares };
    let scale = problem.scale(gyro.known_e)?;
    let as_stated = problem.fit(&scale)?;
    let Some(shrunken) = problem.shrunken(&scale, &as_stated) else { return Ok(as_stated) };
    problem.sd.clone_from(&shrunken.sd[0]);
    problem.shrunken = Some(shrunken);
    problem.fit(&scale)
}

impl BenchProblem<'_> {
    fn scale(&self, known_e: Option<Vector3<f64>>) -> Result<BenchScale, NotFitted> {
        let held = |e| BenchScale { held: Some(e), fitted: Vec::new() };
        let fit_along = |fitted: Vec<Vector3<f64>>| BenchScale { held: None, fitted };
        if let Some(e) = known_e {
            let told = self.answer(&fit_along(vec![e]), e / e.norm_squared(), LEAST_RATE * e.norm());
            return match told {
                Ok(Some((answer, sd))) if is_off(answer - 1.0, sd, STATED_SCALE) => {
                    Err(NotFitted::NotAsStated { found: answer })
                }
                _ => Ok(held(e)),
            };
        }
        let input = self.triad.input();
        if self.method == BenchMethod::TorqueFeedback {
            let whole = fit_along(vec![Vector3::x(), Vector3::y(), Vector3::z()]);
            let single = fit_along(vec![input]);
            let told: Vec<BenchScale> = [whole, single].into_iter().filter(|s| self.determines_scale(s)).collect();
            let otherwise = if told.is_empty() { NotFitted::NoScale } else { NotFitted::ScaleOrSquares };
            let squares = self.squares_beside(&held(input));
            return told.into_iter().find(|scale| self.squares_beside(scale) == squares).ok_or(otherwise);
        }
        let (answer, sd) = self.answer(&fit_along(vec![input]), input, 0.0)?.ok_or(NotFitted::NoServoSign)?;
        if is_off(answer.abs() - 1.0, sd, SERVO_SCALE) {
            return Err(NotFitted::NotATableRate { found: answer });
        }
        if answer.abs() <= SIGNIFICANT * sd {
            return Err(NotFitted::NoServoSign);
        }
        Ok(held(input * answer.signum()))
    }

    /// By what the output answers the Earth's rate: E of a fit along one direction, seen along `unit`, and its standard
    /// deviation. None where the dwells do not determine it, or excite it by less than `least`, pulse/s.
    fn answer(&self, along: &BenchScale, unit: Vector3<f64>, least: f64) -> Result<Option<(f64, f64)>, NotFitted> {
        let factor = self.nominal_factor(along);
        if !self.determines(&factor, 1) || factor.excitation(0) < least {
            return Ok(None);
        }
        let found = self.fit(along)?;
        let of_weights = factor.covariance()[(0, 0)].max(0.0).sqrt();
        let sd = found.noise.covariance_scale().map_or(f64::INFINITY, f64::sqrt) * of_weights;
        Ok(Some((found.e.dot(&unit), sd)))
    }

    /// As for a campaign of an IMU. Errors that are far too large for the residuals say nothing of kinds.
    fn weigh(&self, factor: &Factor, fit: &Fit, station: &OfOne, coordinates: &mut Option<DMatrix<f64>>) -> Weighed {
        let has_sem = self.campaign.states_errors();
        if has_sem && overstated(fit.chi2, fit.dof).is_some() {
            return Weighed::white(1);
        }
        let net = station.net.as_ref().map(|(net, taken)| (net.component_div(factor.weights()), *taken));
        let (residuals, taken) = net.unwrap_or_else(|| (fit.residuals.clone(), 0));
        let dwells = &self.campaign.dwells;
        let even = DVector::from_element(dwells.len(), 1.0);
        let fitted = FittedGyro::of_even(factor, &even, (&residuals, fit.dof.saturating_sub(taken)));
        correlated_noise::weigh(&DwellConditions::of(dwells), &[fitted], std::slice::from_mut(coordinates), has_sem)
    }

    /// None where residuals follow the standard errors as stated.
    fn shrunken(&self, scale: &BenchScale, as_stated: &BenchCalibration) -> Option<ShrunkenErrors> {
        let errors = ScatteringErrors::of(self.campaign).filter(|_| as_stated.residuals.norm() > 0.0)?;
        let factor = Factor::new(self.design(scale, &as_stated.axes).0, &self.sd);
        let even = DVector::from_element(self.sd.len(), 1.0);
        let fitted = FittedGyro::of_even(&factor, &even, (&as_stated.residuals, as_stated.dof));
        errors.likeliest(|sd| Some(fitted.independent(&DVector::from_column_slice(&sd[0]), true)?.0))
    }

    /// Which squares are fitted beside this scale.
    fn squares_beside(&self, scale: &BenchScale) -> Squares {
        self.design(scale, &self.axes(self.triad.input())).1.squares
    }

    fn determines_scale(&self, scale: &BenchScale) -> bool {
        self.determines(&self.nominal_factor(scale), scale.fitted.len())
    }

    /// Whether the first `rates` columns of a design are determined, with dwells to spare.
    fn determines(&self, factor: &Factor, rates: usize) -> bool {
        self.sd.len() > factor.rank() && (0..rates).all(|i| factor.determines_parameter(i))
    }

    /// Of the design on the nominal axes.
    fn nominal_factor(&self, scale: &BenchScale) -> Factor {
        let (design, _) = self.design(scale, &self.axes(self.triad.input()));
        Factor::new(design, &self.sd)
    }

    /// Rows I^, S^, O^: the stated triad carried along by the smallest rotation of its input axis to `input`.
    fn axes(&self, input: Vector3<f64>) -> Matrix3<f64> {
        let [spin, output] = self.triad.carried_to(&input);
        Matrix3::from_rows(&[input.transpose(), spin.transpose(), output.transpose()])
    }

    /// Columns: the fitted rates, 1, a_I, a_S and, where they are asked for and seen, the squares (as their
    /// difference in the gauge) and a_O. The second value says which.
    fn design(&self, scale: &BenchScale, axes: &Matrix3<f64>) -> (DMatrix<f64>, BenchForm) {
        let dwells = &self.campaign.dwells;
        let forces: Vec<Vector3<f64>> = dwells.iter().map(|d| axes * d.specific_force_g0).collect();
        let squares = if self.squares { Squares::seen_in(&forces) } else { Squares::Left };
        let with = |form: BenchForm| {
            let rows: Vec<f64> = dwells
                .iter()
                .zip(&forces)
                .flat_map(|(dwell, a)| {
                    let rates = scale.fitted.iter().map(|axis| axis.dot(&dwell.rate_arcsec_s));
                    rates.chain([1.0, a.x, a.y]).chain(form.columns(a)).collect::<Vec<f64>>()
                })
                .collect();
            DMatrix::from_row_iterator(dwells.len(), rows.len() / dwells.len(), rows)
        };
        let forms = [(squares, true), (squares, false), (Squares::Left, true)];
        for form in forms.map(|(squares, output)| BenchForm { squares, output }) {
            let full = with(form);
            let factor = Factor::new(full.clone(), &self.sd);
            if factor.rank() == full.ncols() && full.nrows() > full.ncols() {
                return (full, form);
            }
        }
        let least = BenchForm { squares: Squares::Left, output: false };
        (with(least), least)
    }

    fn mean_squared_force(&self, axes: &Matrix3<f64>) -> f64 {
        let dwells = &self.campaign.dwells;
        dwells.iter().map(|d| (axes * d.specific_force_g0).xy().norm_squared()).sum::<f64>() / dwells.len() as f64
    }

    fn fit(&self, scale: &BenchScale) -> Result<BenchCalibration, NotFitted> {
        let e = scale.held.unwrap_or_else(|| self.triad.input());
        let mut solved = self.solve(scale, &e)?;
        // With E fitted, its direction carries the axes; one more pass suffices, as the axes move by arc-minutes.
        if scale.fitted.len() == 3 {
            if !solved.e.norm().is_normal() {
                return Err(NotFitted::NoScale);
            }
            solved = self.solve(scale, &solved.e)?;
        }
        self.finish(scale, solved)
    }

    fn solve(&self, scale: &BenchScale, direction: &Vector3<f64>) -> Result<BenchSolution, NotFitted> {
        let along = direction.normalize();
        // A table that cancels the gyro has E against the input axis; the gyro's axes do not turn round with it.
        let axes = self.axes(if along.dot(&self.triad.input()) < 0.0 { -along } else { along });
        let (design, form) = self.design(scale, &axes);
        let first = scale.fitted.len();
        let factor = Factor::new(design, &self.sd);
        let undetermined: Vec<&'static str> = ["D_F", "D_I", "D_S"]
            .into_iter()
            .enumerate()
            .filter(|(i, name)| {
                let column = first + i;
                !factor.determines_parameter(column) || *name != "D_F" && factor.excitation(column) < LEAST_EXCITED
            })
            .map(|(_, name)| name)
            .collect();
        if !undetermined.is_empty() {
            return Err(NotFitted::Undetermined(undetermined));
        }
        let held = scale.held.unwrap_or_default();
        let dwells = &self.campaign.dwells;
        let y = DVector::from_iterator(
            dwells.len(),
            dwells.iter().map(|d| d.output_pulse_s[0] - held.dot(&d.rate_arcsec_s)),
        );
        let fit = factor.fit(&y);
        let fitted: Vector3<f64> = scale.fitted.iter().zip(fit.estimate.iter()).map(|(axis, k)| axis * *k).sum();
        let e = held + fitted;
        let k = e.norm() * if e.dot(&self.triad.input()) < 0.0 { -1.0 } else { 1.0 };
        Ok(BenchSolution { e, k, axes, form, first, factor, fit, y })
    }

    /// A product's column fitted by what is fitted: what D_I and D_S take of it, and what the others do where residuals
    /// would not show it.
    fn aliases(&self, factor: &Factor, axes: &Matrix3<f64>, (form, first): (BenchForm, usize)) -> Vec<Alias> {
        let dwells = &self.campaign.dwells;
        let mut found = Vec::new();
        for (product, a, b) in [("D_SI", 1, 0), ("D_IO", 0, 2), ("D_OS", 2, 1)] {
            let forces = dwells.iter().map(|d| axes * d.specific_force_g0);
            let column = DVector::from_iterator(dwells.len(), forces.map(|f| f[a] * f[b]));
            let taken = factor.fit(&column);
            let is_hidden = taken.chi2 < LEAST_SEEN * column.component_mul(factor.weights()).norm_squared();
            for (coefficient, _, place, sign) in form.names() {
                let moves = sign * taken.estimate[first + place];
                if moves.abs() > LEAST_MOVED && (is_hidden || ["D_I", "D_S"].contains(&coefficient)) {
                    found.push(Alias { product, coefficient, moves });
                }
            }
        }
        found
    }

    /// What D_I and D_S take of terms of the third degree.
    fn cubic_aliases(&self, factor: &Factor, axes: &Matrix3<f64>, first: usize) -> Vec<Alias> {
        let forces: Vec<Vector3<f64>> = self.campaign.dwells.iter().map(|d| axes * d.specific_force_g0).collect();
        let of_term = |(product, i, s): (&'static str, i32, i32)| {
            let column = DVector::from_iterator(forces.len(), forces.iter().map(|a| a.x.powi(i) * a.y.powi(s)));
            let taken = factor.fit(&column).estimate;
            let alias = |(coefficient, place)| Alias { product, coefficient, moves: taken[first + place] };
            [("D_I", 1), ("D_S", 2)].map(alias)
        };
        CUBIC_TERMS.into_iter().flat_map(of_term).filter(|alias| alias.moves.abs() > LEAST_MOVED).collect()
    }

    /// Time fitted by what is fitted, where little of it is left over: a drift would not show, but in the coefficients.
    fn by_drift(&self, factor: &Factor, first: usize) -> Option<[f64; 2]> {
        const HOUR_S: f64 = 3600.0;
        let dwells = &self.campaign.dwells;
        let hours = DVector::from_iterator(dwells.len(), dwells.iter().map(|d| d.mid_s() / HOUR_S));
        let hours = hours.add_scalar(-hours.mean());
        let taken = factor.fit(&hours);
        let follow = taken.chi2 < FOLLOWED * hours.component_mul(factor.weights()).norm_squared();
        follow.then(|| [1, 2].map(|place| taken.estimate[first + place]))
    }

    /// What the station makes of the fit; `g` is G over |E|, deg/(h g0), fixture axes.
    fn station(&self, e: &Vector3<f64>, g: Vector3<f64>, fit: (&Factor, &Fit), has_sem: bool) -> OfOne {
        if !self.campaign.station_uncertainty.is_stated() {
            return OfOne::default();
        }
        let nominal = GyroAxes::carried(self.campaign.gyros[0].slot, self.triad.mat_gyro_body(), *e, Vector3::zeros());
        station::of_one(self.campaign, GyroAxes { input: e.normalize(), g, ..nominal }, fit, has_sem)
    }

    fn finish(&self, scale: &BenchScale, solved: BenchSolution) -> Result<BenchCalibration, NotFitted> {
        let BenchSolution { e, k, axes, form, first, ref factor, ref fit, ref y } = solved;
        let groups = repeats(&self.campaign.dwells);
        let has_sem = self.campaign.states_errors();
        let g = axes.tr_mul(&Vector3::from(solved.linear()));
        let station = self.station(&e, k.signum() * g, (factor, fit), has_sem);
        let pure_error = PureError::of(&groups, |k| y[k], |k| self.sd[k]);
        let evidence = match &station.net {
            Some((net, taken)) => Evidence::of(net.norm_squared(), fit.dof.saturating_sub(*taken), pure_error),
            None => Evidence::of(fit.chi2, fit.dof, pure_error),
        };
        let noise = noise(&[evidence], has_sem)[0];
        let noise =
            if self.shrunken.is_some() { noise } else { noise.with_scatter(sem_scatter(&self.campaign.dwells, 0)) };
        let sigma = noise.factor.map(|f| DVector::from_fn(self.sd.len(), |i, _| self.sd[i] * f));
        let rank = factor.rank();
        let white = noise.covariance_scale().map(|scale| DMatrix::from_diagonal_element(rank, rank, scale));
        let mut coordinates = white.clone();
        let weighed = self.weigh(factor, fit, &station, &mut coordinates);
        // Of one gyro, kinds may widen what white noise makes of a coefficient, and not narrow it.
        let of_kind = |(coordinates, of_white): (DMatrix<f64>, f64)| {
            let identity = DMatrix::identity(fit.estimate.len(), fit.estimate.len());
            Uncertainty {
                fit: factor.covariance_of(&coordinates),
                white: factor.covariance_of(&white.clone().unwrap_or(coordinates)) * of_white,
                share: noise.share(&evidence, noise_report::is_other(&weighed.kinds)),
                station: StationResponse::by_part(&station.responses, &identity),
                unstated: StationResponse::contradicted(&station.responses, &identity),
            }
        };
        let mixed = coordinates.map(|mixed| (mixed, weighed.white[0]));
        let uncertainties: Vec<Uncertainty> =
            white.clone().map(|white| (white, 1.0)).into_iter().chain(mixed).map(of_kind).collect();
        let slot = self.campaign.gyros[0].slot;
        if let Some(parts) = uncertainties.first().filter(|_| first > 0)
            && self.method == BenchMethod::TorqueFeedback
            && k.abs() < LEAST_SCALE_TO_NOISE * parts.fit.view((0, 0), (first, first)).trace().max(0.0).sqrt()
        {
            return Err(NotFitted::NoScale);
        }
        let coefficients: Vec<BenchCoefficient> = form
            .names()
            .map(|(name, unit, ..)| {
                let gradient = solved.gradient(name, &scale.fitted);
                let variance = |c: &DMatrix<f64>| gradient.dot(&(c * &gradient));
                let combined = |parts: &Uncertainty| variance(&parts.covariance());
                let widest = uncertainties.iter().max_by(|a, b| combined(a).total_cmp(&combined(b)));
                let sd = widest.map(|parts| combined(parts).max(0.0).sqrt());
                let budget = widest.and_then(|parts| parts.budgets(|c| Some([variance(c)])));
                let uncertainty = budget.map(|[budget]| budget);
                BenchCoefficient { name, unit, value: solved.value(name), sd, uncertainty }
            })
            .collect();
        // Outputs next to nothing have a scale next to nothing, which nothing can be divided by.
        if !coefficients.iter().all(|c| c.value.is_finite() && c.sd.is_none_or(f64::is_finite)) {
            return Err(NotFitted::NoScale);
        }
        let aliases = self.aliases(factor, &axes, (form, first));
        let cubic_aliases = self.cubic_aliases(factor, &axes, first);
        let by_drift = self.by_drift(factor, first);
        let fit = solved.fit;
        Ok(BenchCalibration {
            slot,
            has_sem,
            method: self.method,
            e,
            scale_source: if scale.held.is_some() { ScaleSource::Held } else { ScaleSource::Fitted },
            holds_direction: scale.fitted.len() < 3,
            axes,
            coefficients,
            gauge: (form.squares == Squares::Difference).then_some(GAUGE),
            aliases,
            cubic_aliases,
            by_drift,
            squared_force: self.mean_squared_force(&axes),
            chi2: fit.chi2,
            dof: fit.dof,
            p_value: noise.p_value(&evidence).filter(|_| evidence.dof > 0),
            rank: fit.rank,
            standardised: sigma.as_ref().map(|sigma| standardised(&fit.residuals, sigma, &fit.leverage)),
            sigma,
            noise,
            errors_scatter: self.shrunken.as_ref().and_then(|shrunken| shrunken.scatter),
            noise_found: noise_report::of_kinds(&weighed, &[(slot, Some(k.abs()))]),
            notes: station.notes,
            residuals: fit.residuals,
            leverage: fit.leverage,
            repeats: groups,
        })
    }
}

fn is_off(off: f64, sd: f64, passes: f64) -> bool {
    off.abs() > passes && off.abs() > SIGNIFICANT * sd
}

/// The design fitted on the axes that E has.
struct BenchSolution {
    e: Vector3<f64>,
    /// K, negative where E is against the input axis.
    k: f64,
    axes: Matrix3<f64>,
    form: BenchForm,
    /// Column of D_F, after the fitted rates.
    first: usize,
    factor: Factor,
    fit: Fit,
    y: DVector<f64>,
}

impl BenchSolution {
    /// Place of a coefficient among the estimates, and its sign there.
    fn place(&self, name: &str) -> Option<(usize, f64)> {
        let (.., column, sign) = self.form.names().find(|(of, ..)| *of == name)?;
        Some((self.first + column, sign))
    }

    /// Zero where it is not fitted.
    fn value(&self, name: &str) -> f64 {
        self.place(name).map_or(0.0, |(place, sign)| sign * self.fit.estimate[place] / self.k)
    }

    /// D_I, D_S and D_O.
    fn linear(&self) -> [f64; 3] {
        ["D_I", "D_S", "D_O"].map(|name| self.value(name))
    }

    /// Derivatives of a coefficient by the estimates, of which the first are E along `fitted`. K goes with E's length; the
    /// axes follow its direction: a turn of I towards S takes D_S into D_I, and D_I out of D_S.
    fn gradient(&self, name: &str, fitted: &[Vector3<f64>]) -> DVector<f64> {
        let mut gradient = DVector::zeros(self.fit.estimate.len());
        if let Some((place, sign)) = self.place(name) {
            gradient[place] = sign / self.k;
        }
        let [d_i, d_s, d_o] = self.linear();
        for (i, axis) in fitted.iter().enumerate() {
            let [towards_s, towards_o] = [1, 2].map(|row| self.axes.row(row).dot(&axis.transpose()) / self.k);
            let by_turn = match name {
                "D_I" => d_s * towards_s + d_o * towards_o,
                "D_S" => -d_i * towards_s,
                "D_O" => -d_i * towards_o,
                _ => 0.0,
            };
            let by_length = axis.dot(&self.e) / self.k;
            gradient[i] = by_turn - self.value(name) * by_length / self.k;
        }
        gradient
    }
}

impl BenchCalibration {
    /// The coefficient of that name, where it was fitted.
    pub fn coefficient(&self, name: &str) -> Option<&BenchCoefficient> {
        self.coefficients.iter().find(|c| c.name == name)
    }

    /// What a reader should know of the fit, its noise and its standard deviations.
    pub fn all_notes(&self) -> Vec<CampaignNote> {
        let mut notes: Vec<CampaignNote> =
            self.aliases.iter().map(|alias| CampaignNote::ProductAliased(*alias)).collect();
        let told = |by: f64, name| self.coefficient(name).and_then(|c| c.sd).is_some_and(|sd| by > TOLD_FROM * sd);
        let moved = |alias: &&Alias| told(CUBIC_SIZE * alias.moves.abs(), alias.coefficient);
        let cubic: Vec<Alias> = self.cubic_aliases.iter().filter(moved).copied().collect();
        notes.extend((!cubic.is_empty()).then_some(CampaignNote::CubicAliased { size: CUBIC_SIZE, aliases: cubic }));
        let exceeds = exceeds_noise(self.p_value);
        notes.extend(exceeds.then(|| CampaignNote::ResidualsExceedNoise { gyros: vec![self.slot], law: None }));
        notes.extend(self.errors_scatter.map(|scatter| CampaignNote::ErrorsScatter { scatter }));
        notes.extend(remembers(&self.noise_found));
        notes.extend(self.overstated().map(|times| CampaignNote::ErrorsOverstated { gyros: vec![(self.slot, times)] }));
        let moved = self.by_drift.map(|by| by.map(|by| DRIFT * by.abs()));
        let told = moved.filter(|[d_i, d_s]| told(*d_i, "D_I") || told(*d_s, "D_S"));
        notes.extend(told.map(|[d_i, d_s]| CampaignNote::DriftAliased { of: None, drift: DRIFT, d_i, d_s }));
        notes.extend(self.gauge.map(|_| CampaignNote::OffsetInGauge { moves: 0.5 * self.squared_force }));
        notes.extend(self.notes.iter().cloned());
        notes
    }

    /// How many times the stated standard errors are too large for the scatter of the dwells.
    fn overstated(&self) -> Option<f64> {
        overstated(self.chi2, self.dof).filter(|_| self.has_sem)
    }

    /// The direction that the gauge fixes, a unit vector: what D_F gains, D_II and D_SS can lose.
    pub fn null_direction(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let length = (self.squared_force.powi(2) + 2.0).sqrt();
        [("D_F", self.squared_force / length), ("D_II", -1.0 / length), ("D_SS", -1.0 / length)].into_iter()
    }

    /// What is stored and compared with other methods.
    pub fn result(&self, campaign: &Campaign) -> BenchResult {
        let of = |name| self.coefficient(name).expect("D_I and D_S are always fitted");
        let (d_i, d_s) = (of("D_I"), of("D_S"));
        BenchResult {
            serial: campaign.gyros[0].serial.clone(),
            station: campaign.station.clone(),
            measured_at: campaign.measured_at,
            method: self.method,
            d_i: d_i.value,
            d_s: d_s.value,
            d_i_sd: d_i.sd,
            d_s_sd: d_s.sd,
            temperature_c: campaign.temperature_c,
            operator: campaign.operator.clone(),
            note: campaign.note.clone(),
        }
    }
}

#[cfg(test)]
mod tests;
