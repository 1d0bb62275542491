# Diagnoses of campaigns.

## Why a campaign cannot be diagnosed

no_degrees_of_freedom = { $dwells } dwells leave nothing over the { $parameters } parameters of the model: nothing can be held against it
output_is_constant = the output of { $slot } is the same in every dwell
model_without_terms = the model holds no terms

## What a campaign lacks for an effect

dwells_without_temperature = the dwells carry no temperature
temperature_is_constant = the temperature is constant
dwells_without_attitude = the dwells carry no attitude
every_rate_is_zero = every commanded rate is zero

## Why a campaign cannot be held against a reference

reference_of_other_imu = the reference is of IMU { $reference }, the campaign of { $campaign }
reference_of_other_geometry = the reference has another geometry than the campaign
reference_without_gyro = the reference holds no gyro in { $slot }, where the campaign has { $serial }
reference_of_other_gyro = the reference has gyro { $reference } in { $slot }, the campaign { $campaign }
no_reference_for_bench_test = a bench test of one gyro is compared with no reference
reference_determines_nothing = the reference determines no parameter of the model in use
