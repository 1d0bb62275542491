//! A target that is down for days, on a simulated clock: the ladder is climbed as it is documented, nothing is lost,
//! the others are told at once, and what is given up can be looked at and sent again.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::prelude::*;
use crate::receiver::Told;
use axum::http::StatusCode;
use gyrowatch::core::time::UtcMicros;
use gyrowatch::wire::time;

const MINUTE: f64 = 60.0;
const HOUR: f64 = 60.0 * MINUTE;
/// As in docs/alerts.md, but for the first: a target that is down is probed so far apart in real time.
const WAITS_S: [f64; 9] =
    [0.05, 5.0 * MINUTE, 30.0 * MINUTE, 2.0 * HOUR, 5.0 * HOUR, 10.0 * HOUR, 14.0 * HOUR, 20.0 * HOUR, 24.0 * HOUR];

/// A laboratory with two hooks: one whose target can be taken down, and one whose target is up.
struct Scene {
    lab: Lab,
    up: Arc<AtomicBool>,
    troubled: Receiver,
    sound: Receiver,
    troubled_hook: String,
    sound_hook: String,
}

impl Scene {
    async fn set() -> Self {
        let lab = Lab::with(|config| config.hooks.retry_waits_s = WAITS_S.to_vec()).await;
        let (troubled, up) = Receiver::switched(false, StatusCode::BAD_GATEWAY).await;
        let sound = Receiver::start().await;
        let mut hooks = Vec::new();
        for target in [&troubled, &sound] {
            hooks.push(lab.tells(target, json!({"filter": {"rules": ["step"]}})).await);
        }
        let (sound_hook, troubled_hook) = (hooks.remove(1), hooks.remove(0));
        Self { lab, up, troubled, sound, troubled_hook, sound_hook }
    }

    async fn station_posts(&self, serial: &str, history: &[(i64, f64)]) {
        self.lab.posts_history(&format!("IMU-{serial}"), serial, history).await;
    }

    /// Deliveries of a hook, oldest first.
    async fn deliveries(&self, hook: &str, query: &str) -> Vec<Value> {
        let found = self.lab.get(&format!("/v1/hooks/{hook}/deliveries?{query}")).await.ok();
        let mut deliveries = found["deliveries"].as_array().unwrap().clone();
        deliveries.reverse();
        deliveries
    }

    /// Moves the clock, and has every hook's queue looked at.
    async fn clock_goes_on(&self, seconds: f64) {
        self.lab.clock.set(UtcMicros(self.lab.clock.now().0 + (seconds * 1e6) as i64));
        let before = self.sound.told().len();
        assert_eq!(self.lab.post(&format!("/v1/hooks/{}/test", self.sound_hook), &json!({})).await.status, 202);
        self.sound.has_been_told(before + 1).await;
    }

    /// Waits until the first delivery to the troubled target has had so many attempts, and is not under way.
    async fn has_tried(&self, attempts: usize) -> Value {
        let look = async || self.deliveries(&self.troubled_hook, "").await.remove(0);
        let has_settled = |first: &Value| {
            // Attempts are read after the rest of a delivery: one that has just been written down shows half.
            let due = first["due_at"].as_str().map(|due| time::parse(due).unwrap());
            let settled = due.is_none_or(|due| due > self.lab.clock.now());
            settled && first["attempts"].as_array().unwrap().len() >= attempts
        };
        once(look, has_settled).await
    }

