use super::*;
use crate::core::judge::{Coefficient, Finding, Limit, LimitKey, Rule};

const POLICY: Policy = Policy { repeat_days: 7.0, resolve_below: 0.8, resolve_after: 2, backfill_days: 30.0 };

fn day(n: f64) -> UtcMicros {
    UtcMicros(1_767_225_600_000_000).plus_days(n)
}

fn verdict(rule: Rule, state: State, value: f64, confirmed: bool) -> Verdict {
    let limit = Limit { value: 0.01, from: LimitKey::BUDGET };
    let finding = Finding::Baseline { level: 3.0, since: None, now: 3.0 + value };
    Verdict { state, value: Some(value), confirmed, ..Verdict::undecided(Coefficient::DI, rule, limit, finding) }
}

fn exceeded() -> Verdict {
    verdict(Rule::Baseline, State::Exceeded, 0.012, false)
}

fn confirmed() -> Verdict {
    verdict(Rule::Baseline, State::Exceeded, 0.012, true)
}

fn within(value: f64) -> Verdict {
    verdict(Rule::Baseline, State::Within, value, false)
}

fn straddling() -> Verdict {
    verdict(Rule::Baseline, State::Indeterminate, 0.0102, false)
}

fn too_few() -> Verdict {
    Verdict { value: None, finding: Finding::TooFew { have: 1, need: 3 }, ..straddling() }
}

/// One alert followed through verdicts and ticks; a record is calibrated when it arrives.
#[derive(Default)]
struct AlertTimeline {
    alert: Option<Alert>,
}

impl AlertTimeline {
    fn record(&mut self, at: f64, verdict: &Verdict) -> Action {
        let decision = follow(self.alert.as_ref(), verdict, day(at), day(at), &POLICY);
        self.alert = decision.alert;
        decision.action
    }

    fn tick(&mut self, at: f64) -> Action {
        let decision = tick(&self.alert.expect("an alert"), day(at), &POLICY);
        self.alert = decision.alert;
        decision.action
    }

    fn silence(&mut self, until: f64) {
        self.alert = self.alert.map(|alert| silence(&alert, Some(day(until))));
    }

    fn status(&self) -> Option<Status> {
        self.alert.map(|alert| alert.status)
    }
}

#[test]
fn an_exceeded_limit_fires_once_and_resolves_once() {
    let mut timeline = AlertTimeline::default();
    assert_eq!(timeline.record(0.0, &within(0.001)), Action::Silent);
    assert_eq!(timeline.status(), None);
    assert_eq!(timeline.record(14.0, &exceeded()), Action::Fire);
    assert_eq!(timeline.record(28.0, &exceeded()), Action::Silent);
    assert_eq!(timeline.record(42.0, &within(0.002)), Action::Resolve);
    assert_eq!(timeline.record(56.0, &within(0.002)), Action::Silent);
    assert_eq!(timeline.record(70.0, &exceeded()), Action::Fire);
}

#[test]
fn a_second_campaign_escalates_even_what_was_acknowledged() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    timeline.alert = timeline.alert.map(|alert| acknowledge(&alert));
    assert_eq!(timeline.record(12.0, &exceeded()), Action::Silent);
    assert!(timeline.alert.unwrap().acknowledged, "the same severity is no news");
    assert_eq!(timeline.tick(10.0), Action::Silent, "acknowledged: no repeats");
    assert_eq!(timeline.record(14.0, &confirmed()), Action::Escalate);
    assert_eq!(timeline.alert.unwrap().severity, Severity::Critical);
    assert!(!timeline.alert.unwrap().acknowledged);
    assert_eq!(timeline.record(28.0, &confirmed()), Action::Silent);
    assert_eq!(timeline.record(42.0, &exceeded()), Action::Silent, "an episode's severity never falls");
}

#[test]
fn a_step_that_the_next_campaign_confirms_goes_on_firing_and_escalates() {
    let step = |state, value, confirmed| verdict(Rule::Step, state, value, confirmed);
    let mut timeline = AlertTimeline::default();
    assert_eq!(timeline.record(0.0, &step(State::Exceeded, 0.02, false)), Action::Fire);
    assert_eq!(timeline.record(14.0, &step(State::Exceeded, 0.021, true)), Action::Escalate);
    assert_eq!(timeline.status(), Some(Status::Firing));
    assert_eq!(timeline.record(28.0, &step(State::Within, 0.001, false)), Action::Resolve);
}

