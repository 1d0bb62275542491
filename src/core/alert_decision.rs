//! When to tell somebody: earlier alert + verdict + now in, next alert + action out.
//!
//! There is one alert per gyro, coefficient and rule. It follows the verdict on the gyro's *newest* record. A late
//! record is history, not news: it leaves the alert as all records do in the order of time. The caller keeps the state
//! and does the telling; nothing here knows a clock, a person or a hook.

use super::judge::{Finding, Rule, Severity, State, Verdict};
use super::time::UtcMicros;
use crate::core::named::named;

/// How an alert behaves between verdicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Policy {
    /// A firing alert that nobody acknowledged is told again after so many days.
    pub repeat_days: f64,
    /// Hysteresis: one verdict within resolves where its value is below this fraction of the limit,
    pub resolve_below: f64,
    /// and otherwise so many campaigns in a row that lie within.
    pub resolve_after: u32,
    /// What a gyro did longer ago than so many days, when it is found, is history: see [`Late`].
    pub backfill_days: f64,
}

impl Default for Policy {
    fn default() -> Self {
        Self { repeat_days: 7.0, resolve_below: 0.8, resolve_after: 2, backfill_days: 30.0 }
    }
}

/// What is told of what is found late: longer than [`Policy::backfill_days`] after the gyro did it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Late {
    /// Everything, as though it had just been done.
    Told,
    /// Nothing by a record that is old; a recent record that exceeds is told, however long the gyro has done so.
    #[default]
    Quiet,
    /// An import: what fires since long ago waits for the digest at its end.
    Digest,
    /// An import: what fires since long ago is told to nobody.
    Never,
    /// The clock judges, and no record: what was suppressed stays so.
    Clock,
}

named! {
/// Whether an alert fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    Firing = "firing",
    Resolved = "resolved",
}
}

named! {
/// How an alert stands for whoever looks at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AlertState {
    Firing = "firing",
    /// Firing, and somebody knows.
    Acknowledged = "acknowledged",
    /// Firing, and nobody is told before a time.
    Silenced = "silenced",
    /// Firing, and the alert of a station or an IMU explains it: nobody is told while that fires.
    Inhibited = "inhibited",
    Resolved = "resolved",
}
}

/// What is kept of an alert. Who acknowledged or silenced it, and why, is kept beside it by the caller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alert {
    pub status: Status,
    pub severity: Severity,
    /// When the gyro began to do this: the time of the record that began the episode.
    pub since: UtcMicros,
    /// When that was found.
    pub fired_at: UtcMicros,
    pub resolved_at: Option<UtcMicros>,
    /// The record that was judged last.
    pub record_at: UtcMicros,
    /// Campaigns in a row that lay within since the last that did not.
    pub within: u32,
    pub acknowledged: bool,
    pub silenced_until: Option<UtcMicros>,
    /// Until when a silence of many alerts holds for this one.
    pub muted_until: Option<UtcMicros>,
    /// Another alert explains it.
    pub inhibited: bool,
    /// Nobody is told that it fires, or that it has become worse: it was found late.
    pub suppressed: Option<Suppressed>,
    /// What the world believes: that it fires, as it was last told; none where it believes that all is well.
    pub last_notification: Option<LastNotification>,
}

impl Alert {
    /// How the alert is shown at `now`: resolved, else the first of silenced, inhibited and acknowledged that holds,
    /// else firing.
    pub fn standing(&self, now: UtcMicros) -> AlertState {
        match self.status {
            Status::Resolved => AlertState::Resolved,
            Status::Firing if is_silenced(self, now) => AlertState::Silenced,
            Status::Firing if self.inhibited => AlertState::Inhibited,
            Status::Firing if self.acknowledged => AlertState::Acknowledged,
            Status::Firing => AlertState::Firing,
        }
    }
}

/// An alert was found so late that it is not told by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Suppressed {
    pub at: UtcMicros,
    /// It waits for the digest of an import.
    pub digest: bool,
}

