-- When the gyro did it, beside when that was found: null for what an earlier version found, which counts as found at once. `hushed_at`: found late, so that
-- nobody is told; `digest`: it waits for the digest of an import. `muted_by`: the silence of many alerts that holds for this one.
ALTER TABLE alert ADD COLUMN since BIGINT;
ALTER TABLE alert ADD COLUMN hushed_at BIGINT;
ALTER TABLE alert ADD COLUMN digest BIGINT NOT NULL DEFAULT 0;
ALTER TABLE alert ADD COLUMN muted_by BIGINT;
ALTER TABLE alert ADD COLUMN muted_until BIGINT;

-- Silences of every alert that matches: what is null matches all.
CREATE TABLE silence (
    id           BIGINT PRIMARY KEY,
    serial       TEXT,
    imu          TEXT,
    station      TEXT,
    rule         TEXT,
    until        BIGINT NOT NULL,
    author       TEXT NOT NULL,
    reason       TEXT NOT NULL,
    at           BIGINT NOT NULL,
    ended_at     BIGINT,
    ended_by     TEXT,
    ended_reason TEXT
);

-- `batch`: one message for all that a record changes. `expect`: what an answer is to say (JSON); null where its status is enough.
ALTER TABLE hook ADD COLUMN batch BIGINT NOT NULL DEFAULT 0;
ALTER TABLE hook ADD COLUMN expect TEXT;

-- That an alert fires, and how severe it was when the hook was last told; no row where the hook believes that all is well.
CREATE TABLE hook_heard (
    hook     BIGINT NOT NULL REFERENCES hook (id),
    alert    BIGINT NOT NULL REFERENCES alert (id),
    severity TEXT NOT NULL,
    PRIMARY KEY (hook, alert)
);
INSERT INTO hook_heard (hook, alert, severity)
    SELECT newest.hook, newest.alert, coalesce(alert.told_severity, alert.severity)
    FROM (SELECT hook, alert, max(id) AS id FROM delivery WHERE alert IS NOT NULL AND state <> 'dropped' GROUP BY hook, alert) AS newest
    JOIN delivery ON delivery.id = newest.id
    JOIN alert_step ON alert_step.id = delivery.step
    JOIN alert ON alert.id = newest.alert
    WHERE alert_step.action <> 'resolve';

-- What the hook is told of the alert, where that is not what the step says; of many alerts, of the gravest. `digest`: how many alerts of
-- which kind an import has left firing (JSON).
ALTER TABLE delivery ADD COLUMN action TEXT;
ALTER TABLE delivery ADD COLUMN digest TEXT;

-- The alerts of a delivery that tells of many, or of no step. `body`: the alert as it then was, where no step says so.
CREATE TABLE delivery_part (
    delivery BIGINT NOT NULL REFERENCES delivery (id),
    place    BIGINT NOT NULL,
    hook     BIGINT NOT NULL REFERENCES hook (id),
    alert    BIGINT NOT NULL REFERENCES alert (id),
    action   TEXT NOT NULL,
    step     BIGINT REFERENCES alert_step (id),
    body     TEXT,
    PRIMARY KEY (delivery, place)
);
CREATE INDEX delivery_part_of_alert ON delivery_part (hook, alert, delivery);

-- What the target said.
ALTER TABLE delivery_attempt ADD COLUMN answer TEXT;
