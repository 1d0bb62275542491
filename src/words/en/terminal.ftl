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
terminal_cannot_tell_beyond = cannot tell: the campaign is beyond the temperatures that the model has seen, where the effect may be bent
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

## `separate`, `calibrate`

terminal_separated = { $imu }, calibrated by { $station } at { $at }
terminal_requirements = E and G against what is required of them
terminal_requirements_head = gyro | serial | E | G
terminal_drift = Drift coefficients, deg/(h g0)
terminal_drift_head = gyro | serial | method | D_I | D_S | left | which is
terminal_published = published
terminal_as_printed = as printed
terminal_rms = residual, rms
terminal_not_skewed = equations (8) to (13) hold for the skewed geometry only
terminal_directions_coincide = the input and spin directions of equations (8) to (13) coincide for this E
terminal_mounting = Mounting: |E| in pulse/arcsec, angles of the input axis in deg, clocking of S about I if D_O = 0 in truth
terminal_mounting_head = gyro | |E| | alpha x | alpha y | alpha z | off nominal | clocking
terminal_calibrated = { $imu }, measured by { $station } at { $at }: { $dwells } dwells, model { $model }
terminal_causes = Causes: { $causes }.
terminal_gap_beside_fit = { $verdict } What that does to D_I and D_S: gyrowatch diagnose { $file }
terminal_fit = Fit
terminal_fit_head = gyro | serial | E | rank | left over | chi2/dof | p, lack of fit | noise, deg/h | its source
terminal_fit_source = { $source }, factor { $factor }
terminal_gauge = Gauge: { $gauge }
terminal_parameters = Parameters
terminal_parameters_head = gyro | parameter | value | unit | remark
terminal_not_determined = not determined by these dwells
terminal_effect = effect
terminal_residuals = Largest residuals (dwells counted from 0)
terminal_residuals_head = dwell | gyro | phase | pulse/s | deg/h | in sigma | leverage
terminal_uncertainties = Standard uncertainties, deg/(h g0)
terminal_uncertainties_head = gyro | coefficient | sd | noise | levelling | azimuth | fixture | discrepancy | combined
terminal_uncertainties_unstated = No uncertainty of the station is stated: its levelling, azimuth and fixture are in no sd.
terminal_not_separated = { $slot } ({ $serial }) is not separated: { $reason }
terminal_campaigns = { $imu }: { $count } campaigns
terminal_campaigns_head = campaign | station | measured | gyro | D_I | D_S
terminal_copies = { $first } and { $second }: all outputs are the same to the last digit; is it one measurement with another time? Leave one of them out
terminal_repeats = Between campaigns
terminal_repeats_head = gyro | coefficient | n | mean | unit | stated sd | scatter | scatter/stated | p | beyond
terminal_repeats_nothing = Nothing is determined by two campaigns.
terminal_repeats_none = No coefficient differs between campaigns by more than is stated (p >= 0.05, corrected for their number).
terminal_reseated = { $file }: all input axes are turned together against { $first }, as of an IMU that was seated anew: by { $about_x }, { $about_y }, { $about_z } arcsec about its x, y and z.
terminal_reseated_explains = It explains the change of D_O of { $gyros }.
terminal_repeats_beyond = Campaigns differ by more than is stated (p < 0.05, corrected for their number), and the sd of the mean holds it: { $coefficients }.

## `model fit`, `predict`, `gap`

