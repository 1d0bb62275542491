//! What repeats from campaign to campaign of one IMU: whether stated standard deviations hold between campaigns.

use super::outcome::Outcome;
use crate::core::campaign::Campaign;
use crate::core::model::Term;
use crate::core::mounting::Slot;
use crate::core::name::Name;
use crate::core::numerics::between::Scatter;
use crate::core::numerics::tails::chi2_quantile;

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
    /// Of that mean. A station's own part is the same in all of its campaigns, and does not average out.
    pub sd: f64,
    /// Root mean square of the stated standard deviations, and standard deviation of the values about their mean.
    pub stated_sd: f64,
    pub scatter_sd: f64,
    pub scatter: Scatter,
    /// tau: what campaigns differ by beyond what is stated; zero within chance (p >= 0.05).
    pub beyond_sd: f64,
}

/// A value of one campaign.
#[derive(Debug, Clone, Copy)]
struct Value<'a> {
    value: f64,
    sd: f64,
    /// Part of the standard deviation that the campaigns of a station share.
    of_station: f64,
    station: &'a Name,
}

impl Repeated {
    /// Real over stated standard deviation, sqrt(Q/dof).
    pub fn ratio(&self) -> f64 {
        (self.scatter.chi2 / self.scatter.dof as f64).sqrt()
    }

    /// Interval of that ratio, 95 %: sqrt(Q/chi2_q) for the quantiles 0.975 and 0.025.
    pub fn ratio_interval(&self) -> [f64; 2] {
        [0.975, 0.025].map(|q| (self.scatter.chi2 / chi2_quantile(q, self.scatter.dof as f64)).sqrt())
    }

    fn of(
        (slot, serial): (Slot, &Name),
        (coefficient, unit): (&'static str, &'static str),
        all: &[Value],
    ) -> Option<Self> {
        let pairs: Vec<(f64, f64)> = all.iter().map(|v| (v.value, v.sd)).collect();
        let scatter = Scatter::of(&pairs)?;
        let beyond_sd = scatter.beyond();
        let weights: Vec<f64> = all.iter().map(|v| 1.0 / (v.sd.powi(2) + beyond_sd.powi(2))).collect();
        let total: f64 = weights.iter().sum();
        let shares = || weights.iter().map(|w| w / total);
        let mean = all.iter().zip(shares()).map(|(v, share)| v.value * share).sum();
        let own = |v: &Value| v.sd.powi(2) - v.of_station.powi(2) + beyond_sd.powi(2);
        let independent: f64 = all.iter().zip(shares()).map(|(v, share)| share * share * own(v)).sum();
        let mut stations: Vec<(&Name, f64)> = Vec::new();
        for (v, share) in all.iter().zip(shares()) {
            match stations.iter_mut().find(|(name, _)| *name == v.station) {
                Some((_, sum)) => *sum += share * v.of_station,
                None => stations.push((v.station, share * v.of_station)),
            }
        }
        let shared: f64 = stations.iter().map(|(_, sum)| sum * sum).sum();
        let n = all.len() as f64;
        let plain = all.iter().map(|v| v.value).sum::<f64>() / n;
        let squares = all.iter().map(|v| (v.value - plain).powi(2)).sum::<f64>();
        Some(Self {
            slot,
            serial: serial.clone(),
            coefficient,
            unit,
            campaigns: all.len(),
            mean,
            sd: (independent + shared).sqrt(),
            stated_sd: (all.iter().map(|v| v.sd * v.sd).sum::<f64>() / n).sqrt(),
            scatter_sd: (squares / (n - 1.0)).sqrt(),
            scatter,
            beyond_sd,
        })
    }
}

/// Units of D_I, D_S, D_O, |E| and D_F.
const COEFFICIENTS: [(&str, &str); 5] =
    [("D_I", "deg/(h*g0)"), ("D_S", "deg/(h*g0)"), ("D_O", "deg/(h*g0)"), ("|E|", "pulse/arcsec"), ("D_F", "deg/h")];

/// Every coefficient that two campaigns or more determine, gyro by gyro. The campaigns are of one IMU.
pub fn repeated(fitted: &[(&Campaign, &Outcome)]) -> Vec<Repeated> {
    let Some((first, _)) = fitted.first() else { return Vec::new() };
    let mut all = Vec::new();
    for gyro in &first.gyros {
        let each: Vec<[Option<Value>; 5]> = fitted.iter().map(|(c, outcome)| values(c, outcome, gyro.slot)).collect();
        for (place, coefficient) in COEFFICIENTS.into_iter().enumerate() {
            let known: Vec<Value> = each.iter().filter_map(|values| values[place]).collect();
            all.extend(Repeated::of((gyro.slot, &gyro.serial), coefficient, &known));
        }
    }
    all
}

