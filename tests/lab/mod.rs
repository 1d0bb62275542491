//! A laboratory for scenarios: the service on a port of its own with a database of its own, stations that post, and
//! engineers who look. Everything goes over real HTTP.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use crate::receiver::Receiver;
use crate::support::{client, document, file_url, id, once};
use crate::{behind, cluster};
use gyrowatch::config::Config;
use gyrowatch::core::mounting::{Geometry, Slot};
use gyrowatch::core::time::UtcMicros;
use gyrowatch::http::{self, App};
use gyrowatch::pipeline::{Outbox, Pipeline, Verified};
use gyrowatch::routes::Routes;
use gyrowatch::store;
use gyrowatch::system::{self, Clock};
use gyrowatch::wire::time;
use reqwest::header::{CONTENT_TYPE, HeaderMap};
use reqwest::{Client, Method, RequestBuilder};
use serde_json::{Value, json};
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{AssertSqlSafe, Connection, FromRow, PgConnection, Postgres, Sqlite};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

pub const JSON: &str = "application/json";
pub const NDJSON: &str = "application/x-ndjson";

/// The service, and whoever talks to it.
pub struct Lab {
    dir: TempDir,
    pub config: Config,
    pub clock: Clock,
    client: Client,
    running: Option<Running>,
}

struct Running {
    address: SocketAddr,
    pipeline: Arc<Pipeline>,
    stop: oneshot::Sender<()>,
    served: JoinHandle<()>,
    written: JoinHandle<()>,
    outbox: Outbox,
}

impl Lab {
    /// With the default configuration.
    pub async fn open() -> Self {
        Self::with(|_| {}).await
    }

    /// With the history of a gyro `A`.
    pub async fn holding(history: &[(i64, f64)]) -> Self {
        let lab = Self::open().await;
        lab.posts_history("IMU-1", "A", history).await;
        lab
    }

    /// With a configuration of its own, in which nothing is found late. The clock stands at noon of 2026-11-21 until
    /// it is moved.
    pub async fn with(change: impl FnOnce(&mut Config)) -> Self {
        system::install_crypto();
        let dir = TempDir::new().expect("a directory for the database");
        let mut config = Config::defaults();
        config.access.open = true;
        config.server.listen = "127.0.0.1:0".parse().expect("an address");
        // Stations of the laboratory measure in 2025, and are not late.
        config.alerts.backfill_days = 1e5;
        config.database.url = file_url(&dir.path().join("gyrowatch.db"));
        if cluster::is_wanted() {
            config.database.url = cluster::fresh_database().await;
            config.database.lease_s = cluster::LEASE_S;
        }
        change(&mut config);
        let noon = time::parse("2026-11-21T12:00:00Z").expect("a time");
        let client = client();
        let mut lab = Self { dir, config, clock: Clock::manual(noon), client, running: None };
        lab.start().await;
        lab
    }

    pub async fn start(&mut self) {
        let config = Arc::new(self.config.clone());
        let (store, writer) = store::open(&config.database.options()).await.expect("the database opens");
        let (pipeline, written) =
            Pipeline::start(store, writer, config.clone(), self.clock.clone()).await.expect("the pipeline starts");
        let outbox = Outbox::start(&pipeline.hooks).expect("the delivery worker starts");
        let listener = TcpListener::bind(config.server.listen).await.expect("a free port");
        let address = listener.local_addr().expect("an address");
        let pipeline = Arc::new(pipeline);
        let app = App { config: config.clone(), clock: self.clock.clone(), pipeline: Arc::clone(&pipeline) };
        let router = http::router(app, Routes::default());
        let (stop, stopped) = oneshot::channel::<()>();
        let served = tokio::spawn(async move {
            http::server::serve(listener, None, router, &config.server, async {
                let _told_or_dropped = stopped.await;
            })
            .await;
        });
        self.running = Some(Running { address, pipeline, stop, served, written, outbox });
    }

    /// As SIGTERM does: requests in flight are finished, the database is closed.
    pub async fn stop(&mut self) {
        let Running { stop, served, written, outbox, .. } = self.running.take().expect("it runs");
        stop.send(()).expect("it listens");
        served.await.expect("it ends in order");
        outbox.stop().await;
        written.await.expect("the writer ends in order");
    }

    pub async fn restart(&mut self) {
        self.stop().await;
        self.start().await;
    }

    /// Everything that is stored, computed again, as it now is.
    pub async fn verified(&self) -> Verified {
        let store = store::open_to_read(&self.config.database.options()).await.expect("the database opens");
        let config = Arc::new(self.config.clone());
        let reading = Pipeline::to_read(store.clone(), config, self.clock.clone()).await.expect("it can be read");
        let verified = reading.queries.records.verify().await.expect("all can be read");
        store.close().await;
        verified
    }

    /// Changes what is stored behind the service's back; how many rows.
    pub async fn change(&self, sql: &str) -> u64 {
        self.change_to(sql, &[]).await
    }