terminal_fit_short = { $at }: { $verdict }; forecasts will miss by what is left
terminal_fit_left_out = { $effect } is left out: these campaigns do not tell it; docs/diagnosis.md says what each effect needs
terminal_no_temperature = no temperature
terminal_model_of = { $imu }: { $coefficients } coefficients from { $campaigns ->
    [one] one campaign
   *[other] { $campaigns } campaigns
}, { $first } to { $last }, at { $reference }
terminal_model_gyros = Gyros: deg/h, deg/(h g0), pulse/arcsec, deg/sqrt(h)
terminal_model_gyros_head = gyro | serial | D_F | D_I | D_S | D_O | |E| | noise N
terminal_model_plain = No effects beside model (6)
terminal_model_effects = Effects
terminal_model_effects_head = effect | gyro | coefficient | value | unit
terminal_forecast = { $imu }, { $station } at { $at }: forecast by the model of { $model } ({ $campaigns ->
    [one] one campaign
   *[other] { $campaigns } campaigns
}, { $count ->
    [0] no effects
   *[other] { $effects }
})
terminal_promised = Promised by the model: { $closes }
terminal_seen = Seen: { $closes }
terminal_closes = the effects close { $closure } % of the forecast error (95 % { $low } to { $high } %); { $before } deg/h before, { $after } after
terminal_closes_nothing = nothing to close, the error without the effects is within the noise; { $before } deg/h before, { $after } after
terminal_nothing_to_close = nothing to close
terminal_foretold_head = dwell | gyro | output, pulse/s | sd | of it noise
terminal_not_foretold = not forecast
terminal_to_measure = Dwells that tell most of what the model does not know
terminal_to_measure_head = dwell | a, g0 | w, arcsec/s | tells, nats | sd/noise
terminal_forecast_measured = Measured: { $state }. rms(error/sd) { $rms } over { $count } outputs, p { $p }; uniformity of the PIT, p { $pit }
terminal_forecast_outside = outside its forecast
terminal_forecast_met = as forecast
terminal_forecast_not_judged = cannot be judged
terminal_forecast_gyros_head = gyro | rms(error/sd) | p
terminal_missed = { $count ->
    [one] One output missed its forecast
   *[other] { $count } outputs missed their forecast
}
terminal_missed_head = missed dwell | gyro | z
terminal_model_6 = model (6)
terminal_noise_floor = noise floor
terminal_steps_head = model | forecast error, deg/h | in sd
terminal_gap_none = { $imu }: no campaign has a forecast; it needs an earlier campaign of the same gyros
terminal_gap_of = { $imu }: forecast error of each campaign
terminal_gap_head = campaign | model | forecast error, deg/h | in sd | closes
terminal_gap_plain = No effects are adopted. `gyrowatch model fit` finds them.

## `dwells`

terminal_dwells_head = dwell | phase | start s | length s | force g0 | output pulse/s | ± pulse/s

## `import`, `revise`, `void`

terminal_tally = { $stored } stored, { $known } already known, { $refused } refused
terminal_together = together: { $tally }
terminal_refused = { $count } refused
terminal_no_coefficients = no D_I and D_S: { $reason }
terminal_verdicts = verdicts: { $counts }
terminal_counted = { $count } { $status }
terminal_watching = watching { $folder } for { $service }
terminal_revise_asked = { $file }: say in { $beside } who replaces what is stored, and why
terminal_revise_unsaid = { $file }: needs a line `author: NAME` and a line `reason: WHY`
file_empty = is empty
file_document_too_large = is one document of more than { $bytes } bytes; send one document per line
file_of_several = holds { $count } documents: take one at a time, in a file of its own
file_of_lines = holds one document per line: take one at a time
file_of_no_kind = is neither a calibration record (`gyros`), a campaign (`dwells`) nor a bench result (`method`)
file_nothing_to_print = is no table of records or bench results: there is nothing to print
file_last_line_open = its last line has no end
terminal_link = { $file }: is a symbolic link, which is not followed
terminal_file_refused = refused
terminal_stays = { $trouble }; it stays and is tried again
terminal_again = { $trouble }; trying again for half a minute
terminal_digest_late = hooks hear in a quarter of an hour what still fires: { $trouble }
terminal_interrupted = interrupted; run the same command again to resume
terminal_replaced = counts no more: { $record } stands in its place ({ $author }: { $reason })
terminal_voided = counts no more: it was voided ({ $author }: { $reason })
terminal_set_aside = does not count: set aside until somebody confirms its time
terminal_is_stored = is what is stored already, as { $id }
terminal_is_withdrawn = is stored already, as { $id }, and { $standing }
terminal_put_back = `gyrowatch revise FILE --of { $id } --author NAME --reason WHY` puts it back
terminal_stands = stands in the place of { $old }, as { $new }
terminal_revise_none = nothing is stored for IMU { $imu }: `gyrowatch import` stores this one at { $time }
terminal_revise_absent = nothing is stored for IMU { $imu } at { $time }; nearest: { $nearest }. Correct the time, or name the wrong one with --of ID; `gyrowatch import` stores a new one
terminal_was_new = nothing was stored for this IMU and time; it is stored as { $id }. If it replaces one of another time, void that one
terminal_is_voided = { $id } is voided
terminal_bench_revise = is a bench result: `gyrowatch void ID --author NAME --reason WHY` takes the wrong one out, then send this one with `gyrowatch import`
replace_bench = if this one is right, `gyrowatch void { $id } --author NAME --reason WHY` takes the other out; then send this one again

