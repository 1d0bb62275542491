-- An alert of a station: `gyro` is null there. NOT NULL is taken off as https://sqlite.org/lang_altertable.html has it for constraints.
PRAGMA writable_schema = ON;
UPDATE sqlite_schema SET sql = replace(sql, 'gyro                INTEGER NOT NULL REFERENCES gyro (id)', 'gyro                INTEGER REFERENCES gyro (id)')
    WHERE type = 'table' AND name = 'alert';
PRAGMA writable_schema = RESET;
ALTER TABLE alert ADD COLUMN station INTEGER REFERENCES station (id);
-- The alert of the station that explains this one: nobody is told meanwhile.
ALTER TABLE alert ADD COLUMN inhibited_by INTEGER;
CREATE UNIQUE INDEX alert_of_station ON alert (station, coefficient, rule) WHERE station IS NOT NULL;
CREATE INDEX alert_inhibited ON alert (inhibited_by) WHERE inhibited_by IS NOT NULL;
