-- The diagnosis of each campaign: the answer as clients read it (JSON) or, where there is none, why; by which program, and
-- against which adopted model. One without a body is still to be made.
CREATE TABLE diagnosis (
    record  INTEGER PRIMARY KEY REFERENCES record (id),
    model   INTEGER REFERENCES imu_model (id),
    program TEXT,
    refused INTEGER,
    body    TEXT
) STRICT;
CREATE INDEX diagnosis_due ON diagnosis (record) WHERE body IS NULL;

-- Campaigns (kind 1) that were stored before.
INSERT INTO diagnosis (record) SELECT id FROM record WHERE kind = 1;
