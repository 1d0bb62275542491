//! Competing hypotheses that follow time.

use std::f64::consts::PI;

use super::common::{mid, picked};
use crate::core::campaign::Phase;
use crate::core::effects::entry::{COMPETING, Effect, Entry, Prior, Shape};
use crate::core::effects::setting::Setting;
use crate::core::effects::station::{afterwards, instants};

pub(super) const ENTRIES: &[&Entry] = &[
    &CURVE_IN_TIME,
    &WANDER_IN_TIME,
    &CORRELATED_IN_TIME,
    &BEND_IN_TIME,
    &BURST,
    &DRIFTING_MASS_UNBALANCE,
    &DRIFTING_SCALE,
    &STEPPING_MASS_UNBALANCE,
    &STEPPING_SCALE,
    &PART_TIME,
];

pub const CURVE_IN_TIME: Entry = Entry {
    effect: Effect::CurveInTime,
    id: "curve_in_time",
    cause: "flex leads, suspension and electronics settle by no single law",
    equation: "sum_m c_m cos(pi m t/span)/m^2, m = 1 .. 9",
    unit: "deg/h",
    typical: [0.001, 0.1], // bias stability of floated gyros within a day
    confused_with: &[Effect::TimeRamp, Effect::Warmup, Effect::BiasStep, Effect::Periodic],
    prior: Prior::Smooth,
    columns: &|s, _, _| waves(s, 9, 2.0),
    wanders: true,
    ..COMPETING
};

pub const WANDER_IN_TIME: Entry = Entry {
    effect: Effect::WanderInTime,
    id: "wander_in_time",
    cause: "rate random walk: the bias drifts by what has no memory",
    equation: "sum_m c_m cos(pi m t/span)/m, m = 1 .. 16",
    unit: "deg/h",
    typical: [0.0001, 0.01], // IEEE 517, rate random walk, per square root of an hour
    confused_with: &[Effect::TimeRamp, Effect::BiasStep, Effect::Warmup, Effect::Periodic],
    prior: Prior::Smooth,
    columns: &|s, _, _| waves(s, 16, 1.0),
    wanders: true,
    ..COMPETING
};

pub const CORRELATED_IN_TIME: Entry = Entry {
    effect: Effect::CorrelatedInTime,
    id: "correlated_in_time",
    cause: "flicker of bias, and supplies that several dwells share",
    equation: "sum_m c_m cos(pi m t/span)/m^0.35, m = 1 .. 26",
    unit: "deg/h",
    typical: [0.0001, 0.01], // IEEE 517, bias instability
    confused_with: &[Effect::Periodic, Effect::OutlierDwell, Effect::BiasStep],
    prior: Prior::Smooth,
    columns: &|s, _, _| waves(s, 26, 0.35),
    wanders: true,
    ..COMPETING
};

pub const BEND_IN_TIME: Entry = Entry {
    effect: Effect::BendInTime,
    id: "bend_in_time",
    cause: "settling that is slower or faster than one time constant",
    equation: "c_1 t + c_2 t^2 + c_3 t^3",
    unit: "deg/h",
    typical: [0.001, 0.1], // bias stability of floated gyros within a day
    confused_with: &[Effect::TimeRamp, Effect::Warmup, Effect::Periodic],
    shapes: &|_| vec![(Shape::Only(&[2]), 1.0), (Shape::Only(&[1, 2]), 1.0), (Shape::Only(&[1, 2, 3]), 1.0)],
    columns: &|s, _, shape| picked(shape).iter().map(|&degree| legendre_in_time(s, degree)).collect(),
    ..COMPETING
};

pub const BURST: Entry = Entry {
    effect: Effect::Burst,
    id: "burst",
    cause: "a door, a crane, a power supply that recovers: a passing disturbance",
    equation: "k in neighbouring dwells",
    unit: "deg/h",
    typical: [0.001, 1.0], // station logs
    confused_with: &[Effect::BiasStep, Effect::OutlierDwell, Effect::Periodic],
    shapes: &windows,
    columns: &|s, _, shape| match shape {
        Shape::Window(from, to) => vec![s.column(|k| f64::from(u8::from((from..to).contains(&k))))],
        _ => Vec::new(),
    },
    ..COMPETING
};