    /// The same with what `$1` and so on stand for.
    pub async fn change_to(&self, sql: &str, texts: &[&str]) -> u64 {
        let sql = AssertSqlSafe(sql.to_owned());
        let texts = texts.iter().map(|text| (*text).to_owned());
        if self.is_on_file() {
            let mut connection = behind::open(&self.database()).await;
            let query = texts.fold(sqlx::query::<Sqlite>(sql), |query, text| query.bind(text));
            let done = query.execute(&mut connection).await.unwrap();
            connection.close().await.unwrap();
            return done.rows_affected();
        }
        let mut connection = PgConnection::connect(&self.config.database.url).await.unwrap();
        let query = texts.fold(sqlx::query::<Postgres>(sql), |query, text| query.bind(text));
        query.execute(&mut connection).await.unwrap().rows_affected()
    }

    /// What a question to the database itself finds.
    pub async fn rows<R>(&self, sql: &str) -> Vec<R>
    where
        R: Send + Unpin + for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow>,
    {
        let sql = AssertSqlSafe(sql.to_owned());
        if self.is_on_file() {
            let mut connection = behind::open(&self.database()).await;
            return sqlx::query_as::<Sqlite, R>(sql).fetch_all(&mut connection).await.unwrap();
        }
        let mut connection = PgConnection::connect(&self.config.database.url).await.unwrap();
        sqlx::query_as::<Postgres, R>(sql).fetch_all(&mut connection).await.unwrap()
    }

    fn is_on_file(&self) -> bool {
        self.config.database.url.starts_with("sqlite")
    }

    pub fn database(&self) -> PathBuf {
        self.dir.path().join("gyrowatch.db")
    }

    pub fn address(&self) -> SocketAddr {
        self.running.as_ref().expect("it runs").address
    }

    /// What HTTP asks: for what happens between two of its steps.
    pub fn pipeline(&self) -> &Pipeline {
        &self.running.as_ref().expect("it runs").pipeline
    }

    pub fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address())
    }

    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, self.url(path))
    }

    pub async fn get(&self, path: &str) -> Answer {
        Answer::of(self.request(Method::GET, path)).await
    }

    pub async fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_text(path, JSON, body.to_string()).await
    }

    pub async fn post_text(&self, path: &str, media_type: &str, body: impl Into<reqwest::Body>) -> Answer {
        Answer::of(self.request(Method::POST, path).header(CONTENT_TYPE, media_type).body(body)).await
    }

    /// Posts a record that is to be stored, and answers its answer.
    pub async fn posts(&self, record: &Value) -> Value {
        self.post("/v1/records", record).await.created()
    }

    /// D_I of a gyro on given days, posted in the order given.
    pub async fn posts_history(&self, imu: &str, serial: &str, history: &[(i64, f64)]) {
        for (at, d_i) in history {
            self.posts(&record(imu, &day(*at), &[("G1", serial, *d_i, 2.0)])).await;
        }
    }

    /// Imports documents, one a line; the answers line by line.
    pub async fn imports(&self, documents: &[Value]) -> Vec<Value> {
        let text: String = documents.iter().map(|document| format!("{document}\n")).collect();
        self.post_text("/v1/import", NDJSON, text).await.lines()
    }

    /// The points of a trend; `query` is appended.
    pub async fn sees_trend(&self, serial: &str, query: &str) -> Vec<Value> {
        let trend = self.get(&format!("/v1/gyros/{serial}/trend?{query}")).await.ok();
        trend["points"].as_array().expect("points").clone()
    }

    /// The diagnosis of a campaign; asks again while it is being made.
    pub async fn diagnosis(&self, campaign: &str) -> Answer {
        loop {
            let answer = self.get(&format!("/v1/campaigns/{campaign}/diagnosis")).await;
            if answer.status != 202 {
                return answer;
            }
        }
    }

    /// Sets up a hook that tells the target, with what else is asked of it; its identifier.
    pub async fn tells(&self, target: &Receiver, more: Value) -> String {
        let mut hook = json!({"kind": "standard-webhooks", "url": target.url()});
        hook.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        id(&self.post("/v1/hooks", &hook).await.created()).to_owned()
    }

    /// Waits until nothing is open for a hook.
    pub async fn all_told(&self, hook: &str) {
        let path = format!("/v1/hooks/{hook}");
        once(async || self.get(&path).await.ok()["queue"].clone(), |queue| queue["open"] == 0).await;
    }

    /// The alerts that a query finds.
    pub async fn alerts(&self, query: &str) -> Vec<Value> {
        self.get(&format!("/v1/alerts?{query}")).await.ok()["alerts"].as_array().expect("alerts").clone()
    }

    pub async fn patch(&self, path: &str, body: &Value) -> Answer {
        Answer::of(self.request(Method::PATCH, path).header(CONTENT_TYPE, JSON).body(body.to_string())).await
    }

    /// Moves the clock to an RFC 3339 time.
    pub fn clock_shows(&self, text: &str) {
        self.clock.set(time::parse(text).expect("a time"));
    }
}

