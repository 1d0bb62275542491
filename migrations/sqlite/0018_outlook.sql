-- How each gyro lies to its budget, where it goes, and since when; see the migration `head`. Made anew by the start.
-- Loads are (value - baseline) / budget, signed, 1 at the budget; slopes are in budgets a year, where the rule `trend`
-- has established one.
ALTER TABLE head ADD COLUMN d_i_load REAL;
ALTER TABLE head ADD COLUMN d_i_load_sd REAL;
ALTER TABLE head ADD COLUMN d_s_load REAL;
ALTER TABLE head ADD COLUMN d_s_load_sd REAL;
ALTER TABLE head ADD COLUMN d_o_load REAL;
ALTER TABLE head ADD COLUMN d_o_load_sd REAL;
ALTER TABLE head ADD COLUMN d_i_year REAL;
ALTER TABLE head ADD COLUMN d_i_year_sd REAL;
ALTER TABLE head ADD COLUMN d_s_year REAL;
ALTER TABLE head ADD COLUMN d_s_year_sd REAL;
-- The larger load of D_I and D_S without its sign; -1 without one.
ALTER TABLE head ADD COLUMN extreme REAL NOT NULL DEFAULT -1;
-- Which of D_I and D_S its trend carries to the budget first, when by the line, and by both edges of its 95 % band;
-- `reach_provisional`: the course is young, so that the dates may be off by more.
ALTER TABLE head ADD COLUMN reach_of TEXT;
ALTER TABLE head ADD COLUMN reach_at INTEGER;
ALTER TABLE head ADD COLUMN reach_from INTEGER;
ALTER TABLE head ADD COLUMN reach_until INTEGER;
ALTER TABLE head ADD COLUMN reach_provisional INTEGER NOT NULL DEFAULT 0;
-- Since when it is beyond its limits; where it is not, since when it drifts. When the newest of its alerts that fire
-- began: a gyro is new or worse since then. Neither counts what is overdue.
ALTER TABLE head ADD COLUMN since INTEGER;
ALTER TABLE head ADD COLUMN changed_at INTEGER;
CREATE INDEX head_extreme ON head (extreme DESC, serial);
-- What has no time comes last, in both databases.
CREATE INDEX head_calibrated ON head (coalesce(calibrated_at, 9223372036854775807), serial);
CREATE INDEX head_reach ON head (coalesce(reach_at, 9223372036854775807), serial);
CREATE INDEX head_changed ON head (changed_at DESC, serial) WHERE changed_at IS NOT NULL;
DROP INDEX head_imu;
CREATE INDEX head_imu ON head (imu, rank, extreme);

-- Which gyros a station has ever calibrated.
CREATE TABLE gyro_station (
    station INTEGER NOT NULL REFERENCES station (id),
    gyro    INTEGER NOT NULL REFERENCES gyro (id),
    PRIMARY KEY (station, gyro)
) STRICT, WITHOUT ROWID;

CREATE INDEX alert_firing ON alert (rule, gyro) WHERE status = 'firing';
UPDATE head_made SET limits = '', through = '';
