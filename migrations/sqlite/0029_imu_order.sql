-- IMUs are listed by their worst gyro: the index has all that their order asks for.
CREATE INDEX head_imu_order ON head (imu, rank, extreme, overdue_at);
DROP INDEX head_imu;
