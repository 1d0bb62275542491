# What commands print for people, by code. A head has " | " between its columns.

terminal_note = note: { $note }

## `diagnose`

terminal_measured_by = { $imu }, measured by { $station } at { $at }: { $verdict }
terminal_no_gap = no gap
terminal_explained = explained
terminal_partly_explained = partly explained
terminal_unexplained = unexplained
terminal_gap = noise floor { $floor } deg/h ({ $source }); gap { $gap } deg/h, where noise alone would leave { $noise }: reduced chi-square { $chi2 }, adjusted p of all tests { $p }
terminal_model = model: { $terms }
terminal_split = Against { $imu }, measured by { $station } at { $at }
terminal_split_head = gyro | gap, deg/h | parameters | structure | noise | p, parameters
terminal_all = all
terminal_moved = Then and now
terminal_moved_head = gyro | coefficient | reference | now | shift | unit
terminal_effects = Named effects
terminal_effects_head = effect | gyros | parameter | value | unit | closes | p | d | or just as well
terminal_effects_key =
    closes: of the reducible gap (what the error on held-out dwells exceeds the noise floor by), with its 95 % interval; of several
    effects each of what those above it left: compare their d, not what they close
    p: that noise alone shows as much, adjusted for everything that was tried; d: detectability, the root of the whitened power that
    the effect takes from the residuals (8 is named nearly always, 5 in two campaigns of three)
terminal_alone = { $slot } alone: { $effects }
terminal_signs = What remains
terminal_signs_head = sign of something more | gyros | p
terminal_candidates = Also beyond the noise
terminal_candidates_head = candidate | gyros | closes alone | adjusted p | not taken because
terminal_tried = Tried and within the noise: no finding (beside each its adjusted p; a name needs < { $level })
terminal_impact = Drift coefficients before and after the named effects entered the model, deg/(h g0)
terminal_impact_head = gyro | coefficient | before | after | shift | of the budget | moved
terminal_yes = yes
terminal_within_noise = no: within its noise
terminal_blind = Blind spots
terminal_blind_head = cannot be told here | visible | because | needs
terminal_next = Worth measuring next
terminal_next_head = up | north | table rate, deg/s | separates
terminal_nothing_adopted = nothing was named: the model in use
terminal_calibrated_by = { $imu }, calibrated by { $station } at { $at }: { $verdict }
terminal_closure = Closure: what two coefficients leave of G
terminal_closure_head = gyro | D_O, deg/(h g0) | of the budget | p, noise alone | clocking, deg | D_S if clocking
terminal_one_class = One class, not to be told apart here: { $effects }
terminal_peers = { $serial }; { $peers } other gyros of its stations
terminal_not_named_head = not named | what | why
terminal_changed = Effects against the model
terminal_changed_head = effect | gyro | coefficient | model | now | unit | p | changed
terminal_no = no
terminal_cannot_tell = cannot tell
terminal_cannot_tell_why = cannot tell: the gyro shows more than the model holds; that may be what has changed
terminal_moved_by = { $coefficient } of { $slot }: { $shift } deg/(h g0) from the change
terminal_diagnosed = { $count ->
    [one] { $count } campaign diagnosed
   *[other] { $count } campaigns diagnosed
}
terminal_clean = { $count } within the noise, nothing to explain
terminal_count_explained = { $count } with a gap that is explained
terminal_count_partly = { $count } with a gap that is partly explained
terminal_count_unexplained = { $count } with a gap that nothing in the catalogue explains
terminal_count_outdated = { $count } of them diagnosed by another version of the program
terminal_count_refused = { $count } left out, with nothing to diagnose
terminal_count_waiting = { $count } not diagnosed yet
terminal_findings_head = effect | gyro | IMU | stations | last without | first with | last with | campaigns | closes | D_I | D_S
terminal_or = or { $effects }
terminal_of = { $part } of { $all }
terminal_to = { $from } to { $to }
terminal_findings_key =
    campaigns: with the effect / since the first one with it, of all of the gyro; closes: of the reducible gap that what was named
    before it in the campaign has left, on held-out dwells, median (least to greatest);
    D_I, D_S: largest shift, deg/(h g0), and its part of the budget
terminal_doubts = Not explained by the catalogue, or not wholly
terminal_doubts_head = IMU | verdict | gyros | signs | stations | campaigns | first | last

## `dwells`

terminal_dwells_head = dwell | phase | start s | length s | force g0 | output pulse/s | ± pulse/s

## `import`, `revise`, `void`

terminal_tally = { $stored } stored, { $known } already known, { $refused } refused
terminal_together = together: { $tally }
terminal_refused = { $count } refused
terminal_no_coefficients = no D_I and D_S: { $reason }
terminal_verdicts = verdicts: { $counts }
terminal_counted = { $count } { $status }
terminal_interrupted = interrupted; run the same command again to resume
terminal_replaced = counts no more: { $record } stands in its place ({ $author }: { $reason })
terminal_voided = counts no more: it was voided ({ $author }: { $reason })
terminal_set_aside = does not count: set aside until somebody confirms its time
terminal_is_stored = is what is stored already, as { $id }
terminal_is_withdrawn = is stored already, as { $id }, and { $standing }
terminal_put_back = `gyrowatch revise FILE --of { $id } --author NAME --reason WHY` puts it back
terminal_stands = stands in the place of { $old }, as { $new }
terminal_was_new = nothing was stored for this IMU and time; it is stored as { $id }. If it replaces one of another time, void that one
terminal_is_voided = { $id } is voided
terminal_bench_revise = is a bench result: `gyrowatch void ID --author NAME --reason WHY` takes the wrong one out, then send this one with `gyrowatch import`
replace_bench = if this one is right, `gyrowatch void { $id } --author NAME --reason WHY` takes the other out; then send this one again