## Databases and tokens

terminal_copied_head = table | rows | copied | checksum | result
terminal_same = same
terminal_different = DIFFERENT
terminal_copied = { $from } is copied to { $to }: row counts and checksums match
terminal_copy_differs = the copy is not what the file holds now; begin again with an empty database
terminal_holdings = whole; { $records } records, { $bench_results } bench results, { $figures } calibrations of { $gyros } gyros
terminal_verified = { $records } records, { $separations } separations, { $verdicts } verdicts, { $bench_results } bench results computed again
terminal_lists_verified = { $gyros } gyros compared in lists with what is stored of them
terminal_lists_not_compared = lists of gyros are not made yet, or were made with other limits: not compared, a start makes them
terminal_not_compared = { $verdicts } verdicts were decided with other limits than those in force, by an earlier version that judged otherwise, or on records that count no more: not compared
terminal_differ = { $count } differ from what is computed again. Where only verdicts do, an event `note` of the gyro just before such a record has them decided again; else restore the newest backup on which verify finds nothing
terminal_exported = { $rows } rows of { $gyros } gyros
terminal_token_made = token { $id } ({ $name }, { $role }): keep it now, it is shown this once
terminal_no_token_id = "{ $id }" is no identifier of a token; `token list` shows them
terminal_token_revoked = token { $id } is revoked
terminal_token_revoked_before = token { $id } was revoked before
terminal_database = the database { $url }
terminal_not_backed_up = no backup of { $database } was made
terminal_not_restored = { $file } was not restored to { $database }
terminal_not_copied = { $from } was not copied to { $to }
terminal_export_form = { $file }: neither .csv nor .parquet; say --format
terminal_nameless = record { $record } has an IMU or a station without a name: check the database with gyrowatch verify
terminal_no_parquet = this program was built without Parquet: cargo build --release --features parquet
terminal_no_answer = { $address } does not answer: { $why }
terminal_answers = { $address } answers { $status }: { $why }
terminal_no_database = there is no database { $database }
terminal_other_database = the service at { $listen } has another database than { $database }, which does not exist. Name its own in GYROWATCH_DATABASE_URL or --config
terminal_new_database = there is no database { $database }: making it. A service that has another one does not know this token: name that one in GYROWATCH_DATABASE_URL or --config
terminal_tokens_head = id | name | role | station | made | state
terminal_revoked = revoked { $at }
terminal_expired = expired { $at }
terminal_until = until { $at }
terminal_valid = valid
terminal_any = any
terminal_noise_means = { $cells } weekly means of { $coefficients } coefficients between two events; { $moving } left out because they drift
terminal_noise_spacing = { $weeks } weeks with records apart ({ $days } days): spread { $spread } deg/(h g0) from { $differences } differences
terminal_noise_fitted = fitted: scatter { $scatter } deg/(h g0), correlation { $phi }, walk { $walk } deg/(h g0) per root year. For the configuration (drawn towards the defaults by 100 weekly means):
terminal_noise_unfitted = The history is too short for a fit: the defaults stay in force.
terminal_noise_stations_alike = The history does not show how stations differ: between_stations stays 0.
store_full = the disk is full
store_unusable = the database cannot be read or written: { $why }
store_locked = the database is locked by another process
store_in_use = another gyrowatch serves the database { $database }; stop it first, or use another file
store_not_durable = a write could not be made durable: { $why }; restart after checking the disk
store_unreachable = the database cannot be reached: { $why }
store_unanswered = a commit was not answered, and the database cannot be asked what became of it: { $why }
store_overtaken = overtaken by another writer: { $why }
store_refused = refused by the database: { $why }
store_other = database

## Files and servers of the database

