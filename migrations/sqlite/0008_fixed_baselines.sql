-- Levels that a baseline mark states, deg/(h g0): what comes after it is compared with these instead of the mean of its first
-- records.
ALTER TABLE event ADD COLUMN d_i REAL;
ALTER TABLE event ADD COLUMN d_i_sd REAL;
ALTER TABLE event ADD COLUMN d_s REAL;
ALTER TABLE event ADD COLUMN d_s_sd REAL;
