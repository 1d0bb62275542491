-- What 10^5 gyros are listed and told by, without a look at each row: stations with what is overdue, IMUs that are due, alerts that the clock moves.
DROP INDEX alert_of_clock;
DROP INDEX head_station;
CREATE INDEX head_station ON head (station, rank, overdue_at, calibrated_at);
DROP INDEX head_overdue;
CREATE INDEX head_overdue ON head (overdue_at, imu) WHERE overdue_at IS NOT NULL;
-- To be repeated some time after `told_at`; to be told at the end of a silence, or as soon as the clock looks; to be told with an import's digest.
CREATE INDEX alert_repeated ON alert (told_at) WHERE status = 'firing' AND acknowledged_at IS NULL;
CREATE INDEX alert_held_back ON alert (id) WHERE silenced_until IS NOT NULL OR muted_until IS NOT NULL;
CREATE INDEX alert_untold ON alert (id)
    WHERE hushed_at IS NULL AND inhibited_by IS NULL AND CASE WHEN status = 'firing' THEN told_at IS NULL OR severity <> told_severity ELSE told_at IS NOT NULL END;
CREATE INDEX alert_for_digest ON alert (hushed_at) WHERE digest <> 0;
