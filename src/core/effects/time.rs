//! Effects of time and of the order of dwells.

use std::f64::consts::TAU as FULL_TURN;

use super::entry::{Effect, Entry, PLAIN, Parameter, Shape};
use super::setting::Setting;

pub(super) const ENTRIES: &[&Entry] = &[&WARMUP, &TIME_RAMP, &BIAS_STEP, &OUTLIER_DWELL, &PERIODIC];

pub const WARMUP: Entry = Entry {
    effect: Effect::Warmup,
    id: "warmup",
    cause: "the gyro and its electronics settle after power-up",
    equation: "k exp(-t/tau)",
    unit: "deg/h",
    typical: [0.01, 1.0], // IEEE 517, warm-up of floated gyros; tau of minutes to hours
    plausible: 1e4,
    confused_with: &[Effect::TimeRamp, Effect::TemperatureBias, Effect::OutlierDwell],
    shapes: &time_constants,
    columns: &|s, _, shape| {
        let Shape::Tau(tau) = shape else { return Vec::new() };
        vec![s.column(|k| (-s.elapsed(k) / tau).exp())]
    },
    parameter: Parameter::Tau,
    course_in_time: true,
    follows_time: true,
    ..PLAIN
};

pub const TIME_RAMP: Entry = Entry {
    effect: Effect::TimeRamp,
    id: "time_ramp",
    cause: "steady ageing or settling through the campaign",
    equation: "k t",
    unit: "deg/h/h",
    typical: [1e-4, 0.1], // day-to-day bias stability of floated gyros over a campaign of hours
    plausible: 1e4,
    confused_with: &[Effect::Warmup, Effect::TemperatureBias, Effect::Periodic, Effect::GLinear],
    columns: &|s, _, _| vec![s.column(|k| s.elapsed(k) / 3600.0)],
    course_in_time: true,
    follows_time: true,
    ..PLAIN
};

pub const BIAS_STEP: Entry = Entry {
    effect: Effect::BiasStep,
    id: "bias_step",
    cause: "a mass shift, a power interruption or a reconnected plug changes the bias once",
    equation: "k H(t - t_0)",
    unit: "deg/h",
    typical: [1e-3, 1.0], // turn-on to turn-on bias of floated gyros
    plausible: 1e4,
    confused_with: &[Effect::TimeRamp, Effect::OutlierDwell, Effect::Periodic],
    shapes: &instants,
    columns: &|s, _, shape| {
        let Shape::Instant(instant) = shape else { return Vec::new() };
        vec![s.column(|k| if s.time[k] > instant { 1.0 } else { 0.0 })]
    },
    parameter: Parameter::Instant,
    course_in_time: true,
    follows_time: true,
    one_occasion: true,
    ..PLAIN
};

pub const OUTLIER_DWELL: Entry = Entry {
    effect: Effect::OutlierDwell,
    id: "outlier_dwell",
    cause: "one dwell was disturbed: a shock, a wrong position, a lost count",
    equation: "k delta(i, n)",
    unit: "deg/h",
    typical: [0.01, 100.0], // station logs: any size
    plausible: f64::INFINITY,
    confused_with: &[Effect::BiasStep, Effect::Warmup],
    shapes: &|s| (0..s.dwells()).map(|k| (Shape::Dwell(k), 1.0)).collect(),
    columns: &|s, _, shape| {
        let Shape::Dwell(dwell) = shape else { return Vec::new() };
        vec![s.column(|k| if k == dwell { 1.0 } else { 0.0 })]
    },
    parameter: Parameter::Dwell,
    one_occasion: true,
    ..PLAIN
};

pub const PERIODIC: Entry = Entry {
    effect: Effect::Periodic,
    id: "periodic",
    cause: "air conditioning, a thermostat's cycle or the mains beat with the dwells",
    equation: "k_s sin(2 pi t/period) + k_c cos(2 pi t/period)",
    unit: "deg/h",
    typical: [1e-3, 0.1], // thermostat cycles of minutes to hours
    plausible: 1e4,
    confused_with: &[Effect::TemperatureBias, Effect::TimeRamp, Effect::BiasStep],
    names: &|_| vec!["k_sin", "k_cos"],
    shapes: &periods,
    columns: &|s, _, shape| {
        let Shape::Period(period) = shape else { return Vec::new() };
        let phase = |k: usize| FULL_TURN * s.elapsed(k) / period;
        vec![s.column(|k| phase(k).sin()), s.column(|k| phase(k).cos())]
    },
    parameter: Parameter::Period,
    course_in_time: true,
    follows_time: true,
    ..PLAIN
};

/// From half an interval between dwells to the whole campaign: longer ones are a ramp, shorter ones one dwell.
fn time_constants(s: &Setting) -> Vec<(Shape, f64)> {
    const COUNT: usize = 14;
    let (low, high) = (0.5 * s.interval(), s.span().max(s.interval()));
    let ratio = (high / low).powf(1.0 / (COUNT - 1) as f64);
    (0..COUNT).map(|i| (Shape::Tau(low * ratio.powi(i as i32)), 1.0)).collect()
}

/// Between neighbouring dwells, two dwells or more from either end: a change of one dwell alone is an outlier.
fn instants(s: &Setting) -> Vec<(Shape, f64)> {
    let n = s.dwells();
    let between = |k: usize| 0.5 * (s.time[k - 1] + s.time[k]);
    let found: Vec<_> = (2..n.saturating_sub(1)).map(|k| (Shape::Instant(between(k)), 1.0)).collect();
    if found.is_empty() { vec![(Shape::Instant(s.time[0]), 1.0)] } else { found }
}

/// Frequencies from one cycle a campaign to the Nyquist frequency of the dwells, 2.5 to a resolution cell.
/// Long periods are as likely as short ones decade by decade: the weight falls as 1/frequency, flat at the low end.
fn periods(s: &Setting) -> Vec<(Shape, f64)> {
    let span = s.span().max(s.interval());
    let (lowest, highest) = (1.0 / span, 0.5 / s.interval());
    let step = 0.4 / span;
    let count = (((highest - lowest) / step).floor() as usize).clamp(1, 200);
    (0..count)
        .map(|i| lowest + step * i as f64)
        .map(|f| (Shape::Period(1.0 / f), 1.0 / (1.0 + f / (8.0 * lowest))))
        .collect()
}
