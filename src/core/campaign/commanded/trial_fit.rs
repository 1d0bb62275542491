//! Whether D_I and D_S can still be relied on.

use super::{EARTH, MistakeKind};
use crate::core::calibrate::{Calibration, GyroCalibration, calibrate_in_white_noise};
use crate::core::campaign::Campaign;
use crate::core::numerics::median::median_of;
use crate::core::record::Plausibility;
use crate::core::separate::Rigid;

/// What D_I and D_S may be moved by, deg/(h g0): a tenth of the error budget.
const MAY_MOVE: f64 = 1e-3;

/// The Earth's rate matters where it is so many times the noise of a dwell.
const TIMES_NOISE: f64 = 3.0;

/// Residuals are far beyond the noise at so many times it, and from here on in arcsec/s.
const FAR_BEYOND: f64 = 5.0;
const LEAST_LEFT: f64 = 0.05;

/// A mistake whose fit leaves more than this many times the squares of the best is not that one.
const WORSE: f64 = 4.0;

/// A campaign as it stands, or as a mistake undone leaves it, fitted.
pub(super) struct TrialFit {
    calibration: Calibration,
    /// Noise of a dwell of each gyro as its standard errors or repeats say, and what the fit leaves, arcsec/s; none
    /// where E is not known.
    gyros: Vec<Option<(f64, f64)>>,
    squares: f64,
    plausible: bool,
}

impl TrialFit {
    /// Fits the campaign as if its noise were white, with the terms it asks for.
    pub fn of(campaign: &Campaign) -> Self {
        let calibration = calibrate_in_white_noise(campaign, campaign.terms());
        let plausible = calibration.gyros.iter().all(|gyro| {
            let limits = Plausibility::ever();
            gyro.scale_factor().is_none()
                || gyro.e().is_none_or(|e| limits.check_scale(&e, &campaign.geometry, gyro.slot).is_ok())
        });
        let gyros = (0..campaign.gyros.len()).map(|j| noise(campaign, &calibration, j)).collect();
        let squares = calibration.gyros.iter().map(|g| g.chi2).sum();
        Self { calibration, gyros, squares, plausible }
    }

    /// Noise of a dwell and what the fit leaves, of the middle gyro.
    fn middle(&self) -> Option<(f64, f64)> {
        let known: Vec<(f64, f64)> = self.gyros.iter().copied().flatten().collect();
        median_of(known.iter().map(|n| n.0)).zip(median_of(known.iter().map(|n| n.1)))
    }

    fn earth_is_above_noise(&self) -> bool {
        self.middle().is_some_and(|(own, left)| TIMES_NOISE * own < EARTH && left < EARTH)
    }
}

fn noise(campaign: &Campaign, calibration: &Calibration, j: usize) -> Option<(f64, f64)> {
    let gyro = &calibration.gyros[j];
    let scale = gyro.scale_factor()?;
    let left = (gyro.residuals.norm_squared() / gyro.dof.max(1) as f64).sqrt() / scale;
    let repeats = gyro.noise.pure_error;
    let scatter = (repeats.dof > 0).then(|| (repeats.chi2 / repeats.dof as f64).sqrt());
    // What remains if the wrong part of the Earth's rate is a third of the squares of its horizontal part.
    let horizontal = campaign.site.map_or(EARTH, |site| EARTH * site.latitude.cos());
    let beside = (left * left - horizontal * horizontal / 3.0).max(0.0).sqrt();
    let stated = campaign.errors_of(j).and_then(median_of);
    let own = match (stated, scatter) {
        (Some(sem), _) => sem / scale,
        (None, Some(scatter)) => (scatter / scale).min(beside),
        (None, None) => beside,
    };
    Some((own, left))
}

/// What the commanded vectors are worth, asked for where something is wrong with them.
pub(super) struct TrialFits<'a> {
    campaign: &'a Campaign,
    as_sent: Option<TrialFit>,
    /// The best fit with a mistake undone.
    undone: Option<TrialFit>,
}

