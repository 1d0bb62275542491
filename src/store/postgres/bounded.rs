//! Questions to the database that come to an end: a host that falls silent neither closes a connection nor answers on
//! it, and TCP by itself waits for a quarter of an hour.

use std::io::{Error as IoError, ErrorKind};
use std::time::{Duration, Instant};

use futures::future::BoxFuture;
use futures::stream::{BoxStream, StreamExt, unfold};
use sqlx::postgres::{PgConnectOptions, PgPoolOptions, PgQueryResult, PgRow, PgStatement, PgTypeInfo};
use sqlx::{Connection, Either, Error, Execute, Executor, PgPool, Postgres, SqlStr};
use tokio::sync::watch;
use tokio::time::timeout;

/// How long a database that does not answer yet is waited for at the start.
pub(super) const COMES_UP: Duration = Duration::from_secs(10);
pub(super) const BREATH: Duration = Duration::from_millis(300);

/// What comes of `work`, unless nothing has within `limit`.
///
/// # Errors
/// Those of `work`; [`ErrorKind::TimedOut`].
pub(super) async fn within<T, E: From<Error>>(
    limit: Duration,
    work: impl Future<Output = Result<T, E>>,
) -> Result<T, E> {
    timeout(limit, work).await.unwrap_or_else(|_| Err(silent(limit).into()))
}

fn silent(limit: Duration) -> Error {
    Error::Io(IoError::new(ErrorKind::TimedOut, format!("no answer within {} s", limit.as_secs_f64())))
}

/// When the database last left a question unanswered. Every connection from before may lead to a host that is gone:
/// finding that out on each of them in turn takes the limit of a question each time.
#[derive(Debug, Clone)]
pub(super) struct LastTimeout(watch::Sender<Option<Instant>>);

impl Default for LastTimeout {
    fn default() -> Self {
        Self(watch::Sender::new(None))
    }
}

impl LastTimeout {
    pub fn is_now(&self) {
        self.0.send_replace(Some(Instant::now()));
    }

    /// Whether a connection of this age was opened after it.
    pub fn is_before(&self, age: Duration) -> bool {
        self.0.borrow().is_none_or(|silence| age < silence.elapsed())
    }

    /// Returns once another question was left unanswered while this one had waited for `long`: it holds a connection
    /// that others wait for.
    async fn falls_after(&self, long: Duration) {
        let (begun, mut silences) = (Instant::now(), self.0.subscribe());
        while silences.changed().await.is_ok() {
            if begun.elapsed() >= long {
                return;
            }
        }
        std::future::pending().await
    }
}

/// Connections that read. None of them waits longer than `limit` for the next row.
#[derive(Debug, Clone)]
pub(crate) struct PgReaders {
    pool: PgPool,
    limit: Duration,
    silence: LastTimeout,
}

impl PgReaders {
    pub(super) async fn connect(
        options: PgPoolOptions,
        connect: PgConnectOptions,
        limit: Duration,
        silence: LastTimeout,
    ) -> Result<Self, sqlx::Error> {
        let (lent, released) = (silence.clone(), silence.clone());
        // The pool's own test asks a connection before anything else, and so each silent one in turn.
        let options = options.test_before_acquire(false).before_acquire(move |connection, its| {
            let answers = lent.is_before(its.age);
            Box::pin(async move { Ok(answers && connection.ping().await.is_ok()) })
        });
        // A connection on which a question was given up is closed, not handed to the next.
        let options = options.after_release(move |connection, its| {
            let answers = released.is_before(its.age);
            Box::pin(async move { Ok(answers && within(limit, connection.ping()).await.is_ok()) })
        });
        let pool = options.connect_with(connect).await?;
        Ok(Self { pool, limit, silence })
    }

    /// Of whom further connections are asked.
    pub fn turn_to(&self, connect: PgConnectOptions) {
        self.pool.set_connect_options(connect);
    }

    pub fn pool(&self) -> &PgPool {
        &self.pool
    }

    /// What comes of `work`, unless nothing has within the limit of one question.
    async fn within_limit<T, E: From<Error>>(&self, work: impl Future<Output = Result<T, E>>) -> Result<T, E> {
        self.unless_silent(work).await.unwrap_or_else(|silent| Err(silent.into()))
    }

    async fn unless_silent<T>(&self, work: impl Future<Output = T>) -> Result<T, Error> {
        tokio::select! {
            done = timeout(self.limit, work) => done.map_err(|_| {
                self.silence.is_now();
                silent(self.limit)
            }),
            () = self.silence.falls_after(self.limit / WAITED) => Err(silent(self.limit)),
        }
    }

    pub fn is_closed(&self) -> bool {
        self.pool.is_closed()
    }

    /// Connections on which nobody answers are left to themselves.
    pub async fn close(&self) {
        let _silent = timeout(self.limit, self.pool.close()).await;
    }
}

/// A question that has waited for this part of its limit gives up with another one.
const WAITED: u32 = 10;

type Step = Result<Either<PgQueryResult, PgRow>, Error>;

impl<'c> Executor<'c> for &'c PgReaders {
    type Database = Postgres;

    fn fetch_many<'e, 'q: 'e, E>(self, query: E) -> BoxStream<'e, Step>
    where
        'c: 'e,
        E: 'q + Execute<'q, Postgres>,
    {
        let steps = self.pool.fetch_many(query);
        let next = move |steps: Option<BoxStream<'e, Step>>| async move {
            let mut steps = steps?;
            match self.unless_silent(steps.next()).await {
                Ok(step) => Some((step?, Some(steps))),
                Err(silent) => Some((Err(silent), None)),
            }
        };
        unfold(Some(steps), next).boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(self, query: E) -> BoxFuture<'e, Result<Option<PgRow>, Error>>
    where
        'c: 'e,
        E: 'q + Execute<'q, Postgres>,
    {
        Box::pin(self.within_limit(self.pool.fetch_optional(query)))
    }

    fn prepare_with<'e>(self, sql: SqlStr, parameters: &'e [PgTypeInfo]) -> BoxFuture<'e, Result<PgStatement, Error>>
    where
        'c: 'e,
    {
        Box::pin(self.within_limit(self.pool.prepare_with(sql, parameters)))
    }
}
