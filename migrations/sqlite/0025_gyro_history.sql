-- The history of every gyro in plain columns, for SQL and what speaks it: a row per gyro, method and record (or bench result) that counts.
-- Figures in deg/(h g0), null where they are not known; `time` in UTC; the states are the verdict on the record, whatever the method.
-- The service does not read it. Where a figure stands in a row says src/store/packed/history_row.rs.
CREATE VIEW gyro_history AS
WITH RECURSIVE
    byte (i) AS (VALUES (0), (1), (2), (3), (4), (5), (6), (7)),
    place (n) AS (VALUES (0), (1), (2), (3), (4), (5), (6), (7), (8), (9), (10)),
    -- What waits in the log to be folded into `history`, one row each.
    logged (entry, gyro, figures, rest) AS (
        SELECT id, hex(substr(rows, 1, 4)), hex(substr(rows, 5, 120)), substr(rows, 125) FROM history_log
        UNION ALL
        SELECT entry, hex(substr(rest, 1, 4)), hex(substr(rest, 5, 120)), substr(rest, 125) FROM logged WHERE rest <> x''
    ),
    -- Of two rows of a gyro and instant the later one holds.
    waiting (entry, gyro, calibrated_at, record, figures) AS (
        SELECT max(entry),
            (SELECT sum((16 * instr('123456789ABCDEF', substr(gyro, 2 * i + 1, 1))
                + instr('123456789ABCDEF', substr(gyro, 2 * i + 2, 1))) << 8 * i) FROM byte WHERE i < 4),
            (SELECT sum((16 * instr('123456789ABCDEF', substr(figures, 2 * i + 25, 1))
                + instr('123456789ABCDEF', substr(figures, 2 * i + 26, 1))) << 8 * i) FROM byte),
            (SELECT sum((16 * instr('123456789ABCDEF', substr(figures, 2 * i + 41, 1))
                + instr('123456789ABCDEF', substr(figures, 2 * i + 42, 1))) << 8 * i) FROM byte),
            figures
        FROM logged GROUP BY 2, 3
    ),
    packed (gyro, calibrated_at, record, figures) AS (
        SELECT gyro, calibrated_at, record, figures FROM waiting
        UNION ALL
        SELECT gyro, calibrated_at, record, hex(figures) FROM history
        WHERE (gyro, calibrated_at) NOT IN (SELECT gyro, calibrated_at FROM waiting)
    ),
    -- The n-th figure of a row as the 64 bits of an IEEE 754 number.
    bits (gyro, record, figures, n, bits) AS MATERIALIZED (
        SELECT gyro, record, figures, n,
            (SELECT sum((16 * instr('123456789ABCDEF', substr(figures, 16 * n + 2 * i + 57, 1))
                + instr('123456789ABCDEF', substr(figures, 16 * n + 2 * i + 58, 1))) << 8 * i) FROM byte)
        FROM packed, place
    ),
    -- Significand by powers of two; what is below 1e-37 is zero, and exponent 2047 a NaN.
    parts (gyro, record, figures, n, sign, significand, halvings) AS (
        SELECT gyro, record, figures, n, CASE WHEN bits < 0 THEN -1.0 ELSE 1.0 END,
            bits & 4503599627370495 | 4503599627370496, 1075 - (bits >> 52 & 2047)
        FROM bits WHERE bits >> 52 & 2047 < 2047
    ),
    figure (gyro, record, figures, n, value) AS (
        SELECT gyro, record, figures, n, CASE WHEN halvings > 176 THEN 0.0 ELSE sign * significand
            / (1 << min(halvings, 60)) / (1 << min(max(halvings - 60, 0), 60)) / (1 << max(halvings - 120, 0)) END
        FROM parts
    ),
    -- States in two bits each, the sixth set where the record counts no more.
    calibration AS (
        SELECT gyro, record,
            instr('123456789ABCDEF', substr(figures, 4, 1)) AS slot,
            16 * instr('123456789ABCDEF', substr(figures, 5, 1)) + instr('123456789ABCDEF', substr(figures, 6, 1)) AS equation,
            16 * instr('123456789ABCDEF', substr(figures, 7, 1)) + instr('123456789ABCDEF', substr(figures, 8, 1)) AS states,
            max(value) FILTER (WHERE n = 0) AS d_i, max(value) FILTER (WHERE n = 3) AS d_i_sd,
            max(value) FILTER (WHERE n = 1) AS d_s, max(value) FILTER (WHERE n = 4) AS d_s_sd,
            max(value) FILTER (WHERE n = 2) AS d_o, max(value) FILTER (WHERE n = 5) AS d_o_sd,
            max(value) FILTER (WHERE n = 6) AS published_d_i, max(value) FILTER (WHERE n = 9) AS published_d_i_sd,
            max(value) FILTER (WHERE n = 7) AS published_d_s, max(value) FILTER (WHERE n = 10) AS published_d_s_sd
        FROM figure GROUP BY gyro, record
    ),
    method (method, of_rigid) AS (VALUES ('rigid', 1), ('published', 0)),
    method_value (gyro, record, slot, states, method, d_i, d_i_sd, d_s, d_s_sd, d_o, d_o_sd) AS (
        SELECT gyro, record, slot, states, method,
            iif(of_rigid, d_i, published_d_i), iif(of_rigid, d_i_sd, published_d_i_sd),
            iif(of_rigid, d_s, published_d_s), iif(of_rigid, d_s_sd, published_d_s_sd),
            iif(of_rigid, d_o, NULL), iif(of_rigid, d_o_sd, NULL)
        FROM calibration, method WHERE states & 64 = 0 AND (of_rigid OR equation > 0)
    ),
    state (number, state) AS (VALUES (0, 'indeterminate'), (1, 'within'), (2, 'indeterminate'), (3, 'exceeded'))
SELECT serial, strftime('%Y-%m-%dT%H:%M:%fZ', calibrated_at / 1000000.0, 'unixepoch') AS time, method,
    d_i, d_i_sd, d_s, d_s_sd, d_o, d_o_sd,
    (SELECT state FROM state WHERE number = states & 3) AS state_d_i,
    (SELECT state FROM state WHERE number = states >> 2 & 3) AS state_d_s,
    (SELECT state FROM state WHERE number = states >> 4 & 3) AS state_d_o,
    imu.name AS imu, 'G' || (slot + 1) AS slot, station.name AS station, record
FROM method_value AS of_gyro
JOIN gyro ON gyro.id = of_gyro.gyro
JOIN record ON record.id = of_gyro.record
JOIN imu ON imu.id = record.imu
JOIN station ON station.id = record.station
UNION ALL
SELECT serial, strftime('%Y-%m-%dT%H:%M:%fZ', measured_at / 1000000.0, 'unixepoch'), method,
    d_i, d_i_sd, d_s, d_s_sd, NULL, NULL, NULL, NULL, NULL, NULL, NULL, station.name, bench_result.id
FROM bench_result
JOIN gyro ON gyro.id = bench_result.gyro
JOIN station ON station.id = bench_result.station
WHERE voided = 0;
