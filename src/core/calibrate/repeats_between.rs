//! What repeats from campaign to campaign of one IMU: whether stated standard deviations hold between campaigns.

use nalgebra::{Rotation3, Vector3};

use super::outcome::Outcome;
use super::uncertainty::UncertaintyBudget;
use crate::core::campaign::Campaign;
use crate::core::model::Term;
use crate::core::mounting::Slot;
use crate::core::name::Name;
use crate::core::numerics::between::{Mean, Observation, Quantity, Scatter, means};
use crate::core::numerics::tails::chi2_quantile;
use crate::core::separate::separate;

/// One coefficient over several campaigns.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeated {
    pub slot: Slot,
    pub serial: Name,
    /// D_I, D_S, D_O, |E| or D_F.
    pub coefficient: &'static str,
    pub unit: &'static str,
    /// Campaigns that determine it.
    pub campaigns: usize,
    /// Weighted by 1/(sd^2 + tau^2).
    pub mean: f64,
    /// Of that mean, with what campaigns may differ by where a coefficient in the same unit shows that they do. A
    /// station's own part is the same in all of its campaigns, and what the model leaves out in all: neither averages
    /// out.
    pub sd: f64,
    /// Root mean square of the stated standard deviations, and standard deviation of the values about their mean.
    pub stated_sd: f64,
    pub scatter_sd: f64,
    pub scatter: Scatter,
    /// tau: what campaigns differ by beyond what is stated; zero within chance (p >= 0.05).
    pub beyond_sd: f64,
}

/// The coefficients of one gyro, by their places in [`COEFFICIENTS`]: what campaigns determine of each, with the
/// standard deviation that each value has of what the model leaves out.
type Values = [Vec<(Observation, f64)>; COEFFICIENTS.len()];

impl Repeated {
    /// Real over stated standard deviation, sqrt(Q/dof).
    pub fn ratio(&self) -> f64 {
        (self.scatter.chi2 / self.scatter.dof as f64).sqrt()
    }

    /// Interval of that ratio, 95 %: sqrt(Q/chi2_q) for the quantiles 0.975 and 0.025.
    pub fn ratio_interval(&self) -> [f64; 2] {
        [0.975, 0.025].map(|q| (self.scatter.chi2 / chi2_quantile(q, self.scatter.dof as f64)).sqrt())
    }

    /// None of fewer than two values.
    fn of(
        (slot, serial): (Slot, &Name),
        (coefficient, unit): (&'static str, &'static str),
        (values, left_out): (&[Observation], &[f64]),
        mean: Mean,
    ) -> Option<Self> {
        let scatter = Scatter::of(values)?;
        let n = values.len() as f64;
        let plain = values.iter().map(|v| v.value).sum::<f64>() / n;
        let squares = values.iter().map(|v| (v.value - plain).powi(2)).sum::<f64>();
        let stated = values.iter().map(|v| v.sd.powi(2) + v.shared_sd.powi(2)).sum::<f64>() / n;
        Some(Self {
            slot,
            serial: serial.clone(),
            coefficient,
            unit,
            campaigns: values.len(),
            mean: mean.value,
            sd: with_all_left_out(mean.sd, scatter.beyond(), values, left_out),
            stated_sd: stated.sqrt(),
            scatter_sd: (squares / (n - 1.0)).sqrt(),
            scatter,
            beyond_sd: scatter.beyond(),
        })
    }
}

/// The standard deviation `sd` of a weighted mean with the same weights w where what the model leaves out of the values
/// (s each) is the same error in all: sd^2 - sum (w s)^2 + (sum w s)^2.
fn with_all_left_out(sd: f64, tau: f64, values: &[Observation], left_out: &[f64]) -> f64 {
    let weights = || values.iter().map(|value| 1.0 / (value.sd.powi(2) + tau.powi(2)));
    let all: f64 = weights().sum();
    let parts = || weights().zip(left_out).map(|(weight, left_out)| weight / all * left_out);
    let (whole, averaged) = (parts().sum::<f64>().powi(2), parts().map(|part| part * part).sum::<f64>());
    ((sd * sd - averaged).max(0.0) + whole).sqrt()
}

/// Units of D_I, D_S, D_O, |E| and D_F.
const COEFFICIENTS: [(&str, &str); 5] =
    [("D_I", "deg/(h*g0)"), ("D_S", "deg/(h*g0)"), ("D_O", "deg/(h*g0)"), ("|E|", "pulse/arcsec"), ("D_F", "deg/h")];

/// Share of a variance, at the least, that a value has for itself.
const OF_ROUNDING: f64 = 1e-8;