#[test]
fn a_requirement_missed_by_a_second_campaign_escalates_and_two_that_keep_it_resolve() {
    let requirement = |state| verdict(Rule::Requirement, state, -0.6, false);
    let mut timeline = AlertTimeline::default();
    assert_eq!(timeline.record(0.0, &requirement(State::Exceeded)), Action::Fire);
    assert_eq!(timeline.record(0.0, &requirement(State::Exceeded)), Action::Silent, "the same campaign again");
    assert_eq!(timeline.record(14.0, &requirement(State::Exceeded)), Action::Escalate);
    assert_eq!(timeline.record(28.0, &requirement(State::Within)), Action::Silent);
    assert_eq!(timeline.record(42.0, &requirement(State::Within)), Action::Resolve);
}

#[test]
fn how_an_alert_stands_is_told_by_what_people_said_and_by_the_time() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    let alert = timeline.alert.unwrap();
    let known = acknowledge(&alert);
    assert_eq!(alert.standing(day(1.0)), AlertState::Firing);
    assert_eq!(known.standing(day(1.0)), AlertState::Acknowledged);
    let silenced = silence(&known, Some(day(5.0)));
    assert_eq!(silenced.standing(day(4.9)), AlertState::Silenced);
    assert_eq!(silenced.standing(day(5.0)), AlertState::Acknowledged);
    assert_eq!(reset(&silenced, day(2.0)).alert.unwrap().standing(day(2.0)), AlertState::Resolved);
}

#[test]
fn near_the_limit_it_takes_two_campaigns_to_resolve() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    assert_eq!(timeline.record(14.0, &within(0.0095)), Action::Silent);
    assert_eq!(
        timeline.record(14.0, &within(0.0095)),
        Action::Silent,
        "the same record judged again is no second campaign"
    );
    assert_eq!(timeline.record(28.0, &exceeded()), Action::Silent, "no flapping: it never stopped firing");
    assert_eq!(timeline.record(42.0, &within(0.0095)), Action::Silent);
    assert_eq!(timeline.record(56.0, &within(0.0095)), Action::Resolve);
}

#[test]
fn what_is_uncertain_or_sparse_neither_fires_nor_takes_back() {
    let mut timeline = AlertTimeline::default();
    assert_eq!(timeline.record(0.0, &too_few()), Action::Silent);
    assert_eq!(timeline.record(14.0, &straddling()), Action::Silent);
    assert_eq!(timeline.status(), None);
    timeline.record(28.0, &exceeded());
    assert_eq!(timeline.record(42.0, &straddling()), Action::Silent);
    assert_eq!(timeline.status(), Some(Status::Firing));
    assert_eq!(timeline.record(56.0, &too_few()), Action::Resolve, "the history was restarted");
}

#[test]
fn a_firing_alert_repeats_until_it_is_acknowledged() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    assert_eq!(timeline.tick(6.9), Action::Silent);
    assert_eq!(timeline.tick(7.0), Action::Repeat);
    assert_eq!(timeline.tick(7.1), Action::Silent);
    assert_eq!(timeline.tick(14.0), Action::Repeat);
    timeline.alert = timeline.alert.map(|alert| acknowledge(&alert));
    assert_eq!(timeline.tick(40.0), Action::Silent);
}

#[test]
fn a_silence_holds_back_and_loses_nothing() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    timeline.silence(20.0);
    assert_eq!(timeline.record(5.0, &confirmed()), Action::Silent);
    assert_eq!(timeline.tick(19.9), Action::Silent);
    assert!(timeline.alert.unwrap().silenced_until.is_some());
    assert_eq!(timeline.tick(20.0), Action::Escalate, "what was escalated under the silence is told at its end");
    assert_eq!(timeline.alert.unwrap().silenced_until, None, "it is over");

    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    timeline.silence(20.0);
    assert_eq!(timeline.record(5.0, &within(0.001)), Action::Silent);
    assert_eq!(timeline.tick(20.0), Action::Resolve, "nobody is left believing that it fires");
    assert_eq!(timeline.tick(21.0), Action::Silent);

    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    timeline.record(1.0, &within(0.001));
    timeline.silence(20.0);
    assert_eq!(timeline.record(5.0, &exceeded()), Action::Silent);
    assert_eq!(timeline.record(6.0, &within(0.001)), Action::Silent);
    assert_eq!(timeline.tick(20.0), Action::Silent, "what came and went in silence is not told");
    assert_eq!(timeline.record(30.0, &exceeded()), Action::Fire);
}

