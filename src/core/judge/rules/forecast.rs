//! `forecast`: a campaign against what the adopted model of its IMU has foretold of it, gyro by gyro. Of the IMU, and
//! not of one of its gyros.
//!
//! The n errors of a gyro, each over its standard deviation given those before it (coefficients, what they do from
//! campaign to campaign, noise), are independent and of unit variance where nothing has changed. Their sum of squares
//! is chi-square, or n F(n, dof) where the noise was estimated. Of m gyros the one with the smallest p is judged, which
//! must lie below [`FALSE_ALARMS`]/m (Bonferroni).
//!
//! A step `d` of D_I or D_S adds `d^2 noncentrality` to the sum. A forecast that would not show a step of the
//! limit says nothing of a gyro that lies within, nor one of conditions that the model has not seen of any gyro: but for
//! errors that nothing plausible makes there. Nor does one that came true only where the model has seen the like.

use crate::core::judge::{Coefficient, Finding, Limit, Rule, State, Unseen, Verdict};
use crate::core::mounting::Slot;
use crate::core::numerics::tails::{squares_quantile, squares_tail};

/// Share of campaigns without a change that are told. Few, for the noise is never quite as the model has it.
pub const FALSE_ALARMS: f64 = 0.002;
/// 95 % of the normal distribution: the probability with which a step is to be seen.
const SEEN: f64 = 1.644_853_627;

/// A gyro of the campaign against its forecast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroForecastErrors {
    pub slot: Slot,
    /// Dwells that were foretold.
    pub count: usize,
    /// Degrees of freedom that its noise is known by.
    pub dof: f64,
    /// Of the independent errors over their standard deviations.
    pub squares: f64,
    /// What a step of D_I and of D_S of 1 deg/(h g0) adds to `squares`.
    pub noncentrality: [f64; 2],
    /// Where most dwells are unlike those seen: number and sum of squares as they are with all that temperature may
    /// plausibly do beyond.
    pub beyond_seen: Option<(usize, f64)>,
    /// The dwell that is furthest from its forecast, and its error over its standard deviation.
    pub furthest: Option<(usize, f64)>,
}

/// A campaign against its forecast.
#[derive(Debug, Clone, PartialEq)]
pub struct ForecastErrors {
    pub gyros: Vec<GyroForecastErrors>,
    /// Campaigns that the model was fitted to: one does not know what changes between campaigns.
    pub campaigns: usize,
    /// What the model has not seen, where no dwell is judged by itself for that.
    pub unseen: Option<Unseen>,
    /// What it has not seen of dwells that are not judged, where their errors contradict the forecast.
    pub contradicted: Option<Unseen>,
}

