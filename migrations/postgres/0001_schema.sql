-- The whole schema as SQLite's migrations 1 to 9 leave it, for PostgreSQL and databases that speak as it does. All whole numbers
-- are 64 bits wide; instants are microseconds UTC. There is no log before the history: what a commit costs here does not hang on
-- how many pages it touches.

-- Names are stored once; rows refer to them by number.
CREATE TABLE imu (id BIGINT PRIMARY KEY, name TEXT NOT NULL UNIQUE);
CREATE TABLE station (id BIGINT PRIMARY KEY, name TEXT NOT NULL UNIQUE);
CREATE TABLE gyro (id BIGINT PRIMARY KEY, serial TEXT NOT NULL UNIQUE);

-- What stations sent, word for word, in order of arrival. Only `verdicts` ever changes: a record that arrives late
-- changes what later ones are compared with. Instants are microseconds UTC.
CREATE TABLE record (
    id            BIGINT PRIMARY KEY,
    kind          BIGINT NOT NULL,
    imu           BIGINT NOT NULL REFERENCES imu (id),
    station       BIGINT NOT NULL REFERENCES station (id),
    calibrated_at BIGINT NOT NULL,
    received_at   BIGINT NOT NULL,
    body          TEXT NOT NULL,
    body_sha256   BYTEA NOT NULL,
    verdicts      BYTEA NOT NULL,
    -- 0, or the item's own id once it does not count: what comes in its place may be of the same time.
    voided        BIGINT NOT NULL DEFAULT 0
);
CREATE UNIQUE INDEX record_of_imu ON record (imu, calibrated_at, voided);

-- One row a gyro and record, clustered by gyro and time, so that a record touches one page a gyro and a trend reads
-- neighbours. `figures` is packed (store/figures.rs): a trend reads a thousand of them in one value.
CREATE TABLE history (
    gyro          BIGINT NOT NULL REFERENCES gyro (id),
    calibrated_at BIGINT NOT NULL,
    record        BIGINT NOT NULL REFERENCES record (id),
    figures       BYTEA NOT NULL,
    PRIMARY KEY (gyro, calibrated_at)
);

CREATE TABLE bench_result (
    id            BIGINT PRIMARY KEY,
    gyro          BIGINT NOT NULL REFERENCES gyro (id),
    station       BIGINT NOT NULL REFERENCES station (id),
    measured_at   BIGINT NOT NULL,
    method        TEXT NOT NULL,
    d_i           DOUBLE PRECISION NOT NULL,
    d_s           DOUBLE PRECISION NOT NULL,
    d_i_sd        DOUBLE PRECISION,
    d_s_sd        DOUBLE PRECISION,
    received_at   BIGINT NOT NULL,
    body          TEXT NOT NULL,
    body_sha256   BYTEA NOT NULL,
    voided        BIGINT NOT NULL DEFAULT 0
);
CREATE UNIQUE INDEX bench_result_of_gyro ON bench_result (gyro, measured_at, method, voided);

-- What was done to a gyro: baseline marks, repairs, re-installations.
CREATE TABLE event (
    id            BIGINT PRIMARY KEY,
    gyro          BIGINT NOT NULL REFERENCES gyro (id),
    at            BIGINT NOT NULL,
    kind          TEXT NOT NULL,
    reason        TEXT NOT NULL,
    author        TEXT,
    received_at   BIGINT NOT NULL,
    -- Levels that a baseline mark states, deg/(h g0): what comes after it is compared with these instead of the mean of its
    -- first records.
    d_i           DOUBLE PRECISION,
    d_i_sd        DOUBLE PRECISION,
    d_s           DOUBLE PRECISION,
    d_s_sd        DOUBLE PRECISION
);
CREATE UNIQUE INDEX event_of_gyro ON event (gyro, at, kind);

-- Idempotency-Key headers that clients sent, and what came of them.
CREATE TABLE idempotency_key (
    key           TEXT PRIMARY KEY,
    item          BIGINT NOT NULL,
    body_sha256   BYTEA NOT NULL
);

-- One alert a gyro, coefficient and rule, for ever: it fires, resolves and fires again. `finding` is the last verdict
-- as clients read it (JSON).
CREATE TABLE alert (
    id                  BIGINT PRIMARY KEY,
    gyro                BIGINT NOT NULL REFERENCES gyro (id),
    coefficient         TEXT NOT NULL,
    rule                TEXT NOT NULL,
    status              TEXT NOT NULL,
    severity            TEXT NOT NULL,
    fired_at            BIGINT NOT NULL,
    resolved_at         BIGINT,
    record_at           BIGINT NOT NULL,
    within              BIGINT NOT NULL,
    told_at             BIGINT,
    told_severity       TEXT,
    acknowledged_by     TEXT,
    acknowledged_reason TEXT,
    acknowledged_at     BIGINT,
    silenced_by         TEXT,
    silenced_reason     TEXT,
    silenced_at         BIGINT,
    silenced_until      BIGINT,
    finding             TEXT NOT NULL
);
CREATE UNIQUE INDEX alert_of_gyro ON alert (gyro, coefficient, rule);

