//! A straight line through cells, its standard deviations under the noise model, and where it leads.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::core::judge::cells::{CELLS, DAYS_A_YEAR, Point};
use crate::core::judge::noise::{NoiseParameters, ScatterPrior};
use crate::core::judge::rules::baseline::BaselineLevel;
use crate::core::judge::sample::{BASELINE_RECORDS, Measured};
use crate::core::numerics::normal::normal_quantile;
use crate::core::time::UtcMicros;

/// Cells that may be left out,
const MOST_LEFT_OUT: usize = 2;
/// and the standard deviations that each must be off the line through the others.
const LEFT_OUT_AT: f64 = 4.0;
/// Standard deviations from the baseline that say that a course had begun.
const BEGUN: f64 = 2.0;
/// Confidence of the dates, from both sides.
const DATES: f64 = 0.975;

type Weights = [f64; CELLS];

/// Least squares through the cells that were not left out. Times in years before the judged record, so the line's
/// value there is the level now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    noise: &'a NoiseParameters,
    /// Standard deviation of what one station adds.
    between: f64,
    /// Cells that it was asked of.
    cells: usize,
    first: UtcMicros,
    /// The first `n` are those that were not left out.
    points: [Point; CELLS],
    n: usize,
    mean_t: f64,
    /// Sum of squared times about their mean.
    spread: f64,
    mean_x: f64,
    slope: f64,
    /// s^2.
    variance: f64,
    /// Degrees of freedom of s^2, the prior's among them.
    freedom: f64,
    /// In its standard deviations.
    bend: f64,
}

impl<'a> Line<'a> {
    /// Least squares through the points, the outliers among them left out. `prior` is on the variance of their scatter,
    /// `between` the standard deviation of one station's offset, deg/(h g0).
    pub fn through(points: &[Point], noise: &'a NoiseParameters, prior: ScatterPrior, between: f64) -> Self {
        let mut line = Self {
            noise,
            between,
            cells: points.len(),
            first: points[0].first,
            points: [points[0]; CELLS],
            n: points.len(),
            mean_t: 0.0,
            spread: 0.0,
            mean_x: 0.0,
            slope: 0.0,
            variance: 0.0,
            freedom: 0.0,
            bend: 0.0,
        };
        line.points[..points.len()].copy_from_slice(points);
        line.fit();
        for _ in 0..MOST_LEFT_OUT {
            let Some(outlier) = line.outlier(prior) else { break };
            line.leave_out(outlier);
            line.fit();
        }
        line.weigh(prior);
        line
    }

    fn fit(&mut self) {
        let (points, n) = (&self.points[..self.n], self.n as f64);
        self.mean_t = points.iter().map(|one| one.t).sum::<f64>() / n;
        self.mean_x = points.iter().map(|one| one.x).sum::<f64>() / n;
        self.spread = points.iter().map(|one| (one.t - self.mean_t).powi(2)).sum();
        let product: f64 = points.iter().map(|one| (one.t - self.mean_t) * (one.x - self.mean_x)).sum();
        self.slope = if self.spread > 0.0 { product / self.spread } else { 0.0 };
    }

    fn residual(&self, i: usize) -> f64 {
        self.points[i].x - self.mean_x - self.slope * self.since_mean(i)
    }

    /// Of a cell's time from the mean of all.
    fn since_mean(&self, i: usize) -> f64 {
        self.points[i].t - self.mean_t
    }

    fn squares(&self) -> f64 {
        (0..self.n).map(|i| self.residual(i).powi(2)).sum()
    }