/// Judges a campaign against its forecast; `limits`: the steps of D_I and D_S that it is to show. None where no gyro
/// was foretold, or nobody asks.
pub fn forecast(errors: &ForecastErrors, limits: [Option<Limit>; 2]) -> Option<Verdict> {
    let from = limits.into_iter().flatten().next()?.from;
    let gyros: Vec<&GyroForecastErrors> = errors.gyros.iter().filter(|gyro| gyro.count > 0).collect();
    let each = FALSE_ALARMS / gyros.len() as f64;
    let p_of = |gyro: &GyroForecastErrors| squares_tail(gyro.squares, gyro.count, gyro.dof);
    let p_beyond = |gyro: &GyroForecastErrors| {
        gyro.beyond_seen.map_or(1.0, |(count, squares)| squares_tail(squares, count, gyro.dof))
    };
    let worst_by = |p: &dyn Fn(&GyroForecastErrors) -> f64| {
        gyros.iter().copied().map(|gyro| (gyro, p(gyro))).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let beyond = worst_by(&p_beyond).filter(|(_, p)| errors.unseen.is_some() && *p < each);
    let is_beyond = beyond.is_some();
    let (worst, p) = beyond.or_else(|| worst_by(&p_of))?;
    let (count, squares) = worst.beyond_seen.filter(|_| is_beyond).unwrap_or((worst.count, worst.squares));
    let quantile = |gyro: &GyroForecastErrors| squares_quantile(each, gyro.count, gyro.dof);
    let shown = gyros.iter().flat_map(|gyro| {
        let step = smallest_step(gyro, quantile(gyro));
        [0, 1].map(|column| limits[column].map(|limit| (step[column], limit.value)))
    });
    let (step, budget) = shown.flatten().max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))?;
    let state = match (errors.unseen, p < each) {
        (Some(_), _) if is_beyond => State::Exceeded,
        (Some(_), _) => State::Indeterminate,
        (None, true) => State::Exceeded,
        (None, false) if step > budget || errors.contradicted.is_some() => State::Indeterminate,
        (None, false) => State::Within,
    };
    let limit = Limit { value: (squares_quantile(each, count, worst.dof) / count as f64).sqrt(), from };
    let finding = Finding::Forecast {
        slot: worst.slot,
        furthest: worst.furthest,
        p: (p * gyros.len() as f64).min(1.0),
        step: step.is_finite().then_some(step),
        campaigns: errors.campaigns,
        unseen: errors.unseen.or(errors.contradicted.filter(|_| state == State::Indeterminate)),
    };
    let undecided = Verdict::undecided(Coefficient::All, Rule::Forecast, limit, finding);
    Some(Verdict { state, value: Some((squares / count as f64).sqrt()), ..undecided })
}