#[test]
fn a_clock_that_jumps_neither_doubles_nor_loses_an_alert() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    assert_eq!(timeline.tick(3650.0), Action::Repeat);
    assert_eq!(timeline.tick(3650.1), Action::Silent);
    assert_eq!(timeline.tick(1.0), Action::Silent, "set back ten years");
    assert_eq!(timeline.tick(7.9), Action::Silent);
    assert_eq!(timeline.tick(8.0), Action::Repeat, "it repeats on the new clock");
}

#[test]
fn an_event_that_resets_the_rule_resolves_the_alert() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    let decision = reset(&timeline.alert.unwrap(), day(1.0));
    assert_eq!(decision.action, Action::Resolve);
    assert_eq!(decision.alert.unwrap().resolved_at, Some(day(1.0)));
    assert_eq!(reset(&decision.alert.unwrap(), day(2.0)).action, Action::Silent);
}

/// A record comes in on its own day.
fn on(at: f64) -> Arrival {
    Arrival { record_at: day(at), now: day(at), late: Late::Told, muted_until: None, inhibited: false }
}

/// A record of one day comes in on another.
fn heard(alert: Option<&Alert>, verdict: &Verdict, record_at: f64, now: f64, late: Late) -> Decision {
    follow_arrival(alert, verdict, &Arrival { now: day(now), late, ..on(record_at) }, &POLICY)
}

#[test]
fn an_alert_knows_since_when_the_gyro_does_it_and_when_that_was_found() {
    let alert = heard(None, &exceeded(), 100.0, 400.0, Late::Told).alert.unwrap();
    assert_eq!((alert.since, alert.fired_at), (day(100.0), day(400.0)));
    let later = heard(Some(&alert), &confirmed(), 120.0, 420.0, Late::Told).alert.unwrap();
    assert_eq!((later.since, later.fired_at), (day(100.0), day(400.0)), "the same episode");
    let ended = heard(Some(&later), &within(0.001), 130.0, 430.0, Late::Told).alert.unwrap();
    let again = heard(Some(&ended), &exceeded(), 140.0, 440.0, Late::Told).alert.unwrap();
    assert_eq!(again.since, day(140.0));
    let alert = heard(None, &overdue(100.0, 400.0), 100.0, 400.0, Late::Clock).alert.unwrap();
    assert_eq!(alert.since, day(190.0), "overdue since the interval was over");
}

fn overdue(last: f64, now: f64) -> Verdict {
    let days = Limit { value: 90.0, from: LimitKey::BUDGET };
    crate::core::judge::overdue(day(last), day(now), days)
}

#[test]
fn what_is_overdue_is_so_since_its_last_calibration_says_and_ends_with_the_next_however_near_the_interval() {
    let first = heard(None, &overdue(100.0, 400.0), 100.0, 400.0, Late::Digest).alert.unwrap();
    // The import goes on with a later calibration, which is too long ago as well.
    let later = heard(Some(&first), &overdue(309.0, 400.0), 309.0, 400.0, Late::Digest);
    let alert = later.alert.unwrap();
    assert_eq!((alert.since, alert.fired_at), (day(399.0), day(400.0)), "since the day on which that became overdue");
    assert_eq!((later.action, alert.suppressed.map(|suppressed| suppressed.digest)), (Action::Silent, Some(true)));
    let told = digest(&alert, day(400.0)).unwrap();
    assert_eq!(told.action, Action::Fire);
    // 85 of 90 days: within is within.
    let ended = heard(told.alert.as_ref(), &overdue(315.0, 400.0), 315.0, 400.0, Late::Quiet);
    assert_eq!((ended.action, ended.alert.unwrap().status), (Action::Resolve, Status::Resolved));
}