    /// The cell that is farthest off the line through the others, if far enough; scatter is that of the others.
    fn outlier(&self, prior: ScatterPrior) -> Option<usize> {
        let (n, squares) = (self.n as f64, self.squares());
        let off = |i: usize| {
            let leverage = 1.0 / n + self.since_mean(i).powi(2) / self.spread;
            let own = self.residual(i).powi(2) / (1.0 - leverage).max(1e-6);
            let rest = ((squares - own).max(0.0) / (n - 3.0).max(1.0)).max(prior.least * prior.least);
            own / rest
        };
        let all = (0..self.n).map(|i| (i, off(i)));
        all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, off)| *off > LEFT_OUT_AT * LEFT_OUT_AT).map(|(i, _)| i)
    }

    fn leave_out(&mut self, i: usize) {
        self.points.copy_within(i + 1..self.n, i);
        self.n -= 1;
    }

    /// Scatter, and the bend in its standard deviations.
    fn weigh(&mut self, prior: ScatterPrior) {
        let n = self.n as f64;
        let (mean, slope) = (self.mean_weights(), self.slope_weights());
        let (of_mean, of_slope) = (self.of_scatter(&mean, &mean), self.of_scatter(&slope, &slope));
        let independent = n - n * of_mean - self.spread * of_slope;
        self.variance = prior.variance(self.squares(), independent);
        self.freedom = n + 3.0;
        let bend = self.bend_weights();
        let value: f64 = bend.iter().zip(&self.points[..self.n]).map(|(w, point)| w * point.x).sum();
        let variance = self.variance_of(&bend);
        self.bend = if variance > 0.0 { value / variance.sqrt() } else { 0.0 };
    }

    /// Zero beyond the cells that were not left out.
    fn weights(&self, of: impl Fn(usize) -> f64) -> Weights {
        std::array::from_fn(|i| if i < self.n { of(i) } else { 0.0 })
    }

    fn mean_weights(&self) -> Weights {
        self.weights(|_| 1.0 / self.n as f64)
    }

    fn slope_weights(&self) -> Weights {
        self.weights(|i| if self.spread > 0.0 { self.since_mean(i) / self.spread } else { 0.0 })
    }

    /// Of the line's value at the judged record.
    fn level_weights(&self) -> Weights {
        let (mean, slope) = (self.mean_weights(), self.slope_weights());
        self.weights(|i| mean[i] - self.mean_t * slope[i])
    }

    /// The part of t^2 that is orthogonal to 1 and t.
    fn bend_weights(&self) -> Weights {
        let square = |i: usize| self.since_mean(i).powi(2);
        let mean = self.spread / self.n as f64;
        let skew: f64 = (0..self.n).map(|i| self.since_mean(i) * square(i)).sum::<f64>() / self.spread;
        self.weights(|i| square(i) - mean - skew * self.since_mean(i))
    }

    fn of_scatter(&self, u: &Weights, w: &Weights) -> f64 {
        self.noise.of_scatter(&u[..self.n], &w[..self.n])
    }

    fn of_walk(&self, u: &Weights, w: &Weights) -> f64 {
        self.noise.of_walk(|i| self.points[i].t, &u[..self.n], &w[..self.n])
    }

    /// The cells' stations, each with a weight; nothing where stations do not differ.
    fn at_stations(&self, weights: &Weights) -> Vec<(Option<u32>, f64)> {
        let n = if self.between == 0.0 { 0 } else { self.n };
        self.points.iter().map(|point| point.station).zip(weights.iter().copied()).take(n).collect()
    }

    /// What stations bring into two sums of figures, a covariance: those of a station share its offset. Nothing where
    /// all are of one station.
    fn of_stations(&self, u: &[(Option<u32>, f64)], v: &[(Option<u32>, f64)]) -> f64 {
        if self.between == 0.0 || u.iter().chain(v).all(|(station, _)| *station == u[0].0) {
            return 0.0;
        }
        let product = |(station, u): &(Option<u32>, f64)| {
            u * v.iter().filter(|(of, _)| of == station).map(|(_, v)| v).sum::<f64>()
        };
        self.between * self.between * u.iter().map(product).sum::<f64>()
    }

    /// Of a sum of the cells whose weights add up to zero.
    fn variance_of(&self, weights: &Weights) -> f64 {
        let stations = self.at_stations(weights);
        self.variance * self.of_scatter(weights, weights)
            + self.of_walk(weights, weights)
            + self.of_stations(&stations, &stations)
    }

    /// Those that were left out among them.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// When the oldest cell begins.
    pub fn first(&self) -> UtcMicros {
        self.first
    }

    /// From the oldest cell to the judged record, days.
    pub fn span_days(&self) -> f64 {
        -self.points[0].t * DAYS_A_YEAR
    }

    /// How far the course bends, in standard deviations of that.
    pub fn bend(&self) -> f64 {
        self.bend
    }

    /// deg/(h g0) a year.
    pub fn slope(&self) -> Measured {
        Measured { value: self.slope, sd: Some(self.variance_of(&self.slope_weights()).sqrt()) }
    }

    /// Whether the slope differs from zero at this two-sided confidence.
    pub fn has_slope(&self, confidence: f64) -> bool {
        let Measured { value, sd } = self.slope();
        value.abs() > normal_quantile(0.5 + 0.5 * confidence) * sd.unwrap_or(0.0)
    }

    /// Its value at the judged record.
    pub fn now(&self) -> f64 {
        self.mean_x - self.slope * self.mean_t
    }

    /// First record of the cell at which a change of level explains the figures better (by least squares) than the
    /// line does.
    pub fn step_that_fits_better(&self) -> Option<UtcMicros> {
        let n = self.n as f64;
        let explained_by_line = self.slope * self.slope * self.spread;
        // A step between two groups explains n1 n2/n (difference of their means)^2 = n/(n1 n2) (sum over one group)^2.
        let mut sum = 0.0;
        let explained_by_step = (1..self.n).map(|first| {
            sum += self.points[first - 1].x - self.mean_x;
            let n1 = first as f64;
            (sum * sum * n / (n1 * (n - n1)), first)
        });
        let best = explained_by_step.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > explained_by_line).then_some(self.points[best.1].first)
    }
}

