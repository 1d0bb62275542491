-- The history of every gyro in plain columns, for SQL and what speaks it: a row per gyro, method and record (or bench result) that counts.
-- Figures in deg/(h g0), null where they are not known; the states are the verdict on the record, whatever the method.
-- The service does not read it. Where a figure stands in a row says src/store/packed/history_row.rs.

-- The IEEE 754 number whose eight bytes, the least significant first, begin at `place`; null for a NaN.
CREATE FUNCTION history_figure(figures BYTEA, place INTEGER) RETURNS DOUBLE PRECISION LANGUAGE SQL IMMUTABLE AS $$
    SELECT CASE high & 2146435072 WHEN 2146435072 THEN NULL WHEN 0 THEN 0 ELSE
        CASE WHEN high & 2147483648 = 0 THEN 1 ELSE -1 END
        * (CAST((high & 1048575 | 1048576) * 4294967296 + low AS DOUBLE PRECISION) / 4503599627370496)
        * power(CAST(2 AS DOUBLE PRECISION), CAST((high & 2146435072) / 1048576 - 1023 AS DOUBLE PRECISION)) END
    FROM (SELECT
        get_byte(figures, place) + get_byte(figures, place + 1) * CAST(256 AS BIGINT)
            + get_byte(figures, place + 2) * CAST(65536 AS BIGINT) + get_byte(figures, place + 3) * CAST(16777216 AS BIGINT) AS low,
        get_byte(figures, place + 4) + get_byte(figures, place + 5) * CAST(256 AS BIGINT)
            + get_byte(figures, place + 6) * CAST(65536 AS BIGINT) + get_byte(figures, place + 7) * CAST(16777216 AS BIGINT) AS high
    ) AS half
$$;

CREATE VIEW gyro_history AS
SELECT serial, TIMESTAMPTZ '1970-01-01 00:00:00Z' + calibrated_at * INTERVAL '1 microsecond' AS time, method,
    history_figure(figures, place_d_i) AS d_i, history_figure(figures, place_d_i_sd) AS d_i_sd,
    history_figure(figures, place_d_s) AS d_s, history_figure(figures, place_d_s_sd) AS d_s_sd,
    history_figure(figures, place_d_o) AS d_o, history_figure(figures, place_d_o_sd) AS d_o_sd,
    CASE get_byte(figures, 3) & 3 WHEN 1 THEN 'within' WHEN 3 THEN 'exceeded' ELSE 'indeterminate' END AS state_d_i,
    CASE get_byte(figures, 3) >> 2 & 3 WHEN 1 THEN 'within' WHEN 3 THEN 'exceeded' ELSE 'indeterminate' END AS state_d_s,
    CASE get_byte(figures, 3) >> 4 & 3 WHEN 1 THEN 'within' WHEN 3 THEN 'exceeded' ELSE 'indeterminate' END AS state_d_o,
    imu.name AS imu, 'G' || CAST(get_byte(figures, 1) + 1 AS TEXT) AS slot, station.name AS station, record
FROM history
CROSS JOIN (VALUES ('rigid', 28, 52, 36, 60, 44, 68), ('published', 76, 100, 84, 108, NULL, NULL))
    AS place (method, place_d_i, place_d_i_sd, place_d_s, place_d_s_sd, place_d_o, place_d_o_sd)
JOIN gyro ON gyro.id = history.gyro
JOIN imu ON imu.id = get_byte(figures, 4) + get_byte(figures, 5) * 256 + get_byte(figures, 6) * 65536
    + get_byte(figures, 7) * CAST(16777216 AS BIGINT)
JOIN station ON station.id = get_byte(figures, 8) + get_byte(figures, 9) * 256 + get_byte(figures, 10) * 65536
    + get_byte(figures, 11) * CAST(16777216 AS BIGINT)
WHERE get_byte(figures, 3) & 64 = 0 AND (method = 'rigid' OR get_byte(figures, 2) > 0)
UNION ALL
SELECT serial, TIMESTAMPTZ '1970-01-01 00:00:00Z' + measured_at * INTERVAL '1 microsecond', method,
    d_i, d_i_sd, d_s, d_s_sd, NULL, NULL, NULL, NULL, NULL, NULL, NULL, station.name, bench_result.id
FROM bench_result
JOIN gyro ON gyro.id = bench_result.gyro
JOIN station ON station.id = bench_result.station
WHERE voided = 0;
