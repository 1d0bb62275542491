//! Fills the outbox of a stopped service with the steps of alerts, from below: what is told and in which order is then
//! known in advance.

use gyrowatch::system::Clock;
use sqlx::{Connection, SqliteConnection};

use crate::prelude::*;

/// So many alerts, each with so many steps, all of them to be told to every hook.
#[derive(Clone, Copy)]
pub struct Queue {
    pub alerts: i64,
    pub steps: i64,
}

impl Queue {
    /// The identifier of a step, ascending over alerts and steps.
    fn step_id(self, alert: i64, step: i64) -> i64 {
        alert * self.steps + step + 1
    }

    pub async fn fill(self, dir: &Path, hooks: &[Value]) {
        let mut database = behind::open(&dir.join("gyrowatch.db")).await;
        let mut batch = database.begin().await.unwrap();
        let now = Clock::System.now().0;
        let mut delivery = 1;
        for alert in 0..self.alerts {
            add_alert(&mut batch, alert + 1, now).await;
            for step in 0..self.steps {
                let id = self.step_id(alert, step);
                let action = if step == 0 { "fire" } else { "repeat" };
                add_step(&mut batch, id, alert + 1, action, &body(alert), now).await;
                let state = if step == 0 { "waiting" } else { "behind" };
                for hook in hooks {
                    add_delivery(&mut batch, delivery, hook, (id, alert + 1), state, now).await;
                    delivery += 1;
                }
            }
        }
        batch.commit().await.unwrap();
        database.close().await.unwrap();
    }

    /// The alert and the step that a `webhook-id` is about; none for what is not of this queue.
    pub fn place(self, webhook_id: &str) -> Option<(i64, i64)> {
        let id: gyrowatch::core::id::Id = webhook_id.strip_prefix("evt_")?.parse().ok()?;
        let place = ((id.0 - 1) / self.steps, (id.0 - 1) % self.steps);
        (place.0 < self.alerts).then_some(place)
    }
}

fn finding() -> Value {
    json!({
        "value": 0.02, "limit": 0.01, "unit": "deg/(h g0)", "sd": 0.001, "probability": 1.0,
        "reason": "D_I stepped by 0.02 deg/(h g0).", "record": "r", "calibrated_at": "2026-03-01T08:00:00Z",
        "imu": "IMU-07", "slot": "G1", "station": "ST-2",
    })
}

fn body(alert: i64) -> Value {
    let mut body = json!({
        "id": format!("a{alert}"), "serial": format!("LFG-{alert:04}"), "coefficient": "D_I", "rule": "step",
        "state": "firing", "severity": "warning", "fired_at": "2026-03-01T08:00:00Z", "resolved_at": null,
        "acknowledged": null, "silenced": null,
    });
    body.as_object_mut().unwrap().extend(finding().as_object().unwrap().clone());
    body
}

async fn add_alert(database: &mut SqliteConnection, id: i64, now: i64) {
    let gyro = "INSERT INTO gyro (id, serial) VALUES ($1, $2)";
    sqlx::query(gyro).bind(id).bind(format!("LFG-{:04}", id - 1)).execute(&mut *database).await.unwrap();
    let alert =
        "INSERT INTO alert (id, gyro, coefficient, rule, status, severity, fired_at, record_at, within, told_at,
                     told_severity, finding)
                 VALUES ($1, $1, 'D_I', 'step', 'firing', 'warning', $2, $2, 0, $2, 'warning', $3)";
    sqlx::query(alert).bind(id).bind(now).bind(finding().to_string()).execute(database).await.unwrap();
}

async fn add_step(database: &mut SqliteConnection, id: i64, alert: i64, action: &str, body: &Value, now: i64) {
    let sql = "INSERT INTO alert_step (id, alert, at, action, told, body) VALUES ($1, $2, $3, $4, 1, $5)";
    let step = sqlx::query(sql).bind(id).bind(alert).bind(now).bind(action).bind(body.to_string());
    step.execute(database).await.unwrap();
}

async fn add_delivery(
    database: &mut SqliteConnection,
    id: i64,
    hook: &Value,
    (step, alert): (i64, i64),
    state: &str,
    now: i64,
) {
    let hook: gyrowatch::core::id::Id = hook["id"].as_str().unwrap().parse().unwrap();
    let sql = "INSERT INTO delivery (id, hook, step, alert, queued_at, state, due_at, attempts)
               VALUES ($1, $2, $3, $4, $5, $6, $5, 0)";
    let delivery = sqlx::query(sql).bind(id).bind(hook.0).bind(step).bind(alert).bind(now).bind(state);
    delivery.execute(database).await.unwrap();
}
