-- Which record an IMU has at which instant, in place of an index, which every commit had to write a page an IMU of: a record newer than
-- every other of its IMU is entered later, many of an IMU at a time (store/calendar.rs). voided: 0, or the record's own id.
CREATE TABLE calendar (
    imu           INTEGER NOT NULL,
    calibrated_at INTEGER NOT NULL,
    voided        INTEGER NOT NULL,
    record        INTEGER NOT NULL,
    PRIMARY KEY (imu, calibrated_at, voided)
) STRICT, WITHOUT ROWID;
INSERT INTO calendar SELECT imu, calibrated_at, voided, id FROM record ORDER BY imu, calibrated_at, voided;
DROP INDEX record_of_imu;

-- Every record before this one has been entered.
CREATE TABLE calendar_begun (id INTEGER PRIMARY KEY CHECK (id = 1), record INTEGER NOT NULL) STRICT;
INSERT INTO calendar_begun SELECT 1, coalesce(max(id), 0) + 1 FROM record;