/// A verdict on the newest record of a gyro comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// When the record was calibrated.
    pub record_at: UtcMicros,
    pub now: UtcMicros,
    pub late: Late,
    /// Until when a silence of many alerts holds for this one.
    pub muted_until: Option<UtcMicros>,
    /// Whether another alert explains what is beyond a limit.
    pub inhibited: bool,
}

/// The last that was told of a firing alert.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastNotification {
    pub at: UtcMicros,
    pub severity: Severity,
}

named! {
/// What to tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// It fires.
    Fire = "fire",
    /// It fires still, and a second campaign has confirmed it.
    Escalate = "escalate",
    /// It fires still, but what had confirmed it counts no more.
    Lower = "lower",
    /// It fires still.
    Repeat = "repeat",
    /// It fires no more.
    Resolve = "resolve",
    /// Nothing to tell.
    Silent = "silent",
}
}

/// The alert as it is to be kept (none: there is none), and what to tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    pub alert: Option<Alert>,
    pub action: Action,
}

/// Follows a new verdict on the newest record, which was calibrated at `record_at`.
///
/// * Exceeded fires. A confirmed violation of a specification escalates: it is told again, acknowledged or not.
/// * Within resolves, with the hysteresis of the policy.
/// * Indeterminate by uncertainty changes nothing. Too few records never fire either; they resolve what fires, because
///   an event has restarted the history or the rule's window has moved on.
pub fn follow(
    earlier: Option<&Alert>,
    verdict: &Verdict,
    record_at: UtcMicros,
    now: UtcMicros,
    policy: &Policy,
) -> Decision {
    let muted_until = earlier.and_then(|alert| alert.muted_until);
    follow_arrival(
        earlier,
        verdict,
        &Arrival { record_at, now, late: Late::Told, muted_until, inhibited: false },
        policy,
    )
}

/// As [`follow`], where what is found late is not told like the rest.
pub fn follow_arrival(earlier: Option<&Alert>, verdict: &Verdict, arrival: &Arrival, policy: &Policy) -> Decision {
    let firing = earlier.filter(|alert| alert.status == Status::Firing);
    let alert = match (firing, verdict.severity()) {
        (Some(alert), _) => go_on(alert, verdict, arrival, policy),
        (None, Some(severity)) => begin(earlier, verdict, severity, arrival),
        (None, None) => return Decision { alert: earlier.copied(), action: Action::Silent },
    };
    come_to(alert, verdict, arrival, policy)
}

/// As [`follow_arrival`], where records have come late, or count no more: an alert that fires is as it comes out of all that
/// there are, followed in the order of time, and so is one that is not known; `left`: as it then fires, `fired_at` the last
/// record that exceeds, none where it does not.
pub fn hear_again(
    earlier: Option<&Alert>,
    left: Option<&Alert>,
    verdict: &Verdict,
    arrival: &Arrival,
    policy: &Policy,
) -> Decision {
    let firing = earlier.filter(|alert| alert.status == Status::Firing);
    match (firing, left) {
        (None, Some(fires)) => {
            let alert = settled(&begin(earlier, verdict, fires.severity, arrival), left, arrival.now);
            // Who hears of it depends on the last record that exceeds.
            come_to(alert, verdict, &Arrival { record_at: fires.fired_at, ..*arrival }, policy)
        }
        (Some(alert), _) if left.is_some() || verdict.severity().is_none() => {
            come_to(settled(alert, left, arrival.now), verdict, arrival, policy)
        }
        _ => follow_arrival(earlier, verdict, arrival, policy),
    }
}

/// As [`hear_again`], of an alert that fires, where the verdict on the newest record stands as it was.
pub fn settle(alert: &Alert, rule: Rule, left: Option<&Alert>, arrival: &Arrival, policy: &Policy) -> Decision {
    let alert = settled(alert, left, arrival.now);
    // The newest record has found nothing that it did not before.
    let exceeds = alert.within == 0 && alert.suppressed.is_none();
    let suppressed = suppress(&alert, (rule, exceeds), arrival, policy);
    announce(Alert { suppressed, ..alert }, arrival.now)
}

