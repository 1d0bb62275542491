//! The noise of each dwell up to a common factor, and which dwells repeat one another.
//!
//! Stated standard errors are themselves estimates: where they scatter about a smooth law in rate and duration, half
//! of the scatter is believed, and less where what a generous model leaves behind does not scatter with them. Where
//! none are stated, the law is found from what that leaves.

use crate::core::calibrate::growth::{Exposure, NoiseGrowth};
use crate::core::calibrate::noise::with_stated;
use crate::core::campaign::repeats::repeats;
use crate::core::campaign::{Campaign, CoarseStep, GyroNoise, coarse_steps};
use crate::core::diagnose::residuals::noise_growth::{GROWTHS, exposure, shape};
use crate::core::diagnose::residuals::pooled_noise::Scatter;
use crate::core::effects::{GyroAxes, Setting};
use crate::core::message::Message;
use crate::core::numerics::basis::{Basis, dot};
use crate::message;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noise {
    /// Per gyro, per dwell, deg/h.
    pub sd: Vec<Vec<f64>>,
    /// Whether the station stated standard errors.
    pub stated: bool,
    /// The law of noise where none is stated.
    pub law: Option<NoiseGrowth>,
    /// Standard deviation of the logarithm of what is still unsure in each `sd`.
    pub log_scatter: f64,
    /// Per gyro: smallest variance that is believed over that of `sd`, mean over dwells; 1 where rounding is all
    /// there is.
    pub rounding: Vec<f64>,
    /// Groups of two or more dwells with the same commanded phase, attitude, specific force and rate.
    pub repeats: Vec<Vec<usize>>,
    /// What the rounding of commands makes of a dwell over its noise, in the gyro that shows it most; 0 where it is
    /// small against it.
    pub commands: f64,
    pub notes: Vec<Message>,
}

/// Smallest noise against the largest output that is believed: f64 and ten-digit files end there.
const ROUNDING: f64 = 1e-9;

pub(crate) fn of(campaign: &Campaign, s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>]) -> Noise {
    let repeats = repeats(&campaign.dwells);
    let mut notes = Vec::new();
    let stated: Option<Vec<Vec<f64>>> = (0..outputs.len())
        .map(|j| {
            let per_pulse = 1.0 / s.gyros[j].scale;
            campaign.errors_of(j).map(|sems| sems.into_iter().map(|sem| sem * per_pulse).collect())
        })
        .collect();
    let (sd, log_scatter, law) = match &stated {
        Some(sems) => {
            let (sd, scatter) = smoothed(s, sems, &generous_residuals(s, outputs, designs));
            (sd, scatter, None)
        }
        None => {
            let law = unstated(s, outputs, designs);
            (law_sd(s, outputs, designs, law), 0.0, Some(law))
        }
    };
    if stated.is_none() {
        notes.push(message!("noise_from_repeats_and_residuals"));
    }
    if repeats.is_empty() {
        notes.push(message!("no_pure_error"));
    }
    let steps = coarse(campaign, s, &sd);
    notes.extend(steps.iter().map(CoarseStep::message));
    let commands = steps.iter().filter(|step| step.is_of_commands()).fold(0.0, |most, step| step.times.max(most));
    let (sd, rounding) = above_rounding(sd, outputs);
    Noise { sd, stated: stated.is_some(), law, log_scatter, rounding, repeats, commands, notes }
}

/// Steps in what was commanded or counted that are not small against the noise.
fn coarse(campaign: &Campaign, s: &Setting, sd: &[Vec<f64>]) -> Vec<CoarseStep> {
    let of_gyro = |(gyro, sd): (&GyroAxes, &Vec<f64>)| GyroNoise {
        slot: gyro.slot,
        g: gyro.scale * gyro.g.norm(),
        e: gyro.scale,
        sd: sd.iter().map(|sd| gyro.scale * sd).collect(),
    };
    let gyros: Vec<Option<GyroNoise>> = s.gyros.iter().zip(sd).map(|gyro| Some(of_gyro(gyro))).collect();
    coarse_steps(campaign, &gyros)
}

impl Noise {
    /// A whitened sum of squares and its degrees of freedom, with what is stated counted in where it is.
    pub fn with_stated(&self, rss: f64, dof: f64) -> Scatter {
        let (rss, nu) = if self.stated { with_stated(rss, dof) } else { (rss, dof) };
        Scatter { rss, nu }
    }

