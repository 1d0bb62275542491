# What to know before relying on an accepted item.

no_attitudes = no attitude column: specific force and rate were not checked against the attitude
no_site = no site: the specific force of static dwells was checked against standard gravity; where g is less by 0.1 %, D_I and D_S are off by as much
no_line_end = line { $line }, the last, does not end with a line break: if the file was cut there, its last number is not { $value }; compare it with the station's
no_temperatures = no temperature column: effects of temperature cannot be seen
withdrawn = is stored and counts no more: it was voided or set aside, or another stands in its place

## Of a campaign's dwells and their fit

some_attitudes_missing = no attitude in { $count } of { $of } dwells ({ $dwells }): these were not checked against it, and effects of the station cannot be seen
temperatures_missing = no temperature in { $count } of { $of } dwells ({ $dwells }): it is taken from the neighbouring dwells
temperatures_mostly_missing = no temperature in { $count } of { $of } dwells ({ $dwells }): with so few, effects of temperature cannot be seen
standard_errors_missing = no standard errors in { $count } of { $of } dwells ({ $dwells }): they get what the others say of their duration and rate
and_more = { $named } and { $more } more
temperature_outlier = the temperature of /dwells/{ $dwell } is { $celsius } deg C; the campaign's median is { $median } deg C. Taken for a fault value of the sensor and left out of temperature effects
time_unit = the median dwell lasts { $median } s: are start_s and duration_s in seconds? What goes with time is off by the same factor
time_unit_of_turns = the median dwell lasts { $median } s, and none turns by more than { $turn } degrees, where whole turns are meant: are start_s and duration_s in seconds? What goes with time is off by the same factor
temperature_unit = the median temperature is { $median } deg C: is it in kelvin or in degrees Fahrenheit?
rate_not_of_attitude = rate_arcsec_s of { $off } of { $of } static dwells is not the Earth's at their attitude and the site's latitude: by { $most } arcsec/s in /dwells/{ $dwell }
dwells_contradict = the outputs of { $dwells } contradict all other dwells, by up to { $most } arcsec/s: a wrong sign, a fault value, a row in another's place? Correct them, or leave these dwells out, and send the campaign again
output_stuck = { $slot }: the output is exactly { $value } pulse/s in { $count } dwells on end, from { $first } on, though the model of the others predicts changes: was it stuck? Leave these dwells out and send the campaign again
outputs_coarse = { $slot }: the outputs come in steps of { $step } pulse/s; these alone make { $times } times the noise of a dwell, and repeats fall on the same step. Measure longer, or count finer
no_standard_errors = no standard errors: all dwells have equal weight and the residuals give the noise
no_repeats = no repeated dwells: nothing but the fit itself tells noise from what the model leaves out
product_aliased = { $product } is not fitted, and these positions do not tell it from { $coefficient }: 0.01 deg/(h g0²) of it would move { $coefficient } by { $moves } { $coefficient ->
        [D_F] deg/h
        [D_II] deg/(h g0²)
        [D_SS] deg/(h g0²)
       *[other] deg/(h g0)
    }