#[test]
fn an_old_record_that_is_sent_by_itself_is_told_to_nobody_and_a_recent_one_that_exceeds_too_is() {
    for (now, action) in [(29.9, Action::Fire), (30.1, Action::Silent)] {
        assert_eq!(heard(None, &exceeded(), 0.0, now, Late::Quiet).action, action, "{now} days");
    }
    let old = heard(None, &exceeded(), 0.0, 400.0, Late::Quiet).alert.unwrap();
    assert_eq!((old.status, old.suppressed.map(|suppressed| suppressed.digest)), (Status::Firing, Some(false)));
    assert_eq!(tick(&old, day(430.0), &POLICY).action, Action::Silent, "nor is it told later");
    let escalated = heard(Some(&old), &confirmed(), 14.0, 400.0, Late::Quiet);
    assert_eq!((escalated.action, escalated.alert.unwrap().severity), (Action::Silent, Severity::Critical));
    let unsure = heard(Some(&old), &straddling(), 399.0, 400.0, Late::Quiet);
    assert_eq!(unsure.action, Action::Silent, "a recent record that does not exceed is no news");
    let recent = heard(unsure.alert.as_ref(), &exceeded(), 399.0, 400.0, Late::Quiet);
    assert_eq!((recent.action, recent.alert.unwrap().since), (Action::Fire, day(0.0)));
    let ended = heard(Some(&old), &within(0.001), 399.0, 400.0, Late::Quiet);
    assert_eq!(
        (ended.action, ended.alert.unwrap().suppressed),
        (Action::Silent, None),
        "nobody believes that it fires"
    );
}

#[test]
fn an_import_keeps_what_fires_since_long_ago_for_its_digest_or_to_itself() {
    let waits = heard(None, &exceeded(), 0.0, 400.0, Late::Digest);
    let alert = waits.alert.unwrap();
    assert_eq!((waits.action, alert.suppressed), (Action::Silent, Some(Suppressed { at: day(400.0), digest: true })));
    let recent = heard(Some(&alert), &exceeded(), 399.0, 400.0, Late::Digest);
    assert_eq!(recent.action, Action::Silent, "since long ago, so the digest tells it");
    assert_eq!(
        heard(None, &exceeded(), 399.0, 400.0, Late::Digest).action,
        Action::Fire,
        "recent ones are told as ever"
    );
    let told = digest(&alert, day(401.0)).unwrap();
    assert_eq!((told.action, told.alert.unwrap().suppressed), (Action::Fire, None));
    assert_eq!(digest(&told.alert.unwrap(), day(401.0)), None, "once");
    let silenced = digest(&silence(&alert, Some(day(500.0))), day(401.0)).unwrap();
    assert_eq!(silenced.action, Action::Silent);
    assert_eq!(tick(&silenced.alert.unwrap(), day(500.0), &POLICY).action, Action::Fire, "at the end of the silence");
    let never = heard(None, &exceeded(), 0.0, 400.0, Late::Never).alert.unwrap();
    assert_eq!(digest(&never, day(401.0)), None);
    assert_eq!(heard(Some(&never), &exceeded(), 399.0, 400.0, Late::Never).action, Action::Silent);
    assert_eq!(heard(None, &exceeded(), 0.0, 400.0, Late::Told).action, Action::Fire);
}

#[test]
fn what_was_told_long_ago_is_told_its_end_whenever_that_is_found_and_a_late_rise_is_not_told_by_itself() {
    let told = heard(None, &exceeded(), 0.0, 1.0, Late::Quiet).alert.unwrap();
    let rise = heard(Some(&told), &confirmed(), 14.0, 400.0, Late::Quiet);
    assert_eq!(rise.action, Action::Silent);
    assert_eq!(
        digest(&heard(Some(&told), &confirmed(), 14.0, 400.0, Late::Digest).alert.unwrap(), day(400.0)).unwrap().action,
        Action::Escalate
    );
    assert_eq!(heard(rise.alert.as_ref(), &within(0.001), 28.0, 400.0, Late::Quiet).action, Action::Resolve);
    assert_eq!(heard(Some(&told), &confirmed(), 399.0, 400.0, Late::Digest).action, Action::Escalate, "news of today");
}

