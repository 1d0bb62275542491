-- Records and bench results that do not count any more, and why: voided, or revised by another. What was sent stays.
-- An item is voided once at the most, and revised once at the most.
CREATE TABLE correction (
    item        INTEGER NOT NULL,
    replaced_by INTEGER REFERENCES record (id),
    at          INTEGER NOT NULL,
    author      TEXT NOT NULL,
    reason      TEXT NOT NULL
) STRICT;
CREATE UNIQUE INDEX correction_of_item ON correction (item, replaced_by IS NULL);
CREATE UNIQUE INDEX correction_by ON correction (replaced_by) WHERE replaced_by IS NOT NULL;

-- 0, or the item's own id once it does not count: what comes in its place may be of the same time.
ALTER TABLE record ADD COLUMN voided INTEGER NOT NULL DEFAULT 0;
DROP INDEX record_of_imu;
CREATE UNIQUE INDEX record_of_imu ON record (imu, calibrated_at, voided);
ALTER TABLE bench_result ADD COLUMN voided INTEGER NOT NULL DEFAULT 0;
DROP INDEX bench_result_of_gyro;
CREATE UNIQUE INDEX bench_result_of_gyro ON bench_result (gyro, measured_at, method, voided);

-- Rows of `history` whose record does not count any more, as they stood there. In `history` they are marked, and what comes
-- in their place may take their key.
CREATE TABLE voided_history (
    gyro          INTEGER NOT NULL REFERENCES gyro (id),
    calibrated_at INTEGER NOT NULL,
    record        INTEGER NOT NULL REFERENCES record (id),
    figures       BLOB NOT NULL,
    PRIMARY KEY (gyro, calibrated_at, record)
) STRICT, WITHOUT ROWID;
