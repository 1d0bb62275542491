# What is wrong with a document, by code.

## Tables

no_table = no table: expected a header row and one row per dwell below the "# key: value" lines
table_unreadable = the table cannot be read: { $why }
not_a_number = "{ $value }" is not a number
decimal_comma = "{ $value }" has a decimal comma; write decimals with a point
not_finite = must be a finite number, is "{ $value }"
not_slot_and_serial = "{ $text }" is not a slot and a serial, such as G1 LFG-0101
utf16 = the file is UTF-16; save it as UTF-8 ("CSV UTF-8" in a spreadsheet)
not_utf8_text = not UTF-8 text: save it as UTF-8 ("CSV UTF-8" in a spreadsheet)
not_utf8_from = not UTF-8 from byte { $byte } on
not_utf8 = is not UTF-8: { $why }

## Names, texts, times

empty_text = must not be empty
too_many_characters = must have at most { $most } characters, has { $have }
control_character = must not contain the control character { $character }
invisible_character = must not contain the invisible character { $character }; type the name again
not_day_or_rfc3339 = must be a day (UTC) such as 2026-03-01, or an RFC 3339 time such as 2026-03-01T16:00:00+08:00
not_rfc3339 = must be an RFC 3339 time such as 2026-03-01T08:00:00Z or 2026-03-01T16:00:00+08:00
no_utc_offset = must have an offset from UTC: Z, or for example +08:00
utc_offset_range = its offset from UTC must be between -23:59 and +23:59
not_in_calendar = is not a date and time of the calendar
before_year_0 = must not be before the year 0 in UTC
no_leap_second = has a 60th second where there was no leap second
after_last_time = is after { $last }, the last time that can be stored
before_earliest = is before { $earliest }, the earliest time that `plausibility.earliest` accepts
clock_never_set = comes from a clock that was never set and counts from 1970-01-01; set the station's clock and send the true time, or remove the date from `plausibility.clock_epochs`
time_in_future = is more than { $hours } hours ahead of the service's clock

## Numbers

wrong_length = must have { $need } elements, has { $have }
magnitude_at_most = must be a finite number of magnitude at most { $most }, is { $value }
temperature_range = must be a temperature between -273.15 and 1000 deg C, is { $value }
deviation_range = must be a standard deviation from 0 to { $most }, is { $value }
latitude_range = must be from -90 to 90, is { $value }
station_uncertainty_range = must be a standard uncertainty of 0 to { $most } arcsec, is { $value }
gravity_range = must be local gravity in g0 (9.80665 m/s^2), 0.9 to 1.1, is { $value }
gravity_of_no_place = is { $value } g0, gravity of no place at latitude { $latitude } deg: normal gravity there is { $normal } g0, and { $least } to { $most } is accepted. Write local gravity in m/s^2 divided by 9.80665, or correct the latitude
no_direction = must have a direction
not_unit_vector = must be a unit vector, its length is { $length }
not_perpendicular = must be perpendicular to the input axis, the angle is { $angle } deg
not_unit_quaternion = must be a unit quaternion [w, x, y, z], its length is { $length }
scale_factor_range = |E| = { $norm } pulse/arcsec is outside { $low } to { $high }, the limits that `plausibility.min_scale_factor` and `plausibility.max_scale_factor` set; is it in another unit?
direction_of_another = its direction is { $angle } deg from the input axis that the geometry gives { $slot }; at most { $most } deg is accepted; it fits that of { $other }: have two been interchanged?
direction_off_axis = its direction is { $angle } deg from the input axis that the geometry gives { $slot }; at most { $most } deg is accepted
drift_range = |G/E| = { $value } deg/(h g0) is beyond { $most }, the limit that `plausibility.max_drift_deg_per_h_g0` sets; is it in another unit?
coefficient_range = { $value } deg/(h g0) is beyond { $most }, the limit that `plausibility.max_drift_deg_per_h_g0` sets; is it in another unit?
baseline_range = must be within +-{ $most } deg/(h g0), is { $value }
not_positive = must be positive, is { $value }
negative = must not be negative, is { $value }
negative_start = must not be negative (it counts from the first dwell), is { $value }
sem_not_positive = a standard error must be positive (at least { $least } pulse/s), is { $value }