    /// The same with another growth of the noise with rate, where no errors are stated.
    pub fn with_growth(&self, s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>], growth: f64) -> Self {
        let Some(law) = self.law.map(|law| NoiseGrowth { growth, ..law }) else { return self.clone() };
        let (sd, rounding) = above_rounding(law_sd(s, outputs, designs, law), outputs);
        Self { sd, rounding, law: Some(law), ..self.clone() }
    }
}

fn above_rounding(mut sd: Vec<Vec<f64>>, outputs: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let mut rounding = Vec::new();
    for (sd, output) in sd.iter_mut().zip(outputs) {
        let least = ROUNDING * output.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE / ROUNDING);
        sd.iter_mut().for_each(|x| *x = x.max(least));
        rounding.push(sd.iter().map(|x| (least / x).powi(2)).sum::<f64>() / sd.len() as f64);
    }
    (sd, rounding)
}

/// Stated errors drawn (in logarithm) to the law `sem^2 = (alpha + beta x) duration^-p`, p = 0 or 1: half-way, and
/// further where residuals are clearly likelier so. Errors of a few samples each scatter by tens of per cent.
fn smoothed(s: &Setting, sems: &[Vec<f64>], residuals: &[(Vec<f64>, Vec<f64>)]) -> (Vec<Vec<f64>>, f64) {
    let laws: Vec<Vec<f64>> = (0..sems.len())
        .map(|j| {
            let law = |p: f64| law_of(s, j, &sems[j], p);
            let (flat, falling) = (law(0.0), law(1.0));
            if scatter(&sems[j], &falling) < scatter(&sems[j], &flat) { falling } else { flat }
        })
        .collect();
    let pooled =
        (laws.iter().zip(sems).map(|(law, sem)| scatter(sem, law).powi(2)).sum::<f64>() / sems.len() as f64).sqrt();
    // An estimate from n samples scatters by 1/sqrt(2n); beyond a tenth or so the differences are real ones.
    const ESTIMATED: f64 = 0.085;
    let by_size = (1.0 - (ESTIMATED / pooled.max(1e-9)).powi(2)).clamp(0.0, 1.0);
    let drawn = |believed: f64| -> Vec<Vec<f64>> {
        let one = |(law, sem): (&f64, &f64)| law * (sem / law).powf(believed);
        laws.iter().zip(sems).map(|(law, sem)| law.iter().zip(sem).map(one).collect()).collect()
    };
    let likelihood = |believed: f64| -> f64 {
        let gyros = residuals.iter().zip(drawn(believed));
        gyros.map(|((residual, left), sd)| robust_fit(residual, left, &sd).1).sum()
    };
    let least = likelihood(by_size) + CLEARLY;
    let parts = [0.0, 0.25, 0.5, 0.75].map(|part| (part * by_size, likelihood(part * by_size)));
    let best = parts.into_iter().filter(|(_, likelihood)| *likelihood > least).max_by(|a, b| a.1.total_cmp(&b.1));
    let believed = best.map_or(by_size, |(believed, _)| believed);
    (drawn(believed), (1.0 - believed).max(0.3) * pooled.min(0.15))
}

/// ln of likelihood by which residuals must speak against what errors state.
const CLEARLY: f64 = 3.0;

fn scatter(sem: &[f64], law: &[f64]) -> f64 {
    let logs: Vec<f64> = sem.iter().zip(law).map(|(s, l)| (s / l).ln()).collect();
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    (logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / logs.len() as f64).sqrt()
}

fn law_of(s: &Setting, j: usize, sem: &[f64], p: f64) -> Vec<f64> {
    let n = sem.len();
    let Exposure { rate, duration } = exposure(s, j);
    let fall: Vec<f64> = duration.iter().map(|d| d.powf(-p)).collect();
    let mean = sem.iter().map(|x| x * x).sum::<f64>() / n as f64;
    let mut law: Vec<f64> = vec![mean; n];
    for _ in 0..8 {
        // Weighted by 1/law^2: relative deviations count alike.
        let (mut uu, mut uv, mut vv, mut uy, mut vy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for k in 0..n {
            let (u, v, y) = (fall[k] / law[k], fall[k] * rate[k] / law[k], sem[k] * sem[k] / law[k]);
            (uu, uv, vv, uy, vy) = (uu + u * u, uv + u * v, vv + v * v, uy + u * y, vy + v * y);
        }
        let determinant = uu * vv - uv * uv;
        let beta = if determinant > 1e-9 * uu * vv { ((uu * vy - uv * uy) / determinant).max(0.0) } else { 0.0 };
        let alpha = (uy - beta * uv) / uu;
        let alpha = alpha.max(1e-3 * uy / uu);
        for k in 0..n {
            law[k] = fall[k] * (alpha + beta * rate[k]);
        }
    }
    law.into_iter().map(f64::sqrt).collect()
}

/// Without stated errors: growth with rate and power of duration, from what the model with a generous set of further
/// columns leaves. Student's t (5 dof) keeps single bad dwells from deciding.
fn unstated(s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>]) -> NoiseGrowth {
    let generous = generous_residuals(s, outputs, designs);
    let mut best = (f64::NEG_INFINITY, NoiseGrowth::default());
    for &fall in exposure(s, 0).falls() {
        for law in GROWTHS.map(|growth| NoiseGrowth { growth, fall }) {
            let fit: f64 = generous.iter().enumerate().map(|(j, (e, v))| robust_fit(e, v, &shape(s, j, law)).1).sum();
            if fit > best.0 {
                best = (fit, law);
            }
        }
    }
    best.1
}

