# Diagnoses of campaigns.

## Why a campaign cannot be diagnosed

too_many_dwells = { $dwells } dwells are more than a diagnosis takes, { $most } of so many gyros: average repeats, or diagnose a part
no_degrees_of_freedom = { $dwells ->
    [one] one dwell leaves
   *[other] { $dwells } dwells leave
} nothing over the { $parameters } parameters of the model: nothing can be held against it
output_is_constant = the output of { $slot } is the same in every dwell
model_without_terms = the model holds no terms

## What a campaign lacks for an effect

dwells_without_temperature = the dwells carry no temperature, or fewer than half of them do
temperature_is_constant = the temperature is constant
dwells_without_attitude = the dwells carry no attitude
every_rate_is_zero = every commanded rate is zero

## Effects and competing hypotheses

effect_axial_compliance = compliance along the gyro's axes (D_II, D_SS)
effect_cross_compliance = cross-axis compliance
effect_cubic_g = drift with the cube of specific force
effect_output_axis_g = drift with specific force along O
effect_mount_clocking = the gyro is turned about its input axis
effect_hysteresis = hysteresis (previous attitude)
effect_g_linear = drift linear in specific force
effect_g_squared = drift with the square of specific force
effect_scale = scale factor and misalignment
effect_levelling = the table is not level
effect_azimuth = azimuth error of the table
effect_magnetic = sensitivity to the magnetic field
effect_relevelling = table levelled anew during the campaign
effect_reseating = IMU reseated in its fixture
effect_warmup = warm-up after power-up
effect_time_ramp = bias drifts with time
effect_bias_step = bias jumps once
effect_outlier_dwell = outlier dwell
effect_periodic = a periodic disturbance
effect_scale_asymmetry = scale factor differs with the sign of rate
effect_scale_quadratic = scale factor changes with rate
effect_scale_cubic = scale factor changes with the square of rate
effect_anisoinertia = unequal moments of inertia
effect_g_rate_coupling = product of specific force and rate
effect_temperature_bias = bias changes with temperature
effect_temperature_g = g-sensitivity changes with temperature
effect_temperature_scale = scale factor changes with temperature
effect_curve_in_time = a smooth course in time
effect_wander_in_time = a random walk in time
effect_correlated_in_time = noise that neighbouring dwells share
effect_bend_in_time = a bend in time
effect_burst = a passing disturbance of several dwells
effect_drifting_mass_unbalance = g-sensitivity that changes with time
effect_drifting_scale = a scale factor that changes with time
effect_part_time = effect of a part of the time
effect_rate_even = an even function of rate
effect_rate_odd = an odd function of rate
effect_rate_curve = a smooth function of the rate along the input axis
effect_rate_and_force = a scale factor that depends on orientation
effect_static_to_rate = a difference between standing and turning
effect_torquer_heating = a memory of the rates before
effect_rate_before = a memory of the rate before
effect_rate_product = a product of rates
effect_bent_temperature = a bend in temperature
effect_temperature_rate = a response to the rate of change of temperature
effect_temperature_lag = a late response to temperature
effect_temperature_and_time = a response to temperature that changes with time
effect_temperature_g_squared = compliance that follows temperature
effect_orientation_harmonics = a function of orientation beyond second degree
effect_friction = a dependence on the sense of specific force
effect_heading = a dependence on the table's heading
effect_earth_rate = an error of the Earth's rate along north
effect_orientation_before = a memory of the orientation before
effect_stepping_mass_unbalance = g-sensitivity that changes once
effect_stepping_scale = a scale factor that changes once
effect_lagging_sensitivity = a scale factor or g-sensitivity that follows temperature late
effect_settling_after_rate = settling after the table has turned
effect_table_rate = a wrong rate of the table, in one sense or at one rate
effect_lever_arm = a lever arm: the IMU sits off the table's axis
effect_drifting_table = a tilt or azimuth of the table that changes
effect_misalignment = a table that is neither level nor turned to the north

## What a campaign must hold for an effect to show