impl<'a> TrialFits<'a> {
    /// Fits nothing until it is asked.
    pub fn new(campaign: &'a Campaign) -> Self {
        Self { campaign, as_sent: None, undone: None }
    }

    fn as_sent(&mut self) -> &TrialFit {
        self.as_sent.get_or_insert_with(|| TrialFit::of(self.campaign))
    }

    /// The causes whose fit is about as good as the best, each once; with an impossible E only where there is no
    /// other. All must leave `times` fewer squares than what was sent, where that is more than one.
    pub fn best(&mut self, mut tried: Vec<(MistakeKind, TrialFit)>, times: f64) -> Vec<MistakeKind> {
        if times > 1.0 {
            let most = self.as_sent().squares / times;
            tried.retain(|(_, t)| t.squares <= most);
        }
        let any = tried.iter().any(|(_, t)| t.plausible);
        let eligible = |t: &TrialFit| t.plausible || !any;
        let least = tried.iter().filter(|(_, t)| eligible(t)).map(|(_, t)| t.squares).fold(f64::INFINITY, f64::min);
        let good = |t: &TrialFit| eligible(t) && t.squares <= WORSE * least + f64::MIN_POSITIVE;
        let mut causes: Vec<MistakeKind> = Vec::new();
        for (cause, tried) in tried {
            if good(&tried) && !causes.contains(&cause) {
                causes.push(cause);
                self.undone.get_or_insert(tried);
            }
        }
        causes
    }

    /// Whether the best mistake, undone, fits the outputs clearly better than what was sent.
    pub fn fits_better_undone(&mut self) -> bool {
        let Some((least, plausible)) = self.undone.as_ref().map(|t| (t.squares, t.plausible)) else { return false };
        let sent = self.as_sent();
        WORSE * least < sent.squares || plausible && !sent.plausible
    }

    /// What the fit of what was sent leaves in the middle gyro, arcsec/s, where it is far beyond the noise of a dwell.
    pub fn left_beyond_noise(&mut self) -> Option<f64> {
        let (own, left) = self.as_sent().middle()?;
        (left > FAR_BEYOND * own && left > LEAST_LEFT).then_some(left)
    }

    /// Whether a dwell says more of the Earth's rate than of its own noise.
    pub fn earth_is_above_noise(&mut self) -> bool {
        self.undone.as_ref().is_some_and(TrialFit::earth_is_above_noise) || self.as_sent().earth_is_above_noise()
    }

    /// Whether a rate along the vertical of this many arcsec/s in every dwell moves D_I by more than it may: with E
    /// along I, by as many deg/(h g0).
    pub fn moved_by_rate(&mut self, arcsec_s: f64) -> bool {
        self.drift().iter().any(|(_, sd)| arcsec_s > MAY_MOVE.max(*sd))
    }

    /// Whether a specific force that is `ratio` times the real one moves D_I or D_S by more than it may.
    pub fn moved_by_force(&mut self, ratio: f64) -> bool {
        let share = (1.0 - ratio).abs();
        self.drift().iter().any(|(drift, sd)| share * drift.abs() > MAY_MOVE.max(*sd))
    }

    /// D_I and D_S of each gyro with their standard deviations by noise: what the mistake itself leaves in the residuals
    /// is no reason to let it pass.
    fn drift(&mut self) -> Vec<(f64, f64)> {
        let geometry = &self.campaign.geometry;
        let calibration = &self.as_sent().calibration;
        let separations = calibration.separate(geometry, &Plausibility::ever());
        let pairs = |(rigid, gyro): (&Rigid, &GyroCalibration)| {
            let [d_i, d_s, ..] = gyro.budgets(geometry, false)?;
            Some([(rigid.d_i, d_i.statistical), (rigid.d_s, d_s.statistical)])
        };
        let separated = separations.iter().zip(&calibration.gyros);
        let rigid = separated.filter_map(|(separated, gyro)| Some((&separated.as_ref().ok()?.rigid, gyro)));
        rigid.filter_map(pairs).flatten().collect()
    }
}