## Gyros and campaigns

gyros_one_to_three = must have one to three gyros, has { $have }
slot_taken = { $slot } is already taken by { $place }
serial_taken = { $serial } is already named by { $place }
named_twice = { $name } is named twice
no_axes_for = the geometry names no axes for { $slot }
unknown_slot = must be G1, G2 or G3, is "{ $value }"
unknown_test = unknown test "{ $value }"; the tests are imu, torque_feedback and turntable_servo
bench_one_gyro = a { $test } test has one gyro, here are { $have }
unknown_term = unknown term "{ $value }"; the terms are bias, g_linear, g_squared and scale
no_terms = must name at least one term
unknown_phase = must be static or rate, is "{ $value }"
no_dwells = must have at least one dwell
out_of_time_order = out of time order: starts at { $start } s, { $place } at { $earlier } s
overlaps = overlaps { $place }: starts at { $start } s, that ends at { $end } s
force_not_gravity = its length is { $length } g0 in a static dwell; the { $reference } is { $gravity } g0 and { $percent } % off is accepted
static_too_fast = { $rate } arcsec/s is too fast for a static dwell (the Earth turns at 15.04); is the phase rate?
attitude_contradicts_force = contradicts the specific force: the vertical that it gives is { $angle } deg from specific_force_g0 (v_body = C(q) v_nav, nav = East-North-Up)
rates_inertial_or_table = must be inertial or table, is "{ $value }"
earth_rate_needs = the service adds the Earth's rate where site and attitude are known; missing: { $missing }
attitudes_missing = attitude in { $count } static dwells, the first { $first }
missing_member = `{ $member }` is missing
no_drift_stated = `g_pulse_per_s_g0` is missing (or `g_deg_per_h_g0`, already divided by |E|)
two_drifts_stated = give `g_pulse_per_s_g0` or `g_deg_per_h_g0`, not both
axes_stated_twice = axes are given by slot or once for a fixture, not both
missing_beside = is missing beside `{ $member }`

## Bench tests

is_no_bench_test = is not a bench test
is_bench_test = is a bench test and cannot replace a campaign

## Models

effect_without_size = { $effect } has no plausible size; those that have one are { $effects }
unknown_effect = unknown effect "{ $effect }"; the catalogue has { $effects }
no_gyros_named = must name at least one gyro
must_be = must be { $wanted }, is "{ $value }"
must_be_one_of = must be one of { $known }, is "{ $value }"
shape_for = must be { $wanted } for { $effect }
shape_not_finite = must be finite, and a time constant or period positive

## Events, baselines, silences

nothing_fixed = must state D_I, D_S or both
goes_with = goes with { $member }, which is missing
baseline_reason = must say what was done to the gyro
only_environmental = belongs to environmental_test, not to { $event }
which_test = must name the test, such as vibration or thermal cycling
test_end = must be the end of the test
end_before_begin = is before the beginning of the test
to_before_from = is before `from`
silence_matches_nothing = must name at least one of serial, imu, station, rule: all alerts at once cannot be silenced
unknown_rule = there is no rule "{ $rule }"
not_in_future = must be in the future
station_of_role = limits a token of the role { $of } alone: the role { $role } is not of one station; leave it out
until_before_since = must not be before `since`

## Hooks

