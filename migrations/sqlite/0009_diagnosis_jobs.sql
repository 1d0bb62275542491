-- Orders to diagnose many campaigns: which ones and whether again (`asked`, JSON as clients read it), by whom.
CREATE TABLE diagnosis_job (
    id       INTEGER PRIMARY KEY,
    asked_at INTEGER NOT NULL,
    asked_by TEXT NOT NULL,
    asked    TEXT NOT NULL,
    canceled INTEGER NOT NULL,
    begun_at INTEGER,
    ended_at INTEGER
) STRICT;
CREATE INDEX diagnosis_job_open ON diagnosis_job (id) WHERE ended_at IS NULL;

-- The campaigns of each. state: waiting, done, failed (and why), canceled. What is in work is still waiting, so that it is
-- taken up again by whoever comes after a crash.
CREATE TABLE diagnosis_task (
    job    INTEGER NOT NULL REFERENCES diagnosis_job (id),
    record INTEGER NOT NULL REFERENCES record (id),
    state  TEXT NOT NULL,
    reason TEXT,
    PRIMARY KEY (job, record)
) STRICT, WITHOUT ROWID;
CREATE INDEX diagnosis_task_waiting ON diagnosis_task (job, record) WHERE state = 'waiting';
CREATE INDEX diagnosis_task_of_record ON diagnosis_task (record, job);

-- What a summary of many diagnoses says of each, without the whole of it: verdict, gyros, effects, impact (JSON).
CREATE TABLE diagnosis_gist (
    record      INTEGER PRIMARY KEY REFERENCES record (id),
    imu         INTEGER NOT NULL REFERENCES imu (id),
    station     INTEGER NOT NULL REFERENCES station (id),
    measured_at INTEGER NOT NULL,
    program     TEXT NOT NULL,
    gist        TEXT NOT NULL
) STRICT;
CREATE INDEX diagnosis_gist_in_time ON diagnosis_gist (measured_at, record);

-- Of diagnoses that were made before.
INSERT INTO diagnosis_gist (record, imu, station, measured_at, program, gist)
SELECT record.id, record.imu, record.station, record.calibrated_at, diagnosis.program, json_object(
    'verdict', CASE WHEN diagnosis.refused THEN 'refused' ELSE diagnosis.body->>'$.verdict' END,
    'gyros', json((SELECT json_group_array(json_object('slot', value->>'$.slot', 'serial', value->>'$.serial'))
                   FROM json_each(record.body, '$.gyros'))),
    'effects', json(CASE WHEN diagnosis.refused THEN '[]' ELSE
        (SELECT json_group_array(json_object('effect', value->>'$.effect', 'class', json(value->'$.class'),
                                             'gyros', json(value->'$.gyros'), 'closure', json(value->'$.held_out.closure')))
         FROM json_each(diagnosis.body, '$.effects')) END),
    'impact', json(CASE WHEN diagnosis.refused THEN '[]' ELSE
        (SELECT json_group_array(json_object('slot', value->>'$.slot', 'coefficient', value->>'$.coefficient',
                                             'shift', json(value->'$.shift'), 'of_budget', json(value->'$.of_budget')))
         FROM json_each(diagnosis.body, '$.impact')) END),
    'signs', json(CASE WHEN diagnosis.refused THEN '[]' ELSE
        (SELECT json_group_array(json_object('kind', value->>'$.kind', 'gyros', json(value->'$.gyros')))
         FROM json_each(diagnosis.body, '$.remaining.signs')) END))
FROM diagnosis JOIN record ON record.id = diagnosis.record
WHERE diagnosis.body IS NOT NULL AND diagnosis.program IS NOT NULL;