file_absent = there is no such file
file_there = is there already, and is not overwritten
file_foreign = no database of gyrowatch
file_newer = written by a newer version of gyrowatch
file_older = written by an older version of gyrowatch: start the service on it once
file_name_not_utf8 = its name is not UTF-8
file_of_server = { $database } is no file: a server's database is copied and put back with its own tools, pg_dump and pg_restore
no_directory = there is no directory { $directory }: make it first
directory_closed = this account may not write in { $directory }, where the database and its lock are kept
address_parameter = the parameter `{ $parameter }` of its URL is not understood; what can be set is in the configuration
address_foreign = no address of a database
address_read_only = target_session_attrs={ $value }: the service writes, so it takes any, read-write or primary
server_absent = nothing listens there; does PostgreSQL run at the host and port of database.url? ({ $why })
server_foreign = what answers does not speak as PostgreSQL: { $why }
server_busy = no connection to it became free in time
server_cells_lost = the cells to write were lost
server_connection_lost = the connection was lost
server_pooled = the pooler before the database hands out connections by the transaction: set pool_mode = session for this database, or name the database itself in database.url
copy_direction = a copy goes from sqlite:// to postgres://
copy_of_other = the database holds a part of { $file }: go on with that, or begin with an empty one
copy_not_empty = the database is not empty: there are rows in { $table }
copy_unfinished = a copy into the database has not come to its end: run gyrowatch copy again
secrets_key_missing = GYROWATCH_SECRETS_KEY is missing: the secrets of { $of } are encrypted; start with the key that they were stored with
secrets_key_other = GYROWATCH_SECRETS_KEY is another key than the secrets of { $of } were encrypted with

## What is not as it was stored

damages = { $faults }
checksums_missing = the table checksum is missing
table_unsummed = the table { $table } has no checksum
table_of_other_length = the table { $table } has { $have } rows, { $written } were written
table_changed = a row of the table { $table } is not as it was written
summed_table_missing = there is a checksum of a table that is missing
row_refers_to_none = a row of the table { $table } refers to one that is missing
calendar_entries = { $count } entries of the calendar are no record's
fault_of_record = record { $id }: { $fault }
fault_of_bench_result = bench result { $id }: { $fault }
fault_of_gyro = gyro { $serial }: { $fault }
in_index_only = is in an index only
record_elsewhere = its IMU has it elsewhere
text_not_as_stored = its text is not the one that was stored
text_unreadable = its text cannot be read
under_other_imu = is stored under the IMU { $stored }, its text says { $sent }
under_other_station = is stored under the station { $stored }, its text says { $sent }
under_other_time = is stored under another time than its text says
head_missing = is missing from the table head
head_differs = the table head has { $found }, by what is stored it is { $expected }
not_of_model_in_force = is not stated by the model in force of its IMU
history_missing = is missing from its history
history_of_another = its history names another record, IMU, slot or station
figures_differ = { $stored } is stored, computed again it is { $again } (D_I, D_S, D_O, deg/(h g0), and further)
verdicts_missing = has no verdicts
verdict_differs = the verdict of the rule { $rule } on { $coefficient } is { $stored }, computed again it is { $again }
state_differs = its state is not that of its verdicts
bench_differs = { $stored } is stored, its text says { $sent } (D_I and D_S, deg/(h g0))

## What cannot be done

