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
