//! Why a verdict is what it is: the finding, the limit, whether a second campaign says so, and how certain it is.

use std::fmt::{self, Display, Formatter};

use super::rules::FALSE_ALARMS;
use crate::core::judge::{FigureSource, Finding, LATELY, Rule, State, Status, Unit, Unseen, Verdict};
use crate::core::message::{Message, Parameter, figure, list, p_value, signed, significant, text};
use crate::core::time::UtcMicros;
use crate::core::units::degrees;
use crate::message;

/// Decimals that show a hundredth of the limit.
pub fn digits(limit: f64) -> usize {
    if limit == 0.0 { 6 } else { (2.0 - limit.abs().log10().floor()).clamp(0.0, 12.0) as usize }
}

/// As many decimals as the limit, and more where they would not show the standard deviation.
pub fn sd_digits(sd: f64, limit: f64) -> usize {
    let one = if sd > 0.0 { (-sd.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    digits(limit).max(one)
}

impl Verdict {
    /// What there is to say, sentence by sentence, the finding first.
    ///
    /// Of what is within its limit one phrase without figures: a record has some forty of them, and value, limit and
    /// probability stand beside it. A slope is told all the same, for its figures stand nowhere else.
    pub fn messages(&self) -> Vec<Message> {
        self.phrase().map_or_else(|| self.spelled_out(), |phrase| vec![phrase])
    }

    /// What there is to say where this does not exceed its limit, and its alert fires on: also what ends that. `below`:
    /// the fraction of the limit below which one campaign does, and `campaigns`: how many within the limit do.
    pub fn messages_of_held(&self, below: f64, campaigns: u32) -> Vec<Message> {
        let mut said = self.spelled_out();
        said.push(match (self.state, self.rule) {
            (State::Within, Rule::Requirement) => message!("held_requirement", campaigns = u64::from(campaigns)),
            (State::Within, _) => {
                let value = figure(below * self.limit, digits(self.limit));
                let below_value = message!("measured", value, unit = self.unit().word());
                message!(
                    "held_within",
                    below = below_value,
                    percent = figure(100.0 * below, 0),
                    campaigns = u64::from(campaigns)
                )
            }
            _ => message!("held_undecided"),
        });
        said
    }

    fn spelled_out(&self) -> Vec<Message> {
        let mut said = self.finding_messages();
        if self.value.is_none() {
            return said;
        }
        said.push(self.limit_message());
        if let Finding::Forecast { step, campaigns, unseen, .. } = self.finding {
            said.extend(self.forecast_messages(step, campaigns, unseen));
            return said;
        }
        said.extend(self.between.map(|sd| message!("between_stations", sd = figure(sd, sd_digits(sd, self.limit)))));
        if self.confirmed {
            said.push(match self.rule {
                Rule::Range | Rule::Agreement => message!("not_a_single_result"),
                Rule::StationShift | Rule::BatchShift => message!("whole_budget"),
                Rule::ImuShift => message!("second_campaign_of_one"),
                _ => message!("second_campaign"),
            });
        }
        said.extend(self.certainty());
        said
    }

    /// All that there is to say, where that has no figures.
    pub fn phrase(&self) -> Option<Message> {
        match (self.state, self.finding) {
            (State::Within, Finding::NoTrend { .. }) => self.finding_messages().pop(),
            (State::Within, Finding::Trend { .. }) => None,
            (State::Within, _) => Some(message!("in_tolerance")),
            _ => None,
        }
    }

    /// The value with its standard deviation and unit.
    pub(super) fn measured(&self) -> Message {
        let (value, unit) = (figure(self.value.unwrap_or(0.0), digits(self.limit)), self.unit().word());
        match self.sd {
            Some(sd) => {
                let sd = figure(sd, sd_digits(sd, self.limit));
                message!("measured_with_sd", value, sd, unit)
            }
            None => message!("measured", value, unit),
        }
    }

    fn limit_message(&self) -> Message {
        let from = text(self.limit_from);
        let limit = message!("measured", value = figure(self.limit, digits(self.limit)), unit = self.unit().word());
        let percent = 100.0 * self.value.unwrap_or(0.0) / self.limit;
        match self.finding {
            Finding::Forecast { .. } => {
                message!("limit_of_forecast", limit, percent = figure(100.0 * FALSE_ALARMS, 1))
            }
            // Its bounds were named.
            Finding::Requirement { .. } => message!("limits_from", from),
            Finding::Shift { least, .. } if self.limit > least => {
                message!("limit_of_three_sd", limit, least = figure(least, digits(least)), from)
            }
            _ if self.state == State::Exceeded && percent < 1e5 => {
                message!("limit_exceeded", limit, from, percent = figure(percent, 0))
            }
            _ => message!("limit_is", limit, from),
        }
    }

    /// Why a forecast does not say more.
    fn forecast_messages(&self, step: Option<f64>, campaigns: usize, unseen: Option<Unseen>) -> Vec<Message> {
        let mut said = Vec::new();
        match (self.state, unseen, step) {
            (State::Indeterminate, Some(unseen), _) => said.push(message!("forecast_unseen", what = unseen.word())),
            (State::Indeterminate, None, Some(step)) => {
                let step = message!("measured", value = significant(step, 2), unit = Unit::Drift.word());
                said.push(message!("forecast_wide", step));
            }
            (State::Indeterminate, None, None) => said.push(message!("forecast_says_nothing")),
            (State::Exceeded, unseen, _) => {
                said.extend(unseen.map(|unseen| message!("forecast_beyond_plausible", what = unseen.word())));
                said.extend((campaigns == 1).then(|| message!("forecast_of_one_campaign")));
            }
            _ => {}
        }
        said.extend(self.confirmed.then(|| message!("second_campaign")));
        said
    }

    fn certainty(&self) -> Option<Message> {
        let by_clock_or_chart = matches!(self.rule, Rule::Shift | Rule::Trend | Rule::Overdue | Rule::Cusum);
        match (self.status(), self.sd, self.probability) {
            (Status::TooUncertain, ..) if self.rule == Rule::Shift => Some(message!("too_uncertain_for_shift")),
            (Status::TooUncertain, Some(sd), _) => {
                let limit = figure(self.limit, digits(self.limit));
                Some(message!("too_uncertain", sd = figure(sd, sd_digits(sd, self.limit)), limit))
            }
            (_, _, Some(probability)) => Some(message!("probability_beyond", percent = percent(probability))),
            (_, None, None) if !by_clock_or_chart => Some(message!("no_standard_deviation")),
            _ => None,
        }
    }
}

/// For logs and for programmers.
impl Display for Verdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let said: Vec<String> = self.messages().iter().map(ToString::to_string).collect();
        f.write_str(&said.join("; "))
    }
}

