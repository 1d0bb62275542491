//! The final fit of what was adopted: coefficients with their uncertainty, residuals, and the noise left.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::core::augmented::Adopted;
use crate::core::calibrate::design::first_column;
use crate::core::diagnose::residuals::pooled_noise::Scatter;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::effects::{Coefficient, Effect, GyroAxes, Refusal, Scope, Setting, Shape};
use crate::core::model::Term;
use crate::core::numerics::basis::{Basis, axpy, dot};

/// An effect with its shape and its gyros fixed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub effect: Effect,
    pub shape: Shape,
    pub members: Vec<bool>,
}

impl Part {
    /// Whether all gyros share its coefficients.
    pub fn common(&self) -> bool {
        self.effect.entry().scope == Scope::Common
    }

    /// As it enters the model.
    pub fn adopted(&self, frame: &Frame) -> Adopted {
        let gyros = frame.setting.gyros.iter().zip(&self.members).filter(|(_, member)| **member);
        Adopted { effect: self.effect, shape: self.shape, slots: gyros.map(|(gyro, _)| gyro.slot).collect() }
    }

    /// The one dwell that the effect sets aside, if it is of that kind.
    pub fn dwell(&self) -> Option<usize> {
        match self.shape {
            Shape::Dwell(k) => Some(k),
            _ => None,
        }
    }

    /// Regressors of gyro `j`, deg/h per unit coefficient.
    pub fn columns(&self, frame: &Frame, j: usize) -> Vec<Vec<f64>> {
        (self.effect.entry().columns)(&frame.setting, j, self.shape)
    }
}

/// One fitted coefficient.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fitted {
    pub part: usize,
    /// None where all gyros share it.
    pub gyro: Option<usize>,
    pub coefficient: Coefficient,
    pub value: f64,
    pub sd: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub fitted: Vec<Fitted>,
    /// Whitened residuals of each gyro.
    pub residuals: Vec<Vec<f64>>,
    /// Degrees of freedom left in each gyro; shared coefficients are counted in equal parts.
    pub dof: Vec<f64>,
    /// Noise variance of each gyro over that of `sd`.
    pub variances: Vec<f64>,
    /// Drift that the parts add in each gyro and dwell, deg/h.
    pub drift: Vec<Vec<f64>>,
}

impl Fit {
    /// Coefficients of part `p` in gyro `j`.
    fn of_part(&self, p: usize, j: usize) -> impl Iterator<Item = &Fitted> {
        self.fitted.iter().filter(move |f| f.part == p && f.gyro.is_none_or(|gyro| gyro == j))
    }

    /// What part `p` adds to gyro `j` in the dwells of a setting, those that were fitted or others, deg/h.
    pub fn drift_of(&self, (p, part): (usize, &Part), setting: &Setting, j: usize) -> Vec<f64> {
        let columns = (part.effect.entry().columns)(setting, j, part.shape);
        let mut drift = vec![0.0; setting.dwells()];
        self.of_part(p, j).zip(&columns).for_each(|(fitted, column)| axpy(fitted.value, column, &mut drift));
        drift
    }
}

/// A basis of gyro `j`, whitened, with the columns of the parts that it has.
pub(crate) fn with_parts(frame: &Frame, j: usize, mut basis: Basis, parts: &[&Part]) -> Basis {
    for part in parts.iter().filter(|part| part.members[j]) {
        for column in part.columns(frame, j) {
            basis.push(frame.gyros[j].whiten(column));
        }
    }
    basis
}

/// Unknown of the stacked fit.
struct Unknown {
    part: usize,
    gyro: Option<usize>,
    number: usize,
}

impl Unknown {
    /// The gyros that have it.
    fn gyros(&self, parts: &[Part]) -> impl Iterator<Item = usize> {
        let members = &parts[self.part].members;
        (0..members.len()).filter(|j| self.gyro.is_none_or(|gyro| gyro == *j) && members[*j])
    }
}

