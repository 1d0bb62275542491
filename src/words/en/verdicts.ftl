# Why a verdict is what it is: what the rule saw, then the limit, then how certain it is.

# Within the limit: short, without figures.
in_tolerance = In tolerance.
no_trend = No trend.
no_trend_but_step = No trend: a step fits better.

# Not enough data.
too_few = { $name }: not enough data for { $rule }. It needs { $need } { $of ->
    [results] results
    [weeks] weeks with records
   *[records] records
} and has { $have }.
too_few_within = { $name }: not enough data for { $rule }. It needs { $need } results within { $days } days and has { $have }.
too_few_since_moved = { $name }: the gyro was moved to another IMU or slot before { $since }. Its level there needs { $need } records and has { $have }.

# What each rule saw.
step = { $name } is { $value } { $side ->
    [below] below
   *[above] above
} the records before (median { $level }).
range = { $name } spans { $value } over { $records } records since { $since }: { $lowest } on { $lowest_at } and { $highest } on { $highest_at }.
baseline = { $name } is { $value } { $side ->
    [below] below
   *[above] above
} its baseline { $level } ({ $origin }).
level_from = median of three records from { $since }
level_fixed = fixed
closure = { $name } is { $value } { $side ->
    [below] below
   *[above] above
} its baseline { $level } ({ $origin }).
closure_moved = That level began when the gyro was moved to another IMU or slot.
closure_turn = A turn of { $turn } arcmin about the input axis does the same.
closure_cause = Likely the mounting or an output-axis term, not D_I or D_S.
trend = { $name } drifts by { $rate } a year ({ $cells } weekly means from { $since } to { $until }).
trend_passed = It has passed its budget.
trend_reaches = It reaches its budget about { $at } (95 %: { $first } to { $last }).
never = never
trend_ahead = Its deviation from the baseline is { $deviation } and will be { $value } after { $days } days.
trend_provisional = Dates are provisional: the course is younger than 24 weekly means.
trend_default_noise = The noise constants are defaults, not the fleet's.
shift = { $name }: the newest three weekly means, since { $since }, are { $value } { $side ->
    [below] below
   *[above] above
} the level { $level } of the { $before } before.
rms_successive = { $name }: the rms of successive differences since { $since } is { $value }, without the most deviating record.
rms_explained = Stated standard deviations explain { $explained }.
before_after = { $name } is { $value } { $side ->
    [below] below
   *[above] above
} its last record before the environmental test ({ $level } on { $at }). The test took from { $from } to { $until }.
station_shift = The median { $name } of { $gyros } gyros of { $imus } IMUs is { $value } { $side ->
    [below] below
   *[above] above
} their baselines ({ $since } to { $until }). It is the station, or what these gyros share.
batch_shift = The median { $name } of { $gyros } gyros of { $imus } IMUs of the batch is { $value } { $side ->
    [below] below
   *[above] above
} their baselines ({ $since } to { $until }).
batch_beside_others = Other gyros calibrated within { $days } days are less than half as far off by their median.
imu_shift = All { $gyros } gyros of the IMU have moved at once from their baselines in { $name }, by { $value } or more. It is the IMU, its mounting or that calibration, rather than one gyro.
forecast = { $slot } is furthest from the forecast of the adopted model, by an rms of { $value } (p { $p } over all gyros).
forecast_dwell = Dwell { $dwell } is furthest, by { $z } standard deviations.
between_stations = { $sd } of its standard deviation is the reproducibility of stations.
whole_budget = The shift is beyond the whole budget.
agreement = { $name } spans { $value } over { $results } results: { $lowest } and { $highest }.
result_of_method = { $value } ({ $method } on { $at })
requirement = { $figure } = { $value } is { $place ->
    [inside] inside
   *[outside] outside
} { $low } to { $high }.
requirement_others = Also outside: { $figures }.
overdue = Last calibrated on { $last }, { $days } days ago.

# The limit.
limit_is = Limit { $limit } ({ $from }).
limit_exceeded = Limit { $limit } ({ $from }): { $percent } %.
limit_of_three_sd = Limit { $limit } (three standard deviations; at least { $least }, by { $from }).
limits_from = Limits from { $from }.