/// An alert that fires, as it is by what is left.
pub fn settled(alert: &Alert, left: Option<&Alert>, now: UtcMicros) -> Alert {
    let Some(&Alert { severity, since, record_at, within, .. }) = left else { return end(*alert, now) };
    let acknowledged = alert.acknowledged && severity <= alert.severity;
    Alert { severity, since, record_at, within, acknowledged, ..*alert }
}

/// An alert as a verdict has made it, and what is told of it.
fn come_to(alert: Alert, verdict: &Verdict, arrival: &Arrival, policy: &Policy) -> Decision {
    let Arrival { now, muted_until, inhibited, .. } = *arrival;
    let suppressed = suppress(&alert, (verdict.rule, verdict.severity().is_some()), arrival, policy);
    // What does not exceed is explained by nothing: it stays as it was.
    let inhibited = if verdict.state == State::Exceeded { inhibited } else { alert.inhibited };
    announce(Alert { muted_until, inhibited: inhibited && alert.status == Status::Firing, suppressed, ..alert }, now)
}

/// Whether nobody is told what a verdict by `rule`, which exceeds or does not, has made of an alert.
fn suppress(alert: &Alert, (rule, exceeds): (Rule, bool), arrival: &Arrival, policy: &Policy) -> Option<Suppressed> {
    let is_news = alert.last_notification.is_none_or(|told| alert.severity > told.severity);
    if alert.status == Status::Resolved || !is_news {
        return None;
    }
    let old = |at: UtcMicros| arrival.now.days_since(at) > policy.backfill_days;
    let did = if rule == Rule::Overdue { alert.since } else { arrival.record_at };
    let began = if alert.last_notification.is_some() { did } else { alert.since };
    let (is_suppressed, digest) = match arrival.late {
        Late::Told => (false, false),
        Late::Clock => (alert.suppressed.is_some(), false),
        Late::Quiet => (old(did) || !exceeds && alert.suppressed.is_some(), false),
        // What nobody has calibrated is no news of a record: it waits with all else that the import has found.
        Late::Digest => (rule == Rule::Overdue || old(began), true),
        Late::Never => (old(began), false),
    };
    let waits = alert.suppressed.is_some_and(|suppressed| suppressed.digest);
    let at = alert
        .suppressed
        .filter(|suppressed| suppressed.digest && !digest)
        .map_or(arrival.now, |suppressed| suppressed.at);
    is_suppressed.then_some(Suppressed { at, digest: digest || waits })
}

/// What a hook is told of an alert that has changed or is repeated, where it has heard last that the alert fires with
/// the severity `heard`, or that all is well.
///
/// It never hears more of what it did not hear fire, and always hears the end of what it did.
pub fn for_hook(alert: &Alert, heard: Option<Severity>, action: Action, now: UtcMicros) -> Option<Action> {
    if is_held_back(alert, now) {
        return None;
    }
    match (alert.status, heard) {
        (Status::Resolved, Some(_)) => Some(Action::Resolve),
        (Status::Resolved, None) => None,
        (Status::Firing, None) => alert.suppressed.is_none().then_some(Action::Fire),
        (Status::Firing, Some(heard)) if alert.severity > heard && alert.suppressed.is_none() => Some(Action::Escalate),
        (Status::Firing, Some(heard)) if alert.severity < heard => Some(Action::Lower),
        (Status::Firing, Some(_)) => (action == Action::Repeat).then_some(Action::Repeat),
    }
}

/// The digest of an import tells of an alert that waited for it. None where it does not fire, did not wait, or is
/// silenced: then the end of the silence tells it.
pub fn digest(alert: &Alert, now: UtcMicros) -> Option<Decision> {
    alert.suppressed.filter(|suppressed| suppressed.digest)?;
    Some(announce(Alert { suppressed: None, ..*alert }, now))
}