pub const DRIFTING_MASS_UNBALANCE: Entry = Entry {
    effect: Effect::DriftingMassUnbalance,
    id: "drifting_mass_unbalance",
    cause: "the float's suspension currents and bubbles move its centre of mass through the day",
    equation: "t (k_x a_x + k_y a_y + k_z a_z)",
    unit: "deg/(h g0) per campaign",
    typical: [0.001, 0.05], // day-to-day stability of mass unbalance, 0.01 deg/(h g0)
    confused_with: &[Effect::TemperatureG, Effect::GLinear, Effect::Hysteresis],
    columns: &|s, _, _| s.by_axis(|k, i| mid(s, k) * s.force[k][i]),
    ..COMPETING
};

pub const DRIFTING_SCALE: Entry = Entry {
    effect: Effect::DriftingScale,
    id: "drifting_scale",
    cause: "the torquer's magnet ages or its reference voltage drifts",
    equation: "k t w_I",
    unit: "1 per campaign",
    typical: [1e-6, 0.0001], // stability of torquer scale factors, 1 to 100 ppm
    confused_with: &[Effect::TemperatureScale, Effect::ScaleQuadratic],
    columns: &|s, j, _| vec![s.column(|k| mid(s, k) * s.rate[k].dot(&s.gyros[j].input))],
    ..COMPETING
};

pub const STEPPING_MASS_UNBALANCE: Entry = Entry {
    effect: Effect::SteppingMassUnbalance,
    id: "stepping_mass_unbalance",
    cause: "a shock, a power interruption or a night without power moves the float's centre of mass once",
    equation: "H(t - t_0) (k_x a_x + k_y a_y + k_z a_z)",
    unit: "deg/(h g0)",
    typical: [0.001, 0.1], // stability of mass unbalance across power-downs
    confused_with: &[Effect::TemperatureG, Effect::Relevelling, Effect::Reseating],
    shapes: &|s| instants(s).map(|instant| (Shape::Instant(instant), 1.0)).collect(),
    columns: &|s, _, shape| {
        let columns = s.by_axis(|k, i| s.force[k][i]);
        columns.into_iter().map(|column| afterwards(s, column, shape)).collect()
    },
    only_closer: true,
    ..COMPETING
};

pub const STEPPING_SCALE: Entry = Entry {
    effect: Effect::SteppingScale,
    id: "stepping_scale",
    cause: "the torquer's magnet or its reference changes once, as a power interruption leaves it",
    equation: "k H(t - t_0) w_I",
    unit: "1",
    typical: [1e-6, 0.0001], // stability of torquer scale factors across power-downs, 1 to 100 ppm
    confused_with: &[Effect::Reseating, Effect::Levelling, Effect::GRateCoupling, Effect::TemperatureScale],
    // With the table turning on one side alone it is a scale factor.
    shapes: &|s| {
        let turned = |after: bool, instant: f64| {
            (0..s.dwells()).any(|k| s.phase[k] == Phase::Rate && (s.time[k] > instant) == after)
        };
        let both = instants(s).filter(|instant| turned(false, *instant) && turned(true, *instant));
        both.map(|instant| (Shape::Instant(instant), 1.0)).collect()
    },
    columns: &|s, j, shape| vec![afterwards(s, s.column(|k| s.rate[k].dot(&s.gyros[j].input)), shape)],
    only_closer: true,
    ..COMPETING
};

/// Effects that act throughout where they are a cause, and one column or a few.
const PARTS: [Effect; 12] = [
    Effect::TemperatureBias,
    Effect::TemperatureG,
    Effect::TemperatureScale,
    Effect::TimeRamp,
    Effect::Hysteresis,
    Effect::ScaleAsymmetry,
    Effect::ScaleQuadratic,
    Effect::ScaleCubic,
    Effect::Anisoinertia,
    Effect::GRateCoupling,
    Effect::Magnetic,
    Effect::Warmup,
];

