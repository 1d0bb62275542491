# Diagnoses of histories: why a coefficient changed over months, and what stations do.

## Causes

cause_station = station
cause_ageing = ageing
cause_step_at_event = step at an event
cause_re_mounting = step at a re-mounting
cause_temperature = temperature
cause_clocking = clocking of the spin axis
cause_wandering = wandering without a cause
cause_step = step without a recorded event

## What a cause is tied to

change_slope = a steady slope
change_slope_until = a steady slope until the repair on { $day }
change_slope_after = a steady slope since the repair on { $day }
change_slope_since = a steady slope since { $day }
change_event = { $event } on { $day }
change_events = { $events }, which no record parts
change_moved = from { $from } to { $to }
change_temperature = about { $mean } degrees Celsius
change_temperature_gaps = about { $mean } degrees Celsius; { $missing ->
    [one] one record has
   *[other] { $missing } records have
} no temperature
change_station_offset = { $station } reads differently from { $against }
change_station_drift = { $station } drifts
change_station_drift_since = { $station } drifts since { $day }
change_station_step = { $station } stepped on { $day }
change_station_between = { $station } was off from { $from } until { $until }
station_unlike = Many of its gyros were off from { $from } until { $until }, each its own way ({ $gyros } of { $of }): check its levelling and axes.
station_unlike_since = Many of its gyros are off since { $from }, each its own way ({ $gyros } of { $of }): check its levelling and axes.
station_unlike_brief = { $gyros } of { $of } gyros, each its own way
change_station_unlike = { $gyros } of { $of } gyros of { $station } were off from { $from } until { $until }, each its own way
change_station_unlike_since = { $gyros } of { $of } gyros of { $station } are off since { $from }, each its own way
change_proportion = D_O in proportion to D_S
change_instant = between { $after } and { $before }

## Why a candidate was not named

change_not_separable = not separable from what is named
change_not_significant = not significant (adjusted p { $p })
change_no_better_than_wandering = no better than a wandering coefficient (p { $p })
change_others_deny = { $own } in this gyro, { $others } +- { $sd } in { $gyros ->
    [one] another gyro
   *[other] { $gyros } other gyros
} of the station

## What is said of a coefficient

history_too_few = { $records ->
    [0] No record
    [one] One record
   *[other] { $records } records
}: not enough data to tell a change from scatter.
history_of_a_day = { $records } records within one day: too short a time to tell a change from scatter.
history_looked_at = { $looked_at } of { $records } records are looked at, spread over their time.
history_no_change = No change above the scatter of calibration.
history_explained = Explained. What is left is scatter.
history_explained_by_step = A step of unknown cause describes the change. What is left is scatter.
history_partly_explained = Partly explained. The coefficient may also change without a recorded cause.
history_unexplained = Unexplained. The coefficient changes without a recorded cause.
history_excess = What is left varies by { $sd } deg/(h g0), where the noise of calibration is { $expected }.
history_cause = { $cause }: { $detail }, { $value } +- { $sd } { $unit }
history_class = These records cannot tell it from: { $others }.
history_closure = Closes { $closure } of the change on records left out ({ $low } to { $high }).
history_outlier_newest = The newest record is of { $day }, { $deviation } from those before it, and was left out: one record cannot tell a step from a blunder.
history_outlier = The record of { $day } is { $deviation } from its neighbours and was left out.
history_wander_random_walk = It wanders by { $size } deg/(h g0) a root year.
history_wander_walk_by_record = It wanders by { $size } deg/(h g0) from record to record.
history_wander_flicker = It wanders by { $size } deg/(h g0) in all (1/f noise).
history_due = It reaches its budget on { $day } (80 %: { $early } to { $late }).
history_due_open = It reaches its budget on { $day } (80 %: from { $early }; the end is open).
history_calibrate_by = Calibrate it by { $day }: until then it is within its budget with 95 %, as long as its course stays straight.
history_calibrate_now = Calibrate it now: since { $day } it is no longer within its budget with 95 %.
history_due_past = By its course it reached its budget on { $day }.
history_due_by_trend = (The rule trend, from weekly means as measured: { $day }.)

## Stations

title_no_such_station = Unknown station
no_such_station = there is no station { $name }
