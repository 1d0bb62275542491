-- IMUs are listed by their worst gyro: the index has all that their order asks for.
DROP INDEX head_imu;
CREATE INDEX head_imu ON head (imu, rank, extreme, overdue_at);