/// Coefficients that may differ alike between campaigns: those of gyros in one unit.
const ALIKE: [std::ops::Range<usize>; 3] = [0..3, 3..4, 4..5];

/// Every coefficient that two campaigns or more determine, gyro by gyro. The campaigns are of one IMU.
pub fn repeated(fitted: &[(&Campaign, &Outcome)]) -> Vec<Repeated> {
    let Some((first, _)) = fitted.first() else { return Vec::new() };
    let mut stations: Vec<&Name> = fitted.iter().map(|(campaign, _)| &campaign.station).collect();
    stations.sort();
    stations.dedup();
    let mut gyros: Vec<Values> = vec![Default::default(); first.gyros.len()];
    for (campaign, outcome) in fitted {
        let group = stations.partition_point(|station| *station < &campaign.station);
        for (gyro, all) in first.gyros.iter().zip(&mut gyros) {
            for (all, value) in all.iter_mut().zip(values((campaign, outcome), gyro.slot, group)) {
                all.extend(value);
            }
        }
    }
    let mut all: Vec<Vec<Repeated>> = vec![Vec::new(); gyros.len()];
    for places in ALIKE {
        let of_gyro = |(j, values): (usize, &Values)| {
            let known = places.clone().filter(|place| values[*place].len() > 1);
            let observed = |place: usize| values[place].iter().map(|(value, _)| *value).collect();
            known.map(|place| Quantity { sets: [j, place], values: observed(place) }).collect::<Vec<_>>()
        };
        let quantities: Vec<Quantity> = gyros.iter().enumerate().flat_map(of_gyro).collect();
        for (Quantity { sets: [j, place], values }, mean) in quantities.iter().zip(means(&quantities)) {
            let gyro = &first.gyros[*j];
            let left_out: Vec<f64> = gyros[*j][*place].iter().map(|(_, left_out)| *left_out).collect();
            let of = (gyro.slot, &gyro.serial);
            all[*j].extend(Repeated::of(of, COEFFICIENTS[*place], (values, &left_out), mean));
        }
    }
    all.into_iter().flatten().collect()
}

fn values(
    (campaign, outcome): (&Campaign, &Outcome),
    slot: Slot,
    group: usize,
) -> [Option<(Observation, f64)>; COEFFICIENTS.len()] {
    let none = [None; COEFFICIENTS.len()];
    let Outcome::Imu { calibration, separations, .. } = outcome else { return none };
    let fitted = calibration.gyros.iter().zip(separations).find(|(gyro, _)| gyro.slot == slot);
    let Some((gyro, Ok(separation))) = fitted else { return none };
    let value = |value: f64, sd: Option<f64>, [shared_sd, left_out]: [f64; 2]| {
        Some((observed(value, sd?, shared_sd, group)?, left_out))
    };
    let rigid = &separation.rigid;
    let sds = rigid.sd().map_or([None; 3], |sds| sds.map(Some));
    let parts = |b: UncertaintyBudget| [b.station, b.discrepancy].map(Option::unwrap_or_default);
    let budgets = gyro.budgets(&campaign.geometry, false).map(|all| all.map(parts)).unwrap_or_default();
    let k = separation.scale_factor;
    let bias = gyro.of(Term::Bias).map(|bias| &bias[0]).filter(|bias| bias.determined);
    let of_bias = gyro.uncertainty.as_ref().and_then(|parts| parts.budgets(|c| Some([c[(0, 0)]])));
    let of_bias = of_bias.map(|[budget]| parts(budget)).unwrap_or_default().map(|sd| sd / k);
    [
        value(rigid.d_i, sds[0], budgets[0]),
        value(rigid.d_s, sds[1], budgets[1]),
        value(rigid.d_o, sds[2], budgets[2]),
        value(k, separation.scale_factor_sd, budgets[3]),
        bias.and_then(|bias| value(bias.value / k, bias.sd.map(|sd| sd / k), of_bias)),
    ]
}

/// Of the standard deviation the campaigns of a station share what the station does.
fn observed(value: f64, sd: f64, shared_sd: f64, group: usize) -> Option<Observation> {
    // Of what a station shares nearly all the rest is rounding.
    let own = (sd * sd - shared_sd * shared_sd).max(OF_ROUNDING * sd * sd);
    (sd > 0.0).then(|| Observation { value, sd: own.sqrt(), shared_sd, group })
}

/// D_S, deg/(h g0), and D_O of one gyro.
pub(super) struct OutputAxisDrift {
    pub d_s: f64,
    pub d_o: Observation,
}