#[test]
fn what_was_told_already_is_not_kept_back_when_it_is_found_once_more() {
    let told = heard(None, &exceeded(), 399.0, 400.0, Late::Quiet).alert.unwrap();
    let again = heard(Some(&told), &exceeded(), 14.0, 400.0, Late::Quiet).alert.unwrap();
    assert_eq!((again.severity, again.suppressed), (told.severity, None), "as severe as its hooks believe");
}

#[test]
fn without_what_confirmed_it_an_alert_is_lowered_and_whoever_was_told_more_hears_so() {
    let mut timeline = AlertTimeline::default();
    assert_eq!(
        [timeline.record(0.0, &exceeded()), timeline.record(1.0, &confirmed())],
        [Action::Fire, Action::Escalate]
    );
    let critical = timeline.alert.unwrap();
    let lowered = lower(&critical, Severity::Warning, day(2.0));
    let alert = lowered.alert.unwrap();
    assert_eq!((lowered.action, alert.severity, alert.since), (Action::Lower, Severity::Warning, critical.since));
    timeline.alert = lowered.alert;
    assert_eq!(timeline.record(3.0, &confirmed()), Action::Escalate, "another record confirms it anew");
    let silenced = lower(&silence(&critical, Some(day(9.0))), Severity::Warning, day(2.0));
    assert_eq!(silenced.action, Action::Silent);
    assert_eq!(tick(&silenced.alert.unwrap(), day(9.0), &POLICY).action, Action::Lower, "told when the silence ends");
}

#[test]
fn what_ended_by_a_record_that_counts_no_more_goes_on_as_it_was() {
    let fires = heard(None, &exceeded(), 10.0, 10.0, Late::Told).alert.unwrap();
    let known = acknowledge(&fires);
    let ended = heard(Some(&known), &within(0.001), 30.0, 30.0, Late::Told).alert.unwrap();
    let goes_on = resume(&ended, &Alert { record_at: day(20.0), ..fires }, false);
    assert_eq!(goes_on, Alert { record_at: day(20.0), last_notification: None, ..known });
    let told = heard(Some(&goes_on), &exceeded(), 20.0, 31.0, Late::Told);
    assert_eq!(told.action, Action::Fire, "those who heard of its end hear that it fires");
    assert!(told.alert.unwrap().acknowledged);
    // What is left begins after the record that ended it: another episode.
    assert_eq!(resume(&ended, &Alert { since: day(40.0), ..fires }, false), ended);
    assert_eq!(resume(&fires, &Alert { since: day(15.0), ..fires }, true).since, day(15.0));
}

#[test]
fn an_alert_is_as_all_records_make_it_where_some_come_late() {
    let fires = heard(None, &exceeded(), 10.0, 10.0, Late::Told).alert.unwrap();
    let again = |alert: Option<&Alert>, left: Option<&Alert>, verdict: &Verdict| {
        hear_again(alert, left, verdict, &Arrival { now: day(30.0), ..on(20.0) }, &POLICY)
    };
    let left = Alert { since: day(5.0), severity: Severity::Critical, record_at: day(20.0), within: 1, ..fires };
    let graver = again(Some(&acknowledge(&fires)), Some(&left), &within(0.0095));
    let alert = graver.alert.unwrap();
    assert_eq!((graver.action, alert.since, alert.within), (Action::Escalate, day(5.0), 1));
    assert!(!alert.acknowledged);
    assert_eq!(again(Some(&fires), None, &within(0.0095)).action, Action::Resolve, "nothing bears it out");
    assert_eq!(again(None, None, &within(0.0095)), Decision { alert: None, action: Action::Silent });
    let begun = again(None, Some(&left), &exceeded());
    assert_eq!((begun.action, begun.alert.unwrap().since), (Action::Fire, day(5.0)));
    let goes_on = |arrival: Arrival| hear_again(None, Some(&left), &straddling(), &arrival, &POLICY);
    let begun = goes_on(on(20.0));
    assert_eq!((begun.action, begun.alert.unwrap().since), (Action::Fire, day(5.0)), "the newest has not ended it");
    let quiet = goes_on(Arrival { now: day(45.0), late: Late::Quiet, ..on(20.0) });
    assert_eq!((quiet.action, quiet.alert.unwrap().status), (Action::Silent, Status::Firing), "the last one is old");
    let settled = settle(&alert, Rule::Baseline, Some(&Alert { since: day(7.0), ..left }), &on(20.0), &POLICY);
    assert_eq!((settled.action, settled.alert.unwrap().since), (Action::Silent, day(7.0)));
}

