//! The fleet's noise constants from its history: correlation and walk from how differences grow with the time between.

use crate::core::judge::cells::DAYS_A_YEAR;
use crate::core::judge::{NoiseParameters, Series};
use crate::core::numerics::median::median;
use crate::core::numerics::normal::SD_OF_MEDIAN;

/// Lags, in cells.
const LAGS: [usize; 9] = [1, 2, 3, 4, 6, 8, 13, 20, 26];
/// Cells that the default counts for.
const WEIGHT: f64 = 100.0;
/// A coefficient whose mean square difference at its longest lag is so many times the fleet's median moves, and is
/// left out.
const MOVES: f64 = 4.0;
/// Differences that a lag must have to be looked at.
const LEAST_DIFFERENCES: usize = 8;

/// How far differences spread at one lag, pooled over the fleet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// Cells between.
    pub lag: usize,
    /// Mean time between, years.
    pub years: f64,
    /// Half of the robust mean square difference, (deg/(h g0))^2.
    pub half_square: f64,
    pub differences: usize,
}

/// What a fleet's history says of its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct FleetNoise {
    /// As fitted, drawn towards the default by [`WEIGHT`] cells: what the rules are to use.
    pub noise: NoiseParameters,
    /// As fitted alone; none where the history is too short for a fit.
    pub fitted: Option<NoiseParameters>,
    /// Scatter of a cell about its level, deg/(h g0), as fitted.
    pub scatter: Option<f64>,
    /// Cells that were used, and coefficients of gyros that they belong to.
    pub cells: usize,
    pub coefficients: usize,
    /// Coefficients that were left out because they move.
    pub moving: usize,
    pub spacings: Vec<Spacing>,
}

/// Cells of one coefficient between two events: years and figures, oldest first.
type Stretch = Vec<(f64, f64)>;

/// Fits half the mean square difference g_h = s^2 (1 - phi^h) + q^2 tau_h / 2 over the lags h, tau_h being the time
/// between, with equal relative errors: phi on a grid, s^2 and q^2 not negative. g_h comes from the median
/// difference, so single outliers have no part.
pub fn fit_fleet<'a>(histories: impl IntoIterator<Item = &'a Series>) -> FleetNoise {
    let stretches: Vec<Stretch> = histories.into_iter().flat_map(stretches_of).collect();
    let all = stretches.len();
    let still = without_moving(stretches);
    let spacings: Vec<Spacing> = LAGS.iter().filter_map(|lag| spacing(&still, *lag)).collect();
    let cells = still.iter().map(Vec::len).sum::<usize>();
    let best = (spacings.len() >= 3).then(|| fit(&spacings)).flatten();
    let n = if best.is_some() { cells as f64 } else { 0.0 };
    let default = NoiseParameters::default();
    let fitted = best.map(|(noise, _)| noise);
    let of = fitted.unwrap_or(default);
    let drawn = |fitted: f64, default: f64| (n * fitted + WEIGHT * default) / (n + WEIGHT);
    FleetNoise {
        noise: NoiseParameters {
            phi: drawn(of.phi, default.phi),
            walk: drawn(of.walk * of.walk, default.walk * default.walk).sqrt(),
            of_fleet: fitted.is_some(),
        },
        fitted,
        scatter: best.map(|(_, scatter)| scatter),
        cells,
        coefficients: still.len(),
        moving: all - still.len(),
        spacings,
    }
}

fn stretches_of(series: &Series) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for column in 0..2 {
        for cells in series.undisturbed_cells() {
            let begin = cells[0].first;
            let point = |cell: &crate::core::judge::cells::Cell| {
                let (days, value) = cell.mean(column);
                ((cell.first.days_since(begin) + days) / DAYS_A_YEAR, value)
            };
            stretches.push(cells.iter().map(point).collect());
        }
    }
    stretches.retain(|stretch| stretch.len() > LAGS[0]);
    stretches
}

/// Leaves out what moves. Only stretches of the same length are compared: a short one has no long lag.
fn without_moving(stretches: Vec<Stretch>) -> Vec<Stretch> {
    let longest = |stretch: &Stretch| LAGS.iter().rev().copied().find(|lag| stretch.len() > *lag).unwrap_or(LAGS[0]);
    let mean_square = |stretch: &Stretch| {
        let lag = longest(stretch);
        let squares = stretch.iter().zip(&stretch[lag..]).map(|(a, b)| (b.1 - a.1) * (b.1 - a.1));
        squares.sum::<f64>() / (stretch.len() - lag) as f64
    };
    let mut limits = std::collections::BTreeMap::<usize, Vec<f64>>::new();
    for stretch in &stretches {
        limits.entry(longest(stretch)).or_default().push(mean_square(stretch));
    }
    let limits: std::collections::BTreeMap<usize, f64> =
        limits.into_iter().filter_map(|(lag, mut squares)| Some((lag, MOVES * median(&mut squares)?))).collect();
    let still = |stretch: &Stretch| limits.get(&longest(stretch)).is_none_or(|limit| mean_square(stretch) <= *limit);
    stretches.into_iter().filter(still).collect()
}

fn spacing(stretches: &[Stretch], lag: usize) -> Option<Spacing> {
    let pairs = stretches.iter().filter(|stretch| stretch.len() > lag).flat_map(|s| s.iter().zip(&s[lag..]));
    let (years, mut sizes): (Vec<f64>, Vec<f64>) = pairs.map(|(a, b)| (b.0 - a.0, (b.1 - a.1).abs())).unzip();
    let differences = sizes.len();
    let size = median(&mut sizes).filter(|size| differences >= LEAST_DIFFERENCES && *size > 0.0)?;
    let years = years.iter().sum::<f64>() / differences as f64;
    Some(Spacing { lag, years, half_square: 0.5 * (SD_OF_MEDIAN * size).powi(2), differences })
}

/// The noise, and the scatter s.
fn fit(spacings: &[Spacing]) -> Option<(NoiseParameters, f64)> {
    let of_phi = |phi: f64| {
        // Relative errors: a s^2 + b q^2 against 1.
        let rows = spacings
            .iter()
            .map(|of| ((1.0 - phi.powi(of.lag as i32)) / of.half_square, 0.5 * of.years / of.half_square));
        let (mut aa, mut ab, mut bb, mut a, mut b) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (of_s, of_q) in rows.clone() {
            aa += of_s * of_s;
            ab += of_s * of_q;
            bb += of_q * of_q;
            a += of_s;
            b += of_q;
        }
        let determinant = aa * bb - ab * ab;
        let (mut s2, mut q2) = ((a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant);
        if !(s2 >= 0.0 && q2.is_finite()) {
            (s2, q2) = (0.0, b / bb);
        }
        if q2 < 0.0 {
            (s2, q2) = (a / aa, 0.0);
        }
        let misfit: f64 = rows.map(|(of_s, of_q)| (of_s * s2 + of_q * q2 - 1.0).powi(2)).sum();
        (misfit, phi, s2, q2)
    };
    let all = (0..=95).map(|hundredth| of_phi(f64::from(hundredth) / 100.0));
    let (misfit, phi, s2, q2) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    misfit.is_finite().then(|| (NoiseParameters { phi, walk: q2.sqrt(), of_fleet: true }, s2.sqrt()))
}
