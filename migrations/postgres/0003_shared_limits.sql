-- From here on the limits in a record's verdicts are written once (store/verdicts.rs). What is stored is read as before; programs that
-- knew nothing of it refuse the database.
SELECT 3;