terminal_scenario = scenario
terminal_csv_of_experiment = --csv needs --preset { $preset }
terminal_count_needs_dir = --count needs a --dir to write into
terminal_experiment_takes = { $preset } is seven campaigns: it takes --seed, --count, and --dir or --csv only
terminal_seeds_end = the largest seed is { $last }
model_effects_of_imu = the effects of a model file are for campaigns of an IMU; this is a bench test
effect_cannot_act = { $effect } cannot act in this scenario: { $missing }
effect_without_estimate = { $effect } has no estimate of { $coefficient } for { $slot }
none_of_these_gyros = the campaign has none of these gyros
hypothesis_unseen = this design cannot see { $effect }: the model takes all of it up, or the campaign has no noise
hypothesis_of_model = --hypothesis: the model in use holds another { $id }; give one of them another id
hypothesis_undefined = --hypothesis: { $id }: { $lack } ({ $place }): { $equation } divides by zero there, or takes the square root or logarithm of a number that has none. Write it so that every dwell has a value
terminal_not_reached = some targets were not reached
terminal_key_sealed = { $count ->
    [one] key of { $count } campaign sealed: SHA-256 { $seal }
   *[other] key of { $count } campaigns sealed: SHA-256 { $seal }
}
terminal_key_revealed = key revealed: { $file }
terminal_key_read = key { $file }: SHA-256 { $seal }
terminal_is_campaign = this is a campaign: calibrate it with `gyrowatch calibrate`, which separates its gyros too
terminal_is_record = this is a calibration record: separate it with `gyrowatch separate`
terminal_is_bench_result = this is a bench result: it holds D_I and D_S already; `gyrowatch import` sends it to a service
terminal_record_without_dwells = a record has no dwells; --model, --hypothesis, --adopt, --report and --reference go with a campaign
terminal_order_canceled = order { $id } was canceled; campaigns not diagnosed: { $count }
terminal_not_diagnosed = { $failed } of { $count } campaigns could not be diagnosed
terminal_order_goes_on = order { $id } continues at the service; the same command finds it again
terminal_gap_needs_campaigns = with a model file, name the campaigns to compare it with
terminal_hypothesis_by_id = --hypothesis: name its id in --effects; `diagnose --hypothesis` says whether the campaign shows it
terminal_one_occasion = --effects: { $effect } belongs to the campaign in which it happened; auto finds it there
terminal_part_of_g = --effects: { $effect } is part of G, which the model holds already
terminal_no_model_file = { $faults }; and there is no model file of that name
terminal_holds_no_model = { $file }: holds no model, and only model files are replaced; name another file
terminal_model_without_imu = { $file }: holds effects but no coefficients of an IMU; `gyrowatch model fit` makes such a file
terminal_too_large = is larger than { $most } bytes
terminal_file_replaced = replaced { $file }
terminal_files_replaced = { $count ->
    [one] replaced { $count } file in { $folder }
   *[other] replaced { $count } files in { $folder }
}
terminal_no_template = there is no { $of } as { $format }: see `gyrowatch template --help`
terminal_workbook_out = write a workbook with --out FILE
terminal_diagnosis_failed = { $campaign } of { $imu } ({ $at }): { $reason }

## Talking to a service

terminal_no_address = "{ $address }" is not the address of a service, such as http://127.0.0.1:8080
terminal_no_certificate = { $file }: holds no certificate in PEM
terminal_token_read_again = read again, since its token was refused: { $file }
terminal_cannot_reach = cannot reach { $address }: { $why }
terminal_foreign_answer = the answer does not come from gyrowatch
terminal_batch_refused = the whole batch was refused: { $why }
terminal_answers_missing = { $sent } lines were sent, { $answered } answered
terminal_is_folder = { $folder } is a directory; name its files, or watch it with --watch
terminal_no_folder = { $folder } must be a directory, not a symbolic link or a file
terminal_cannot_move = cannot move it to { $file }
terminal_nothing_to_void = no record, campaign or bench result has the identifier "{ $id }"

## `serve`, `demo`

terminal_listens = gyrowatch listens on { $url }
terminal_cannot_listen = cannot listen on { $address } (server.listen)
terminal_cannot_use = cannot use the database { $database } (database.url)
terminal_token_first = cannot listen on { $address } (server.listen): there is no token yet, and without one anyone could do everything. Create one first: gyrowatch token create NAME --role admin
terminal_not_ended = not everything ended within { $seconds } s (server.shutdown_grace_s): what was not answered may not be stored
terminal_demo_on = the demo on { $address } (--listen takes another address, port 0 a free one)
terminal_demo_not_posted = the demo's fleet could not be posted: { $why }
terminal_demo_posted = posted { $count } records, bench results and marks through the API
terminal_demo_pages =
    The fleet                        { $base }/
    A gyro whose D_I rises           { $base }/gyros/LFG-0004
    Cause of the rise                { $base }/gyros/LFG-0004/diagnosis
    One that ages within its budget  { $base }/gyros/LFG-0014
    One whose D_S jumped             { $base }/gyros/LFG-0008
    One that was repaired and moved  { $base }/gyros/LFG-0011
    Raw campaigns, to diagnose       { $base }/imus/IMU-21
    Table 5, method beside method    { $base }/gyros/PAPER-T5-G1
    A trend as CSV                   { $base }/v1/gyros/LFG-0004/trend?coefficient=D_I&format=csv
    The API, to read and try         { $base }/docs

    Ctrl-C stops it; the data stay in the file.