/// What came back.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: HeaderMap,
    pub text: String,
}

impl Answer {
    pub async fn of(request: RequestBuilder) -> Self {
        let response = request.send().await.expect("an answer");
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        Self { status, headers, text: response.text().await.expect("a whole answer") }
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap_or_else(|error| panic!("{error}: {}", self.text))
    }

    pub fn lines(&self) -> Vec<Value> {
        self.text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().expect("text"))
    }

    #[track_caller]
    pub fn ok(&self) -> Value {
        assert_eq!(self.status, 200, "{}", self.text);
        self.json()
    }

    #[track_caller]
    pub fn created(&self) -> Value {
        assert_eq!(self.status, 201, "{}", self.text);
        self.json()
    }

    /// A refusal in the common form; the pointers that it names.
    #[track_caller]
    pub fn refused(&self, status: u16) -> Vec<String> {
        assert_eq!(self.status, status, "{}", self.text);
        assert_eq!(self.header("content-type"), "application/problem+json");
        let problem = self.json();
        assert_eq!(problem["status"], status, "{problem}");
        for member in ["title", "detail"] {
            assert!(problem[member].as_str().is_some_and(|text| !text.is_empty()), "{member}: {problem}");
        }
        let errors = problem["errors"].as_array().cloned().unwrap_or_default();
        errors.iter().map(|error| error["pointer"].as_str().expect("a pointer").to_owned()).collect()
    }
}

/// Tables 3-4 of the paper as a record.
pub fn tables_3_and_4() -> Value {
    document("paper.json")
}

/// A gyro that a made-up record holds: slot, serial, D_I, D_S (deg/(h g0)).
pub type Made<'a> = (&'a str, &'a str, f64, f64);

/// A record of nominally mounted gyros, 1.4676 pulse/arcsec each, so that both methods find D_I and D_S as they are
/// given (the rigid one to rounding).
pub fn record(imu: &str, at: &str, gyros: &[Made<'_>]) -> Value {
    let gyros: Vec<Value> = gyros.iter().map(|gyro| made(*gyro)).collect();
    json!({"imu": imu, "station": "ST-1", "calibrated_at": at, "geometry": "skewed", "gyros": gyros})
}

fn made((slot, serial, d_i, d_s): Made<'_>) -> Value {
    let triad = Geometry::Skewed.triad(Slot::from_name(slot).expect("a slot")).expect("skewed axes");
    let scale = 1.4676;
    let (e, g) = (triad.input() * scale, (triad.input() * d_i + triad.spin() * d_s) * scale);
    let (e, g): ([f64; 3], [f64; 3]) = (e.into(), g.into());
    json!({"slot": slot, "serial": serial, "e_pulse_per_arcsec": e, "g_pulse_per_s_g0": g})
}

/// A bench result.
pub fn bench(serial: &str, at: &str, d_i: f64, d_s: f64) -> Value {
    json!({"serial": serial, "station": "BENCH-1", "measured_at": at, "method": "torque_feedback",
        "d_i_deg_per_h_g0": d_i, "d_s_deg_per_h_g0": d_s})
}

/// What a diagnosis names.
pub fn effects(diagnosis: &Value) -> Vec<&str> {
    let effects = diagnosis["effects"].as_array().expect("effects").iter();
    effects.map(|effect| effect["effect"].as_str().expect("a name")).collect()
}

/// The same campaign at another time.
pub fn at(mut campaign: Value, measured_at: &str) -> Value {
    campaign["measured_at"] = measured_at.into();
    campaign
}

/// Scatter of calibration, deg/(h g0): a fixed sequence of standard deviation about `sigma` that no cause follows.
pub fn scatter(k: i64, sigma: f64) -> f64 {
    let noise = [0.3, -1.1, 0.8, 0.1, -0.6, 1.2, -0.2, -0.9, 0.5, 0.7, -1.0, 0.4, -0.3, 1.0, -0.8, 0.2, 0.6];
    noise[(k * 5 % 17) as usize] * sigma
}

/// Noon of the `day`-th day of 2025, counting from 0.
pub fn day(day: i64) -> String {
    let start = time::parse("2025-01-01T12:00:00Z").expect("a time");
    time::format(UtcMicros(start.0 + day * UtcMicros::DAY))
}

/// The verdict of a rule on a coefficient of a gyro in an answer.
#[track_caller]
pub fn verdict<'a>(answer: &'a Value, serial: &str, coefficient: &str, rule: &str) -> &'a Value {
    let verdicts = answer["verdicts"].as_array().expect("verdicts");
    let is_it = |v: &&Value| v["serial"] == serial && v["coefficient"] == coefficient && v["rule"] == rule;
    verdicts.iter().find(is_it).unwrap_or_else(|| panic!("no verdict {serial} {coefficient} {rule}: {answer}"))
}

#[track_caller]
pub fn assert_close(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("a number, not {value}"));
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected} within {tolerance}");
}
