-- What somebody said of what a station measured in a window of time: suspect, or to be trusted again. Of two the later
-- holds where they meet.
CREATE TABLE suspect_window (
    id       BIGINT PRIMARY KEY,
    station  BIGINT NOT NULL REFERENCES station (id),
    first_at BIGINT NOT NULL,
    last_at  BIGINT NOT NULL,
    trusted  BIGINT NOT NULL,
    author   TEXT NOT NULL,
    reason   TEXT NOT NULL
);
CREATE INDEX suspect_window_station ON suspect_window (station, id);