/// The deviation from the baseline, carried on from the judged record: variance v0 + (2 c + q^2) tau + vb tau^2, tau
/// in years.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinePrediction {
    deviation: f64,
    per_year: f64,
    v0: f64,
    v1: f64,
    vb: f64,
    freedom: f64,
    /// Of v0, v1 and vb what stations bring.
    stations: [f64; 3],
}

impl LinePrediction {
    /// The scatter's part weighs the cells as the line does, less those that make the baseline. The walk's part
    /// weighs them as the line does, less the newest: the walk from the baseline to the judged record is no error,
    /// the gyro is there. Stations' part weighs cells and baseline as the scatter's does.
    pub fn of(line: &Line<'_>, level: &BaselineLevel, now: UtcMicros) -> Self {
        let (slope, of_now) = (line.slope_weights(), line.level_weights());
        let (in_window, apart) = baseline_weights(line, level, now);
        let of_scatter = line.weights(|i| of_now[i] - in_window[i]);
        let mut of_walk = of_now;
        of_walk[line.n - 1] -= 1.0;
        let of_level = match level.since {
            Some(_) => line.variance * (line.noise.of_scatter(&apart, &apart) + line.noise.median_excess()),
            None => level.level.sd.map_or(0.0, |sd| sd * sd),
        };
        let part = |u: &Weights, v: &Weights, walk_u: &Weights, walk_v: &Weights| {
            line.variance * line.of_scatter(u, v) + line.of_walk(walk_u, walk_v)
        };
        let of_baseline = level.records.iter().flatten();
        let of_baseline = of_baseline.map(|record| (Some(record.station), -1.0 / BASELINE_RECORDS as f64));
        let here: Vec<_> = line.at_stations(&of_now).into_iter().chain(of_baseline).collect();
        let ahead = line.at_stations(&slope);
        let stations =
            [line.of_stations(&here, &here), 2.0 * line.of_stations(&here, &ahead), line.of_stations(&ahead, &ahead)];
        let walk = line.noise.walk;
        Self {
            deviation: line.now() - level.level.value,
            per_year: line.slope,
            v0: part(&of_scatter, &of_scatter, &of_walk, &of_walk) + of_level + stations[0],
            v1: 2.0 * part(&of_scatter, &slope, &of_walk, &slope) + walk * walk + stations[1],
            vb: part(&slope, &slope, &slope, &slope) + stations[2],
            freedom: line.freedom,
            stations,
        }
    }

    /// What of the standard deviation so many days ahead comes from different stations.
    pub fn between_stations(&self, days: f64) -> Option<f64> {
        let (years, [v0, v1, vb]) = (days / DAYS_A_YEAR, self.stations);
        Some(v0 + years * (v1 + years * vb)).filter(|variance| *variance > 0.0).map(f64::sqrt)
    }