needed_for_axial_compliance = gyros skewed in the body, and dwells with specific force off the body axes
needed_for_cross_compliance = dwells with specific force off the body axes (edges at 45 deg, tilts of 30 and 60 deg)
needed_for_cubic_g = dwells with specific force off the body axes
needed_for_output_axis_g = the closure of G over a history in which D_S changes; dwell residuals never show it
needed_for_mount_clocking = the closure of G over a history in which D_S changes; dwell residuals never show it
needed_for_hysteresis = an order of dwells in which the orientation before differs for one and the same orientation
needed_for_g_linear = at least three independent directions of specific force
needed_for_g_squared = specific force along at least three axes; at 1 g one combination is the bias
needed_for_scale = rates about three axes
needed_for_levelling = attitudes, with several azimuths a face
needed_for_azimuth = attitudes, with several azimuths a face
needed_for_magnetic = attitudes and rate dwells: without them it is Earth rate
needed_for_relevelling = attitudes, with dwells of several azimuths before and after
needed_for_reseating = static and rate dwells, or dwells of several faces before and after
needed_for_warmup = dwells early after power-up, several within tau
needed_for_time_ramp = an order of dwells that specific force, rate and temperature do not follow
needed_for_bias_step = several dwells on either side
needed_for_outlier_dwell = enough dwells that one is not needed for the fit
needed_for_periodic = periods longer than two intervals between dwells and shorter than the campaign
needed_for_scale_asymmetry = rotation in both senses
needed_for_scale_quadratic = four or more rates in both senses
needed_for_scale_cubic = four or more rates in both senses
needed_for_anisoinertia = rates about axes that have components along both I and S
needed_for_g_rate_coupling = each rate axis with its up-direction both ways
needed_for_temperature_bias = a temperature column whose course differs from time's
needed_for_temperature_g = a temperature column that varies within each orientation family
needed_for_temperature_scale = a temperature column and rate dwells
needed_for_ones_own = dwells in which its equation differs from what the model holds

## Signs that more remains

sign_lack_of_fit = the fit leaves more than repeats scatter
sign_spread = residuals spread wider than the noise
sign_neighbours_in_time = successive dwells err alike
sign_runs_in_time = dwells of one stretch of time err alike
sign_same_specific_force = dwells of one specific force err alike
sign_neighbouring_orientations = dwells of neighbouring orientations err alike
sign_similar_rates = dwells of similar rates err alike
sign_same_orientation_before = dwells after one and the same orientation err alike
sign_similar_temperatures = dwells of similar temperatures err alike
sign_harmonics = a named sinusoid has harmonics
sign_dwell_beside_structure = a dwell stands out beside other structure
sign_several_bad_dwells = more than one dwell stands out
sign_one_shape_is_not_enough = one entry would be needed twice, with two instants or periods
sign_wandering_in_time = a course in time, or two, that a wandering one replaces nearly as well
sign_noise_with_memory = the noise has a memory: its bias wanders from dwell to dwell
sign_not_constant = a named effect is not the same throughout the campaign
sign_commands_rounded = what is named may be the rounding of what was commanded
sign_goes_with_a_variable = the residuals go with a variable
sign_many_causes_at_once = more names than a gap that is explained would need
sign_tests_together = no test alone, but all of them together

## Why a candidate was not taken

design_does_not_show_it = the design does not show it
one_class_with = this campaign cannot tell it from { $effect }, which stands for both
beyond_plausible_size = its size would be beyond what is plausible
not_significant = not significant (adjusted p { $p }; needs < { $level })
closes_nothing_held_out = it closes nothing of dwells that were held out
several_outlier_dwells = several dwells stand out, each by itself: that is not one outlier dwell
not_with_noise_growth_open = it did not hold with the growth of the noise with rate left open
not_in_joint_fit = it did not hold with everything fitted together
not_in_joint_fit_beside = beside { $effect } it did not hold with everything fitted together
too_many_causes = { $count } causes are in the model already: what needs more has not been understood
too_small_beside = beside { $effect } it is so small that it may be a part of that which the fit leaves: mend that first, then diagnose again
explains_less_than = it explains the same dwells as { $effect } less well, and nothing more
explained_outside_catalogue = outside the catalogue, { $effect } explains the same dwells better

## Why an effect cannot be identified

hard_to_tell_from_g_linear = g_linear takes { $share } % of its power in these dwells (principal angle { $angle } deg). What is just too small to be seen of it shifts D_I and D_S by up to { $sds } of their standard deviations
seen_in_closure_of_g_only = D_O a_O is part of G; it shows in the closure of G only
temperature_too_steady = temperatures span { $span } K: below { $least } { $unit } it is more often missed than named, and gyros have up to { $most }
absorbed_by_model = the model in use absorbs it in every dwell of this campaign
mostly_absorbed_by_model = the model in use absorbs all but { $share } of its power in every dwell of this campaign

## Notes of a diagnosis