expected_members = must have 1 to { $most } members, for example {"{"}"errcode": 0{"}"}
expected_pair = a member and its value, for example `errcode = 0`; given was `{ $given }`
too_many_entries = must have at most { $most } entries, has { $have }
unknown_severity = must be `warning` or `critical`
secret_is_drawn = generates a secret, so `secret` must be left out
authorization_form = must be 1 to { $most } visible ASCII characters
no_secret_drawn = cannot generate a secret, send one: { $why }
secret_prefix = must begin with { $prefix }
secret_base64 = must be base64 after { $prefix }
secret_length = must hold a key of { $least } to { $most } bytes, has { $have }
url_too_long = must have at most { $most } characters
not_a_url = is not a URL: { $why }
url_scheme = must begin with http:// or https://, not { $scheme }:
mail_scheme = must be like mailto:wei.li@lab.example
no_mail_address = is no e-mail address: { $value }
too_many_recipients = may have at most { $most } recipients
url_credentials = must not contain a user name or password, because everyone who lists hooks would read it; use `authorization`
url_fragment = must not have a fragment (#…): it is never sent
url_port_0 = must not name port 0
url_no_host = must name a host
url_no_scheme = it must begin with http:// or https://
url_port_range = its port must be 1 to 65535
url_ip_address = its IP address does not exist; an IPv6 address stands in brackets, as in http://[::1]:9093/
url_host_name = its host cannot be a name: letters, digits, hyphens and dots

## The simulator

not_a_standard_deviation = { $value } is not a standard deviation
not_zero_or_more = { $value } is not zero or more
must_not_be_zero = must not be zero
no_noise_no_detectability = without noise nothing has a detectability: give sizes instead
size_or_detectability = must have either a finite size or a positive detectability
not_positive_time = { $value } is not a positive time
acts_never = { $value } is no span of the campaign: give two shares of its time, the earlier first
beyond_last_dwell = { $dwell } is beyond the last of { $dwells } dwells
names_no_gyro = names no gyro of this campaign
unknown_geometry = "{ $value }" is neither skewed nor orthogonal
unknown_model_term = "{ $value }" is not a term of the model
scenario_test = "{ $value }" is not imu, torque_feedback or turntable_servo
scenario_slot = "{ $value }" is not a slot; the slots are G1, G2 and G3
scenario_latitude = { $value } is not between -90 and 90
has_no_direction = has no direction
not_positive_gravity = { $value } is not a positive gravity
no_positions_or_rates = has neither positions nor rates
not_positive_seconds = { $value } is not a positive number of seconds
not_a_rate = { $value } is not a rate other than zero
at_least_1 = must be at least 1

## Where in a table, before what is wrong there

at_line = line { $line }: { $fault }
at_line_key = line { $line } ({ $key }): { $fault }
at_cell = line { $line }, column { $column } ({ $name }): { $fault }
at_column = line { $line }, column { $column }: { $fault }
at_head_line = head line "# { $key }: ...": { $fault }
unknown_column = unknown column "{ $name }"
unknown_column_like = unknown column "{ $name }"; did you mean "{ $known }"?
unknown_column_with_unit = unknown column "{ $name }"; did you mean "{ $known }"? Its unit is part of its name: convert the figures to that
quote_open = a quotation mark opens here and is never closed: is the file cut off?
quote_within = text behind the closing quotation mark: write a mark within a cell twice, or close the cell before
second_column = a second column "{ $name }"
missing_columns = no column { $names }
columns_and_gyros = { $columns } columns of { $field }, but { $gyros } gyros in the head
cells_under_columns = { $cells } cells under { $columns } columns
cells_decimal_comma = { $cells } cells under { $columns } columns; is { $number } a number with a decimal comma? Write decimals with a point
empty_cell = empty
row_without_output = { $fault }: where a gyro has no output, leave the row out
row_without_value = { $fault }: where it is not known, leave every column of { $field } in this row empty
unknown_separator = the columns are separated by "{ $found }": separate them by commas, semicolons or tabs
map_names = the map names an { $fault }
map_column_missing = the map takes { $name } from a column "{ $column }", which the table does not have
map_column_shared = the map takes { $names } from one column, "{ $column }": a column can be only one of them
table_foreign = no column is one of a campaign's ({ $names } …). A log of samples or averages goes through `gyrowatch dwells`, a table of records or bench results through `gyrowatch import --map`
table_of_records = these look like columns of records or bench results ({ $names }), under a header of its own: name them in a map with [columns], and send it with `gyrowatch import --map MAP.toml FILE`
table_is_of_records = this is a table of records or bench results, no campaign: `gyrowatch import FILE` sends it, with --print it prints their documents
head_without_mark = "{ $text }" belongs to the head: begin its line with "# "
table_without_rows = the table has a header and no rows
time_not_in_format = "{ $value }" is not a time in the format { $format }
differs_from_line = differs from line { $first }, which is of the same record
serial_twice = { $serial } is in line { $first } already: one row per gyro
unknown_key = unknown key "{ $key }"; the keys are { $known }
key_twice = { $key } is given twice
key_below_header = { $key } stands below the header row: keys stand above it, and a file holds one campaign. Put another campaign into a file of its own

## Parts of other messages

site_gravity = site's gravity
standard_gravity = standard gravity (no site given)
site_missing = site
absent = absent
absent_or = absent or { $shape }
a_gyro_of_the_effect = one of the effect's gyros
whole_document = document
verbatim = { $text }

## JSON

not_json = not JSON: { $why }
value_not_json = is not JSON: { $why }
several_documents = several JSON documents, but only one is accepted here (POST /v1/import and `gyrowatch import` accept many, one per line): the second begins at { $place }
at_place = { $fault } at { $place }
line_and_column = line { $line } column { $column }
in_column = column { $column }
invalid_type = must be { $expected }, is { $found }
invalid_value = must be { $expected }, is { $found }
invalid_length = must be { $expected }, has { $have } elements
member_twice = `{ $member }` is given twice
unknown_member = unknown member `{ $member }`; the members are { $known }
no_members_here = unknown member `{ $member }`; there are no members here
unknown_value = unknown value `{ $value }`; must be one of { $known }
json_ends_early = it ends within { $within }
json_expected_value = expected a value
json_expected_ident = expected true, false or null
json_expected_colon = expected `:`
json_expected_comma_or_brace = expected `,` or `{"}"}`
json_expected_comma_or_bracket = expected `,` or `]`
json_key_not_string = a member's name must be a string
json_trailing_characters = trailing characters
json_trailing_comma = trailing comma
json_invalid_number = invalid number
json_number_out_of_range = number out of range
json_invalid_escape = invalid escape
json_escape_ends_early = the escape is incomplete
json_lone_surrogate = the escape is incomplete: the second half of a surrogate pair is missing
json_invalid_code_point = invalid Unicode code point
json_control_character = a control character in a string
json_too_deep = nested too deeply
json_value = a value
json_string = the string { $value }
json_integer = the integer { $value }
json_number = the number { $value }
json_boolean = the boolean { $value }
json_null = null
json_object = an object
json_array = an array
json_a_string = a string
json_a_number = a number
json_a_count = a whole number, not negative
json_an_integer = a whole number
json_a_boolean = a boolean
json_numbers = a list of numbers
json_three_numbers = an array of 3 numbers
json_geometry = "skewed", "orthogonal" or an object with the axes of each slot

## What a campaign does not determine

no_drift_fitted = the model has no g_linear term: no acceleration-sensitive drift was fitted
no_scale_fitted = E is neither fitted (no scale term) nor held (known_e_pulse_per_arcsec): G stays in pulse/(s g0), so there is no D_I and D_S in deg/(h g0)
parameters_undetermined = the dwells do not determine { $parameters }; { $needs }
scale_in_noise = E is not resolved from the noise: |E| is { $ratio } of its standard deviations
untold_field = E and G hold the part of a field along north, which these dwells do not tell from them; dwells that turn tell it
implausible_scale = the fitted E is impossible: { $why }
zero_scale = E is zero: it has no direction and cannot divide G
quotient_not_finite = E, G or their quotient is not a finite number
points_away = E points { $angle } deg away from its nominal input axis: reversed polarity or another slot
not_a_bench_test = not a single-gyro bench test
no_fixture_axes = the fixture's axes are not stated for { $slot }
bench_undetermined = the dwells do not determine { $parameters }: the specific force must take several directions about the input and spin axes
bench_no_scale = the scale factor is neither stated (known_e_pulse_per_arcsec) nor seen: the Earth's rate along the input axis hardly changes between dwells
bench_scale_or_squares = these positions tell the scale factor or D_II and D_SS, not both: state known_e_pulse_per_arcsec, measure at more headings, or leave g_squared out of model
bench_not_as_stated = the output answers the Earth's rate with { $found } times the stated known_e_pulse_per_arcsec: check sign and unit of the output and of that, and the latitude; without it E is fitted
not_a_table_rate = the output answers the Earth's rate with { $found } where a table rate in arcsec/s answers with 1 or -1; state known_e_pulse_per_arcsec if the output is in other units
no_servo_sign = whether the table turns with the gyro's drift or against it does not show in the Earth's rate: state known_e_pulse_per_arcsec, the input axis as a unit vector with its sign

## What was commanded against the Earth

commanded = { $likely }. Measured: { $measured }
commanded_hidden = { $likely }. Measured: { $measured }; the noise of these gyros hides it
either_of_two = either { $first }, or { $second }
either_of_three = either { $first }, or { $second }, or { $third }
commanded_wrong = unit, sign or axes of specific_force_g0 or rate_arcsec_s are wrong
force_reversed = the specific force is reversed: it must point up, away from the Earth, in a static dwell
rates_reversed = the rates are reversed: send them positive for a turn about the positive axis by the right-hand rule
latitude_reversed = the latitude has the wrong sign, in site.latitude_deg or where the rates were made: north is positive
ned_for_enu = North-East-Down is mixed with East-North-Up: attitude, specific force and rate must all be made with nav = East-North-Up
attitude_inverted = the attitude is inverted: send the quaternion with v_body = C(q) v_nav
earth_rate_left_out = the Earth's rate is left out of the rates: send inertial rates; with attitudes and a site "rates": "table" lets the service add it
rate_unit = the rates of { $dwells } are in { $unit }: send them in arcsec/s
all_dwells = all dwells
static_dwells = static dwells
rate_dwells = rate dwells
axis_reversed = the { $axis } axis of { $vectors } is reversed
axes_exchanged = the { $first } and { $second } axes of { $vectors } are exchanged
force_and_rate = specific_force_g0 and rate_arcsec_s
other_latitude = the rates are those of latitude { $degrees } deg: correct site.latitude_deg or the rates
other_earth_rate = the rates are made with an Earth that turns at { $rate } arcsec/s: use 15.041, that of a sidereal day
other_headings = the rates of static dwells are made with other headings than the attitudes: send the Earth's rate at each attitude
force_unit = the specific force is in { $unit }: send it in g0 = 9.80665 m/s^2
force_normalised = the specific force is normalised to 1: multiply it by the site's gravity in g0
force_scale = the specific force is { $ratio } times gravity: correct it, or state the gravity of the site in site.gravity_g0
measured_static_rate = |rate_arcsec_s| is { $value } arcsec/s at rest in { $share }; the Earth turns at 15.041
measured_vertical_rate = w.f/|f| is { $value } arcsec/s at rest in { $share }; Omega sin(latitude) is { $expected }
measured_turning_rate = in { $share } the table turns, but rate_arcsec_s is not along specific_force_g0 or is slower than any table ({ $value } arcsec/s)
measured_heading = rate_arcsec_s is { $value } arcsec/s from the Earth's rate at the attitude in { $share }
measured_output = the outputs are { $value } arcsec/s from the model in the root mean square
measured_senses = the outputs of { $share } show input axes up to { $value } deg from those that static dwells show
output_scale = while the table turns the outputs of { $gyros } are in another unit than at rest, or beyond their range: send the outputs of all dwells in pulse/s
measured_scale = in { $share } they answer rates { $value } times as strongly as at rest
measured_gravity = |specific_force_g0| is { $value } g0 in { $share }; gravity is { $expected } g0
measured_attitude = the vertical of the attitude is { $value } deg from specific_force_g0 in { $share }
this_dwell = this dwell
share_of_dwells = { $count } of { $of } dwells
effect_not_seen = this design cannot see { $effect }: give it a size instead
needs_directions = dwells with other directions of the specific force are needed
needs_rates = dwells with other rates are needed
needs_directions_and_rates = dwells with other directions of the specific force and other rates are needed

## A hypothesis of one's own

equation_too_long = has { $have } characters; an equation may have { $most }: part it into several hypotheses
equation_too_deep = at character { $place } brackets, functions, signs and powers lie more than { $most } deep: multiply out what is inside
equation_unexpected = at character { $place } stands "{ $found }" where { $wanted } is expected
equation_ends = ends where { $wanted } is expected
equation_value = a number, a name or an opening bracket
equation_operator = +, -, *, / or ^ (a product is written with *)
equation_closing = a closing bracket
equation_number = at character { $place } stands "{ $found }", which is no finite number
equation_function = at character { $place } stands "{ $name }", which is no function; there are { $known }
equation_name = at character { $place } stands "{ $name }", which is no quantity of a dwell; there are { $known }, coefficients that begin with k, and one parameter with a [range]
equation_coefficients = has { $have } coefficients; 1 to { $most } are possible: names that begin with k, as in k * T * w_I
equation_without_parameter = does not hold "{ $name }", for which a range is given: use it, or leave the range out
equation_units_differ = at character { $place } something in { $left } meets something in { $right }: only what has one unit can be added
equation_pure_number = at character { $place } something in { $unit } stands where a pure number must: divide it by something of that unit, as in exp(-t/tau)
equation_over_zero = at character { $place } something is divided by zero
equation_not_linear = at character { $place } a coefficient is more than a factor: put what is not linear into a parameter with a [range]
equation_free_term = at character { $place } a term has no coefficient: multiply it by one, or leave it out
equation_no_drift = comes to { $unit }, and drift is in deg/h: the coefficients would have to be in { $needed }
equation_not_finite = the equation has no finite value in dwell { $dwell }
unknown_unit = "{ $value }" is no unit; units are made of { $known }, as in deg/(h g0 K)
range_empty = runs from { $from } to { $to }: both must be finite, the second greater
range_through_zero = runs from { $from } to { $to }, through zero, where the equation has no value: give a range above zero
range_name = "{ $name }" is a quantity of a dwell, a coefficient or no name: give the parameter another name
hypothesis_sizes = plausible and typical must be positive and finite, typical from small to large and below plausible
hypothesis_id = "{ $value }" must be small letters, digits and underscores, a letter first, at most { $most }
hypothesis_id_taken = "{ $value }" is an effect of the catalogue or competes with it already: choose another id
hypothesis_words = must be a text in one line of at most { $most } characters
hypothesis_one_range = has { $have } parameters; one is possible: give the others numbers, or write a hypothesis for each
hypothesis_too_long = the file may have { $most } bytes
too_many_hypotheses = { $most } different hypotheses were asked since the program began: start it anew

## Configuration

config_unreadable = configuration cannot be read: { $why }
config_key = configuration key { $key }: { $fault }
config_at_least = must be at least { $least }, is { $value }
config_above_0 = must be above 0 and at most { $most }, is { $value }
config_between = must be between { $least } and { $most }, is { $value }
config_negative = must not be negative, is { $value }
config_above_max = must be below { $max }, which is { $most }; is { $value }
config_log_filter = "{ $value }" is no level: off, error, warn, info, debug or trace; for one module write { $value }=debug
config_unread = the environment variable { $name } is not read: keys are written GYROWATCH_SECTION__KEY, and it sets nothing
config_unread_like = the environment variable { $name } is not read and sets nothing; likely meant: { $meant }
config_http = must begin with http:// or https://, is { $value }
config_proxy = must be http://host:port, `environment`, or empty for no proxy
config_mail_server = must be smtps://user:password@host:port, or smtp://host:port?tls=required
config_mail_from = must be an address such as gyrowatch@lab.example
config_mail_authority = the certificates of the authority cannot be used: { $why }
config_of_whole_gyro = applies to the gyro as a whole: leave coefficient out
config_in_the_open = { $address } can be reached from other machines, and HTTP would carry tokens and records in the open. Set server.tls_certificate and server.tls_key, or server.plain_http = "{ $value }"
config_plain_http = must be empty or "{ $wanted }"
config_base_path = must be empty or like /gyrowatch, is "{ $value }"
config_database = must begin with sqlite:// or postgres://, is "{ $value }"; a file is sqlite://gyrowatch.db
config_secrets_key = must be 32 bytes in hexadecimal (64 digits) or base64, or empty for no key
config_from_0_below_1 = must be 0 or more and below 1, is { $value }
unknown_toml_key = unknown field `{ $key }`, expected one of { $known }
config_address = an IP address and a port, such as 127.0.0.1:8080 (this machine alone), [::1]:8080 or 0.0.0.0:8080
config_networks = networks or addresses, such as 10.0.0.0/8,192.168.1.5,fd12::/16
config_numbers = numbers, such as 5,30,120
config_instant = a date or an RFC 3339 time, such as "1950-01-01" or "1950-01-01T00:00:00Z"
config_bounds = { $bounds } is neither [low, high] nor [], which requires nothing
config_off_requirement = requirement is switched off by judging.requirements = false, or figure by figure in judging.requirement
config_off_overdue = overdue is switched off by interval_days = 0
