-- How each gyro stands: one row a gyro, written in the transaction of whatever changes it. Nothing in it is known from
-- here alone: it follows from history, record, alert, event and the configuration, and `gyrowatch verify` compares.
-- Instants are microseconds UTC, drifts deg/(h g0). For lists, and for whoever asks in SQL:
--     SELECT serial, imu.name, status, load, d_i, d_s FROM head JOIN imu ON imu.id = head.imu
--     ORDER BY rank DESC, load DESC LIMIT 20
CREATE TABLE head (
    gyro          BIGINT PRIMARY KEY REFERENCES gyro (id),
    serial        TEXT NOT NULL,
    -- What a search looks in: serial, IMU and station in small letters, a line each.
    sought        TEXT NOT NULL,
    -- Counts the times that the row was written.
    version       BIGINT NOT NULL DEFAULT 1,
    -- The newest calibration that counts, by its time; null for a gyro that only a bench has seen.
    calibrated_at BIGINT,
    record        BIGINT,
    imu           BIGINT,
    station       BIGINT,
    slot          TEXT,
    -- By the judged method.
    d_i           DOUBLE PRECISION,
    d_i_sd        DOUBLE PRECISION,
    d_s           DOUBLE PRECISION,
    d_s_sd        DOUBLE PRECISION,
    -- The worst of what the rules say of it: within, indeterminate, exceeded.
    state         TEXT,
    -- The worst of its verdicts and of what its alerts know besides, in the words of /v1/gyros; but never overdue,
    -- which time alone brings: see overdue_at.
    status        TEXT,
    -- The status as a number, the worst the greatest: 0 without one, 1 in_tolerance, 2 not_enough_data, 3
    -- too_uncertain, 4 borderline, 6 drifting, 7 unconfirmed, 8 out_of_tolerance, 9 confirmed; 10 more for a
    -- gyro in use.
    rank          BIGINT NOT NULL,
    -- The largest figure over its limit.
    load          DOUBLE PRECISION NOT NULL,
    -- The rule trend: how far from their baselines D_I and D_S will be at its horizon.
    d_i_ahead     DOUBLE PRECISION,
    d_s_ahead     DOUBLE PRECISION,
    -- After this instant the gyro is overdue; null where it never is: without an interval, or out of use.
    overdue_at    BIGINT,
    -- retired or in_storage, and not calibrated since.
    out_of_use    TEXT,
    -- Alerts that are not resolved, silenced ones among them, and the gravest of them: warning, critical.
    firing        BIGINT NOT NULL,
    severity      TEXT
);
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
    id      BIGINT PRIMARY KEY CHECK (id = 1),
    limits  TEXT NOT NULL,
    through TEXT
);
INSERT INTO head_made VALUES (1, '', '');