/// Five degrees: far beyond any seat.
const LARGEST_TURN_ARCMIN: f64 = 300.0;

/// The turn of the spin axis about the input axis that moves D_O by as much, arc minutes: D_O moves by D_S psi when
/// it turns by psi. None where it would not show, and where no mount turns as far: then it is no turn.
pub fn turn_arcmin(moved: f64, d_s: Option<f64>) -> Option<f64> {
    d_s.map(|d_s| degrees((moved / d_s).atan()) * 60.0)
        .filter(|turn| (0.05..=LARGEST_TURN_ARCMIN).contains(&turn.abs()))
}

fn percent(probability: f64) -> String {
    match probability {
        p if p > 0.999 => "> 99.9".to_owned(),
        p if p < 0.001 => "< 0.1".to_owned(),
        p => format!("= {:.1}", 100.0 * p),
    }
}

/// The side of a level on which a figure is.
fn side(difference: f64) -> &'static str {
    if difference < 0.0 { "below" } else { "above" }
}

/// What makes a baseline.
fn origin(since: Option<UtcMicros>) -> Message {
    match since {
        Some(at) => message!("level_from", since = text(at.date())),
        None => message!("level_fixed"),
    }
}

impl Verdict {
    /// What the rule saw, by code: a first sentence, and what there is to add.
    fn finding_messages(&self) -> Vec<Message> {
        let name = self.coefficient.name();
        let shown = |value: f64| figure(value, digits(self.limit));
        let day = |at: UtcMicros| text(at.date());
        let value = || self.measured();
        match self.finding {
            Finding::TooFew { have, need } => {
                let of = match self.rule {
                    Rule::Agreement => "results",
                    Rule::Shift | Rule::Trend => "weeks",
                    _ => "records",
                };
                vec![message!("too_few", name, rule = self.rule.word(), need, have, of)]
            }
            Finding::FewWithin { have, need, days } => {
                vec![message!("too_few_within", name, rule = self.rule.word(), need, have, days = text(days),)]
            }
            Finding::Moved { since, have, need } => {
                vec![message!("too_few_since_moved", name, since = day(since), need, have)]
            }
            Finding::Step { level, now } => {
                let side = side(now - level);
                vec![message!("step", name, value = value(), side, level = shown(level))]
            }
            Finding::Range { records, since, lowest, highest } => vec![message!(
                "range",
                name,
                value = value(),
                records,
                since = day(since),
                lowest = shown(lowest.1),
                lowest_at = day(lowest.0),
                highest = shown(highest.1),
                highest_at = day(highest.0),
            )],
            Finding::Baseline { level, since, now } => vec![message!(
                "baseline",
                name,
                value = value(),
                side = side(now - level),
                level = shown(level),
                origin = origin(since),
            )],
            Finding::Closure { level, since, moved, now, d_s } => {
                let mut said = vec![message!(
                    "closure",
                    name,
                    value = value(),
                    side = side(now - level),
                    level = shown(level),
                    origin = origin(since),
                )];
                said.extend(moved.then(|| message!("closure_moved")));
                let turn = turn_arcmin(now - level, d_s);
                said.extend(turn.map(|turn| message!("closure_turn", turn = signed(turn, 1))));
                // What is not beyond its limit is not said to have a cause.
                said.extend((self.state == State::Exceeded).then(|| message!("closure_cause")));
                said
            }
            Finding::NoTrend { step: None, .. } => vec![message!("no_trend")],
            Finding::NoTrend { step: Some(_), .. } => vec![message!("no_trend_but_step")],
            Finding::Trend { .. } => self.trend_messages(),
            Finding::Shift { level, before, since, now, .. } => vec![message!(
                "shift",
                name,
                since = day(since),
                value = value(),
                side = side(now - level),
                level = shown(level),
                before,
            )],
            Finding::RmsSuccessive { since, explained } => {
                let mut said = vec![message!("rms_successive", name, since = day(since), value = value())];
                said.extend(explained.map(|explained| message!("rms_explained", explained = shown(explained))));
                said
            }
            Finding::BeforeAfter { before, from, until, now } => vec![message!(
                "before_after",
                name,
                value = value(),
                side = side(now - before.1),
                level = shown(before.1),
                at = day(before.0),
                from = day(from),
                until = day(until),
            )],
            Finding::GroupShift { gyros, imus, since, until, shift } => {
                macro_rules! said {
                    ($code:literal) => {
                        message!(
                            $code,
                            name,
                            value = value(),
                            side = side(shift),
                            gyros,
                            imus,
                            since = day(since),
                            until = day(until),
                        )
                    };
                }
                if self.rule == Rule::StationShift {
                    return vec![said!("station_shift")];
                }
                let mut said = vec![said!("batch_shift")];
                // Only then they were compared, or are known to lie so.
                said.extend(
                    (self.state == State::Exceeded).then(|| message!("batch_beside_others", days = text(LATELY))),
                );
                said
            }
            Finding::ImuShift { gyros } => vec![message!("imu_shift", name, value = value(), gyros)],
            Finding::Forecast { slot, furthest, p, .. } => {
                let p = if p < 1e-6 { text("< 1e-6") } else { text(format!("= {}", p_value(p))) };
                let slot = slot.name();
                let mut said = vec![message!("forecast", slot, value = value(), p)];
                said.extend(furthest.map(|(dwell, z)| message!("forecast_dwell", dwell, z = signed(z, 1))));
                said
            }
            Finding::Agreement { results, lowest, highest } => {
                let of = |(source, at, result): (FigureSource, UtcMicros, f64)| {
                    message!("result_of_method", value = shown(result), method = source.word(), at = day(at))
                };
                vec![message!("agreement", name, value = value(), results, lowest = of(lowest), highest = of(highest),)]
            }
            Finding::Requirement { figure, low, high, others } => {
                let inside = self.value.is_some_and(|value| (low..=high).contains(&value));
                let place = if inside { "inside" } else { "outside" };
                let (low, high) = (shown(low), shown(high));
                let mut said = vec![message!("requirement", figure, value = value(), place, low, high)];
                let others: Vec<&str> = others.into_iter().flatten().collect();
                said.extend((!others.is_empty()).then(|| message!("requirement_others", figures = list(others))));
                said
            }
            Finding::Overdue { last } => {
                vec![message!("overdue", last = day(last), days = figure(self.value.unwrap_or(0.0), 1))]
            }
        }
    }