limit_of_forecast = Limit { $limit }: chance exceeds it in { $percent } % of campaigns.

# How certain it is.
forecast_unseen = It says nothing: the model has not seen { $what }.
forecast_beyond_plausible = The model has not seen { $what }, but no effect of plausible size reaches that far beyond what it has.
forecast_wide = It says nothing: only a step of D_I and D_S of { $step } or more is sure to show.
forecast_says_nothing = It says nothing: no step of D_I and D_S would show.
forecast_of_one_campaign = The model is of one campaign: what usually changes between campaigns may be all of it.
unseen_temperature_outside_model = such temperatures
unseen_rate_outside_model = such rates
unseen_attitudes_outside_model = such attitudes
unseen_campaign_before_model = what was before it
unseen_effect_not_foretold = what one of its effects needs
unseen_effect_of_other_station = this station
second_campaign = Confirmed by a second campaign.
second_campaign_of_one = A second campaign has confirmed it of one of them.
not_a_single_result = Not due to a single result.
too_uncertain = Too uncertain to judge: standard deviation { $sd } against a limit of { $limit }.
too_uncertain_for_shift = Too uncertain to judge: three standard deviations are more than the budget.
probability_beyond = P(out of tolerance) { $percent } %.
no_standard_deviation = No standard deviation is known: compared as it stands.
held_within = Within its limit again: the alert ends once a campaign is below { $below } ({ $percent } % of it), or after { $campaigns } campaigns within.
held_requirement = Within again: the alert ends after { $campaigns } campaigns within.
held_undecided = No longer certain: the alert ends once a campaign is within its limit.

# Of a stored verdict.
decided_before = As it was decided when the record was judged; the limits or the history have changed since.
does_not_count = It does not count any more: the record was voided or revised.
does_not_count_yet = It does not count: the record is set aside until somebody confirms it.

# The rules.
rule_step = step
rule_range = range
rule_baseline = distance from baseline
rule_trend = trend
rule_cusum = cumulative sum
rule_rms_successive = scatter
rule_closure = closure
rule_agreement = agreement of methods
rule_requirement = requirement
rule_overdue = overdue
rule_shift = shift of level
rule_before_after = before and after a test
rule_station_shift = shift of a station
rule_forecast = forecast
rule_imu_shift = shift of an IMU
rule_batch_shift = shift of a batch

# A line of a hook.
alert_fires = { $serial }: { $coefficient } { $rule } fires ({ $severity })
mail_test = Test of the hook { $hook }: nothing is wrong
alert_is_resolved = { $serial }: { $coefficient } { $rule } is resolved

# The figure that leads a line.
share_of_limit = { $percent } % of the limit
in_days = in { $days } days

# What the verdicts suggest. A person decides.
suggestion_release = Release: in tolerance by every rule that could judge.
suggestion_more_records = Calibrate again: there are too few records to judge by, or no baseline yet.
suggestion_check_record = Check the newest record first, and revise or void it where it is wrong: a name may be misspelt, or its figures may be another gyro's or in another unit.
suggestion_check_station = Check the station first: what changed is put down to it, and other gyros that it measures changed with it.
suggestion_calibrate = Calibrate: its interval is over.
suggestion_lower_uncertainty = Calibrate again with a smaller uncertainty: nothing can be decided with this one.
suggestion_find_cause = Find why it changes: the gyro scatters by more than its records are uncertain, and a smaller uncertainty decides nothing.
suggestion_retest = Re-test: one more campaign decides.
suggestion_shorten_interval = Calibrate sooner: it may reach its budget before its next calibration.
suggestion_calibrate_now = Calibrate now: by its course it is no longer within its budget with 95 %.
suggestion_watch = Keep watching: it drifts within its budget.
suggestion_check_mounting = Check the mounting: only D_O is out of tolerance. Note a re-installation if there was one; otherwise re-test.
suggestion_remove = Take it out: it has no steady level.
suggestion_remove_or_accept = Take it out. If it has stepped once and is steady since, its new level may be accepted: start a baseline with a reason.
suggestion_accept_or_remove = Accept the new level (start a baseline with a reason), or take it out: a recorded event explains the change.
