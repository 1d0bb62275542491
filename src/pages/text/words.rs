//! The words of the pages: a field each, read once from `page_*` of `src/words`. A word that no page uses does not
//! compile; one without words fails `tests/words.rs`.

use std::sync::LazyLock;

use crate::core::message::Message;
use crate::words::Language;

macro_rules! words_of_pages {
    ($($key:ident)*) => {
        pub(in crate::pages) struct Text { language: Language, $(pub $key: &'static str),* }

        impl Text {
            pub fn language(&self) -> Language {
                self.language
            }

            fn of(language: Language) -> Self {
                let word = |code: &'static str| -> &'static str { language.words(&Message::new(code, Vec::new())).leak() };
                Self { language, $($key: word(concat!("page_", stringify!($key)))),* }
            }
        }
    };
}

static TEXTS: LazyLock<[Text; 2]> = LazyLock::new(|| Language::ALL.map(Text::of));

impl Language {
    pub(in crate::pages) fn text(self) -> &'static Text {
        &TEXTS[self as usize]
    }
}

words_of_pages! {
    // The frame of every page.
    fleet stations api book contents other_language dark light skip skip_to_first skip_to_verdicts navigation error_title error_back

    // Quantities.
    unit rate_unit serial imu station calibrated method date range meaning_d_i meaning_d_s meaning_d_o meaning_e
    meaning_g meaning_all

    // How things stand.
    status_word limit limit_within stop colon slot no_record event_test_kind event_test_to moved
    other_station method_bench

    // The fleet.
    search search_hint all_states none_found nothing_yet clear_filters days_ago violates page_of previous next printed_part gyros
    last_seen

    // One gyro.
    history plot_note since_baseline whole_history save_picture verdicts passed too_few before_after
    before_after_test_note coefficient last_before first_after difference not_compared agreement agreement_note
    not_counted one_result events no_events calibrations history_diagnosis peers_of_stations cause cause_elsewhere tied_to estimate
    change_closed ruled_out outlier about_mean line_explained line_station station_figures_note repeatability offset
    last_step repeatability_short suspect_from_here offset_against drift_a_year within_chance drift_of_gyros off_found
    step_found
    gyro_by_station reproducibility reproducibility_note older newer csv deviation value_absolute percent_of_budget
    chart_keys baseline_word no_baseline_yet baseline_forming budget_line control_line baseline_records trend_line
    condensed load records_short suggested decision record_decision withdraw_decision release_though_out decision_what records_since axis_word
    axis_deviation axis_absolute span_word last_year since_then a_year probability alert_word never_calibrated

    // Several beside one another.
    compare compare_gyros compare_chosen compare_campaigns differs differs_nowhere beyond_note same_time time_since_baseline days_since_baseline compare_note trend_a_year scale_factor_moved
    measured_at effects_found other_imus other_gyros no_common_slot

    // One calibration.
    record campaign measured received sent_by identifier operator dwells dwell diagnose verdicts_of_record
    uncounted_note not_judged separated closure_diagnosis closure_within closure_stands_out if_clocked tell_by_history tell_by_seat tell_by_bench published_by as_printed
    as_printed_note closure_rms mounting misalignment clocking parameters requirement_note not_determined pass fail
    uncertainty_budget uncertainty_note combined discrepancy fit_quality rank freedom lack_of_fit noise sem_factor noise_from not_seen fixed_by residuals_by_dwell
    residuals_note no_noise every_residual

    // Diagnoses of many campaigns.
    diagnoses diagnoses_note measured_since measured_until what_was_found campaigns_diagnosed campaigns
    coverage_no_gap coverage_explained coverage_partly_explained coverage_unexplained coverage_refused
    coverage_waiting coverage_outdated first_seen last_seen_in last_clear gyro_by_gyro findings_note or_as_well
    closed not_explained doubts_note verdict_word signs_word orders no_orders ordered which_campaigns progress
    failed_word ended order_done order_canceled order_running order_waiting cancel all_campaigns again_short
    not_diagnosed new_order new_order_note again_word start_order

    // A diagnosis.
    diagnosis diagnosis_waiting gap_word held_out_before after_effect ladder_note ladder_of_fit semicolon impact_none impact_some
    evidence_note residual_word regressor ruled_out_same ruled_out_weaker ruled_out_within model_in_use noise_floor sign_of_more
    what_parts_them no_effect adjusted_p detectability cannot_tell_from alone_cannot_tell_from
    parameter value unit_word all_gyros held_out located heat_note heat_map by_attitude place share against against_note
    none_before hold_against reference whole_gap part_parameters part_structure part_noise p_parameters now
    what_else effect closes_alone within_noise why_not impact plain with_effects shift of_budget
    how_far before_after_note cannot_be_told hardly_shown visible why would_show measure_next up_axis north_axis table_rate as_programme phase_static phase_rate
    separates notes

    // An IMU; stations.
    gyros_in_it none_in_it never_in_it gyros_before gyros_before_note seat_taken last_calibrated_in_it newest_parameters record_doubted
    records kind kind_record kind_campaign stations_note scatter

    // Import.
    import import_note choose_file or_paste preview no_document can_be_stored cannot_be_stored first_foreseen store
    store_note result line refused contradicts_line is_stored was_there of_a_log map_of_log programme_of_log
    log_needs_map of_the_log look_at_stored replace_it replace_what

    // Alerts.
    alerts alerts_note no_alerts alert_all alert_firing alert_acknowledged alert_silenced alert_resolved
    overdue_gyros alert_inhibited explained_by_another stations_alerts batches_alerts imus_alerts inhibited_by_it handling is_confirmed
    rule_word any since fired said_by until acknowledge acknowledge_title acknowledge_what unacknowledge
    unacknowledge_title unacknowledge_what unsilence unsilence_title silence silence_title silence_what silence_days silences silence_of
    silence_many silence_many_what silence_of_nothing end_silence end_silence_title end_silence_what

    // What somebody does: who, why, and that it is meant.
    actions_word who reason_word confirm_word confirmation event_time hook_secret_word must_confirm go_back
    add_event start_baseline event_what resets_nothing event_word event_at

    // What counts no more.
    void void_record void_campaign void_bench void_what voided set_aside was_set_aside was_confirmed confirm_time
    suspect_window suspect_windows trust_this_window nothing_counts suspect_what trust_window trust_what window_from window_to confirm_what revised was_voided
    was_revised stands_for replacement calibration_of bench_result bench_results

    // Hooks.
    hooks hooks_note no_hooks hook add_hook add_hook_what delete_hook delete_hook_title delete_hook_what hook_name
    hook_url hook_secret hook_secret_shown hook_authorization hook_rules hook_gyros batch gyro_type
    gyro_unit edit_attributes edit_attributes_what hook_batch hook_expect hook_set_up enabled disabled enable
    disable test_hook open_deliveries dead_letters deliveries no_deliveries message queued attempts last_attempt next_attempt
    redeliver redeliver_dead delivery_behind delivery_waiting delivery_delivered delivery_dead delivery_dropped
    answer

    // A report to print.
    report report_of_gyro report_of_imu printed_at identity records_word judged_by records_judged newest_record
    baseline_record limits_in_force set_by days confidence_word newest_of signature

    // Signing in.
    sign_in sign_out sign_in_note token takes_role role_viewer role_station role_engineer role_admin wrong_token
    too_many_tokens

    // Today, and the fleet on one scale.
    today_title counted_apart hook_told_nothing worse_since since_day show_word still_out nothing_else_out nothing_worse will_cross nothing_crosses calibrate_by calibrate_now reached_by_course dates_of_others reach_note
    never overdue_and_due nothing_due none_selected due_word due_more in_days days_word several_at_once
    nothing_together several_note stations_not_compared outside_forecast_title outside_note forecast forecasts forecasts_note
    forecast_error forecast_ladder model_6 as_foretold forecast_indeterminate outside_forecast not_foretold
    error_in_sd effects_close nothing_to_close promised foretold_by  without_effects
    effects_then_and_now in_model in_campaign changed_word yes no cannot_tell change_undecided change_beyond_seen by_the_change as_measured
    adopted_models
    adopted_models_note plain_model adopt adopt_what undo_model in_force_again undo_model_what adopted_at model_word stated_at campaigns_stated author in_force all_moved_by
    budgets_or_more wrong_file median_word share_of_budget_unit percent_sign percent_a_year of_budget_unit
    slope_or_date by_date_note days_short violates_besides reaches_budget last_in gyros_of load_note spark_note choose with_selected compare_ticked
    reports more_filters calibrated_there calibrated_last calibrated_ever calibrated_since changed_since as_list
    by_imu imus_worst_first all_of_them

    // Many alerts at once, and one by itself.
    alert alerts_of_gyro gyros_of_one_record bulk_title action_word comment undo confirm_short what_became
    what_word told_word told_yes step_fires step_escalates step_lowered step_repeats step_silent

    // The head of every page, and how the service is set up.
    find_short find_hint times_are_in setup setup_limits limits_note set_by_key layer_default layer_file layer_environment nothing_required overrides tokens tokens_note no_tokens
    name_word role_word created expires valid not_valid audit audit_note subject from_where

    // What a file would come to.
    gyro_word ends_in_tolerance text_of_file to_be_checked check_first station_unknown serial_unknown
    from_last_value last_value change_of_budget load_word first_calibration

    // The API.
    api_token schemas member meaning_word required_word request_body answers example
}