noise_from_repeats_and_residuals = no standard errors are stated: the noise is taken from repeats and residuals
commands_rounded = { $of ->
    [force] specific force is given in steps of { $step } g0: rounding alone makes { $times } times the noise of a dwell in { $slot }. Write more digits
    [sent] rates are given in steps of { $step } arcsec/s, which alone would make { $times } times the noise of a dwell in { $slot }: the exact Earth rate of the site is used instead. Write more digits
   *[rate] rates are given in steps of { $step } arcsec/s: rounding alone makes { $times } times the noise of a dwell in { $slot }. Write more digits
}
no_pure_error = no dwell repeats another: there is no pure error to check the noise against
described_by = what is left goes with { $variable }; that is a description, no cause
described_by_two = what is left goes with { $first } or { $second }; that is a description, no cause
variable_time = time
variable_temperature = temperature
variable_rate_of_temperature = the rate of temperature
variable_up_direction = the direction that is up
variable_heading = the heading
variable_rate_level = the size of the rate
variable_rate_axis = the axis and sense of the rate
variable_rate_history = the rates before
variable_previous_orientation = the orientation before
variable_orientation_age = how long the orientation has been held
variable_phase = rest against rotation
variable_time_and_force = time and specific force together
variable_time_and_rate = time and rate together
variable_temperature_and_force = temperature and specific force together
variable_temperature_and_rate = temperature and rate together
variable_time_and_heading = time and heading together
variable_temperature_and_heading = temperature and heading together
variable_temperature_and_time = temperature and time together
variable_single_dwells = a few dwells alone
field_direction_untold = the direction of the field ({ $effect }) is not told: its part along north is one with E and G in these dwells. D_I and D_S with it are not stated; dwells that turn tell it, or site.magnetic_field_nav
acts_in_part = { $effect } acts in a part of the campaign only: from { $from } to { $to } h
noise_shared = gyros share noise: their correlation is up to { $correlation }
noise_memory = the noise has a memory (probability { $probability }): a wander of about { $size } deg/h
noise_of_duration = the noise falls with duration to the power { $power }, which the standard errors do not say
noise_of_rate = the noise is { $bound ->
        [least] about { $times } or more
        [most] about { $times } or less
       *[other] { $times }
    } times as large at the fastest rate as at rest, which the standard errors do not say
noise_of_time = the noise is { $bound ->
        [least] about { $times } or more
        [most] about { $times } or less
       *[other] { $times }
    } times as large at the end as at the beginning, which the standard errors do not say
standard_errors_understated = { $slots }: outputs scatter { $times } times as much as the stated standard errors say, in repeated dwells too. Those are too small, or what changes from one time to the next is no noise

## Against a reference

reference_of_other_imu = the reference is of IMU { $reference }, the campaign of { $campaign }
reference_of_other_geometry = the reference has another geometry than the campaign
reference_without_gyro = the reference holds no gyro in { $slot }, where the campaign has { $serial }
reference_with_other_gyro = the reference has gyro { $reference } in { $slot }, the campaign { $campaign }
bench_test_has_no_reference = a bench test of one gyro is compared with no reference
nothing_in_common = the reference determines no parameter of the model in use
e_is_held = { $slot }: E is held in this campaign and not compared
not_determined_by_reference = { $slot }: the reference does not determine { $parameters }; fitted anew
effects_fitted_anew = the effects of the model in use are fitted anew in each campaign and not compared
reference_without_noise_of_d0 = the reference is a record: it states no noise of D0 and P
reference_taken_as_exact = the reference states no standard deviations: it is taken to be exact

## Model of an IMU and its forecast