/// Weighted least squares of all parts together; gyros weigh with the noise that the fit itself leaves them.
pub(crate) fn fit(frame: &Frame, parts: &[Part]) -> Fit {
    let gyros = frame.gyros.len();
    let columns: Vec<Vec<Vec<Vec<f64>>>> =
        parts.iter().map(|part| (0..gyros).map(|j| part.columns(frame, j)).collect()).collect();
    let unknowns = unknowns(parts, &columns);
    let n = frame.dwells();
    let mut design = DMatrix::zeros(gyros * n, unknowns.len());
    for (u, unknown) in unknowns.iter().enumerate() {
        for j in unknown.gyros(parts) {
            let mut column = frame.gyros[j].whiten(columns[unknown.part][j][unknown.number].clone());
            let before = dot(&column, &column);
            frame.gyros[j].basis.project_out(&mut column);
            if dot(&column, &column) > 1e-12 * before {
                design.view_mut((j * n, u), (n, 1)).copy_from_slice(&column);
            }
        }
    }
    let lengths: Vec<f64> = (0..unknowns.len()).map(|u| design.column(u).norm().max(f64::MIN_POSITIVE)).collect();
    for (u, length) in lengths.iter().enumerate() {
        design.column_mut(u).scale_mut(1.0 / length);
    }
    let dof = degrees_of_freedom(frame, &unknowns);
    let mut variances: Vec<f64> = vec![1.0; gyros];
    let (mut solution, mut covariance) = (DVector::zeros(unknowns.len()), DMatrix::zeros(0, 0));
    let mut residuals: Vec<Vec<f64>> = frame.gyros.iter().map(|gyro| gyro.residual.clone()).collect();
    for _ in 0..3 {
        variances = (0..gyros).map(|j| variance_left(frame, j, &residuals[j], dof[j])).collect();
        if unknowns.is_empty() {
            break;
        }
        (solution, covariance) = solve(frame, &design, &variances);
        let predicted = &design * &solution;
        for j in 0..gyros {
            residuals[j] = (0..n).map(|k| frame.gyros[j].residual[k] - predicted[j * n + k]).collect();
        }
    }
    variances = (0..gyros).map(|j| variance_left(frame, j, &residuals[j], dof[j])).collect();
    let mut drift = vec![vec![0.0; n]; gyros];
    let mut fitted = Vec::new();
    for (u, unknown) in unknowns.iter().enumerate() {
        let part = &parts[unknown.part];
        let value = solution[u] / lengths[u];
        for j in unknown.gyros(parts) {
            axpy(value, &columns[unknown.part][j][unknown.number], &mut drift[j]);
        }
        fitted.push(Fitted {
            part: unknown.part,
            gyro: unknown.gyro,
            coefficient: part.effect.entry().coefficients(part.shape)[unknown.number],
            value,
            sd: covariance[(u, u)].max(0.0).sqrt() / lengths[u],
        });
    }
    Fit { fitted, residuals, dof, variances, drift }
}

fn unknowns(parts: &[Part], columns: &[Vec<Vec<Vec<f64>>>]) -> Vec<Unknown> {
    let mut unknowns = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let count = columns[p].iter().map(Vec::len).max().unwrap_or(0);
        if part.common() {
            unknowns.extend((0..count).map(|number| Unknown { part: p, gyro: None, number }));
        } else {
            for j in (0..part.members.len()).filter(|j| part.members[*j]) {
                unknowns.extend((0..count).map(|number| Unknown { part: p, gyro: Some(j), number }));
            }
        }
    }
    unknowns
}

fn degrees_of_freedom(frame: &Frame, unknowns: &[Unknown]) -> Vec<f64> {
    let shared = unknowns.iter().filter(|u| u.gyro.is_none()).count() as f64 / frame.gyros.len() as f64;
    (0..frame.gyros.len())
        .map(|j| {
            let own = unknowns.iter().filter(|u| u.gyro == Some(j)).count() as f64;
            (frame.gyros[j].dof() as f64 - own - shared).max(1.0)
        })
        .collect()
}

fn variance_left(frame: &Frame, j: usize, residual: &[f64], dof: f64) -> f64 {
    let Scatter { rss, nu } = frame.noise.with_stated(dot(residual, residual), dof);
    (rss / nu).max(frame.noise.rounding[j]).max(1e-12)
}

