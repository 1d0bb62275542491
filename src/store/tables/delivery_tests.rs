use crate::core::alert_filter::Matchers;
use crate::core::delivery::{DeliveryState, QueueState};
use crate::core::id::Id;
use tempfile::TempDir;

use crate::core::alert_decision::{Alert, LastNotification, Status, Suppressed};
use crate::core::judge::{Coefficient, Rule, Severity};
use crate::core::time::UtcMicros;
use crate::store;
use crate::store::tests::{first_names, opened};
use crate::store::*;

const HORIZON: UtcMicros = UtcMicros(1_000_000);

fn alert(id: Id, gyro: u32) -> AlertRow {
    AlertRow {
        id,
        of: gyro.into(),
        coefficient: Coefficient::DI,
        rule: Rule::Step,
        alert: Alert {
            status: Status::Firing,
            severity: Severity::Warning,
            since: UtcMicros(4),
            fired_at: UtcMicros(10),
            resolved_at: None,
            record_at: UtcMicros(5),
            within: 1,
            acknowledged: false,
            silenced_until: None,
            muted_until: None,
            inhibited: true,
            suppressed: Some(Suppressed { at: UtcMicros(11), digest: true }),
            last_notification: Some(LastNotification { at: UtcMicros(10), severity: Severity::Warning }),
        },
        acknowledged: None,
        silenced: None,
        muted: None,
        inhibited_by: Some(Id(1)),
        finding: r#"{"reason": "D_I \"jumped\"\n by 0.02 度"}"#.into(),
    }
}

fn step(id: Id, alert: Id) -> StepRow {
    StepRow {
        id,
        alert,
        at: UtcMicros(10),
        action: "fire".into(),
        told: true,
        author: None,
        reason: None,
        body: format!("{{\"step\": \"{id}\"}}"),
    }
}

