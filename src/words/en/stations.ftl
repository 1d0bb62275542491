# What is said of a station's own files, by code.

standard_input = standard input
at_file = { $file }: { $fault }
at_map_key = `{ $key }`: { $fault }

## What a file is

file_is_folder = is a folder; name the files in it
file_is_empty = is empty: nothing was written to it
file_is_zeros = holds nothing but zeros: it was being written when the power failed; take the copy of the logger
file_is_binary = is binary, in a format that is not known here; let the logger write CSV, or convert the file to CSV
file_is_other = is a file of { $name }, not a log; export a table of samples as CSV
file_is_mat = is a MAT-file of version { $version }, which is not read; in MATLAB: load('FILE'); save('FILE7.mat', '-v7')
file_is_hdf5 = is an HDF5 file, which is not read; write the data sets as CSV, for example with h5dump or Python's h5py
file_is_ulog = is a ULog of PX4, a binary log of many topics; `pip install pyulog`, then `ulog2csv FILE -m sensor_combined`, and use the CSV
file_is_rosbag = is a ROS bag, which is not read; `rostopic echo -b FILE -p /imu/data > log.csv`, and use the CSV
file_is_mcap = is an MCAP recording, which is not read; export the IMU's topic as CSV, for example with Foxglove
file_is_dataflash = is a dataflash log of ArduPilot, which is not read; `mavlogdump.py --format csv --types IMU FILE > log.csv`
file_is_tdms = is a TDMS file of LabVIEW, which is not read; open it in Excel with NI's add-in and save it as xlsx or CSV
file_is_xls = is an old Excel or Office file (.xls); save it as .xlsx or CSV
file_is_no_text = is a file of { $name }, not text; save the table as CSV, or send it with `gyrowatch import`
file_is_log = is a log of { $name }; `gyrowatch dwells` makes a campaign of it first
file_is_parquet = is a Parquet file, which this program was built to leave alone (build it with `--features parquet`); in Python: pandas.read_parquet("FILE").to_csv("log.csv", index=False)
file_is_arrow = is an Arrow (Feather) file, which is not read; in Python: pandas.read_feather('FILE').to_csv('FILE.csv', index=False)
file_is_gzip = is compressed with gzip; unpack it with `gunzip FILE`
file_is_zip = is a zip archive; unpack it and name the files in it
file_is_json = is JSON, not a table of samples; campaigns and records go to `gyrowatch import`
log_too_large = a file sent here may have { $most } bytes, the limit that { $key } sets; `gyrowatch dwells` makes a campaign of logs of any length, `gyrowatch import` sends files of many documents
mat_broken = is a MAT-file that breaks off or is damaged; save it again with save('FILE', '-v7')
npy_broken = is a file of NumPy that breaks off or is damaged; save it again with numpy.save or numpy.savez
npy_pickled = holds Python objects, which are not read; save numbers: numpy.save("FILE", array.astype(float))
npy_shape = holds an array of { $dimensions } dimensions; a log has a row a sample and a column a channel
npy_wide = would have { $columns } columns of { $rows } rows; a log has a row a sample and a column a channel
npy_no_numbers = holds no array of real numbers
parquet_broken = cannot be read as Parquet: { $why }
parquet_codec = is compressed with { $codec }, which is not read; in Python: pandas.read_parquet("FILE").to_parquet("log.parquet", compression="snappy")
parquet_no_numbers = is a Parquet file without a column of numbers
xlsx_broken = cannot be read as xlsx: { $why }
xlsx_no_table = is a workbook without a table of numbers
no_numbers = is text without a table of numbers ({ $lines } lines were looked at): a header alone, or no log
no_rows = no row has a number in every column that the map names; { $count } rows have empty cells or nan
commas_of_two_kinds = decimal commas between commas: { $cells } cells under { $columns } columns, and nothing tells the two apart; let the program write semicolons between the columns, or decimal points
zeros_from_here = only zero bytes from here on: the logger lost power while it wrote; cut the file off here
rows_unreadable = { $count } of { $rows } rows cannot be read; the first: { $fault }
cell_missing = the row ends before this column
row_too_long = the row has more than { $cells } cells: a decimal comma between commas, or a delimiter within a text, moves those behind it
cell_thousands = "{ $value }" has a mark for decimals or for thousands, and nothing tells which: the column has { $count } such cells, whole numbers beside them, and no other decimals; write numbers without separators of thousands

