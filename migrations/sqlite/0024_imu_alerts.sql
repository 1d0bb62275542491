-- An alert of an IMU: `gyro` and `station` are null there.
ALTER TABLE alert ADD COLUMN imu INTEGER REFERENCES imu (id);
CREATE UNIQUE INDEX alert_of_imu ON alert (imu, coefficient, rule) WHERE imu IS NOT NULL;
