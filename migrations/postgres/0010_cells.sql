-- What writers lock, in place of the one turn: whoever changes something of an IMU or of its gyros holds the row of their cell for one
-- transaction. A cell is the hash of an IMU's name (store/cells.rs); a gyro's home is the cell of the IMU in which it was first seen, for ever.
-- `stamp` is random and new with each commit; `last_id` the greatest identifier given out under its lock. The others are the stamps of the last
-- commits that brought names, changed hooks or silences (`settings`), queued deliveries (`outbox`), adopted models, made diagnoses due,
-- or changed tokens or sessions: by these a server finds out what others have written.
CREATE TABLE cell (
    cell      BIGINT PRIMARY KEY CHECK (cell BETWEEN 0 AND 255),
    stamp     BIGINT NOT NULL,
    last_id   BIGINT NOT NULL,
    names     BIGINT NOT NULL,
    settings  BIGINT NOT NULL,
    outbox    BIGINT NOT NULL,
    models    BIGINT NOT NULL,
    diagnoses BIGINT NOT NULL,
    access    BIGINT NOT NULL
);
INSERT INTO cell SELECT number, 0, (SELECT last_id FROM turn), 0, 0, 0, 0, 0, 0 FROM generate_series(0, 255) AS number;

-- Commits of the last minutes, by their stamps: a writer whose connection broke in the middle of a commit looks here for what became of it.
CREATE TABLE cell_commit (
    cell  BIGINT NOT NULL,
    at    TIMESTAMPTZ NOT NULL,
    stamp BIGINT NOT NULL,
    PRIMARY KEY (cell, at, stamp)
);

-- Null until the next start, which fills in what an earlier version has left.
ALTER TABLE imu ADD COLUMN cell BIGINT;
ALTER TABLE station ADD COLUMN cell BIGINT;
ALTER TABLE gyro ADD COLUMN cell BIGINT;
CREATE INDEX imu_of_cell ON imu (cell);
CREATE INDEX station_of_cell ON station (cell);
CREATE INDEX gyro_of_cell ON gyro (cell);
DROP INDEX imu_since;
DROP INDEX station_since;
DROP INDEX gyro_since;
ALTER TABLE imu DROP COLUMN since;
ALTER TABLE station DROP COLUMN since;
ALTER TABLE gyro DROP COLUMN since;
DROP TABLE turn_commit;
DROP TABLE turn;

-- What the clock may have to follow.
CREATE INDEX alert_of_clock ON alert (id) WHERE status = 'firing' OR told_at IS NOT NULL OR silenced_until IS NOT NULL OR muted_until IS NOT NULL;
