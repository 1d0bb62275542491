//! Where the gap lies: which gyro, which phase, which dwell.

use crate::core::campaign::Phase;
use crate::core::diagnose::diagnosis::{DwellShare, Located, Residual};
use crate::core::diagnose::residuals::whitened::Frame;

/// Number of dwells that are named one by one.
const NAMED_DWELLS: usize = 10;

/// Shares of the whitened sum of squares above what noise of `variances` would leave; never negative, summing to 1.
pub(crate) fn located(frame: &Frame, variances: &[f64]) -> Located {
    let cells: Vec<(usize, usize, f64)> = frame
        .gyros
        .iter()
        .enumerate()
        .flat_map(|(j, gyro)| {
            gyro.residual
                .iter()
                .enumerate()
                .map(move |(k, r)| (j, k, r * r / variances[j] - (1.0 - gyro.basis.leverage(k))))
        })
        .collect();
    let slot = |j: usize| frame.setting.gyros[j].slot;
    let group =
        |of: &dyn Fn(&(usize, usize, f64)) -> bool| cells.iter().filter(|c| of(c)).map(|c| c.2).sum::<f64>().max(0.0);
    let gyros: Vec<f64> = (0..frame.gyros.len()).map(|j| group(&|c| c.0 == j)).collect();
    let kinds = [Phase::Static, Phase::Rate];
    let present: Vec<Phase> = kinds.into_iter().filter(|p| frame.setting.phase.contains(p)).collect();
    let phases: Vec<f64> = present.iter().map(|p| group(&|c| frame.setting.phase[c.1] == *p)).collect();
    let all: f64 = cells.iter().map(|c| c.2.max(0.0)).sum::<f64>();
    let mut dwells: Vec<DwellShare> = cells
        .iter()
        .map(|&(j, k, above)| DwellShare {
            index: k,
            slot: slot(j),
            residual_deg_per_h: frame.gyros[j].residual[k] * frame.gyros[j].sd[k],
            share: if all > 0.0 { above.max(0.0) / all } else { 0.0 },
        })
        .collect();
    dwells.sort_by(|a, b| b.share.total_cmp(&a.share));
    dwells.truncate(NAMED_DWELLS);
    Located {
        gyros: (0..gyros.len()).map(slot).zip(shares(&gyros)).collect(),
        phases: present.into_iter().zip(shares(&phases)).collect(),
        dwells,
    }
}

fn shares(parts: &[f64]) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    parts.iter().map(|part| if whole > 0.0 { part / whole } else { 0.0 }).collect()
}

/// Residuals of every gyro in every dwell, before and `after` adoption (whitened), deg/h.
pub(crate) fn residuals(frame: &Frame, after: &[Vec<f64>], variances: &[f64]) -> Vec<Residual> {
    let mut list = Vec::with_capacity(frame.gyros.len() * frame.dwells());
    let dwells = 0..frame.dwells();
    for k in dwells {
        for (j, gyro) in frame.gyros.iter().enumerate() {
            list.push(Residual {
                index: k,
                slot: frame.setting.gyros[j].slot,
                before_deg_per_h: gyro.residual[k] * gyro.sd[k],
                after_deg_per_h: after[j][k] * gyro.sd[k],
                sd_deg_per_h: gyro.sd[k] * variances[j].sqrt(),
            });
        }
    }
    list
}
