-- What lists of 10^6 gyros and their alerts are made of, without a look at each row: every index has all that its list asks for.
CREATE INDEX head_sought ON head (sought, gyro);
DROP INDEX head_changed;
CREATE INDEX head_changed ON head (changed_at DESC, serial, rank, extreme) WHERE changed_at IS NOT NULL;
DROP INDEX head_reach;
CREATE INDEX head_reach ON head (coalesce(reach_at, 9223372036854775807), serial, rank, reach_at);
DROP INDEX head_calibrated;
CREATE INDEX head_calibrated ON head
    (coalesce(calibrated_at, 9223372036854775807), serial, calibrated_at, gyro, imu, station, d_i_load, d_i_load_sd, d_s_load, d_s_load_sd);
DROP INDEX alert_firing;
CREATE INDEX alert_standing ON alert (status, rule, gyro, severity, silenced_until, muted_until, inhibited_by, acknowledged_at);
CREATE INDEX alert_of_no_gyro ON alert (id) WHERE gyro IS NULL OR rule = 'batch_shift';
-- Whether anything was written of gyros the stamps of the cells say.
ALTER TABLE head DROP COLUMN version;