pub(in crate::store) fn hook(id: Id) -> HookRow {
    HookRow {
        id,
        name: "pager".into(),
        kind: "standard-webhooks".into(),
        url: "http://x.example/'\"".into(),
        authorization: None,
        secret: Some("whsec_new".into()),
        old_secret: Some(("whsec_old".into(), UtcMicros(99))),
        filter: "{}".into(),
        batch: true,
        expect: Some(r#"{"json":{"errcode":0}}"#.into()),
        enabled: true,
        disabled_because: None,
        created_at: UtcMicros(1),
        changed_at: UtcMicros(1),
        deleted_at: None,
    }
}

/// One hook, two alerts, and their steps 30 to 35, taken in turn: the even ones of alert 1, the odd ones of alert 2.
struct Bench {
    dir: TempDir,
    store: Store,
    writer: Writer,
}

const HOOK: Id = Id(20);

impl Bench {
    async fn new() -> Self {
        let dir = TempDir::new().unwrap();
        let (store, mut writer) = opened(&dir).await;
        let changes = Changes {
            alerts: vec![alert(Id(1), 1), alert(Id(2), 2)],
            alert_steps: (30..36).map(|i| step(Id(i), Id(1 + i % 2))).collect(),
            hooks: vec![hook(HOOK), hook(Id(21))],
            ..first_names()
        };
        writer.commit(&changes).await.unwrap();
        Self { dir, store, writer }
    }

    async fn change(&mut self, outbox: OutboxChanges) {
        self.writer.commit(&Changes { outbox, ..Changes::default() }).await.unwrap();
    }

    /// With deliveries 40 to 45 of the steps, queued at instant 100.
    async fn queued() -> Self {
        let mut bench = Self::new().await;
        bench.queue_all((30..36).map(|i| one(10 + i, i, 1 + i % 2)).collect()).await;
        bench
    }

    async fn queue_all(&mut self, queued: Vec<NewDelivery>) {
        self.change(OutboxChanges { queued, ..OutboxChanges::default() }).await;
    }

    async fn replay(&mut self, deliveries: &[i64]) {
        let replayed = deliveries.iter().map(|id| (Id(*id), UtcMicros(700))).collect();
        self.change(OutboxChanges { replayed, ..OutboxChanges::default() }).await;
    }

    async fn attempt(&mut self, delivery: i64, at: i64, progress: Progress) {
        let attempt = AttemptRow {
            id: Id(1000 + at),
            delivery: Id(delivery),
            at: UtcMicros(at),
            status: Some(500),
            detail: "answered 500".into(),
            answer: Some("no \"such\" 频道".into()),
            took_us: 7,
        };
        self.change(OutboxChanges { attempts: vec![(attempt, progress)], ..OutboxChanges::default() }).await;
    }

    async fn due(&self, now: i64) -> Vec<i64> {
        let due = store::delivery::due_of_hook(&self.store, HOOK, UtcMicros(now), HORIZON, 100).await.unwrap();
        due.iter().map(|delivery| delivery.id.0).collect()
    }

    async fn states(&self) -> Vec<DeliveryState> {
        let mut rows = store::delivery::of_hook(&self.store, HOOK, None, None, 100).await.unwrap();
        rows.reverse();
        rows.into_iter().map(|row| row.state).collect()
    }
}

const DONE: Progress = Progress::Done(DeliveryState::Delivered);

#[tokio::test]
async fn alerts_steps_and_hooks_are_read_back_as_they_were_written() {
    let mut bench = Bench::new().await;
    assert_eq!(store::alerts::all(&bench.store).await.unwrap(), [alert(Id(1), 1), alert(Id(2), 2)]);
    assert_eq!(store::alerts::steps(&bench.store, Id(1), 2).await.unwrap(), [step(Id(32), Id(1)), step(Id(34), Id(1))]);
    assert_eq!(store::hook::get(&bench.store, HOOK).await.unwrap(), Some(hook(HOOK)));

    let remark = |by: &str| Some(Remark { by: by.into(), reason: "known".into(), at: UtcMicros(60) });
    let mut changed = alert(Id(2), 2);
    changed.alert = Alert {
        status: Status::Resolved,
        severity: Severity::Critical,
        since: UtcMicros(50),
        fired_at: UtcMicros(51),
        resolved_at: Some(UtcMicros(52)),
        record_at: UtcMicros(53),
        within: 0,
        acknowledged: true,
        silenced_until: Some(UtcMicros(90)),
        muted_until: Some(UtcMicros(91)),
        inhibited: false,
        suppressed: None,
        last_notification: None,
    };
    let matchers = Matchers { serial: Some("LFG-0101".into()), rule: Some(Rule::Step), ..Matchers::default() };
    let silence = SilenceRow { id: Id(80), matchers, until: UtcMicros(91), said: remark("eve").unwrap(), ended: None };
    changed.inhibited_by = None;
    changed.muted = Some((Id(80), remark("eve").unwrap()));
    (changed.acknowledged, changed.silenced, changed.finding) = (remark("ann"), remark("bob"), "{}".into());
    let gone = HookRow { deleted_at: Some(UtcMicros(70)), old_secret: None, enabled: false, ..hook(HOOK) };
    let changes = Changes {
        silences: vec![silence.clone()],
        alerts: vec![changed.clone()],
        hooks: vec![gone],
        ..Changes::default()
    };
    bench.writer.commit(&changes).await.unwrap();
    assert_eq!(store::alerts::get(&bench.store, Id(2)).await.unwrap(), Some(changed));
    assert_eq!(store::alerts::get(&bench.store, Id(3)).await.unwrap(), None);
    assert_eq!(store::hook::get(&bench.store, HOOK).await.unwrap(), None);
    assert_eq!(store::hook::all(&bench.store).await.unwrap(), [hook(Id(21))]);

    let in_force = async |bench: &Bench, at| store::silence::list(&bench.store, Some(UtcMicros(at)), 9).await.unwrap();
    assert_eq!(in_force(&bench, 90).await, std::slice::from_ref(&silence));
    assert_eq!(in_force(&bench, 91).await, [], "its time is over");
    let ended = SilenceRow { ended: remark("bob"), ..silence };
    bench.writer.commit(&Changes { silences: vec![ended.clone()], ..Changes::default() }).await.unwrap();
    assert_eq!(in_force(&bench, 70).await, []);
    assert_eq!(store::silence::get(&bench.store, Id(80)).await.unwrap(), Some(ended.clone()));
    assert_eq!(store::silence::list(&bench.store, None, 9).await.unwrap(), [ended]);
}

/// A delivery of a step.
fn one(id: i64, step: i64, alert: i64) -> NewDelivery {
    let subject = DeliverySubject::Step { step: Id(step), alert: Id(alert) };
    NewDelivery { subject, action: None, ..many(id, &[]) }
}

fn many(id: i64, alerts: &[i64]) -> NewDelivery {
    let part = |(alert, body): (&i64, bool)| Part {
        alert: Id(*alert),
        action: "fire",
        step: (!body).then_some(Id(29 + alert)),
        body: body.then(|| "{\"as\": \"it 是\"}".into()),
    };
    let parts = alerts.iter().zip([false, true]).map(part).collect();
    NewDelivery {
        id: Id(id),
        hook: HOOK,
        subject: DeliverySubject::Many,
        queued_at: UtcMicros(100),
        action: Some("fire"),
        parts,
        digest: None,
    }
}

/// 1 and 2 are the alerts; a delivery of both stands behind all that is open of either.
#[tokio::test]
async fn a_message_of_many_alerts_keeps_the_order_of_each() {
    use DeliveryState::{Behind, Waiting};
    let mut bench = Bench::new().await;
    let queued =
        vec![one(40, 30, 1), one(41, 31, 2), many(42, &[1, 2]), one(43, 32, 1), many(44, &[2]), one(45, 33, 2)];
    bench.queue_all(queued).await;
    assert_eq!(bench.states().await, [Waiting, Waiting, Behind, Behind, Behind, Behind]);
    bench.attempt(40, 150, DONE).await;
    assert_eq!(bench.due(150).await, [41], "42 tells of alert 2 as well");
    bench.attempt(41, 151, DONE).await;
    assert_eq!(bench.due(151).await, [42]);
    bench.attempt(42, 152, DONE).await;
    assert_eq!(bench.due(152).await, [43, 44], "each in its own line");
    bench.attempt(44, 153, DONE).await;
    assert_eq!(bench.due(153).await, [43, 45]);
}

#[tokio::test]
async fn a_message_of_many_alerts_says_of_each_what_its_step_says_or_what_it_was() {
    let mut bench = Bench::new().await;
    let digest = NewDelivery { digest: Some("{\"total\":2}".into()), ..many(40, &[2, 1]) };
    bench.queue_all(vec![digest]).await;
    let due = store::delivery::due_of_hook(&bench.store, HOOK, UtcMicros(100), HORIZON, 1).await.unwrap().remove(0);
    assert_eq!((due.subject, due.at, due.digest.as_deref()), (DeliverySubject::Many, None, Some("{\"total\":2}")));
    let fire = |body: String| ("fire".to_owned(), body);
    assert_eq!(due.content, [fire(step(Id(31), Id(2)).body), fire("{\"as\": \"it 是\"}".into())]);
    let row = store::delivery::get(&bench.store, Id(40)).await.unwrap().unwrap();
    assert_eq!((row.subject, row.action.as_deref(), row.alert), (DeliverySubject::Many, Some("fire"), Some(Id(2))));
}

#[tokio::test]
async fn what_a_hook_has_heard_is_kept_and_forgotten_and_known_from_what_it_took() {
    let mut bench = Bench::new().await;
    let (warning, critical) = (Some(Severity::Warning), Some(Severity::Critical));
    let heard = vec![(HOOK, Id(1), warning), (HOOK, Id(2), warning), (HOOK, Id(1), critical), (Id(21), Id(1), warning)];
    bench.change(OutboxChanges { heard, ..OutboxChanges::default() }).await;
    let all = async |bench: &Bench| {
        let mut all = store::hook::heard_of(&bench.store, &[Id(1), Id(2)]).await.unwrap();
        all.sort();
        all
    };
    let row = |hook, alert, severity: &str| (hook, Id(alert), severity.to_owned());
    assert_eq!(all(&bench).await, [row(HOOK, 1, "critical"), row(HOOK, 2, "warning"), row(Id(21), 1, "warning")]);
    let heard = vec![(HOOK, Id(1), warning), (HOOK, Id(1), None)];
    bench.change(OutboxChanges { heard, ..OutboxChanges::default() }).await;
    assert_eq!(all(&bench).await, [row(HOOK, 2, "warning"), row(Id(21), 1, "warning")]);
    let (forgotten, heard) = (vec![HOOK], vec![(HOOK, Id(1), critical)]);
    bench.change(OutboxChanges { forgotten, heard, ..OutboxChanges::default() }).await;
    assert_eq!(all(&bench).await, [row(HOOK, 1, "critical"), row(Id(21), 1, "warning")], "what is new holds");

    let delivered_firing = async |store: &Store| -> Vec<Id> {
        store::hook::delivered_firing(store, HOOK).await.unwrap().into_keys().collect()
    };
    assert_eq!(delivered_firing(&bench.store).await, []);
    let ends = NewDelivery { action: Some("resolve"), ..one(41, 32, 1) };
    bench.queue_all(vec![many(40, &[1, 2]), ends]).await;
    bench.attempt(40, 150, DONE).await;
    assert_eq!(delivered_firing(&bench.store).await, [Id(1), Id(2)]);
    bench.attempt(41, 151, DONE).await;
    assert_eq!(delivered_firing(&bench.store).await, [Id(2)]);
}

#[tokio::test]
async fn only_the_first_of_each_alerts_line_is_due_and_its_end_moves_the_next_up() {
    let mut bench = Bench::queued().await;
    assert_eq!(bench.due(99).await, [] as [i64; 0]);
    assert_eq!(bench.due(100).await, [40, 41]);
    bench.attempt(40, 150, DONE).await;
    assert_eq!(bench.due(150).await, [41, 42]);
    bench.attempt(42, 160, Progress::RetryAt(UtcMicros(500))).await;
    assert_eq!(bench.due(499).await, [41], "44 waits behind 42");
    assert_eq!(bench.due(500).await, [41, 42]);
    bench.attempt(42, 500, Progress::Done(DeliveryState::Dead)).await;
    assert_eq!(bench.due(500).await, [41, 44], "a dead letter holds nobody up");
    let row = store::delivery::get(&bench.store, Id(42)).await.unwrap().unwrap();
    assert_eq!((row.state, row.finished_at, row.attempts.len()), (DeliveryState::Dead, Some(UtcMicros(500)), 2));
    assert_eq!((row.attempts[0].at, row.attempts[0].status), (UtcMicros(160), Some(500)));
    let due = store::delivery::due_of_hook(&bench.store, HOOK, UtcMicros(500), HORIZON, 1).await.unwrap().remove(0);
    assert_eq!((due.at, due.content), (Some(UtcMicros(10)), vec![("fire".into(), step(Id(31), Id(2)).body)]));
    assert_eq!(row.attempts[0].answer.as_deref(), Some("no \"such\" 频道"));
}

#[tokio::test]
async fn a_line_that_grows_later_stays_in_order() {
    let mut bench = Bench::queued().await;
    bench.attempt(40, 150, DONE).await;
    bench.attempt(42, 150, DONE).await;
    bench.attempt(44, 150, DONE).await;
    assert_eq!(bench.due(150).await, [41]);
    let new = |id| NewDelivery { queued_at: UtcMicros(200), action: Some("fire"), ..one(id, 30, 1) };
    bench.queue_all(vec![new(50), new(51)]).await;
    assert_eq!(bench.due(200).await, [41, 50]);
}

#[tokio::test]
async fn the_next_that_is_due_later_is_known() {
    let mut bench = Bench::queued().await;
    let next = async |bench: &Bench, now| store::delivery::next_due(&bench.store, HOOK, UtcMicros(now)).await.unwrap();
    assert_eq!(next(&bench, 99).await, Some(UtcMicros(100)));
    assert_eq!(next(&bench, 100).await, None);
    bench.attempt(41, 200, Progress::RetryAt(UtcMicros(400))).await;
    assert_eq!(next(&bench, 100).await, Some(UtcMicros(400)));
}

#[tokio::test]
async fn times_that_a_mad_clock_wrote_hold_nothing_up() {
    let mut bench = Bench::queued().await;
    let years_ahead = UtcMicros(HORIZON.0 + 1);
    bench.attempt(40, 150, Progress::RetryAt(years_ahead)).await;
    assert_eq!(bench.due(200).await, [41, 40]);
}

#[tokio::test]
async fn a_test_comes_before_whatever_waits() {
    let mut bench = Bench::queued().await;
    let test = NewDelivery { subject: DeliverySubject::Test, action: None, ..many(60, &[]) };
    bench.queue_all(vec![test]).await;
    assert_eq!(bench.due(100).await, [60, 40, 41]);
    let row = store::delivery::get(&bench.store, Id(60)).await.unwrap().unwrap();
    assert_eq!((row.subject, row.action), (DeliverySubject::Test, None));
}

#[tokio::test]
async fn replayed_deliveries_start_anew_and_a_deleted_hooks_queue_is_dropped() {
    use DeliveryState::{Behind, Dead, Delivered, Dropped, Waiting};
    let mut bench = Bench::queued().await;
    bench.attempt(40, 150, Progress::Done(Dead)).await;
    assert_eq!(bench.states().await, [Dead, Waiting, Waiting, Behind, Behind, Behind]);
    bench.replay(&[40, 43]).await;
    let states = [Waiting, Waiting, Behind, Behind, Behind, Behind];
    assert_eq!(bench.states().await, states, "42 has its turn after 40; 43 is not done yet");
    assert_eq!(store::delivery::queue_state(&bench.store, HOOK).await.unwrap().open, 6);
    let totals = store::delivery::totals(&bench.store).await.unwrap();
    assert_eq!((totals.open, totals.dead, totals.oldest_open), (6, 0, Some(UtcMicros(100))));
    let disabled = HookRow { enabled: false, ..hook(HOOK) };
    bench.writer.commit(&Changes { hooks: vec![disabled], ..Changes::default() }).await.unwrap();
    assert_eq!(store::delivery::totals(&bench.store).await.unwrap().oldest_open, None);
    bench.attempt(40, 701, DONE).await;
    bench.change(OutboxChanges { dropped: vec![(HOOK, UtcMicros(800))], ..OutboxChanges::default() }).await;
    bench.attempt(41, 801, DONE).await;
    assert_eq!(bench.states().await, [Delivered, Dropped, Dropped, Dropped, Dropped, Dropped]);
    assert_eq!(store::delivery::queue_state(&bench.store, HOOK).await.unwrap(), QueueState::default());
}

#[tokio::test]
async fn dead_letters_that_are_sent_again_come_one_after_another() {
    use DeliveryState::{Behind, Dead, Delivered, Waiting};
    let mut bench = Bench::queued().await;
    bench.queue_all(vec![many(60, &[1, 2])]).await;
    for delivery in [40, 41, 42, 43, 44, 45, 60] {
        bench.attempt(delivery, 100 + delivery, Progress::Done(Dead)).await;
    }
    bench.replay(&[40, 42, 43, 60]).await;
    assert_eq!(bench.states().await, [Waiting, Dead, Behind, Waiting, Dead, Dead, Behind]);
    bench.attempt(40, 701, DONE).await;
    assert_eq!(bench.due(702).await, [43, 42]);
    // What was under way when an earlier one was sent again is done all the same.
    bench.change(OutboxChanges { replayed: vec![(Id(40), UtcMicros(703))], ..OutboxChanges::default() }).await;
    bench.attempt(42, 704, DONE).await;
    bench.attempt(43, 705, DONE).await;
    assert_eq!(bench.states().await, [Waiting, Dead, Delivered, Delivered, Dead, Dead, Behind]);
}

#[tokio::test]
async fn a_target_that_is_back_is_told_at_once_what_waits() {
    let mut bench = Bench::queued().await;
    bench.attempt(41, 150, Progress::RetryAt(UtcMicros(90_000))).await;
    bench.change(OutboxChanges { hastened: vec![(HOOK, UtcMicros(200))], ..OutboxChanges::default() }).await;
    assert_eq!(bench.due(200).await, [40, 41]);
    let dead = store::delivery::of_hook(&bench.store, HOOK, Some(DeliveryState::Dead), None, 9).await.unwrap();
    let old = store::delivery::of_hook(&bench.store, HOOK, None, Some(Id(42)), 1).await.unwrap();
    assert_eq!((dead.len(), old[0].id), (0, Id(41)));
}

#[tokio::test]
async fn a_restart_finds_everything_that_was_queued() {
    let bench = Bench::queued().await;
    bench.store.close().await;
    bench.writer.close().await.unwrap();
    let (store, mut writer) = opened(&bench.dir).await;
    let due = store::delivery::due_of_hook(&store, HOOK, UtcMicros(100), HORIZON, 100).await.unwrap();
    assert_eq!(due.len(), 2);
    assert!(writer.next_id(UtcMicros(0)) > Id(45), "identifiers go on where they were");
}

#[tokio::test]
async fn what_a_hook_has_heard_fire_is_known_as_it_was_last_told() {
    let mut bench = Bench::new().await;
    let untold = StepRow { told: false, ..step(Id(36), Id(1)) };
    let outbox = OutboxChanges { heard: vec![(HOOK, Id(1), Some(Severity::Critical))], ..OutboxChanges::default() };
    bench.writer.commit(&Changes { alert_steps: vec![untold], outbox, ..Changes::default() }).await.unwrap();
    let firing = store::alerts::heard_firing(&bench.store, HOOK).await.unwrap();
    assert_eq!(firing, [("critical".to_owned(), step(Id(34), Id(1)).body)]);
    assert_eq!(store::alerts::heard_firing(&bench.store, Id(21)).await.unwrap(), []);
}