    /// Climbs the ladder to the attempt that is the `rungs`-th after the first: each comes when it is due, and not
    /// before.
    async fn climbs(&self, rungs: usize) {
        let mut tried = self.has_tried(1).await;
        for (climbed, wait) in WAITS_S[..rungs].iter().enumerate() {
            let attempted_at = self.lab.clock.now();
            if climbed > 0 {
                let due = time::parse(tried["due_at"].as_str().unwrap()).unwrap();
                let drawn_out = (due.0 - attempted_at.0) as f64 / 1e6 / wait;
                assert!((1.0..=1.1).contains(&drawn_out), "rung {climbed}: {drawn_out} of {wait} s");
                self.clock_goes_on(wait * 0.99).await;
                tokio::time::sleep(Duration::from_millis(100)).await;
                assert_eq!(
                    self.has_tried(climbed + 1).await["attempts"].as_array().unwrap().len(),
                    climbed + 1,
                    "too soon"
                );
            }
            self.lab.clock.set(UtcMicros(attempted_at.0 + (wait * 1.1 * 1e6) as i64 + 1));
            self.clock_goes_on(0.0).await;
            tried = self.has_tried(climbed + 2).await;
        }
    }

    fn alerts_told(target: &Receiver) -> Vec<Told> {
        target.told().into_iter().filter(|told| told.json()["type"] != "hook.test").collect()
    }

    /// Waits until nothing is open for the troubled target.
    async fn all_is_told(&self) {
        let patience = Instant::now() + Duration::from_secs(120);
        let path = format!("/v1/hooks/{}", self.troubled_hook);
        while self.lab.get(&path).await.ok()["queue"]["open"] != 0 {
            assert!(Instant::now() < patience, "{:?}", self.deliveries(&self.troubled_hook, "").await);
            self.clock_goes_on(1.0).await;
        }
    }
}

