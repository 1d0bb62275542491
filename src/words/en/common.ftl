# What several areas say. Codes are snake_case and the same as in answers; a code never changes its meaning.

beside = { $first } and { $second }

# A figure in its unit.
measured = { $value } { $unit }
measured_with_sd = { $value } +- { $sd } { $unit }
unit_drift = deg/(h g0)
unit_drift_a_year = deg/(h g0) a year
unit_drift_a_kelvin = deg/(h g0)/K
unit_days = days
unit_standard_deviations = standard deviations
unit_pulse_per_arcsec = pulse/arcsec
unit_pulse_per_second = pulse/(s g0)

# How a gyro stands.
status_in_tolerance = in tolerance
status_not_enough_data = not enough data
status_too_uncertain = too uncertain
status_borderline = borderline
status_overdue = overdue
status_drifting = drifting
status_unconfirmed = unconfirmed
status_out_of_tolerance = out of tolerance
status_confirmed = confirmed

severity_warning = warning
severity_critical = critical

# What is done to a gyro.
event_baseline = new baseline
event_repair = repair
event_reinstallation = re-installation
event_transport = transport
event_firmware = firmware
event_note = note
event_environmental_test = environmental test
event_retired = retired
event_in_storage = in storage
event_decision_release = decision: release
event_decision_retest = decision: re-test
event_decision_remove = decision: take out
event_decision_withdrawn = decision: the last one is withdrawn

# How a figure was found.
method_rigid = rigid
method_published = published, eqs. (8)-(13)
method_separation = separation
method_torque_feedback = torque feedback
method_turntable_servo = turntable servo