/// Solution and covariance by QR with column pivoting; columns that the others span get zero and no variance.
fn solve(frame: &Frame, design: &DMatrix<f64>, variances: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
    let n = frame.dwells();
    let mut weighted = design.clone();
    let mut side = DVector::zeros(design.nrows());
    for (j, variance) in variances.iter().enumerate() {
        let weight = 1.0 / variance.sqrt();
        weighted.rows_mut(j * n, n).scale_mut(weight);
        for k in 0..n {
            side[j * n + k] = frame.gyros[j].residual[k] * weight;
        }
    }
    let m = design.ncols();
    let qr = weighted.col_piv_qr();
    let r = qr.r();
    let rank = (0..m).take_while(|&i| r[(i, i)].abs() > 1e-7 * r[(0, 0)].abs().max(f64::MIN_POSITIVE)).count();
    let along = qr.q().transpose() * side;
    let mut inverse = DMatrix::zeros(m, m);
    let top = r.view((0, 0), (rank, rank)).into_owned();
    if let Some(top) = top.solve_upper_triangular(&DMatrix::identity(rank, rank)) {
        inverse.view_mut((0, 0), (rank, rank)).copy_from(&top);
    }
    let mut solution = &inverse * along;
    let mut covariance = &inverse * inverse.transpose();
    qr.p().inv_permute_rows(&mut solution);
    qr.p().inv_permute_rows(&mut covariance);
    covariance.transpose_mut();
    qr.p().inv_permute_rows(&mut covariance);
    (solution, covariance)
}

/// Fits of a strong effect and of what hangs on it, one after the other, until neither moves the other.
const ROUNDS: usize = 4;

impl Frame {
    /// The same about the fit of `parts`: the gyros' axes, G and P as they are with the parts in the model, and the
    /// outputs less what effects of that size add beyond their regressors. The axes of the plain fit are off by what
    /// a strong effect moves them. Of first order alone where not `all_orders`.
    pub(crate) fn about(&self, parts: &[Part], all_orders: bool) -> Result<Self, Refusal> {
        let mut frame = self.clone();
        for _ in 0..ROUNDS {
            let fit = fit(&frame, parts);
            let gyros = (0..self.gyros.len()).map(|j| frame.axes_beside(j, &fit.drift[j]));
            frame.setting.gyros = gyros.collect();
            for (j, output) in frame.outputs.iter_mut().enumerate() {
                output.clone_from(&self.outputs[j]);
                for (p, part) in parts.iter().enumerate().filter(|(_, part)| all_orders && part.members[j]) {
                    let Some(beyond) = part.effect.entry().beyond else { continue };
                    let own: Vec<f64> = fit.of_part(p, j).map(|f| f.value).collect();
                    axpy(-1.0, &beyond(&frame.setting, j, part.shape, &own), output);
                }
            }
            frame = frame.whitened()?;
        }
        Ok(frame)
    }

    /// Axes and G of gyro `j` where `drift` is what effects add: those of the model's own columns, where it has them.
    fn axes_beside(&self, j: usize, drift: &[f64]) -> GyroAxes {
        let (gyro, axes) = (&self.gyros[j], &self.setting.gyros[j]);
        let mut output = self.outputs[j].clone();
        axpy(-1.0, drift, &mut output);
        let terms = if self.scale_fitted[j] { self.terms } else { self.terms.without(Term::Scale) };
        let columns: Vec<Vec<f64>> = self.designs[j].iter().map(|column| gyro.whiten(column.clone())).collect();
        let lengths: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt().max(f64::MIN_POSITIVE)).collect();
        let design = DMatrix::from_fn(self.dwells(), columns.len(), |k, c| columns[c][k] / lengths[c]);
        let Ok(solution) = design.svd(true, true).solve(&DVector::from_vec(gyro.whiten(output)), 1e-7) else {
            return axes.clone();
        };
        let vector = |term: Term| {
            let before = first_column(terms, term);
            let value = |i: usize| solution[before + i] / lengths[before + i];
            terms.contains(term).then(|| Vector3::new(value(0), value(1), value(2)))
        };
        axes.turned(
            vector(Term::Scale).unwrap_or(axes.input),
            [vector(Term::GLinear).unwrap_or(axes.g), vector(Term::GSquared).unwrap_or(axes.p)],
            if terms.contains(Term::Bias) { solution[0] / lengths[0] } else { 0.0 },
        )
    }

    /// The same less effects whose coefficients all gyros share: as columns of each gyro they would be fitted once a
    /// gyro.
    pub(super) fn without(mut self, shared: &[&Adopted]) -> Result<Self, Refusal> {
        let seen = shared.iter().filter(|adopted| (adopted.effect.entry().missing)(&self.setting).is_none());
        let part = |adopted: &&Adopted| Part {
            effect: adopted.effect,
            shape: adopted.shape,
            members: self.setting.gyros.iter().map(|gyro| adopted.slots.contains(&gyro.slot)).collect(),
        };
        let parts: Vec<Part> = seen.copied().map(|adopted| part(&adopted)).collect();
        let drift = fit(&self, &parts).drift;
        for (output, drift) in self.outputs.iter_mut().zip(&drift) {
            axpy(-1.0, drift, output);
        }
        self.whitened()
    }
}