no_campaign_to_fit = there is no campaign to fit
bench_test_has_no_model = a bench test of one gyro makes no model of an IMU
campaigns_of_other_imu = the campaigns are of IMU { $first } and of { $other }
campaigns_of_other_geometry = the campaigns have different geometries: leave one out, or correct its `geometry`
campaigns_of_other_gyro = { $slot } was { $first } and is { $other }: one model holds the same gyros throughout
campaigns_of_other_gyros = the campaigns have gyros in different slots: leave one out
campaigns_of_other_held = the campaigns hold different E of { $slot } (known_e_pulse_per_arcsec): leave one out, or fit E in both
campaigns_of_one_instant = two campaigns have the same time: leave one out, or correct its `measured_at`
model_without_noise = { $slot }: nothing gives the noise: no standard errors, no repeats, no dwells left over
nothing_to_foretell_from = no earlier campaign of the IMU has the same gyros: nothing to forecast from
model_of_other_imu = the model is of IMU { $model }, the campaign of { $campaign }
model_of_other_geometry = the model has another geometry than the campaign
bench_test_has_no_forecast = a bench test of one gyro has no forecast
model_without_gyros = no gyro of the campaign is in the model
model_is_of_imu = the coefficients are of IMU { $model }, not of { $imu }; without `identified` its terms and effects can be adopted
model_fitted_to_campaign = the model was fitted to this campaign: that is no forecast
effect_not_foretold = { $effect } is left out of the forecast: { $why }
effect_of_other_station = { $effect } is left out of the forecast: it was found at another station
effect_of_ones_own = { $words }
gyro_exchanged_since = { $slot } was { $then } and is { $now }: left out of the forecast
gyro_not_in_model = { $slot } ({ $serial }) is not in the model: left out of the forecast
temperature_outside_model = outside the model: { $least } to { $most } °C; its campaigns have { $low } to { $high } °C
rate_outside_model = outside the model: rates up to { $now } arcsec/s; its campaigns have up to { $seen }
attitudes_outside_model = outside the model: { $dwells } dwells are more than 20° from every attitude of its campaigns
campaign_before_model = the campaign is older than the model
ageing_unknown = one campaign does not say how the coefficients change from campaign to campaign: no such change is in the sd
model_found_in_other_imu = the model is of IMU { $model }; its effects are fitted to this campaign of { $campaign } anew
model_found_in_other_gyro = { $slot } was { $then } when the model was made and is { $now }: the effects are fitted to it anew
model_of_other_gyros = is no model of this IMU as its newest campaign has it: { $why }
covariance_is_no_triangle = must be a lower triangle of { $need } rows, has { $have } or rows of other lengths
covariance_is_not_positive = is no covariance: it has a negative eigenvalue
sd_is_not_of_covariance = is not the root of its place in the covariance
gyro_without_noise_or_scale = E and the noise must be larger than zero
span_is_reversed = its first value { $low } is larger than its second { $high }: give the lowest and the highest
reference_was_not_seen = is outside the temperatures of its campaigns ({ $low } to { $high } deg C): fit the model again with gyrowatch model fit
reference_without_temperatures = its campaigns have no temperatures (/identified/validity/temperature_c): leave it out
is_not_the_coefficient = does not agree with the coefficient { $name } under /identified/coefficients: fit the model again with gyrowatch model fit

## What noise is known from

noise_sem = standard errors
noise_repeats_sem = repeats and standard errors
noise_repeats_residuals_sem = repeats, residuals and standard errors
noise_residuals_sem = residuals and standard errors
noise_repeats = repeats
noise_residuals = residuals
noise_repeats_residual = repeats and residuals
noise_residual = residuals
noise_stated = stated
noise_none = none

## What a diagnosis comes to

diagnosis_no_gap = No gap: fitted to this campaign, the model leaves no more than noise.
diagnosis_explained = Explained by the causes below. The residuals are at the noise floor.
diagnosis_partly_explained = Partly explained by the causes below. Significant residuals remain.
diagnosis_unexplained = Unexplained: no effect in the catalogue accounts for the gap.
diagnosis_by_pattern = The residuals are no larger than noise alone would leave. The gap shows in their pattern over the dwells, not in their size.

## What the closure of a record says

closure_without_deviations = the record states no standard deviations of E and G: a closure counts where it exceeds the budget
closure_is_not_tested = one number a gyro closes itself: nothing can be held out, and neither reading is tested by this record
closure_of_change = { $slot } by { $change }
closure_after_change = another calibration after D_S has changed ({ $changes } deg/(h g0)): a clocked D_O moves in proportion to D_S, a true one stays; the gyro's own diagnosis asks its history for this
closure_seated_again = the gyro taken out, seated again and the IMU calibrated anew: a clocking of the seat changes with the seating, a true D_O comes back as it was
closure_on_bench = a single-gyro bench test on a fixture that takes S from the case's own reference face: it gives D_S and D_O in the gyro's own axes

## A forecast that failed

campaign_outside_forecast = Outside its forecast: { $slot } has rms(error/sd) { $rms }, p { $p } over all gyros. Something has changed that the model does not hold.
campaign_outside_forecast_changed = Outside its forecast: { $slot } has rms(error/sd) { $rms }, p { $p } over all gyros. Adopted coefficients have changed: { $effects }.
