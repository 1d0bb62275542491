//! What a calibration record shows by itself: the closure D_O, which two coefficients cannot explain.
//!
//! With D_I and D_S alone, G/|E| lies in the plane of I and S. What stands out of it, D_O = (G/|E|).O, is either
//! drift in proportion to specific force along O (`output_axis_g`), or part of a D_S whose axis is turned about I by
//! phi = atan(D_O/D_S) in the seat (`mount_clocking`): one number, two causes, and nothing left over to hold one of
//! them against. They part only where D_S changes: a true D_O stays, a clocked one moves by tan(phi) times the
//! change.

use crate::core::diagnose::diagnosis::{BUDGET_DEG_PER_H_G0, Verdict};
use crate::core::effects::Effect;
use crate::core::mounting::Slot;
use crate::core::numerics::normal::normal_cdf;
use crate::core::separate::Separation;

/// The two readings of a closure: one class.
pub const CLOSURE_CLASS: [Effect; 2] = [Effect::OutputAxisG, Effect::MountClocking];

/// Probability of a closure as large by noise alone, over all gyros of the record, below which it counts.
const FALSE_ALARM: f64 = 0.01;

/// Standard deviations by which D_O must move to tell the readings apart.
const TOLD: f64 = 3.0;

/// The closure of one gyro, deg/(h g0).
#[derive(Debug, Clone, PartialEq)]
pub struct GyroClosure {
    pub slot: Slot,
    pub d_s: f64,
    pub d_o: f64,
    /// Where the station states the standard deviations of E and G.
    pub sd: Option<f64>,
    /// |D_O| over the budget of D_I and D_S.
    pub of_budget: f64,
    /// Probability of a |D_O| as large by noise alone, over all gyros; none without a standard deviation.
    pub p_value: Option<f64>,
    /// Whether it is a gap: significant, or, where nothing gives its noise, above the budget.
    pub stands_out: bool,
    /// atan(D_O/D_S): the clocking that would explain it, radians.
    pub clocking: f64,
    /// Shift of D_S if it is clocking: sgn(D_S) |(D_S, D_O)| - D_S. None whatever if it is D_O.
    pub d_s_shift: f64,
    /// Change of D_S after which D_O tells the two readings apart; none where nothing stands out.
    pub telling_change: Option<f64>,
}

/// The answer for one record.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosureDiagnosis {
    pub verdict: Verdict,
    /// Root mean square of D_O over the gyros.
    pub rms: f64,
    pub gyros: Vec<GyroClosure>,
}

/// Diagnoses the closures of a record's gyros.
///
/// The verdict is `no_gap`, or `partly_explained`: the class is named, since nothing else of the catalogue acts
/// inside G; which of the two it is, and whether it is either, one record cannot say.
pub fn closures<'a>(gyros: impl Iterator<Item = (Slot, &'a Separation)>) -> ClosureDiagnosis {
    let separated: Vec<(Slot, &Separation)> = gyros.collect();
    let tried = separated.len();
    let gyros: Vec<GyroClosure> = separated.iter().map(|(slot, s)| GyroClosure::of(*slot, s, tried)).collect();
    let rms = (gyros.iter().map(|g| g.d_o * g.d_o).sum::<f64>() / tried.max(1) as f64).sqrt();
    let gap = gyros.iter().any(|g| g.stands_out);
    ClosureDiagnosis { verdict: if gap { Verdict::PartlyExplained } else { Verdict::NoGap }, rms, gyros }
}

impl GyroClosure {
    fn of(slot: Slot, separation: &Separation, tried: usize) -> Self {
        let rigid = &separation.rigid;
        let (d_s, d_o) = (rigid.d_s, rigid.d_o);
        let sd = rigid.sd().map(|sd| sd[2]).filter(|sd| *sd > 0.0);
        let of_budget = d_o.abs() / BUDGET_DEG_PER_H_G0;
        let p_value = sd.map(|sd| (2.0 * normal_cdf(-d_o.abs() / sd) * tried as f64).min(1.0));
        let stands_out = p_value.map_or(of_budget > 1.0, |p| p < FALSE_ALARM);
        let ratio = (d_o / d_s).abs();
        let scatter = sd.map_or(BUDGET_DEG_PER_H_G0, |sd| sd * std::f64::consts::SQRT_2);
        let telling = TOLD * scatter / ratio;
        Self {
            slot,
            d_s,
            d_o,
            sd,
            of_budget,
            p_value,
            stands_out,
            clocking: rigid.clocking(),
            d_s_shift: d_s.hypot(d_o).copysign(d_s) - d_s,
            telling_change: Some(telling).filter(|change| stands_out && change.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests;