    fn trend_messages(&self) -> Vec<Message> {
        let Finding::Trend { cells, since, until, per_year, deviation, horizon_days, reach, provisional, of_fleet } =
            self.finding
        else {
            return Vec::new();
        };
        let (p, day) = (digits(self.limit), |at: UtcMicros| text(at.date()));
        let rate = message!(
            "measured_with_sd",
            value = signed(per_year.value, p),
            sd = figure(per_year.sd.unwrap_or(0.0), p),
            unit = self.unit().word(),
        );
        let name = self.coefficient.name();
        let (from, to) = (day(since), day(until));
        let mut said = vec![message!("trend", name, rate, cells, since = from, until = to)];
        // This is read long after too: no date is said to be still to come.
        match reach {
            [_, Some(middle), _] if middle <= until => said.push(message!("trend_passed")),
            [Some(first), Some(middle), last] => {
                let last = last.map_or_else(|| Parameter::from(message!("never")), day);
                said.push(message!("trend_reaches", at = day(middle), first = day(first), last));
            }
            _ => {}
        }
        let (deviation, days) = (signed(deviation, p), figure(horizon_days, 0));
        said.push(message!("trend_ahead", deviation, value = self.measured(), days));
        said.extend(provisional.then(|| message!("trend_provisional")));
        said.extend((!of_fleet).then(|| message!("trend_default_noise")));
        said
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Coefficient, Limit, LimitKey};
    use super::*;
    use crate::core::message::Parameter;
    use crate::core::time::UtcMicros;

