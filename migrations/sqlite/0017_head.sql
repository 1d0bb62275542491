-- How each gyro stands: one row a gyro, written in the transaction of whatever changes it. Nothing in it is known from
-- here alone: it follows from history, record, alert, event and the configuration, and `gyrowatch verify` compares.
-- Instants are microseconds UTC, drifts deg/(h g0). For lists, and for whoever asks in SQL:
--     SELECT serial, imu.name, status, load, d_i, d_s FROM head JOIN imu ON imu.id = head.imu
--     ORDER BY rank DESC, load DESC LIMIT 20
CREATE TABLE head (
    gyro          INTEGER PRIMARY KEY REFERENCES gyro (id),
    serial        TEXT    NOT NULL,
    -- What a search looks in: serial, IMU and station in small letters, a line each.
    sought        TEXT    NOT NULL,
    -- Counts the times that the row was written.
    version       INTEGER NOT NULL DEFAULT 1,
    -- The newest calibration that counts, by its time; null for a gyro that only a bench has seen.
    calibrated_at INTEGER,
    record        INTEGER,
    imu           INTEGER,
    station       INTEGER,
    slot          TEXT,
    -- By the judged method.
    d_i           REAL,
    d_i_sd        REAL,
    d_s           REAL,
    d_s_sd        REAL,
    -- The worst of what the rules say of it: within, indeterminate, exceeded.
    state         TEXT,
    -- The worst of its verdicts and of what its alerts know besides, in the words of /v1/gyros; but never overdue,
    -- which time alone brings: see overdue_at.
    status        TEXT,
    -- The status as a number, the worst the greatest: 0 without one, 1 in_tolerance, 2 not_enough_data, 3
    -- too_uncertain, 4 borderline, 6 drifting, 7 unconfirmed, 8 out_of_tolerance, 9 confirmed; 10 more for a
    -- gyro in use.
    rank          INTEGER NOT NULL,
    -- The largest figure over its limit.
    load          REAL    NOT NULL,
    -- The rule trend: how far from their baselines D_I and D_S will be at its horizon.
    d_i_ahead     REAL,
    d_s_ahead     REAL,
    -- After this instant the gyro is overdue; null where it never is: without an interval, or out of use.
    overdue_at    INTEGER,
    -- retired or in_storage, and not calibrated since.
    out_of_use    TEXT,
    -- Alerts that are not resolved, silenced ones among them, and the gravest of them: warning, critical.
    firing        INTEGER NOT NULL,
    severity      TEXT
) STRICT;
-- The order of the fleet's page.
CREATE INDEX head_order ON head (rank DESC, load DESC, serial, overdue_at);
-- What stations have calibrated, counted.
CREATE INDEX head_station ON head (station, rank, calibrated_at);
CREATE INDEX head_serial ON head (serial);
CREATE INDEX head_imu ON head (imu);
CREATE INDEX head_overdue ON head (overdue_at) WHERE overdue_at IS NOT NULL;

-- Up to which serial all rows have been made, and a checksum of the limits in force then; null: up to the last. The
-- start makes the rest.
CREATE TABLE head_made (
    id      INTEGER PRIMARY KEY CHECK (id = 1),
    limits  TEXT NOT NULL,
    through TEXT
) STRICT;
INSERT INTO head_made VALUES (1, '', '');