    /// Deviation from the baseline so many days after the judged record, deg/(h g0).
    pub fn at(&self, days: f64) -> Measured {
        let years = days / DAYS_A_YEAR;
        let variance = self.v0 + years * (self.v1 + years * self.vb);
        Measured { value: self.deviation + self.per_year * years, sd: Some(variance.max(0.0).sqrt()) }
    }

    /// Whether the deviation was there, on the side that it moves to, so many days ago. Of a course that began later,
    /// the line starts off on the other side of the baseline.
    pub fn had_begun(&self, days: f64) -> bool {
        let Measured { value, sd } = self.at(-days);
        value * self.per_year.signum() > BEGUN * sd.unwrap_or(0.0)
    }

    /// Days until the deviation reaches the budget on the side that it moves to: by the edge of its 95 % band that
    /// comes first, by the line, and by the edge that comes last. 0 where it is there already, none where it never
    /// is.
    pub fn reaches(&self, budget: f64) -> [Option<f64>; 3] {
        let (left, rate) = (budget - self.deviation * self.per_year.signum(), self.per_year.abs());
        let t = StudentsT::new(0.0, 1.0, self.freedom).map_or(normal_quantile(DATES), |t| t.inverse_cdf(DATES));
        // (left - rate tau)^2 = t^2 (v0 + v1 tau + vb tau^2): the band's edges meet the budget.
        let [a, b, c] =
            [rate * rate - t * t * self.vb, -2.0 * left * rate - t * t * self.v1, left * left - t * t * self.v0];
        let middle = left / rate;
        let discriminant = b * b - 4.0 * a * c;
        let (first, last) = if discriminant < 0.0 {
            (0.0, f64::INFINITY)
        } else {
            // The form without cancellation.
            let q = -0.5 * (b + discriminant.sqrt().copysign(b));
            let (one, other) = (c / q, q / a);
            let (low, high) = (one.min(other), one.max(other));
            // A slope that is not certain to rise meets the budget late or never.
            if a > 0.0 { (low, high) } else { (high.min(middle), f64::INFINITY) }
        };
        [first, middle, last].map(|years| Some(years.max(0.0) * DAYS_A_YEAR).filter(|days| days.is_finite()))
    }
}