    fn exceeded(rule: Rule, value: f64, finding: Finding) -> Verdict {
        let limit = Limit { value: 0.01, from: LimitKey::BUDGET };
        let undecided = Verdict::undecided(Coefficient::DI, rule, limit, finding);
        Verdict { state: State::Exceeded, value: Some(value), ..undecided }
    }

    fn parameter(messages: &[Message], code: &str, name: &str) -> Parameter {
        let message = messages.iter().find(|message| message.code == code);
        message.and_then(|message| message.parameter(name)).cloned().unwrap_or_else(|| panic!("{code}: {messages:?}"))
    }

    #[test]
    fn the_side_is_the_sign_of_the_difference_from_the_level() {
        let at = UtcMicros(0);
        // Both figures are positive, or both negative: their quotient says nothing of the side.
        for (level, now, side) in
            [(3.0, 2.98, "below"), (3.0, 3.02, "above"), (-3.0, -3.02, "below"), (-3.0, -2.98, "above")]
        {
            let shift = Finding::Shift { level, before: 9, since: at, now, scatter: 1e-3, least: 0.0025 };
            let test = Finding::BeforeAfter { before: (at, level), from: at, until: at, now };
            let closure = Finding::Closure { level, since: None, moved: false, now, d_s: None };
            for (code, rule, finding) in [
                ("step", Rule::Step, Finding::Step { level, now }),
                ("baseline", Rule::Baseline, Finding::Baseline { level, since: None, now }),
                ("closure", Rule::Closure, closure),
                ("shift", Rule::Shift, shift),
                ("before_after", Rule::BeforeAfter, test),
            ] {
                let messages = exceeded(rule, 0.02, finding).messages();
                assert_eq!(parameter(&messages, code, "side"), side.into(), "{code}: {now} against {level}");
            }
        }
    }

    #[test]
    fn others_are_said_to_have_stayed_only_where_they_have() {
        let at = UtcMicros(0);
        let finding = Finding::GroupShift { gyros: 9, imus: 3, since: at, until: at, shift: 0.02 };
        let told = exceeded(Rule::BatchShift, 0.02, finding);
        let says = |verdict: Verdict| verdict.messages().iter().any(|message| message.code == "batch_beside_others");
        assert!(
            says(told) && !says(Verdict { state: State::Indeterminate, ..told }),
            "the rest of the fleet has moved too"
        );
    }

    #[test]
    fn the_turn_is_that_of_the_difference() {
        // D_S of 5 deg/(h g0): 0.02 below is a turn of -0.004 rad, -13.75 arcmin.
        let finding = Finding::Closure { level: 3.0, since: None, moved: false, now: 2.98, d_s: Some(5.0) };
        let messages = exceeded(Rule::Closure, 0.02, finding).messages();
        assert_eq!(parameter(&messages, "closure_turn", "turn"), "-13.8".into());
    }

    #[test]
    fn the_percentage_is_of_the_limit() {
        let messages = exceeded(Rule::Step, 0.025, Finding::Step { level: 3.0, now: 3.025 }).messages();
        assert_eq!(parameter(&messages, "limit_exceeded", "percent"), "250".into());
    }
}