/// The steps of D_I and D_S, deg/(h g0), that exceed `quantile` in 95 %: a noncentral chi-square as a normal variable
/// of mean n + l and variance 2n + 4l, l = `d^2 noncentrality` (Patnaik 1949).
fn smallest_step(gyro: &GyroForecastErrors, quantile: f64) -> [f64; 2] {
    let half = 0.5 * gyro.count as f64;
    // n + l - 2 SEEN sqrt(n/2 + l) = quantile, in sqrt(n/2 + l).
    let root = SEEN + (SEEN * SEEN + quantile - half).max(0.0).sqrt();
    gyro.noncentrality.map(|noncentrality| ((root * root - half) / noncentrality).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::LimitKey;

    const LIMIT: Limit = Limit { value: 0.01, from: LimitKey::BUDGET };

    fn gyro(slot: Slot, squares: f64) -> GyroForecastErrors {
        let noncentrality = [4e6, 4e6];
        GyroForecastErrors {
            slot,
            count: 100,
            dof: f64::INFINITY,
            squares,
            noncentrality,
            beyond_seen: None,
            furthest: Some((7, 3.5)),
        }
    }

    fn errors_of(squares: [f64; 3]) -> ForecastErrors {
        let gyros = [Slot::G1, Slot::G2, Slot::G3].into_iter().zip(squares).map(|(slot, of)| gyro(slot, of));
        ForecastErrors { gyros: gyros.collect(), campaigns: 3, unseen: None, contradicted: None }
    }

    fn judged(errors: &ForecastErrors) -> Verdict {
        forecast(errors, [Some(LIMIT); 2]).unwrap()
    }

    #[test]
    fn one_gyro_of_three_must_be_three_times_as_unlikely() {
        // P(chi-square of 100 > 140.169) = 0.005, > 149.449 = 0.001, > 153.167 = 0.0005 (Abramowitz and Stegun 26.8).
        for (squares, state) in [(100.0, State::Within), (149.0, State::Within), (154.0, State::Exceeded)] {
            let verdict = judged(&errors_of([squares, 90.0, 110.0]));
            assert_eq!(verdict.state, state, "{squares}");
        }
        let verdict = judged(&errors_of([90.0, 160.0, 155.0]));
        let Finding::Forecast { slot, furthest, p, .. } = verdict.finding else { panic!("{verdict:?}") };
        assert_eq!((slot, furthest, verdict.confirmed), (Slot::G2, Some((7, 3.5)), false));
        assert!(p < 0.002 && (verdict.value.unwrap() - 1.6_f64.sqrt()).abs() < 1e-12);
        assert!((1.49449..1.53167).contains(&verdict.limit.powi(2)), "{}", verdict.limit);
        let alone = ForecastErrors { gyros: vec![gyro(Slot::G1, 149.5)], ..errors_of([0.0; 3]) };
        assert_eq!(judged(&alone).state, State::Exceeded, "of one gyro the limit is below 149.449");
    }

    #[test]
    fn a_noise_known_by_few_dwells_needs_more() {
        let mut few = errors_of([160.0, 90.0, 110.0]);
        few.gyros.iter_mut().for_each(|gyro| gyro.dof = 20.0);
        assert_eq!(judged(&few).state, State::Within);
    }

    #[test]
    fn what_would_not_show_a_step_of_the_budget_says_nothing_within() {
        // 50 + (1.645 + sqrt(1.645^2 + 101.7))^2 - 100 = 90.7 over the quantile of 151.7.
        let mut wide = errors_of([100.0, 90.0, 110.0]);
        let Finding::Forecast { step: Some(step), .. } = judged(&wide).finding else { panic!() };
        assert!((step * step * 4e6 - 90.7).abs() < 1.0, "{step}");
        wide.gyros[2].noncentrality[1] = 4e5;
        assert_eq!(judged(&wide).state, State::Indeterminate);
        assert_eq!(judged(&wide).status(), crate::core::judge::Status::TooUncertain);
        wide.gyros[0].squares = 160.0;
        assert_eq!(judged(&wide).state, State::Exceeded, "what is outside is outside however wide");
        wide.gyros[2].noncentrality[1] = 0.0;
        let Finding::Forecast { step: None, .. } = judged(&wide).finding else { panic!("no step would show") };
        let loose = Limit { value: 0.1, ..LIMIT };
        let within = errors_of([100.0, 90.0, 110.0]);
        assert_eq!(forecast(&within, [Some(loose), None]).unwrap().state, State::Within);
        assert_eq!(forecast(&within, [None, None]), None, "switched off");
    }

    #[test]
    fn what_is_within_where_it_was_seen_and_far_off_elsewhere_is_not_decided() {
        let mut errors = ForecastErrors { contradicted: Some(Unseen::Rate), ..errors_of([100.0, 90.0, 110.0]) };
        let verdict = judged(&errors);
        assert_eq!(verdict.state, State::Indeterminate);
        assert!(matches!(verdict.finding, Finding::Forecast { unseen: Some(Unseen::Rate), .. }));
        errors.gyros[1].squares = 160.0;
        let verdict = judged(&errors);
        assert_eq!(verdict.state, State::Exceeded, "what was seen is outside");
        assert!(matches!(verdict.finding, Finding::Forecast { unseen: None, .. }));
    }

    #[test]
    fn what_the_model_has_not_seen_it_cannot_foretell() {
        let unseen = ForecastErrors { unseen: Some(Unseen::Temperature), ..errors_of([400.0, 90.0, 110.0]) };
        let verdict = judged(&unseen);
        assert_eq!((verdict.state, verdict.severity()), (State::Indeterminate, None));
        let mut far = unseen.clone();
        far.gyros.iter_mut().for_each(|gyro| gyro.beyond_seen = Some((60, 70.0)));
        assert_eq!(judged(&far).state, State::Indeterminate, "temperature may have done that");
        far.gyros[1].beyond_seen = Some((60, 200.0));
        let verdict = judged(&far);
        assert_eq!(verdict.state, State::Exceeded, "nothing plausible reaches that far");
        assert!(matches!(verdict.finding, Finding::Forecast { slot: Slot::G2, unseen: Some(Unseen::Temperature), .. }));
        assert_eq!(forecast(&ForecastErrors { gyros: Vec::new(), ..unseen }, [Some(LIMIT); 2]), None);
    }
}