/// Standard deviations by the law, each gyro scaled to what the generous model leaves it.
fn law_sd(s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>], law: NoiseGrowth) -> Vec<Vec<f64>> {
    generous_residuals(s, outputs, designs)
        .iter()
        .enumerate()
        .map(|(j, (e, v))| {
            let shape = shape(s, j, law);
            let sigma = robust_fit(e, v, &shape).0;
            shape.into_iter().map(|x| x * sigma).collect()
        })
        .collect()
}

fn generous_residuals(s: &Setting, outputs: &[Vec<f64>], designs: &[Vec<Vec<f64>>]) -> Vec<(Vec<f64>, Vec<f64>)> {
    (0..outputs.len()).map(|j| generous_residual(s, j, &outputs[j], &designs[j])).collect()
}

/// Residuals and their share of variance left (1 - leverage) after model, polynomials in time, temperature and rate.
fn generous_residual(s: &Setting, j: usize, output: &[f64], design: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let mut basis = Basis::of(design.iter().cloned());
    let n = s.dwells();
    let input: Vec<f64> = (0..n).map(|k| s.rate[k].dot(&s.gyros[j].input)).collect();
    let spin: Vec<f64> = (0..n).map(|k| s.rate[k].dot(&s.gyros[j].spin)).collect();
    let span = s.span().max(f64::MIN_POSITIVE);
    let mut further: Vec<Vec<f64>> = vec![
        s.column(|k| s.elapsed(k) / span),
        input.iter().map(|w| w.abs()).collect(),
        input.iter().map(|w| w * w).collect(),
        s.column(|k| (s.elapsed(k) / span).powi(2)),
        input.iter().map(|w| w.powi(3)).collect(),
        (0..n).map(|k| input[k] * spin[k]).collect(),
        (0..n).map(|k| s.force[k].dot(&s.gyros[j].input) * input[k]).collect(),
        s.column(|k| (s.elapsed(k) / span).powi(3)),
    ];
    if let Some(t) = &s.temperature {
        further.insert(2, t.clone());
        further.insert(4, (0..n).map(|k| t[k] * input[k]).collect());
    }
    for column in further {
        if basis.rank() * 3 < n {
            basis.push(column);
        }
    }
    let mut residual = output.to_vec();
    basis.project_out(&mut residual);
    let left = (0..n).map(|k| (1.0 - basis.leverage(k)).max(0.02)).collect();
    (residual, left)
}

/// Scale and log-likelihood of residuals `e` with share `v` of a variance of given shape, Student's t with 5 dof.
fn robust_fit(e: &[f64], v: &[f64], shape: &[f64]) -> (f64, f64) {
    const NU: f64 = 5.0;
    let z2: Vec<f64> = (0..e.len()).map(|k| e[k] * e[k] / (v[k] * shape[k] * shape[k])).collect();
    let mut variance = (dot(e, e) / e.len() as f64).max(f64::MIN_POSITIVE);
    for _ in 0..30 {
        let weighted: f64 = z2.iter().map(|z| (NU + 1.0) / (NU + z / variance) * z).sum();
        variance = (weighted / e.len() as f64).max(f64::MIN_POSITIVE);
    }
    let log_likelihood = (0..e.len())
        .map(|k| -0.5 * (NU + 1.0) * (1.0 + z2[k] / variance / NU).ln() - 0.5 * variance.ln() - shape[k].ln())
        .sum();
    (variance.sqrt(), log_likelihood)
}
