-- What somebody said of what a station measured in a window of time: suspect, or to be trusted again. Of two the later
-- holds where they meet.
CREATE TABLE suspect_window (
    id       INTEGER PRIMARY KEY,
    station  INTEGER NOT NULL REFERENCES station (id),
    first_at INTEGER NOT NULL,
    last_at  INTEGER NOT NULL,
    trusted  INTEGER NOT NULL,
    author   TEXT NOT NULL,
    reason   TEXT NOT NULL
) STRICT;
CREATE INDEX suspect_window_station ON suspect_window (station, id);