## `simulate`

preset_24_position = 24 positions, 6 repeats and 48 rate dwells in random order: 78 dwells of three minutes
preset_24_bare = 24 positions once each in fixed order, no rates, E stated: the least that yields D_I and D_S
preset_36_position = 24 positions and 12 edges at 45 degrees, 6 repeats, 48 rate dwells
preset_60_position = 24 positions, edges, tilts of 30 and 60 degrees, 6 repeats, 48 rate dwells
preset_long = 1008 dwells: the 60-position programme eight times over, four power-ups, wandering bias, counted pulses
preset_orthogonal_mems = three orthogonal gyros, whole-pulse counter, no rates, no temperature, no standard errors
preset_paper_experiment = Table 5: each gyro on the bench, all in the IMU, each on the bench again
terminal_ranges = range of bench before, IMU, bench after; { $count } simulated experiments from seed { $seed }
terminal_ranges_head = gyro | coefficient | method | median | 95 % | largest | below 1.301e-3
terminal_ranges_below = all six ranges of an experiment below { $headline } deg/(h g0):

## `blindcheck`

terminal_hypothesis = { $id } in campaigns of this design: { $found }
terminal_named_never = not named in { $share } at any of these sizes: use a larger --detectability
terminal_named_from = named in { $share } from { $size } { $unit } on
terminal_named_shown = named in { $share } from { $size } { $unit } on, shown from { $surely } on
terminal_named_unshown = named in { $hits } of { $trials } from { $size } { $unit } on; that is { $interval } (95 % interval) and does not show { $share }: --count { $least } or more can
terminal_hypothesis_head = d | largest coefficient (median) | campaigns | named | 95 % interval | only in a class | something else
terminal_hard_to_tell = hard to tell from it here: { $effects }
terminal_where_not = without it: named in { $hits } of { $trials } ({ $rate }, 95 % interval { $interval }); anything named in { $anything }
terminal_undiagnosed = no answer: { $why }
terminal_blind_campaigns = { $count } campaigns, key SHA-256 { $seal }
terminal_blind_key = named: the effect itself, or a class that holds it because the campaign cannot tell its members apart
terminal_goals_head = case | hits | trials | rate | 95 % interval | to reach
terminal_fleet_goals_head = what | hits | trials | rate | 95 % interval | to reach
terminal_reached = reached
terminal_short_of_it = NOT REACHED
terminal_by_effect_head = one effect, named: by effect | hits | trials | rate | 95 % interval
terminal_by_design_head = by set of positions | hits | trials | rate | 95 % interval
terminal_by_errors_head = by standard errors | hits | trials | rate | 95 % interval
terminal_by_family_head = outside the catalogue, partly or not explained | hits | trials | rate | 95 % interval
terminal_confusion_head = hidden | named (- nothing), how often
terminal_named_instead_head = hidden | named instead (- nothing), how often
terminal_blind_times = one diagnosis: median { $median } ms, 99 % { $p99 } ms, most { $most } ms; all campaigns: { $seconds } s
terminal_kinds_head = kind | campaigns | confident wrong | doubted wrong | all named, if visible | visibly in part, explained as whole | closure in interval | gap, no name | noise said | described | median, ms | no answer
terminal_blind_fleets = { $fleets } fleets of seed { $seed }, { $seconds } s
terminal_speed =
    { $gyros } gyros with { $records } records in { $fleet_s } s on { $threads } threads
    one gyro with { $of_one } records and 40 peers: { $one_ms } ms (median), { $slowest_ms } ms (slowest)

## A value of an argument

argument_one_of = must be one of { $known }
argument_presets = presets are { $known }
argument_positive = must be a positive number
argument_count = must be a whole number from 1 on
argument_seconds = must be a number of seconds from 0 to 3600
