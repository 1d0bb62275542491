-- One alert a gyro, coefficient and rule, for ever: it fires, resolves and fires again. `finding` is the last verdict
-- as clients read it (JSON).
CREATE TABLE alert (
    id                  INTEGER PRIMARY KEY,
    gyro                INTEGER NOT NULL REFERENCES gyro (id),
    coefficient         TEXT NOT NULL,
    rule                TEXT NOT NULL,
    status              TEXT NOT NULL,
    severity            TEXT NOT NULL,
    fired_at            INTEGER NOT NULL,
    resolved_at         INTEGER,
    record_at           INTEGER NOT NULL,
    within              INTEGER NOT NULL,
    told_at             INTEGER,
    told_severity       TEXT,
    acknowledged_by     TEXT,
    acknowledged_reason TEXT,
    acknowledged_at     INTEGER,
    silenced_by         TEXT,
    silenced_reason     TEXT,
    silenced_at         INTEGER,
    silenced_until      INTEGER,
    finding             TEXT NOT NULL
) STRICT;
CREATE UNIQUE INDEX alert_of_gyro ON alert (gyro, coefficient, rule);

-- What became of an alert, step by step. `body` is the alert as it then was, as clients read it (JSON); hooks are told
-- exactly this, however late and often. `told` is 0 for what nobody was told, because the alert was silenced.
CREATE TABLE alert_step (
    id     INTEGER PRIMARY KEY,
    alert  INTEGER NOT NULL REFERENCES alert (id),
    at     INTEGER NOT NULL,
    action TEXT NOT NULL,
    told   INTEGER NOT NULL,
    author TEXT,
    reason TEXT,
    body   TEXT NOT NULL
) STRICT;
CREATE INDEX alert_step_of_alert ON alert_step (alert, id);

-- Whom to tell. A deleted hook stays for the sake of its deliveries.
CREATE TABLE hook (
    id                INTEGER PRIMARY KEY,
    name              TEXT NOT NULL,
    kind              TEXT NOT NULL,
    url               TEXT NOT NULL,
    authorization     TEXT,
    secret            TEXT,
    old_secret        TEXT,
    old_secret_until  INTEGER,
    filter            TEXT NOT NULL,
    enabled           INTEGER NOT NULL,
    disabled_because  TEXT,
    created_at        INTEGER NOT NULL,
    changed_at        INTEGER NOT NULL,
    deleted_at        INTEGER
) STRICT;

-- The outbox: written in the transaction of the step that it tells of. `step` and `alert` are null for a test.
-- state: behind (an earlier one of the same hook and alert is not done), waiting, delivered, dead, dropped.
CREATE TABLE delivery (
    id               INTEGER PRIMARY KEY,
    hook             INTEGER NOT NULL REFERENCES hook (id),
    step             INTEGER REFERENCES alert_step (id),
    alert            INTEGER REFERENCES alert (id),
    queued_at        INTEGER NOT NULL,
    state            TEXT NOT NULL,
    due_at           INTEGER NOT NULL,
    -- Attempts, and the first of them, since it was queued or replayed.
    attempts         INTEGER NOT NULL,
    first_attempt_at INTEGER,
    finished_at      INTEGER
) STRICT;
CREATE INDEX delivery_of_hook ON delivery (hook, id);
CREATE INDEX delivery_open ON delivery (hook, alert, id) WHERE state IN ('behind', 'waiting');
CREATE INDEX delivery_due ON delivery (hook, due_at) WHERE state = 'waiting';
CREATE INDEX delivery_dead ON delivery (hook, id) WHERE state = 'dead';

CREATE TABLE delivery_attempt (
    delivery INTEGER NOT NULL REFERENCES delivery (id),
    id       INTEGER NOT NULL,
    at       INTEGER NOT NULL,
    status   INTEGER,
    detail   TEXT NOT NULL,
    took_us  INTEGER NOT NULL,
    PRIMARY KEY (delivery, id)
) STRICT, WITHOUT ROWID;