## Columns

log_column_unknown = no column is named "{ $name }"; there are: { $known }
log_column_like = no column is named "{ $name }"; did you mean "{ $like }"? There are: { $known }
log_column_number = there is no column { $number }; the log has { $columns }
log_column_twice = several columns are named "{ $name }"; give the number of the one that is meant
log_columns_unnamed = the log has no header, so no column is named "{ $name }"; name columns by number, 1 to { $columns }
log_other_layout = has other columns than { $first }; logs that follow one another must be alike
log_twice = holds the same { $rows } rows as { $other }; what is given twice would count twice: name each log once
log_repeats = holds { $seconds } s of { $other } again, from { $from } s to { $to } s of its clock, and they would count twice: cut them off one of the two, or name one log alone
log_overlaps = begins at { $from }, { $seconds } s before { $other } ends ({ $to }), and what both hold would count twice: cut the first { $seconds } s off this log, or name one of the two alone. If a clock was set back, give `rate_hz` in place of `time`
logs_in_order = the logs were named in another order and are read in order of time: { $logs }
log_unused = nothing in the map is of log { $log }; say `log = { $log }` where its columns are named
logs_apart = the logs have no time in common; do they run beside one another?

## The map

map_unreadable = the map cannot be read: { $why }
map_unanswered = "?" must be answered: the log does not say it
map_missing = `{ $key }` is missing in the map and on the command line
map_no_columns = names no column
map_column_count = must name { $need } columns, names { $have }
map_each = `{ $name }` must be one number or one per column; it has { $have } for { $columns } columns
map_gyros = `gyros` names { $gyros }, `output` has { $outputs } columns
map_known_e = `known_e` has { $have } rows for { $gyros } gyros
map_log = there is no log { $log }: { $logs } were named on the command line
map_logs = the map is of { $logs } logs beside one another; { $have } were named
map_no_time = neither `time` nor `rate_hz` is given: how many samples a second are there?
map_unit_missing = the unit is missing, and the header does not say it; one of { $known }
map_unit_unknown = "{ $unit }" is no unit of this; one of { $known }. Raw counts need `scale` and `offset`, and the unit that these lead to
map_unit_of_header = the map says { $unit }, the header of the log says { $header }; which is right?
map_unit_of_header_alone = the header says "{ $header }", which is no unit of this; say in the map what the numbers are in: `unit`, one of { $known }
map_site_missing = `site` is missing: without latitude and gravity nobody knows what was commanded
unit_of_header = { $key } is taken for { $unit }, as the header says
unit_of_map = { $key } is taken for { $unit }, as the map says
unit_of_map_alone = { $key } is taken for { $unit }, as the map says; the header says "{ $header }", which is no unit known here

## Time

date_unclear = "{ $value }" is a date whose day and month cannot be told apart; write it as 2026-11-24 (yyyy-mm-dd), or name `rate_hz` in place of `time`
time_unread = "{ $value }" is no time that can be read; write 08:15:00.5, 2026-11-24T08:15:00 or 20261124T081500, with an offset or Z if you like, or give `rate_hz` in place of `time`
time_back = time jumps back by { $seconds } s, from { $from } to { $to }: two logs in one file, or a clock that was set; cut the file here and name both parts
time_coarse = { $repeated } of { $rows } samples repeat the time before: the clock is too coarse; leave `time` out and give `rate_hz`
time_wrapped = the clock began anew { $count } times (midnight, or a full counter) and was carried on
clock_of_another_date = is { $stated }, and the log's clock runs from { $from } to { $to }. Mend it; with Unix time or an offset in the log it may be left out. If the clock is wrong, give `rate_hz` in place of `time`
clock_unset = the log's clock says { $from }, as one that was never set: `measured_at` is taken from the map, { $stated }
time_unlikely = a sample every { $step } s, { $days } days of log, { $usual } s a steady interval: `time` (or `rate_hz`) is in another unit than the map or the header says
samples_lost = { $lost } samples are lost in { $gaps } gaps, of { $rows }; means are of what is there
samples_repeated = { $count } samples repeat the time before and are left out
samples_disordered = { $count } samples are out of order by less than two intervals
samples_frozen = frozen: { $runs } times an output or the force read the same for up to { $count } samples in a row, which is left out ({ $spans } s): did the sensor or the logger hang?
output_dead = output { $output } reads { $value } all the while: the gyro, or its column, is dead
rows_incomplete = { $count } rows with empty cells are left out
rows_left_out = { $count } lines that are no rows are left out
rows_left_out_at = { $count } lines that are no rows are left out; the first: { $fault }
temperatures_left_out = { $count } temperatures are fault values of the sensor (a jump of more than 20 °C and back), and left out
counter_wrapped = counters began anew { $count } times (16, 24 or 32 bits) and were carried on
counter_reset = counters fell to zero { $count } times and counted on from there: were they reset, or are they full at another count than 16, 24 or 32 bits? Samples in which they fell are in no dwell
counter_unclear = a counter of { $bits } bits changes by about half of its range from one sample to the next ({ $count } times), so nothing says how often it began anew: log faster, log the pulses of each sample, or use a wider counter
samples_alternate = samples of `{ $key }` { $column } alternate between two levels ({ $one }, { $other }): are they of two IMUs in one file? Write one file for each
log_of_several = column { $column } holds { $ids }: rows of several IMUs in one file; write one file for each