/// The same with E and G turned by `rotation` (rad, body axes) first.
pub(super) fn output_axis_drift(
    campaign: &Campaign,
    outcome: &Outcome,
    slot: Slot,
    rotation: &Vector3<f64>,
) -> Option<OutputAxisDrift> {
    let Outcome::Imu { calibration, .. } = outcome else { return None };
    let gyro = calibration.gyros.iter().find(|gyro| gyro.slot == slot)?;
    let turn = Rotation3::new(*rotation);
    let (e, g) = (turn * gyro.e()?, turn * gyro.g()?);
    let rigid = separate(&campaign.geometry, slot, &e, &g, gyro.covariance_eg().as_ref()).ok()?.rigid;
    let station = gyro.budgets(&campaign.geometry, false).and_then(|all| all[2].station);
    let d_o = observed(rigid.d_o, rigid.sd()?[2], station.unwrap_or(0.0), 0)?;
    Some(OutputAxisDrift { d_s: rigid.d_s, d_o })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeated(values: &[(f64, f64, f64, usize)]) -> Repeated {
        leaving_out(0.0, values)
    }

    fn leaving_out(left_out: f64, values: &[(f64, f64, f64, usize)]) -> Repeated {
        let value = |(value, sd, shared_sd, group): &(f64, f64, f64, usize)| Observation {
            value: *value,
            sd: *sd,
            shared_sd: *shared_sd,
            group: *group,
        };
        let values: Vec<Observation> = values.iter().map(value).collect();
        let mean = means(&[Quantity { sets: [0, 0], values: values.clone() }])[0];
        let serial = Name::parse("A").expect("a name");
        let left_out = vec![left_out; values.len()];
        Repeated::of((Slot::G1, &serial), COEFFICIENTS[0], (&values, &left_out), mean).expect("two values")
    }

    #[test]
    fn two_values_that_differ_by_their_noise_repeat() {
        // x = 1 and 2, sd 1: Q = 1/2, mean 1.5 with sd 1/sqrt 2. Quantiles of one degree of freedom: 5.024, 9.82e-4.
        let found = repeated(&[(1.0, 1.0, 0.0, 0), (2.0, 1.0, 0.0, 0)]);
        assert!((found.scatter.chi2 - 0.5).abs() < 1e-12 && found.scatter.dof == 1);
        assert!((found.mean - 1.5).abs() < 1e-12 && (found.sd - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((found.ratio() - 0.5_f64.sqrt()).abs() < 1e-12 && found.beyond_sd == 0.0);
        let [low, high] = found.ratio_interval();
        assert!((low - (0.5_f64 / 5.0239).sqrt()).abs() < 1e-4 && (high - (0.5_f64 / 9.8207e-4).sqrt()).abs() < 1e-2);
    }

    #[test]
    fn values_that_differ_by_more_widen_the_sd_of_their_mean() {
        // x = 0 and 10, sd 1: Q = 50, tau^2 = (50 - 1)/(2 - 1) = 49. Were tau known, the sd of the mean were sqrt(50/2):
        // two values tell it badly.
        let found = repeated(&[(0.0, 1.0, 0.0, 0), (10.0, 1.0, 0.0, 0)]);
        assert!((found.beyond_sd - 7.0).abs() < 1e-12 && (found.mean - 5.0).abs() < 1e-9, "{found:?}");
        assert!((7.0..9.0).contains(&found.sd), "{found:?}");
    }

    #[test]
    fn what_a_station_does_to_all_its_campaigns_does_not_average_out() {
        // Four values of sd 5, of which 4 are the station's: 3/sqrt 4 and 4 of one station, 4/sqrt 2 of two.
        let four = |stations: [usize; 4]| repeated(&stations.map(|station| (1.0, 3.0, 4.0, station)));
        assert!((four([0; 4]).sd - (2.25_f64 + 16.0).sqrt()).abs() < 1e-12);
        assert!((four([0, 1, 0, 1]).sd - (2.25_f64 + 8.0).sqrt()).abs() < 1e-12);
        assert!((four([0; 4]).stated_sd - 5.0).abs() < 1e-12);
    }

    #[test]
    fn what_the_model_leaves_out_of_all_campaigns_does_not_average_out() {
        // Four values of sd 5, of which 4 are the model's: 3/sqrt 4 and 4, and their scatter as it was.
        let values = [1.0, 2.0, 3.0, 4.0].map(|x| (x, 5.0, 0.0, 0));
        let (found, averaged) = (leaving_out(4.0, &values), repeated(&values));
        assert!((found.sd - (2.25_f64 + 16.0).sqrt()).abs() < 1e-12, "{found:?}");
        assert!((averaged.sd - 2.5).abs() < 1e-12);
        assert_eq!((found.scatter, found.mean), (averaged.scatter, averaged.mean));
    }
}