#[test]
fn a_hook_hears_the_end_of_what_it_heard_fire_and_nothing_of_what_it_did_not() {
    let fires = heard(None, &exceeded(), 0.0, 0.0, Late::Told).alert.unwrap();
    let critical = Alert { severity: Severity::Critical, ..fires };
    let ended = reset(&fires, day(1.0)).alert.unwrap();
    let (warning, none) = (Some(Severity::Warning), None);
    let told = |alert: &Alert, heard, action| for_hook(alert, heard, action, day(2.0));
    assert_eq!(told(&ended, none, Action::Resolve), None);
    assert_eq!(told(&ended, warning, Action::Resolve), Some(Action::Resolve));
    assert_eq!(told(&fires, none, Action::Fire), Some(Action::Fire));
    assert_eq!(told(&critical, none, Action::Escalate), Some(Action::Fire), "it has not heard that it fires");
    assert_eq!(told(&critical, warning, Action::Escalate), Some(Action::Escalate));
    assert_eq!(told(&fires, none, Action::Repeat), Some(Action::Fire));
    assert_eq!(told(&fires, warning, Action::Repeat), Some(Action::Repeat));
    assert_eq!(told(&fires, warning, Action::Silent), None);
    assert_eq!(told(&fires, Some(Severity::Critical), Action::Silent), Some(Action::Lower));
    let suppressed = Alert { suppressed: Some(Suppressed { at: day(1.0), digest: false }), ..critical };
    assert_eq!((told(&suppressed, none, Action::Fire), told(&suppressed, warning, Action::Escalate)), (None, None));
    for silenced in [silence(&ended, Some(day(9.0))), Alert { muted_until: Some(day(9.0)), ..ended }] {
        assert_eq!(told(&silenced, warning, Action::Resolve), None);
        assert_eq!(for_hook(&silenced, warning, Action::Silent, day(9.0)), Some(Action::Resolve));
    }
}

#[test]
fn a_silence_of_many_holds_back_as_that_of_one_does_and_is_gone_at_its_end() {
    let arrival = Arrival { late: Late::Quiet, muted_until: Some(day(20.0)), ..on(0.0) };
    let muted = follow_arrival(None, &exceeded(), &arrival, &POLICY);
    let alert = muted.alert.unwrap();
    assert_eq!((muted.action, alert.standing(day(19.0))), (Action::Silent, AlertState::Silenced));
    assert_eq!(tick(&alert, day(19.9), &POLICY), Decision { alert: Some(alert), action: Action::Silent });
    let told = tick(&alert, day(20.0), &POLICY);
    assert_eq!((told.action, told.alert.unwrap().muted_until), (Action::Fire, None));
}

#[test]
fn an_acknowledgement_that_is_taken_back_lets_repeats_go_on() {
    let mut timeline = AlertTimeline::default();
    timeline.record(0.0, &exceeded());
    timeline.alert = timeline.alert.map(|alert| acknowledge(&alert));
    assert_eq!(timeline.tick(10.0), Action::Silent);
    timeline.alert = timeline.alert.map(|alert| unacknowledge(&alert));
    assert_eq!(timeline.tick(10.1), Action::Repeat);
}