fn values<'a>(campaign: &'a Campaign, outcome: &Outcome, slot: Slot) -> [Option<Value<'a>>; 5] {
    let Outcome::Imu { calibration, separations, .. } = outcome else { return [None; 5] };
    let fitted = calibration.gyros.iter().zip(separations).find(|(gyro, _)| gyro.slot == slot);
    let Some((gyro, Ok(separation))) = fitted else { return [None; 5] };
    let value = |value: f64, sd: Option<f64>, of_station: f64| {
        Some(Value { value, sd: sd.filter(|sd| *sd > 0.0)?, of_station, station: &campaign.station })
    };
    let rigid = &separation.rigid;
    let sds = rigid.sd().map_or([None; 3], |sds| sds.map(Some));
    let stations = gyro.budgets(&campaign.geometry, false).map(|all| all.map(|b| b.station.unwrap_or(0.0)));
    let stations = stations.unwrap_or_default();
    let k = separation.scale_factor;
    let bias = gyro.of(Term::Bias).map(|bias| &bias[0]).filter(|bias| bias.determined);
    let of_bias = gyro.uncertainty.as_ref().and_then(|parts| parts.budgets(|c| Some([c[(0, 0)]])));
    let of_bias = of_bias.and_then(|[budget]| budget.station).unwrap_or(0.0);
    [
        value(rigid.d_i, sds[0], stations[0]),
        value(rigid.d_s, sds[1], stations[1]),
        value(rigid.d_o, sds[2], stations[2]),
        value(k, separation.scale_factor_sd, stations[3]),
        bias.and_then(|bias| value(bias.value / k, bias.sd.map(|sd| sd / k), of_bias / k)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeated(values: &[(f64, f64, f64, &str)]) -> Repeated {
        let name = |text: &str| Name::parse(text).expect("a name");
        let stations: Vec<Name> = values.iter().map(|v| name(v.3)).collect();
        let values: Vec<Value> = values
            .iter()
            .zip(&stations)
            .map(|((value, sd, of_station, _), station)| Value {
                value: *value,
                sd: *sd,
                of_station: *of_station,
                station,
            })
            .collect();
        Repeated::of((Slot::G1, &name("A")), COEFFICIENTS[0], &values).expect("two values")
    }

    #[test]
    fn two_values_that_differ_by_their_noise_repeat() {
        // x = 1 and 2, sd 1: Q = 1/2, mean 1.5 with sd 1/sqrt 2. Quantiles of one degree of freedom: 5.024, 9.82e-4.
        let found = repeated(&[(1.0, 1.0, 0.0, "S"), (2.0, 1.0, 0.0, "S")]);
        assert!((found.scatter.chi2 - 0.5).abs() < 1e-12 && found.scatter.dof == 1);
        assert!((found.mean - 1.5).abs() < 1e-12 && (found.sd - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((found.ratio() - 0.5_f64.sqrt()).abs() < 1e-12 && found.beyond_sd == 0.0);
        let [low, high] = found.ratio_interval();
        assert!((low - (0.5_f64 / 5.0239).sqrt()).abs() < 1e-4 && (high - (0.5_f64 / 9.8207e-4).sqrt()).abs() < 1e-2);
    }

    #[test]
    fn values_that_differ_by_more_widen_the_sd_of_their_mean() {
        // x = 0 and 10, sd 1: Q = 50, tau^2 = (50 - 1)/(2 - 1) = 49, sd of the mean sqrt(50/2).
        let found = repeated(&[(0.0, 1.0, 0.0, "S"), (10.0, 1.0, 0.0, "S")]);
        assert!((found.beyond_sd - 7.0).abs() < 1e-12 && (found.sd - 5.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn what_a_station_does_to_all_its_campaigns_does_not_average_out() {
        // Four values of sd 5, of which 4 are the station's: 3/sqrt 4 and 4 of one station, 4/sqrt 2 of two.
        let four = |stations: [&'static str; 4]| repeated(&stations.map(|station| (1.0, 5.0, 4.0, station))).sd;
        assert!((four(["S"; 4]) - (2.25_f64 + 16.0).sqrt()).abs() < 1e-12);
        assert!((four(["S", "T", "S", "T"]) - (2.25_f64 + 8.0).sqrt()).abs() < 1e-12);
    }
}
