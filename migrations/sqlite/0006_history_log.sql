-- History rows in the order in which they came, until they are folded into `history`: one run of bytes a commit, in it
-- gyro number (4 bytes) and figures (store/figures.rs) of each row. Of two rows of a gyro and instant the later one holds.
CREATE TABLE history_log (
    id   INTEGER PRIMARY KEY,
    rows BLOB NOT NULL
) STRICT;