-- What became of an alert, step by step. `body` is the alert as it then was, as clients read it (JSON); hooks are told
-- exactly this, however late and often. `told` is 0 for what nobody was told, because the alert was silenced.
CREATE TABLE alert_step (
    id     BIGINT PRIMARY KEY,
    alert  BIGINT NOT NULL REFERENCES alert (id),
    at     BIGINT NOT NULL,
    action TEXT NOT NULL,
    told   BIGINT NOT NULL,
    author TEXT,
    reason TEXT,
    body   TEXT NOT NULL
);
CREATE INDEX alert_step_of_alert ON alert_step (alert, id);

-- Whom to tell. A deleted hook stays for the sake of its deliveries.
CREATE TABLE hook (
    id                BIGINT PRIMARY KEY,
    name              TEXT NOT NULL,
    kind              TEXT NOT NULL,
    url               TEXT NOT NULL,
    "authorization"   TEXT,
    secret            TEXT,
    old_secret        TEXT,
    old_secret_until  BIGINT,
    filter            TEXT NOT NULL,
    enabled           BIGINT NOT NULL,
    disabled_because  TEXT,
    created_at        BIGINT NOT NULL,
    changed_at        BIGINT NOT NULL,
    deleted_at        BIGINT
);

-- The outbox: written in the transaction of the step that it tells of. `step` and `alert` are null for a test.
-- state: behind (an earlier one of the same hook and alert is not done), waiting, delivered, dead, dropped.
CREATE TABLE delivery (
    id               BIGINT PRIMARY KEY,
    hook             BIGINT NOT NULL REFERENCES hook (id),
    step             BIGINT REFERENCES alert_step (id),
    alert            BIGINT REFERENCES alert (id),
    queued_at        BIGINT NOT NULL,
    state            TEXT NOT NULL,
    due_at           BIGINT NOT NULL,
    -- Attempts, and the first of them, since it was queued or replayed.
    attempts         BIGINT NOT NULL,
    first_attempt_at BIGINT,
    finished_at      BIGINT
);
CREATE INDEX delivery_of_hook ON delivery (hook, id);
CREATE INDEX delivery_open ON delivery (hook, alert, id) WHERE state IN ('behind', 'waiting');
CREATE INDEX delivery_due ON delivery (hook, due_at) WHERE state = 'waiting';
CREATE INDEX delivery_dead ON delivery (hook, id) WHERE state = 'dead';

CREATE TABLE delivery_attempt (
    delivery BIGINT NOT NULL REFERENCES delivery (id),
    id       BIGINT NOT NULL,
    at       BIGINT NOT NULL,
    status   BIGINT,
    detail   TEXT NOT NULL,
    took_us  BIGINT NOT NULL,
    PRIMARY KEY (delivery, id)
);

-- The error models that people adopted for an IMU, word for word; the newest is in force. One without terms and effects
-- undoes those before it.
CREATE TABLE imu_model (
    id         BIGINT PRIMARY KEY,
    imu        BIGINT NOT NULL REFERENCES imu (id),
    adopted_at BIGINT NOT NULL,
    author     TEXT NOT NULL,
    reason     TEXT NOT NULL,
    body       TEXT NOT NULL
);
CREATE INDEX imu_model_of_imu ON imu_model (imu, id);

-- What a campaign was fitted with, where it was an adopted model: what was judged can be computed again.
CREATE TABLE campaign_model (
    record BIGINT PRIMARY KEY REFERENCES record (id),
    model  BIGINT NOT NULL REFERENCES imu_model (id)
);

-- Records and bench results that do not count any more, and why: voided, or revised by another. What was sent stays.
-- An item is voided once at the most, and revised once at the most.
CREATE TABLE correction (
    item        BIGINT NOT NULL,
    replaced_by BIGINT REFERENCES record (id),
    at          BIGINT NOT NULL,
    author      TEXT NOT NULL,
    reason      TEXT NOT NULL
);
CREATE UNIQUE INDEX correction_of_item ON correction (item, (replaced_by IS NULL));
CREATE UNIQUE INDEX correction_by ON correction (replaced_by) WHERE replaced_by IS NOT NULL;

-- Rows of `history` whose record does not count any more, as they stood there. In `history` they are marked, and what comes
-- in their place may take their key.
CREATE TABLE voided_history (
    gyro          BIGINT NOT NULL REFERENCES gyro (id),
    calibrated_at BIGINT NOT NULL,
    record        BIGINT NOT NULL REFERENCES record (id),
    figures       BYTEA NOT NULL,
    PRIMARY KEY (gyro, calibrated_at, record)
);