/// Weights of the records that make the baseline, on the cells of the line that hold them, and of those that came
/// before it.
fn baseline_weights(line: &Line<'_>, level: &BaselineLevel, now: UtcMicros) -> (Weights, [f64; BASELINE_RECORDS]) {
    let (mut inside, mut apart) = ([0.0; CELLS], [0.0; BASELINE_RECORDS]);
    let Some(records) = level.records else { return (inside, apart) };
    let share = 1.0 / BASELINE_RECORDS as f64;
    for (place, at) in records.iter().map(|record| record.at).enumerate() {
        let cell = line.points[..line.n].partition_point(|point| point.first <= at);
        match cell.checked_sub(1) {
            Some(cell) if at <= now => inside[cell] += share,
            _ => apart[place] = share,
        }
    }
    (inside, apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::numerics::bisection::bisect;

    /// By bisection, where the band's edge `sign` t sd meets the budget.
    fn meets(forecast: &LinePrediction, budget: f64, sign: f64) -> Option<f64> {
        let t = StudentsT::new(0.0, 1.0, forecast.freedom).unwrap().inverse_cdf(DATES);
        let edge = |days: f64| {
            let Measured { value, sd } = forecast.at(days);
            value + sign * t * sd.unwrap() - budget
        };
        (edge(1e6) >= 0.0).then(|| bisect(0.0, 1e6, 200, |days| edge(days) < 0.0).1)
    }

    #[test]
    fn dates_are_where_the_edges_of_the_band_meet_the_budget() {
        let budget = 0.01;
        for (v0, v1, vb) in
            [(1e-7, 0.0, 1e-7), (4e-7, -1e-7, 9e-7), (1e-7, 5e-7, 2e-7), (1e-8, 1e-6, 1e-6), (1e-7, 0.0, 9e-6)]
        {
            let forecast =
                LinePrediction { deviation: 0.002, per_year: 0.006, v0, v1, vb, freedom: 11.0, stations: [0.0; 3] };
            let [first, middle, last] = forecast.reaches(budget);
            assert!((middle.unwrap() - 0.008 / 0.006 * DAYS_A_YEAR).abs() < 1e-6);
            let near = |what: &str, got: Option<f64>, expected: Option<f64>| match (got, expected) {
                (Some(got), Some(expected)) => assert!((got / expected - 1.0).abs() < 1e-6, "{what}: {got} {expected}"),
                (got, expected) => assert_eq!(got, expected, "{what} of {forecast:?}"),
            };
            near("first", first, meets(&forecast, budget, 1.0));
            near("last", last, meets(&forecast, budget, -1.0));
        }
        let falling = LinePrediction {
            deviation: -0.002,
            per_year: -0.006,
            v0: 1e-7,
            v1: 5e-7,
            vb: 2e-7,
            freedom: 11.0,
            stations: [0.0; 3],
        };
        let rising = LinePrediction { deviation: 0.002, per_year: 0.006, ..falling };
        assert_eq!(falling.reaches(budget), rising.reaches(budget), "the side makes no difference");
    }

    fn prior() -> ScatterPrior {
        ScatterPrior { scatter: 1e-4, least: 1e-6 }
    }

    #[test]
    fn a_straight_line_has_no_bend_at_uneven_times() {
        let noise = NoiseParameters { phi: 0.0, walk: 0.0, of_fleet: true };
        let t = [-9.0, -4.0, -2.0, -1.0, -0.5, 0.0];
        let bend = |x: fn(f64) -> f64| {
            let points = t.map(|t| Point { first: UtcMicros(0), t, station: Some(1), x: x(t), sd: None });
            Line::through(&points, &noise, prior(), 0.0).bend
        };
        assert!(bend(|t| 3.0 + 2.0 * t).abs() < 1e-6, "{}", bend(|t| 3.0 + 2.0 * t));
        assert!(bend(|t| 1e-2 * t * t) > 1.0 && bend(|t| -1e-2 * t * t) < -1.0);
    }

    #[test]
    fn a_point_is_left_out_by_the_scatter_of_the_others() {
        // Level but for +-1 by turns and one that is off by `off`: its distance from the others in their standard
        // deviations is known to fit between 4 sqrt((n - 3)/n) and 4 by the choice of `off`.
        let noise = NoiseParameters { phi: 0.0, walk: 0.0, of_fleet: true };
        let line = |off: f64| {
            let x = |i: i32| if i % 2 == 0 { 1.0 } else { -1.0 } + if i == 6 { off } else { 0.0 };
            let point = |i| Point { first: UtcMicros(0), t: f64::from(i) - 11.0, station: Some(1), x: x(i), sd: None };
            let points: Vec<Point> = (0..12).map(point).collect();
            Line::through(&points, &noise, prior(), 0.0).n
        };
        // Through the eleven others by hand: their line and its residuals' sum of squares over n - 3 = 9.
        let others: Vec<(f64, f64)> =
            (0..12).filter(|i| *i != 6).map(|i| (f64::from(i) - 11.0, if i % 2 == 0 { 1.0 } else { -1.0 })).collect();
        let (mt, mx) = (others.iter().map(|p| p.0).sum::<f64>() / 11.0, others.iter().map(|p| p.1).sum::<f64>() / 11.0);
        let sxx: f64 = others.iter().map(|p| (p.0 - mt).powi(2)).sum();
        let slope = others.iter().map(|p| (p.0 - mt) * (p.1 - mx)).sum::<f64>() / sxx;
        let rest: f64 = others.iter().map(|p| (p.1 - mx - slope * (p.0 - mt)).powi(2)).sum::<f64>() / 9.0;
        let ahead = 1.0 + 1.0 / 11.0 + (-5.0 - mt).powi(2) / sxx;
        // The predicted residual at its place over the square root of its variance is 4 exactly here.
        let at_four = 4.0 * (rest * ahead).sqrt() + mx + slope * (-5.0 - mt) - 1.0;
        assert_eq!([line(at_four * 0.999), line(at_four * 1.001)], [12, 11]);
    }
}