pub const PART_TIME: Entry = Entry {
    effect: Effect::PartTime,
    id: "part_time",
    cause: "an effect of the catalogue that is switched on or off during the campaign",
    equation: "another effect's regressors from one instant to another, or its time constant from every power-up anew",
    unit: "that effect's",
    typical: [1e-9, 1.0], // station logs: supplies, heaters and loops switched midway
    confused_with: &[Effect::TemperatureBias, Effect::TimeRamp, Effect::BiasStep, Effect::Warmup],
    shapes: &parts,
    columns: &|s, j, shape| match shape {
        Shape::Part { of, from, to } => {
            let mut columns = (of.entry().columns)(s, j, whole(s, of));
            for column in &mut columns {
                let outside = |k: usize| !(from..=to).contains(&s.elapsed(k));
                column.iter_mut().enumerate().filter(|(k, _)| outside(*k)).for_each(|(_, x)| *x = 0.0);
            }
            columns
        }
        Shape::Restart(tau) => vec![since_power_up(s).into_iter().map(|t| (-t / tau).exp()).collect()],
        _ => Vec::new(),
    },
    only_closer: true,
    standing: PARTS.len(),
    ..COMPETING
};

/// The one shape in which an effect is tried for a part of the time.
fn whole(s: &Setting, of: Effect) -> Shape {
    let heaviest = (of.entry().shapes)(s).into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    heaviest.map_or(Shape::Linear, |(shape, _)| shape)
}

/// Each effect from one of seven instants on, up to one of them, or between two; and where there were pauses, from
/// them on and up to them, and settling anew after each.
fn parts(s: &Setting) -> Vec<(Shape, f64)> {
    let (start, end) = (-1.0, s.span() + 1.0);
    let shares = |from: f64, to: f64| (from * s.span(), to * s.span());
    let mut spans = vec![shares(0.33, 0.66), shares(0.2, 0.5), shares(0.5, 0.8)];
    let mut instants: Vec<f64> = (2..=8).map(|tenth| 0.1 * f64::from(tenth) * s.span()).collect();
    let pauses: Vec<usize> = s.pauses().collect();
    instants.extend(pauses.iter().map(|&k| 0.5 * (s.elapsed(k - 1) + s.elapsed(k))));
    spans.extend(instants.iter().flat_map(|&t| [(start, t), (t, end)]));
    let mut found = Vec::new();
    for of in PARTS.into_iter().filter(|of| *of != Effect::Warmup && (of.entry().missing)(s).is_none()) {
        found.extend(spans.iter().map(|&(from, to)| (Shape::Part { of, from, to }, 1.0)));
    }
    if !pauses.is_empty() {
        // As likely together as another effect in all its parts.
        let taus = (Effect::Warmup.entry().shapes)(s).into_iter();
        let weight = spans.len() as f64 / taus.len() as f64;
        found.extend(taus.filter_map(|(shape, _)| match shape {
            Shape::Tau(tau) => Some((Shape::Restart(tau), weight)),
            _ => None,
        }));
    }
    found
}

/// Time since the last pause, or since the beginning, s.
fn since_power_up(s: &Setting) -> Vec<f64> {
    let pauses: Vec<usize> = s.pauses().collect();
    s.column(|k| s.time[k] - s.time[pauses.iter().copied().filter(|&p| p <= k).max().unwrap_or(0)])
}

/// Half cosines over the campaign, the m-th in proportion to m^-roughness.
fn waves(s: &Setting, count: usize, roughness: f64) -> Vec<Vec<f64>> {
    (1..=count.min(s.dwells() / 2))
        .map(|m| {
            let size = (m as f64).powf(-roughness);
            s.column(|k| size * (PI * m as f64 * 0.5 * (mid(s, k) + 1.0)).cos())
        })
        .collect()
}

fn legendre_in_time(s: &Setting, degree: usize) -> Vec<f64> {
    s.column(|k| {
        let x = mid(s, k);
        match degree {
            1 => x,
            2 => 1.5 * x * x - 0.5,
            _ => 2.5 * x.powi(3) - 1.5 * x,
        }
    })
}

/// Windows of three to a third of the dwells, clear of both ends (one that reaches an end is a step).
fn windows(s: &Setting) -> Vec<(Shape, f64)> {
    let n = s.dwells();
    let mut found = Vec::new();
    for width in [2, 3, 4, 6, 8, 11, 15, 20, 27] {
        let stride = (width / 4).max(1);
        for from in (1..n.saturating_sub(width)).step_by(stride) {
            if 3 * width <= n {
                found.push((Shape::Window(from, from + width), stride as f64 / width as f64));
            }
        }
    }
    if found.is_empty() { vec![(Shape::Window(0, 0), 1.0)] } else { found }
}