-- Who may use the service. Of a token the hash of its secret is kept; a revoked one stays for the sake of the audit trail.
CREATE TABLE token (
    id            BIGINT PRIMARY KEY,
    name          TEXT NOT NULL,
    role          TEXT NOT NULL,
    station       TEXT,
    secret_sha256 BYTEA NOT NULL,
    created_at    BIGINT NOT NULL,
    expires_at    BIGINT,
    revoked_at    BIGINT
);

-- Browsers that have signed in with a token.
CREATE TABLE session (
    id            BIGINT PRIMARY KEY,
    token         BIGINT NOT NULL REFERENCES token (id),
    secret_sha256 BYTEA NOT NULL,
    began_at      BIGINT NOT NULL,
    expires_at    BIGINT NOT NULL
);

-- Who did what, when and from where; what it was about before and after (JSON). Only ever added to: grant the service's role
-- no UPDATE or DELETE on it.
CREATE TABLE audit (
    id      BIGINT PRIMARY KEY,
    at      BIGINT NOT NULL,
    who     TEXT NOT NULL,
    token   BIGINT REFERENCES token (id),
    source  TEXT NOT NULL,
    action  TEXT NOT NULL,
    subject TEXT NOT NULL,
    before  TEXT,
    after   TEXT
);

-- The diagnosis of each campaign: the answer as clients read it (JSON) or, where there is none, why; by which program, and
-- against which adopted model. One without a body is still to be made.
CREATE TABLE diagnosis (
    record  BIGINT PRIMARY KEY REFERENCES record (id),
    model   BIGINT REFERENCES imu_model (id),
    program TEXT,
    refused BIGINT,
    body    TEXT
);
CREATE INDEX diagnosis_due ON diagnosis (record) WHERE body IS NULL;


-- Orders to diagnose many campaigns: which ones and whether again (`asked`, JSON as clients read it), by whom.
CREATE TABLE diagnosis_job (
    id       BIGINT PRIMARY KEY,
    asked_at BIGINT NOT NULL,
    asked_by TEXT NOT NULL,
    asked    TEXT NOT NULL,
    canceled BIGINT NOT NULL,
    begun_at BIGINT,
    ended_at BIGINT
);
CREATE INDEX diagnosis_job_open ON diagnosis_job (id) WHERE ended_at IS NULL;

-- The campaigns of each. state: waiting, done, failed (and why), canceled. What is in work is still waiting, so that it is
-- taken up again by whoever comes after a crash.
CREATE TABLE diagnosis_task (
    job    BIGINT NOT NULL REFERENCES diagnosis_job (id),
    record BIGINT NOT NULL REFERENCES record (id),
    state  TEXT NOT NULL,
    reason TEXT,
    PRIMARY KEY (job, record)
);
CREATE INDEX diagnosis_task_waiting ON diagnosis_task (job, record) WHERE state = 'waiting';
CREATE INDEX diagnosis_task_of_record ON diagnosis_task (record, job);

-- What a summary of many diagnoses says of each, without the whole of it: verdict, gyros, effects, impact (JSON).
CREATE TABLE diagnosis_gist (
    record      BIGINT PRIMARY KEY REFERENCES record (id),
    imu         BIGINT NOT NULL REFERENCES imu (id),
    station     BIGINT NOT NULL REFERENCES station (id),
    measured_at BIGINT NOT NULL,
    program     TEXT NOT NULL,
    gist        TEXT NOT NULL
);
CREATE INDEX diagnosis_gist_in_time ON diagnosis_gist (measured_at, record);


-- Whose turn it is to write: whoever holds this one row. A server finds out by `version` that others have written since its
-- last turn, and by the rest what they wrote: each is the version at which something of its kind last changed. `last_id` is the
-- greatest identifier that was given out.
CREATE TABLE turn (
    id        BIGINT PRIMARY KEY CHECK (id = 1),
    version   BIGINT NOT NULL,
    last_id   BIGINT NOT NULL,
    records   BIGINT NOT NULL,
    marks     BIGINT NOT NULL,
    alerts    BIGINT NOT NULL,
    outbox    BIGINT NOT NULL,
    models    BIGINT NOT NULL,
    diagnoses BIGINT NOT NULL,
    access    BIGINT NOT NULL
);
INSERT INTO turn VALUES (1, 0, 0, 0, 0, 0, 0, 0, 0, 0);

-- The version of each writer's last commit: one whose connection broke in the middle of a commit looks here for what became of it.
CREATE TABLE writer (
    id      BIGINT PRIMARY KEY,
    version BIGINT NOT NULL,
    at      TIMESTAMPTZ NOT NULL
);

-- Work in the background that one server does for all, until when by the database's clock.
CREATE TABLE lease (
    name   TEXT PRIMARY KEY,
    holder BIGINT NOT NULL,
    until  TIMESTAMPTZ NOT NULL
);
INSERT INTO lease VALUES ('deliveries', 0, now()), ('diagnoses', 0, now()), ('clock', 0, now());