## Intervals

no_interval = no interval of { $least } s or more is still or steady in { $seconds } s of log. A campaign needs positions that are held; `min_s` in the map allows shorter ones
intervals_below_min = { $fault }. { $count } steady intervals are left out as shorter than { $least } s (up to { $longest } s long): `min_s` in the map keeps them
moves = nothing is still in { $seconds } s of log: the outputs change smoothly all the time. A campaign needs positions that are held
one_interval = the whole log is one interval of { $seconds } s in one position (mean outputs { $means }). A campaign needs several positions: name the logs of all of them, in order
one_orientation = all { $count } dwells have one orientation: the fit can tell neither D_I nor D_S from them
intervals_short = { $count } steady intervals are much shorter than the others and are taken for pauses (at { $starts } s …); a smaller `min_s` in the map keeps them
intervals_too_short = { $count } steady intervals are shorter than { $least } s (up to { $longest } s long) and left out; `min_s` in the map keeps them
intervals_split = { $count } long intervals were cut into dwells by the regular clock of the others: the position was taken twice
after_clipping = { $clipped }. Without them: { $fault }
intervals_clipped = { $count } intervals are clipped, and left out: an output or the force is at the end of its range (at { $starts } s …)
intervals_turning = { $count } turning intervals are left out: nothing says how fast the table turned; give `rate`, `table` or --programme
intervals_all_edge = { $count } intervals are left out: they are nothing but edges; `cut_s` in the map cuts less
all_turning = the IMU turns in every interval, and nothing says how fast; give `rate`, `table` or --programme. Where it stands, `offset` of `output` is missing
turns_not_whole = { $count } turning dwells are shorter than one turn: what the Earth's horizontal rate leaves in them is less than their noise
turns_too_short = { $count } turning intervals are left out. They are shorter than one turn, and nothing says at which heading they began: up to { $most } arcsec/s of the Earth's rate are in their means. Turn through whole turns, or log the table's angles or the attitude
turns_left = the table turned steadily in { $count } stretches, { $seconds } s in all, that became no dwell, for the reasons above: { $spans } s
turns_unsteady = NO DWELL from { $count } stretches in which the table turned steadily, { $seconds } s in all: the outputs were not steady in them, even without what the Earth's rate does in a turn: { $spans } s
swings_unsteady = NO DWELL from { $count } stretches in which the outputs changed no more than the Earth's rate lets them in a turn, { $seconds } s in all: { $spans } s
intervals_tumbling = { $count } intervals are left out in which the table turned about an axis that is not vertical: gravity does not stand still in them
averaged_rows = { $count } rows are taken for averages, one dwell each
averaged_durations = durations are made up (one second a row): give `duration`, or `samples` and `rate_hz`
averaged_counts = the outputs of averages must be rates (pulse/s, deg/s ...), or `pulse` of a whole row with its `duration`
averaged_many = has more than { $most } rows: these are samples, not averages; leave `averaged` out
averaged_turning = the outputs of { $count } of { $of } rows are those of turns, and nothing says how fast the table turned: name `rate` in the map, or give --programme
averaged_errors = their standard errors are not known: `standard_error` in the map names the columns that hold them
averaged_beside = averages must be in one table: `log` cannot be used with `averaged`
averaged_duration = a duration must be positive, is { $seconds } s
averaged_error = a standard error must be positive, is { $value }
averaged_attitude = an attitude has the length one, this one { $length }: are these its four columns?
rates_inertial = the three rates are taken for rates in inertial space, with the Earth's in them; `inertial = false` in `rate` says otherwise
rates_table = the three rates are taken for those of the table, without the Earth's; `inertial = true` in `rate` says otherwise
rates_unknown = the smallest of the rates is { $least } arcsec/s, neither rest nor the Earth's rate: say `inertial = true` or `false` in `rate`
map_of_averages = `{ $key }` belongs to tables of averages: `averaged = true` is missing
map_column_again = column "{ $name }" is named twice