mod properties {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, Clone)]
    enum Input {
        Verdict(Box<Verdict>),
        Tick,
        Acknowledge,
        Silence(f64),
        Reset,
        Lower,
    }

    fn happening() -> impl Strategy<Value = Input> {
        prop_oneof![
            4 => prop::sample::select(vec![
                exceeded(), confirmed(), within(0.001), within(0.0095), straddling(), too_few(),
                verdict(Rule::Step, State::Within, 0.001, true),
            ])
            .prop_map(|verdict| Input::Verdict(Box::new(verdict))),
            3 => Just(Input::Tick),
            1 => Just(Input::Acknowledge),
            1 => (0.0..40.0).prop_map(Input::Silence),
            1 => Just(Input::Reset),
            1 => Just(Input::Lower),
        ]
    }

    proptest! {
        /// Whoever hears only the actions knows the truth whenever no silence is on.
        #[test]
        fn a_listener_is_never_wrong_outside_a_silence(
            happenings in prop::collection::vec((happening(), 0.1..10.0), 1..80)
        ) {
            let (mut alert, mut now): (Option<Alert>, f64) = (None, 0.0);
            let (mut believes_firing, mut believes_critical) = (false, false);
            for (happening, days) in happenings {
                now += days;
                let decision = match (&happening, alert) {
                    (Input::Verdict(verdict), _) => follow(alert.as_ref(), verdict, day(now), day(now), &POLICY),
                    (_, None) => continue,
                    (Input::Tick, Some(alert)) => tick(&alert, day(now), &POLICY),
                    (Input::Acknowledge, Some(alert)) => {
                        Decision { alert: Some(acknowledge(&alert)), action: Action::Silent }
                    }
                    (Input::Silence(d), Some(alert)) => {
                        Decision { alert: Some(silence(&alert, Some(day(now + d)))), action: Action::Silent }
                    }
                    (Input::Reset, Some(alert)) => reset(&alert, day(now)),
                    (Input::Lower, Some(alert)) => lower(&alert, Severity::Warning, day(now)),
                };
                let is_critical = decision.alert.is_some_and(|alert| alert.severity == Severity::Critical);
                if decision.action != Action::Silent {
                    believes_critical = is_critical;
                }
                alert = decision.alert;
                match decision.action {
                    Action::Fire => { prop_assert!(!believes_firing, "fired twice"); believes_firing = true; }
                    Action::Resolve => { prop_assert!(believes_firing, "resolved what was never told"); believes_firing = false; }
                    Action::Escalate | Action::Lower | Action::Repeat => prop_assert!(believes_firing),
                    Action::Silent => {}
                }
                let Some(alert) = alert else { continue };
                let heard = tick(&alert, day(now), &POLICY).action;
                if alert.silenced_until.is_none_or(|until| until <= day(now)) && matches!(heard, Action::Silent) {
                    prop_assert_eq!(believes_firing, alert.status == Status::Firing);
                    prop_assert!(!believes_firing || believes_critical == (alert.severity == Severity::Critical));
                }
            }
        }
    }
}

#[test]
fn what_a_station_explains_is_told_when_it_does_not_any_more_and_ends_as_ever() {
    let fired = follow_arrival(None, &exceeded(), &Arrival { inhibited: true, ..on(0.0) }, &POLICY);
    let alert = fired.alert.unwrap();
    assert_eq!(
        (fired.action, alert.standing(day(0.0)), alert.last_notification),
        (Action::Silent, AlertState::Inhibited, None)
    );
    assert_eq!(tick(&alert, day(30.0), &POLICY).action, Action::Silent, "no repeats");
    assert_eq!(for_hook(&alert, None, Action::Fire, day(1.0)), None);
    // The station's alert is over, and the gyro's is not.
    let told = inhibit(&alert, false, day(5.0));
    assert_eq!((told.action, told.alert.unwrap().standing(day(5.0))), (Action::Fire, AlertState::Firing));
    // A record that the station does not explain.
    assert_eq!(follow_arrival(Some(&alert), &confirmed(), &on(7.0), &POLICY).action, Action::Fire);
    // Told before the station was found: no word meanwhile, and its end is told at once.
    let known = inhibit(&told.alert.unwrap(), true, day(6.0));
    assert_eq!((known.action, known.alert.unwrap().standing(day(6.0))), (Action::Silent, AlertState::Inhibited));
    let over = follow_arrival(known.alert.as_ref(), &within(0.001), &on(8.0), &POLICY);
    assert_eq!((over.action, over.alert.unwrap().inhibited), (Action::Resolve, false));
}