/// Nobody is told while another alert explains this one; what is then still untold is told at its end.
pub fn inhibit(alert: &Alert, inhibited: bool, now: UtcMicros) -> Decision {
    announce(Alert { inhibited: inhibited && alert.status == Status::Firing, ..*alert }, now)
}

/// Follows the clock: repeats what fires, and tells at the end of a silence what it held back.
pub fn tick(alert: &Alert, now: UtcMicros, policy: &Policy) -> Decision {
    let going_on = |until: &UtcMicros| now < *until;
    let (silenced_until, muted_until) = (alert.silenced_until.filter(going_on), alert.muted_until.filter(going_on));
    let alert = &Alert { silenced_until, muted_until, ..*alert };
    let decision = announce(*alert, now);
    let (Action::Silent, Some(told)) = (decision.action, alert.last_notification) else { return decision };
    if alert.status == Status::Resolved || alert.acknowledged || is_held_back(alert, now) {
        return decision;
    }
    let told_now = Some(LastNotification { at: now, ..told });
    // A clock set back: count from here, so that the alert does not fall silent for as long as it was set back.
    let action = match now.days_since(told.at) {
        days if days < 0.0 => Action::Silent,
        days if days >= policy.repeat_days => Action::Repeat,
        _ => return decision,
    };
    Decision { alert: Some(Alert { last_notification: told_now, ..*alert }), action }
}

/// An event has reset the rule, or the rule has been switched off: what fires is resolved.
pub fn reset(alert: &Alert, now: UtcMicros) -> Decision {
    match alert.status {
        Status::Firing => announce(end(*alert, now), now),
        Status::Resolved => Decision { alert: Some(*alert), action: Action::Silent },
    }
}

/// What ended the alert counts no more, and by what is `left` it fires: it goes on, known to those who knew of it, where
/// it is the same episode. What it began with may be `gone`, too.
pub fn resume(alert: &Alert, left: &Alert, gone: bool) -> Alert {
    let since = if gone { left.since } else { alert.since };
    match alert.status {
        Status::Firing => Alert { since, ..*alert },
        // It fired until the record that ended it.
        Status::Resolved if left.since <= alert.record_at => {
            let Alert { severity, record_at, within, .. } = *left;
            let acknowledged = alert.acknowledged && severity <= alert.severity;
            let status = Status::Firing;
            Alert { status, severity, since, record_at, within, acknowledged, resolved_at: None, ..*alert }
        }
        Status::Resolved => *alert,
    }
}

/// What confirmed the alert counts no more: what is left bears out this severity alone.
pub fn lower(alert: &Alert, severity: Severity, now: UtcMicros) -> Decision {
    announce(Alert { severity: alert.severity.min(severity), ..*alert }, now)
}

/// Acknowledged: no more repeats. Escalation and resolution are still told.
pub fn acknowledge(alert: &Alert) -> Alert {
    Alert { acknowledged: true, ..*alert }
}

/// Nobody does, after all: repeats go on.
pub fn unacknowledge(alert: &Alert) -> Alert {
    Alert { acknowledged: false, ..*alert }
}

/// Nothing is told before `until`; what is then still untold is told by the next [`tick`].
pub fn silence(alert: &Alert, until: Option<UtcMicros>) -> Alert {
    Alert { silenced_until: until, ..*alert }
}

/// A silence, and what the world believes, outlive the episode that they began in; an acknowledgement does not.
fn begin(earlier: Option<&Alert>, verdict: &Verdict, severity: Severity, arrival: &Arrival) -> Alert {
    let Arrival { record_at, now, .. } = *arrival;
    Alert {
        status: Status::Firing,
        severity,
        since: began(verdict, record_at),
        fired_at: now,
        resolved_at: None,
        record_at,
        within: 0,
        acknowledged: false,
        silenced_until: earlier.and_then(|alert| alert.silenced_until),
        muted_until: earlier.and_then(|alert| alert.muted_until),
        inhibited: false,
        suppressed: None,
        last_notification: earlier.and_then(|alert| alert.last_notification),
    }
}