## What was commanded

commanded_unknown = nothing says what was commanded: give --programme, or name `table`, `attitude` or `force` in the map
commanded_heading = the heading of each position is not known, and gyros in pulses see the Earth's horizontal rate: give --programme, or name `table` or `attitude` in the map
commanded_heading_seen = the gyros are quiet enough to see the Earth's horizontal rate, and the heading of each position is not known: give --programme, or name `table` or `attitude` in the map
force_other_unit = the force is { $length } g0 long in the usual interval: it looks like { $unit }, and the map says otherwise
force_no_unit = the force is { $length } g0 long in the usual interval, which is gravity in no unit: are these the columns of the accelerometers?
force_varies = the force is { $least } to { $most } g0 long while nothing moves: is one of its columns that of another sensor, or is the scale of one wrong?
e_held = nothing turned at a known rate, so E is held: one pulse is one arcsec about the nominal input axis

## The programme

programme_empty = the programme has no rows
programme_attitude = a position is `up` and `north`, or all of attitude_w, _x, _y, _z
programme_parallel = "{ $up }" up and "{ $north }" north are parallel
at_programme_column = column { $name }: { $fault }
not_an_axis = "{ $text }" is no body axis; write +X, -X, +Y, -Y, +Z, -Z or three numbers
not_an_earth_axis = "{ $text }" is no direction of the Earth; write east, north or up, with a minus for the opposite
programme_count = { $intervals } intervals were found and the programme has { $rows } rows; without `force`, `rate` or times nothing says which is which
intervals_alike = { $fault }. Neighbours with the same outputs may be one position, which a gap, a clock that was set or a disturbance splits: intervals { $places }. Then repeat its row in the programme, once for each part
pauses_long = { $fault }. Long pauses may hide a position in which nothing was steady: between intervals { $places }. If it is lost, leave its row out of the programme
programme_other = only { $matched } of { $intervals } intervals and { $rows } rows of the programme agree in vertical, rate and order: is it another programme, or are axes exchanged?
programme_undecided = { $intervals } intervals and { $rows } rows of the programme: several ways to match them fit vertical, rate, outputs and the log's clock as well, so nothing says which rows are missing; give each row its `start_s` and `duration_s`
programme_clock_unit = the programme's times fit the log only when each is multiplied by { $factor }: are `start_s` and `duration_s` in another unit than s?
programme_clock_unused = the programme's times do not fit the log and are not used: the order of the rows was
outputs_contradict_in = the table's angles or signs contradict the outputs in dwells { $dwells }; the others agree. With these, the error model leaves { $times } times the noise: are rows exchanged, or not those of the log?
outputs_contradict = the table's angles or signs contradict the outputs: the error model leaves { $times } times the noise of the { $of } dwells, most in dwells { $dwells }. Check axes, signs and zero of the table, the order of the rows, and whether outputs are clipped
output_other_unit = { $slot } has { $scale } pulse/arcsec, where a gyro that measures rates of turn has 1: `output` looks like { $unit }
output_other_scale = { $slot } has { $scale } pulse/arcsec, where a gyro that measures rates of turn has 1: `output` is in another unit, or the commanded rates are wrong by this factor
programme_missing = { $count } of { $rows } rows of the programme have no interval in the log, { $turning } of them turns: rows { $which }
programme_exchanged = the log has { $count } intervals, as many as the programme has rows, and rows { $rows } do not fit theirs: are they exchanged, or is one missing and another too many? `start_s` and `duration_s` would tell
programme_left = { $count } intervals are in no row of the programme and are left out
programme_clock = the programme begins at { $seconds } s of the log
programme_ambiguous = the programme's times fit the log as well from { $one } s on as from { $other } s on, a dwell apart: name `force` or `rate` in the map, or log the whole programme
rate_other_unit = `rate` of the log looks like { $unit }: in all turns programme, angles, attitude, or the swing that the Earth's rate makes in the outputs, say so. Mend its unit in the map
rate_at_rest = `rate` of the log shows { $rates } deg/s in every still position, and from { $least } deg/s on the table is taken to turn: name this in the map as `offset` of `rate`, in the unit of its column
time_other_unit = `time` looks like { $unit }: in all turns the outputs swing as the Earth's rate makes them, if it is. Mend its unit in the map
time_unproved = a sample every { $step } s, intervals of { $usual } s: cannot tell whether `time` is in this unit, because no turn shows the Earth's rate. If these are too long, mend its unit in the map
scale_unproved = cannot tell whether `output` is in this unit, because no heading is known: the Earth's rate at rest would show its scale, and that of `rate`. Give --programme, or name `table` or `attitude` in the map
programme_rates = in { $count } of { $of } dwells the rate in the log contradicts the programme; the first at { $start } s: is it another programme, or a sign?
turns_at_another_rate = in { $count } turns the outputs swing with the Earth's rate as at another rate than the programme tells (at { $turns }): is the rate of a row wrong?
turns_by_one_factor = in all { $count } turns the outputs swing with the Earth's rate about { $percent } % off the rates that the programme tells. The log's clock (`rate_hz`, `time`) or every rate is wrong by so much; |E| is too, unless only the clock is and the outputs are no counts
programme_contradicted = in { $count } of { $of } dwells the accelerometers contradict the programme; the first at { $start } s, by { $degrees } deg: axes, signs or order are wrong
cells_alike = { $count } cells in lines { $from } to { $to } have the same fault; the first: { $fault }
cells_alike_of_line = { $count } cells in line { $line } have the same fault; the first: { $fault }
dwells_told = the head says { $told } dwells, the table has { $have }: it is not finished, or breaks off
stored_otherwise = { $what } of { $at } is stored already, as { $id }, and is quite another document
stored_otherwise_at = { $what } of { $at } is stored already, as { $id }, with other figures: they differ at { $places }
replace_it = if this one is right, `gyrowatch revise FILE --author NAME --reason WHY` puts it in the place of { $id }
not_one_calibration = must be one record or one campaign

