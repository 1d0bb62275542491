-- Who sent a record or a bench result: the line of the audit trail about it (`audit.id`), which several that came together share; null of
-- what an earlier version stored.
ALTER TABLE record ADD COLUMN sent_by BIGINT;
ALTER TABLE bench_result ADD COLUMN sent_by BIGINT;

-- The program that somebody used, by its own word (`User-Agent`).
ALTER TABLE audit ADD COLUMN agent TEXT;
