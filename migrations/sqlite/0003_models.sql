-- The error models that people adopted for an IMU, word for word; the newest is in force. One without terms and effects
-- undoes those before it.
CREATE TABLE imu_model (
    id         INTEGER PRIMARY KEY,
    imu        INTEGER NOT NULL REFERENCES imu (id),
    adopted_at INTEGER NOT NULL,
    author     TEXT NOT NULL,
    reason     TEXT NOT NULL,
    body       TEXT NOT NULL
) STRICT;
CREATE INDEX imu_model_of_imu ON imu_model (imu, id);

-- What a campaign was fitted with, where it was an adopted model: what was judged can be computed again.
CREATE TABLE campaign_model (
    record INTEGER PRIMARY KEY REFERENCES record (id),
    model  INTEGER NOT NULL REFERENCES imu_model (id)
) STRICT;
