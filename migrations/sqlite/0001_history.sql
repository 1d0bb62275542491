-- Names are stored once; rows refer to them by number.
CREATE TABLE imu (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE) STRICT;
CREATE TABLE station (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE) STRICT;
CREATE TABLE gyro (id INTEGER PRIMARY KEY, serial TEXT NOT NULL UNIQUE) STRICT;

-- What stations sent, word for word, in order of arrival. Only `verdicts` ever changes: a record that arrives late
-- changes what later ones are compared with. Instants are microseconds UTC.
CREATE TABLE record (
    id            INTEGER PRIMARY KEY,
    kind          INTEGER NOT NULL,
    imu           INTEGER NOT NULL REFERENCES imu (id),
    station       INTEGER NOT NULL REFERENCES station (id),
    calibrated_at INTEGER NOT NULL,
    received_at   INTEGER NOT NULL,
    body          TEXT NOT NULL,
    body_sha256   BLOB NOT NULL,
    verdicts      BLOB NOT NULL
) STRICT;
CREATE UNIQUE INDEX record_of_imu ON record (imu, calibrated_at);

-- One row a gyro and record, clustered by gyro and time, so that a record touches one page a gyro and a trend reads
-- neighbours. `figures` is packed (store/figures.rs): a trend reads a thousand of them in one value.
CREATE TABLE history (
    gyro          INTEGER NOT NULL REFERENCES gyro (id),
    calibrated_at INTEGER NOT NULL,
    record        INTEGER NOT NULL REFERENCES record (id),
    figures       BLOB NOT NULL,
    PRIMARY KEY (gyro, calibrated_at)
) STRICT, WITHOUT ROWID;

CREATE TABLE bench_result (
    id            INTEGER PRIMARY KEY,
    gyro          INTEGER NOT NULL REFERENCES gyro (id),
    station       INTEGER NOT NULL REFERENCES station (id),
    measured_at   INTEGER NOT NULL,
    method        TEXT NOT NULL,
    d_i           REAL NOT NULL,
    d_s           REAL NOT NULL,
    d_i_sd        REAL,
    d_s_sd        REAL,
    received_at   INTEGER NOT NULL,
    body          TEXT NOT NULL,
    body_sha256   BLOB NOT NULL
) STRICT;
CREATE UNIQUE INDEX bench_result_of_gyro ON bench_result (gyro, measured_at, method);

-- What was done to a gyro: baseline marks, repairs, re-installations.
CREATE TABLE event (
    id            INTEGER PRIMARY KEY,
    gyro          INTEGER NOT NULL REFERENCES gyro (id),
    at            INTEGER NOT NULL,
    kind          TEXT NOT NULL,
    reason        TEXT NOT NULL,
    author        TEXT,
    received_at   INTEGER NOT NULL
) STRICT;
CREATE UNIQUE INDEX event_of_gyro ON event (gyro, at, kind);

-- Idempotency-Key headers that clients sent, and what came of them.
CREATE TABLE idempotency_key (
    key           TEXT PRIMARY KEY,
    item          INTEGER NOT NULL,
    body_sha256   BLOB NOT NULL
) STRICT, WITHOUT ROWID;
