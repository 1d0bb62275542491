-- A random stamp with every commit. A failover or a restore may lose commits whose versions are then given out again: a server that finds
-- another stamp than it has seen forgets what it knows.
ALTER TABLE turn ADD COLUMN stamp BIGINT NOT NULL DEFAULT 0;
-- The last commits. `gyros`: those to which something was done besides a new record (JSON); null where there are none.
CREATE TABLE turn_commit (
    version BIGINT PRIMARY KEY,
    stamp   BIGINT NOT NULL,
    gyros   TEXT
);
INSERT INTO turn_commit (version, stamp) SELECT version, stamp FROM turn;

-- The version of the commit that brought a name; null where that was before this was kept.
ALTER TABLE imu ADD COLUMN since BIGINT;
ALTER TABLE station ADD COLUMN since BIGINT;
ALTER TABLE gyro ADD COLUMN since BIGINT;
CREATE INDEX imu_since ON imu (since);
CREATE INDEX station_since ON station (since);
CREATE INDEX gyro_since ON gyro (since);

-- What became of a commit without an answer, its stamp says.
DROP TABLE writer;
