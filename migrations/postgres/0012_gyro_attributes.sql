-- What a laboratory says of a gyro beside what is measured: words of its own, null where nothing is said.
CREATE TABLE gyro_attribute (
    gyro  BIGINT PRIMARY KEY REFERENCES gyro (id),
    batch TEXT,
    type  TEXT,
    unit  TEXT
);
CREATE INDEX gyro_attribute_batch ON gyro_attribute (batch, gyro) WHERE batch IS NOT NULL;