guess_head = Guessed from { $logs }: check every line, and fill in what is "?".
guess_time_example = such as 2026-03-01T08:00:00Z
guess_geometry = or "skewed", or axes by slot
guess_site = of the station
guess_few_rows = few rows: if each is an average already, say averaged = true, and duration or samples
guess_no_output = no column looks like a gyro's
guess_time_unread = column { $column } holds neither numbers nor times with a plain date (2026-11-24 08:15:00): write it so, or say how many samples a second
guess_time_unsteady = column { $column } is named as a time and does not rise steadily: say how many samples a second
guess_time_counts = column { $column } counts rows and is no time: say how many samples a second
guess_no_time = no column rises steadily: say how many samples a second
guess_time_or_temperature = column "T" rises, but may be a temperature: name it as `time` or as `temperature`, and say the rate if it is no time
guess_time = rises by { $step } from row to row; { $unit } gives { $hz } samples a second
guess_time_ticks = rises by { $step } from row to row; { $count } { $unit } a count gives { $hz } samples a second
guess_clock = times of day or dates: read as seconds, { $step } from row to row
guess_time_unit = rises by { $step } from row to row, in a unit that nothing says: s gives { $of_s } samples a second, ms { $of_ms }
guess_rate = named as a rate, and not that of the gyros: taken for the table's
guess_header = the header says { $unit }
guess_output_unit = nothing says the unit of the gyros: pulse/s, pulse, deg/s, rad/s ...
guess_gravity = its length is { $length } in most rows, which is gravity in { $unit }
guess_no_gravity = its length is gravity in no unit: say with scale and offset what a count is
guess_celsius = named as a temperature; taken for degrees Celsius
