# What several areas say. Codes are snake_case and the same as in answers; a code never changes its meaning.

beside = { $first } and { $second }
