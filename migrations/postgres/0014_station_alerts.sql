-- An alert of a station: `gyro` is null there.
ALTER TABLE alert ALTER COLUMN gyro DROP NOT NULL;
ALTER TABLE alert ADD COLUMN station BIGINT REFERENCES station (id);
-- The alert of the station that explains this one: nobody is told meanwhile.
ALTER TABLE alert ADD COLUMN inhibited_by BIGINT;
CREATE UNIQUE INDEX alert_of_station ON alert (station, coefficient, rule) WHERE station IS NOT NULL;
CREATE INDEX alert_inhibited ON alert (inhibited_by) WHERE inhibited_by IS NOT NULL;