/// When what a verdict says began, if it says so of this record for the first time.
fn began(verdict: &Verdict, record_at: UtcMicros) -> UtcMicros {
    match (verdict.rule, verdict.finding) {
        // A gyro is overdue from the interval on, which is the limit.
        (Rule::Overdue, _) => record_at.plus_days(verdict.limit),
        (_, Finding::GroupShift { since, .. }) => since,
        _ => record_at,
    }
}

fn go_on(alert: &Alert, verdict: &Verdict, arrival: &Arrival, policy: &Policy) -> Alert {
    let Arrival { record_at, now, .. } = *arrival;
    if verdict.rule == Rule::Overdue {
        // Days have no scatter, and a calibration that is itself too long ago leaves nothing of the one before.
        let alert = Alert { record_at, ..*alert };
        let is_over = verdict.state == State::Within;
        return if is_over { end(alert, now) } else { Alert { since: began(verdict, record_at), ..alert } };
    }
    let another_campaign = alert.record_at != record_at || alert.within == 0;
    // A requirement is judged without a history: that a second campaign says the same shows only here.
    let of_requirement = verdict.rule == Rule::Requirement;
    let confirmed = verdict.confirmed || of_requirement && alert.record_at != record_at;
    let alert = Alert { record_at, ..*alert };
    match verdict.state {
        State::Exceeded => escalate(Alert { within: 0, ..alert }, Verdict { confirmed, ..*verdict }.severity()),
        State::Within => {
            let within = alert.within + u32::from(another_campaign);
            let alert = Alert { within, ..alert };
            // The limit of a requirement is a bound of an interval: a fraction of it means nothing.
            let far_within =
                !of_requirement && verdict.value.is_some_and(|value| value <= policy.resolve_below * verdict.limit);
            if far_within || within >= policy.resolve_after { end(alert, now) } else { alert }
        }
        // There were too few records.
        State::Indeterminate if verdict.value.is_none() => end(alert, now),
        State::Indeterminate => alert,
    }
}

/// The severity of an episode never falls but by [`lower`]. A rise ends the acknowledgement, which was of something lesser.
fn escalate(alert: Alert, severity: Option<Severity>) -> Alert {
    match severity {
        Some(severity) if severity > alert.severity => Alert { severity, acknowledged: false, ..alert },
        _ => alert,
    }
}

fn end(alert: Alert, now: UtcMicros) -> Alert {
    Alert { status: Status::Resolved, resolved_at: Some(now), inhibited: false, suppressed: None, ..alert }
}

fn is_silenced(alert: &Alert, now: UtcMicros) -> bool {
    alert.silenced_until.max(alert.muted_until).is_some_and(|until| now < until)
}

fn is_held_back(alert: &Alert, now: UtcMicros) -> bool {
    alert.inhibited || is_silenced(alert, now)
}

/// Tells the difference between what is and what the world believes, unless silenced or inhibited.
fn announce(alert: Alert, now: UtcMicros) -> Decision {
    let action = match (alert.status, alert.last_notification) {
        _ if is_held_back(&alert, now) => Action::Silent,
        (Status::Firing, _) if alert.suppressed.is_some() => Action::Silent,
        (Status::Firing, None) => Action::Fire,
        (Status::Firing, Some(told)) if alert.severity > told.severity => Action::Escalate,
        (Status::Firing, Some(told)) if alert.severity < told.severity => Action::Lower,
        (Status::Resolved, Some(_)) => Action::Resolve,
        _ => Action::Silent,
    };
    let told = match action {
        Action::Silent => alert.last_notification,
        Action::Resolve => None,
        _ => Some(LastNotification { at: now, severity: alert.severity }),
    };
    Decision { alert: Some(Alert { last_notification: told, ..alert }), action }
}

#[cfg(test)]
mod tests;
