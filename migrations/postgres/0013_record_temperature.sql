-- The temperature of a calibration, deg C: as the record states it, or the mean of its campaign's dwells without a sensor's fault values.
-- Null of what an earlier version stored: there the body says it.
ALTER TABLE record ADD COLUMN temperature_c DOUBLE PRECISION;