cubic_moves = { $cubic } moves { $coefficient } by { $moves }
cubic_aliased = terms of the third degree are not fitted. { $size } deg/(h g0³) of each would be taken for D_I and D_S, in deg/(h g0): { $moved }
drift_aliased = the positions follow time: a drift of { $drift } deg/h an hour would hide in the coefficients and move D_I by { $d_i }, D_S by { $d_s } deg/(h g0). Take the positions in random order
drift_aliased_of_gyro = { $slot }: the positions follow time: a drift of { $drift } deg/h over the campaign is too small to be seen and would move D_I by { $d_i }, D_S by { $d_s } deg/(h g0). Take the dwells in random order
d_f_in_gauge = D_F is that of D_II + D_SS = 0, which a tumble about the output axis cannot tell: 0.01 deg/(h g0²) of their sum would move D_F by { $moves } deg/h, which is in no sigma
noise_grows_with_rate = the residuals at the fastest rate are { $times } times those at rest; sigmas follow them
residuals_shared = the residuals of the gyros go together: their correlation is up to { $correlation }. They share noise, or an effect that the model leaves out
residuals_remember = residuals near in time go together (probability { $probability }), by about { $size } deg/h: noise with a memory, or an effect that the model leaves out; sigmas hold it
standard_errors_overstated = the stated standard errors are larger than the scatter of the dwells ({ $gyros }). If they are wrong, sigmas that rest on them are too large and a small gap may not be seen
overstated_times = { $slot } { $times } times
overstated_by_far = { $slot } by far
standard_errors_scatter = the stated standard errors scatter by { $percent } % about a law of duration and rate that the residuals follow better: they are estimates of few values each, and the weights are shrunk to that law
residuals_exceed_noise = { $slots }: residuals exceed the noise; the model leaves something out (see diagnose)
residuals_exceed_noise_or_law = { $slots }: residuals exceed the noise as stated. Either { $law }, or the model leaves something out (see diagnose)
effect_left_out = { $effect } is left out of the fit: { $why }
effect_left_out_of_gyro = { $slot }: { $effect } is left out of the fit: { $why }
effect_contradicted = { $slot }: these dwells contradict the model's { $effect } and tell it less well than the model did: D_I and D_S at the reference temperature are as uncertain as that. Adopt a model that holds these dwells
effect_at_reference = { $effect } is not zero at the reference temperature, and no drift of model (6) there: D_I and D_S leave that out
station_contradicted = the residuals look like a rotation ({ $part }) { $times } times as large as the station states ({ $stated } arcsec). The sigmas hold a rotation of that size
station_left_out = the stated uncertainty of { $parts } is not in the sigmas: { $why }
station_needs_scale = { $slot } has no E that is held or determined
effects_left_out = the effects of the model are left out: { $why }
held_as_in_model = it is taken as in the model, which knows it better than these dwells tell it
any_temperature = no temperature is stated, and the model knows what it does: the sigmas hold what any from -40 to 85 deg C would do. State temperature_c
any_temperature_of_record = no temperature is stated, and the IMU's model states D_I and D_S at one: the sigmas hold what any from -40 to 85 deg C would do. State temperature_c
not_restated = { $slot }: D_I and D_S stay as measured: the IMU's model knows { $effect } of another gyro, or of all gyros in common
not_told_apart = these dwells cannot tell it from the other terms
north_part_not_told = only its part along north, which these dwells cannot tell from E and G
latitude_sign = D_I of every gyro is near { $shift } deg/(h g0), which a wrong sign of the latitude makes: is the station north (+) or south (-) of the equator?
gravity_off = |specific_force_g0| of static dwells is { $percent } % off the site's gravity (- is less): D_I and D_S are off by as much the other way, up to { $moves } deg/(h g0) ({ $slot })
latitude_off = rate_arcsec_s of static dwells is that of latitude { $degrees } deg, and the site states another: where the rates are wrong, D_I is by { $moves } deg/(h g0)
held_scale = the direction of E is held, and taken as exact: { $arcsec } arcsec of it would move D_I or D_S by { $moves } deg/(h g0) ({ $slot }). State how well it is known in station_uncertainty.fixture_arcsec
held_scale_size = |E| is held, and taken as exact: { $percent } % of it would move D_I or D_S by { $moves } deg/(h g0) ({ $slot }), which is in no sigma
nominal_axis = { $slot }: the campaign does not determine E; the nominal input axis and { $scale } pulse/arcsec are used

## Of a record beside the history of its IMU and gyros

time_near_epoch = the time is near { $epoch }, where clocks that were never set begin: set aside until the time is confirmed
time_far_from_others = the time is decades from the other records of its gyros (nearest: { $nearest }): set aside until the time is confirmed
earlier_in_doubt = earlier records were set aside: their time is in doubt
others_set_aside = earlier records are decades before this one and were set aside until their times are confirmed: { $records }
record_of_day = { $record } ({ $day })
suspect = what { $station } measured at that time is suspect ({ $author }: { $reason }): set aside until somebody confirms it
same_time_set_aside = other content is set aside for the same IMU and time, and only one of them can count: { $records }
ahead_of_now = the time is { $hours } hours ahead of the service's clock: is the station's clock right?
year_in_doubt = it is long before the newest record of its gyros; in { $year } it would be the newest: is the year right?
new_serial = { $serial } is new in { $slot }, which had { $had } before
new_serial_like = { $serial } is new in { $slot }, which had { $had } before; the nearest known serial is { $nearest }
look_alike = the new { $of ->
    [imu] IMU
    [station] station
   *[serial] serial
} { $name } looks like the known { $of ->
    [imu] IMU
    [station] station
   *[serial] serial
} { $known }
serials_exchanged = serials are exchanged: { $fits }
figures_of = { $serial } has the figures of { $other }
other_unit = all gyros ({ $serials }) are off their last levels by more than { $budgets } budgets: are these the figures of another IMU, or in another unit, or is the latitude of the site or its sign wrong?
identical_figures = { $serials }: identical to record { $record } of { $at }; is it the same measurement with another time?
unit_factor = { $quantity } of { $serials } is { $times } times what it was before: is it in another unit?
unit_factor_of = { $quantity } of { $serials } is { $times } times what it was before: is it in { $unit }?
sign_reversed = { $quantity } of { $serials } is that of before with the opposite sign: is the output or the specific force reversed?
uncertainty_factor = the stated standard deviations of { $serials } are { $times } times those before: are e_sd or g_sd in another unit?
overlaps_in_time = { $serials }: test { $record } of { $at } was still, or already, under way. Is a time or a serial wrong?
another_gyro = D_I and D_S of { $serials } are both off their last levels by more than { $budgets } budgets: is it another gyro under this serial?
moved = { $serial } was in { $from_imu } { $from_slot } in its last record and is in { $to_imu } { $to_slot } now