fn types(told: &[Told]) -> Vec<String> {
    told.iter().map(|told| told.json()["type"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn a_target_that_is_down_for_three_days_is_told_everything_in_order_when_it_is_back() {
    let scene = Scene::set().await;
    let began = scene.lab.clock.now();
    scene.station_posts("A", &[(0, 1.0), (40, 1.03)]).await;
    scene.has_tried(1).await;
    scene.climbs(7).await;
    // While it is down, the alert becomes critical and ends, and another begins.
    scene.station_posts("A", &[(80, 1.03), (120, 1.03)]).await;
    scene.station_posts("B", &[(0, 1.0), (40, 1.03)]).await;
    // The other target is told at once. What one alert does comes in order; two wait for one another only where a
    // target is slow.
    let sound = once(async || Scene::alerts_told(&scene.sound), |told| told.len() >= 4).await;
    let of = |serial: &str| -> Vec<Told> {
        sound.iter().filter(|told| told.json()["data"]["serial"] == serial).cloned().collect()
    };
    assert_eq!(types(&of("A")), ["alert.fired", "alert.escalated", "alert.resolved"]);
    assert_eq!(types(&of("B")), ["alert.fired"]);
    let end = UtcMicros(began.0 + 3 * UtcMicros::DAY);
    assert!(scene.lab.clock.now() < end);
    scene.lab.clock.set(end);
    scene.clock_goes_on(0.0).await;
    let first = scene.deliveries(&scene.troubled_hook, "").await.remove(0);
    assert_eq!(first["state"], "waiting", "three days are within the ladder: {first}");

    scene.up.store(true, Ordering::SeqCst);
    let failed = scene.troubled.told().len();
    scene.clock_goes_on(27.0 * HOUR).await;
    scene.all_is_told().await;
    let (troubled, sound) = (Scene::alerts_told(&scene.troubled), Scene::alerts_told(&scene.sound));
    let mut ids: Vec<String> = troubled.iter().map(Told::id).collect();
    let of_first: Vec<&String> = ids.iter().filter(|id| **id == sound[0].id()).collect();
    assert!(of_first.len() >= 9, "the same id at every attempt: {ids:?}");
    let of_a = |told: &[Told]| -> Vec<String> {
        let mut ids: Vec<String> =
            told.iter().filter(|told| told.json()["data"]["serial"] == "A").map(Told::id).collect();
        ids.dedup();
        ids
    };
    assert_eq!(of_a(&troubled), of_a(&sound), "in order, with the same ids as at the other hook");
    ids.sort();
    ids.dedup();
    let mut expected: Vec<String> = sound.iter().map(Told::id).collect();
    expected.sort();
    assert_eq!(ids, expected, "nothing is lost, nothing invented");
    assert_eq!(scene.troubled.told().len() - failed, 4, "each once, now that it answers");
    assert!(scene.deliveries(&scene.troubled_hook, "state=dead").await.is_empty());
}

#[tokio::test]
async fn a_target_that_is_down_for_longer_leaves_a_dead_letter_that_can_be_sent_again() {
    let scene = Scene::set().await;
    scene.station_posts("A", &[(0, 1.0), (40, 1.03)]).await;
    scene.climbs(WAITS_S.len()).await;
    let dead = scene.deliveries(&scene.troubled_hook, "state=dead").await;
    assert_eq!(dead.len(), 1, "{dead:?}");
    let attempts = dead[0]["attempts"].as_array().unwrap();
    assert_eq!(attempts.len(), 10, "at once, and once a rung");
    assert!(attempts.iter().all(|attempt| attempt["status"] == 502), "{attempts:?}");
    assert_eq!((&dead[0]["event"], &dead[0]["due_at"]), (&json!("alert.fired"), &Value::Null));
    let metrics = scene.lab.get(&format!("/v1/hooks/{}", scene.troubled_hook)).await.ok();
    assert_eq!((&metrics["queue"]["dead"], &metrics["enabled"]), (&json!(1), &json!(true)));

    scene.up.store(true, Ordering::SeqCst);
    let path = format!("/v1/deliveries/{}/redeliver", dead[0]["id"].as_str().unwrap());
    let again = scene.lab.post(&path, &json!({})).await;
    assert!(matches!(again.status, 200 | 202), "{}", again.text);
    scene.all_is_told().await;
    let told = scene.troubled.told();
    assert_eq!(told.last().unwrap().id(), told[0].id());
    assert_eq!(Scene::alerts_told(&scene.sound).len(), 1, "the other target was told once");
    assert!(scene.deliveries(&scene.troubled_hook, "state=dead").await.is_empty());
}

/// A hook hears the end of what it heard fire, even where that message was given up.
#[tokio::test]
async fn a_target_that_is_back_is_told_the_end_that_it_missed_once() {
    let lab = Lab::with(|config| config.hooks.retry_waits_s = vec![0.05]).await;
    let (target, up) = Receiver::switched(true, StatusCode::BAD_GATEWAY).await;
    let hook = lab.tells(&target, json!({"filter": {"rules": ["step"]}})).await;
    lab.posts_history("IMU-A", "A", &[(0, 1.0), (40, 1.03)]).await;
    lab.all_told(&hook).await;
    assert_eq!(types(&target.told()), ["alert.fired"]);

    up.store(false, Ordering::SeqCst);
    lab.posts_history("IMU-A", "A", &[(80, 1.03), (120, 1.03)]).await;
    let dead = async || {
        lab.clock.set(UtcMicros(lab.clock.now().0 + 100_000));
        lab.get(&format!("/v1/hooks/{hook}/deliveries?state=dead")).await.ok()["deliveries"].clone()
    };
    let given_up = once(dead, |dead| dead.as_array().unwrap().len() == 2).await;
    assert_eq!(given_up[0]["event"], "alert.resolved", "{given_up}");

    up.store(true, Ordering::SeqCst);
    let failed = target.told().len();
    lab.posts_history("IMU-B", "B", &[(0, 1.0), (40, 1.03)]).await;
    let told = target.has_been_told(failed + 2).await;
    assert_eq!(types(&told[failed..]), ["alert.fired", "alert.resolved"]);
    let of = |place: usize| told[place].json()["data"]["serial"].clone();
    assert_eq!([of(failed), of(failed + 1)], ["B", "A"]);
    lab.all_told(&hook).await;
    lab.posts_history("IMU-C", "C", &[(0, 1.0), (40, 1.03)]).await;
    lab.all_told(&hook).await;
    assert_eq!(types(&target.told()[failed..]), ["alert.fired", "alert.resolved", "alert.fired"], "and no more");
}
