use super::*;
use crate::core::judge::limits::{Bounds, Limit, LimitKey, Requirement};
use crate::core::judge::{NoiseParameters, Rule};
use crate::core::mounting::Slot;
use crate::words::Language;

fn in_english(error: ConfigError) -> String {
    Language::English.words(&error.message())
}

fn with(variables: &[(&str, &str)]) -> Result<Config, ConfigError> {
    let owned = variables.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
    Config::of(&[], owned)
}

#[test]
fn the_defaults_are_sound() {
    let config = Config::defaults();
    assert_eq!(config.judging.budget, 1e-2);
    assert_eq!(config.server.listen.port(), 8080);
}

#[test]
fn the_environment_overrides_with_its_short_names_too() {
    let config = with(&[
        ("GYROWATCH_LISTEN", "127.0.0.1:9"),
        ("GYROWATCH_JUDGING__BUDGET", "0.02"),
        ("GYROWATCH_DATABASE_URL", "sqlite://x.db"),
        ("UNRELATED", "1"),
    ])
    .unwrap();
    assert_eq!(config.server.listen.port(), 9);
    assert_eq!(config.judging.budget, 0.02);
    assert_eq!(config.database.url, "sqlite://x.db");
}

#[test]
fn a_wrong_key_is_named() {
    let wrong = |variables: &[(&str, &str)]| with(variables).map_err(in_english).unwrap_err();
    let unknown = wrong(&[("GYROWATCH_SERVER__LISTEM", "127.0.0.1:9")]);
    assert!(unknown.contains("server") && unknown.contains("listem"), "{unknown}");
    let mistyped = wrong(&[("GYROWATCH_JUDGING__BUDGET", "wide")]);
    assert!(mistyped.contains("judging.budget"), "{mistyped}");
    let never = wrong(&[("GYROWATCH_JUDGING__AGREEMENT_DAYS", "0")]);
    assert!(never.contains("judging.agreement_days") && never.contains("positive"), "{never}");
    let negative = wrong(&[("GYROWATCH_JUDGING__BUDGET", "-1")]);
    assert!(negative.contains("judging.budget") && negative.contains("positive"), "{negative}");
}

#[test]
fn a_value_that_is_written_as_text_says_what_is_wanted() {
    for (key, wrong, named, wanted) in [
        ("GYROWATCH_LISTEN", "localhost:18733", "server.listen", "such as 127.0.0.1:8080"),
        ("GYROWATCH_LISTEN", "8080", "server.listen", "an IP address and a port"),
        ("GYROWATCH_PLAUSIBILITY__EARLIEST", "soon", "plausibility.earliest", "such as \"1950-01-01\""),
        ("GYROWATCH_PLAUSIBILITY__EARLIEST", "1950", "plausibility.earliest", "a date or an RFC 3339 time"),
        ("GYROWATCH_PLAUSIBILITY__EARLIEST", "1950-13-01", "plausibility.earliest", "a date or an RFC 3339 time"),
    ] {
        let error = with(&[(key, wrong)]).map_err(in_english).unwrap_err();
        assert!(error.contains(named) && error.contains(wanted) && error.contains(wrong), "{error}");
    }
}

#[test]
fn proxies_and_the_prefix_are_checked() {
    let server = |name: &str, value: &str| with(&[(name, value)]).map(|config| config.server);
    let (proxies, prefix) = ("GYROWATCH_SERVER__TRUSTED_PROXIES", "GYROWATCH_SERVER__BASE_PATH");
    let trusted = server(proxies, "127.0.0.1, fd00::/8,10.0.0.0/8").unwrap();
    assert!(trusted.trusted_proxies.len() == 3 && trusted.is_behind_proxy());
    assert_eq!(trusted.trusted_proxies[0], "127.0.0.1/32".parse().unwrap());
    assert!(!Config::defaults().server.is_behind_proxy());
    for path in ["/gyrowatch", "/a/b.c~d"] {
        assert!(server(prefix, path).unwrap().is_behind_proxy(), "{path}");
    }
    for path in ["gyrowatch", "/", "/gyrowatch/", "//evil.example", "/a/../b", "/a b", "/a\"b", "https://a.example"] {
        let error = server(prefix, path).map_err(in_english).unwrap_err();
        assert!(error.contains("server.base_path") && error.contains("like /gyrowatch"), "{error}");
    }
    for network in ["nowhere", "10.0.0.1;10.0.0.2", "10.0.0.0/33"] {
        let error = server(proxies, network).map_err(in_english).unwrap_err();
        assert!(error.contains("server.trusted_proxies") && error.contains(network), "{error}");
    }
}

#[test]
fn the_earliest_time_may_be_a_date() {
    let earliest = |text: &str| with(&[("GYROWATCH_PLAUSIBILITY__EARLIEST", text)]).unwrap().plausibility.earliest;
    assert_eq!(earliest("1970-01-01").0, 0);
    assert_eq!(earliest("1970-01-01T08:00:01+08:00").0, 1_000_000);
}

#[test]
fn the_last_matching_override_wins() {
    let text = "[[judging.overrides]]\nimu = \"IMU-1\"\nbudget = 0.03\n\
                [[judging.overrides]]\nserial = \"A\"\ncoefficient = \"D_S\"\nbudget = 0.04\n";
    let judging = judging_of(text).unwrap();
    let limits = judging.limits("IMU-1", "A");
    assert_eq!(said(limits.d_i.of(Rule::Step)), Some((0.03, "judging.overrides[0].budget".to_owned())));
    assert_eq!(said(limits.d_s.of(Rule::Step)), Some((0.04, "judging.overrides[1].budget".to_owned())));
    assert_eq!(said(judging.limits("IMU-2", "B").d_s.of(Rule::Step)), Some((0.01, "judging.budget".to_owned())));
}

/// A limit and the key that sets it.
fn said(limit: Option<Limit>) -> Option<(f64, String)> {
    limit.map(|limit| (limit.value, limit.from.to_string()))
}

fn value(limit: Option<Limit>) -> Option<f64> {
    limit.map(|limit| limit.value)
}

fn judging_of(text: &str) -> Result<Judging, ConfigError> {
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    std::fs::write(file.path(), text).unwrap();
    Config::load(&[file.path().to_path_buf()], []).map(|config| config.judging)
}

#[test]
fn single_rules_can_be_set_and_switched_off_for_the_fleet_and_for_one_coefficient() {
    let text = "[judging.rules]\nstep = 0.02\nshift = 0.004\noff = [\"trend\", \"closure\"]\n\
                [[judging.overrides]]\nserial = \"A\"\ncoefficient = \"D_I\"\n\
                rules = { range = 0.03, fixed_baseline = { value = 2.9, sd = 0.001 }, off = [\"step\"] }\n";
    let judging = judging_of(text).unwrap();
    let fleet = judging.limits("IMU-1", "B");
    assert_eq!(said(fleet.d_i.of(Rule::Step)), Some((0.02, "judging.rules.step".to_owned())));
    assert_eq!((value(fleet.d_i.of(Rule::Range)), fleet.d_i.trend, fleet.closure), (Some(0.01), None, None));
    assert_eq!(said(fleet.d_s.shift.map(|of| of.least)), Some((0.004, "judging.rules.shift".to_owned())));
    let gyro = judging.limits("IMU-1", "A");
    assert_eq!((gyro.d_i.of(Rule::Step), gyro.d_i.fixed_baseline.unwrap().value), (None, 2.9));
    assert_eq!(said(gyro.d_i.of(Rule::Range)), Some((0.03, "judging.overrides[0].rules.range".to_owned())));
    assert_eq!(
        (value(gyro.d_s.of(Rule::Step)), value(gyro.d_s.of(Rule::Range)), gyro.d_s.fixed_baseline),
        (Some(0.02), Some(0.01), None)
    );
}

#[test]
fn keys_of_the_rule_that_shift_has_replaced_are_read_and_do_nothing() {
    let text =
        "[judging.rules]\ncusum_records_per_false_alarm = 1000\ncusum_least_scatter = 0.001\noff = [\"cusum\"]\n";
    assert_eq!(judging_of(text).unwrap().limits("", ""), judging_of("").unwrap().limits("", ""));
}

#[test]
fn constants_of_the_fleet_are_told_from_the_defaults_by_the_day_of_their_fit() {
    let noise = |text: &str| judging_of(text).map(|judging| judging.limits("", "").noise);
    assert_eq!(noise("").unwrap(), NoiseParameters::default());
    let fitted = "[judging]\nnoise = { phi = 0.25, walk = 7.5e-4, fitted = \"2026-11-25\" }\n";
    assert_eq!(noise(fitted).unwrap(), NoiseParameters { phi: 0.25, walk: 7.5e-4, of_fleet: true });
    for (text, key) in [
        ("phi = 1.0", "judging.noise.phi"),
        ("phi = -0.1", "judging.noise.phi"),
        ("walk = -1e-9", "judging.noise.walk"),
    ] {
        let error = noise(&format!("[judging.noise]\n{text}\n")).map_err(in_english).unwrap_err();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn a_budget_for_one_gyro_is_its_closures_too() {
    let text = "[[judging.overrides]]\nserial = \"A\"\nbudget = 0.03\n";
    let closure = judging_of(text).unwrap().limits("IMU-1", "A").closure;
    assert_eq!(said(closure), Some((0.03, "judging.overrides[0].budget".to_owned())));
}

#[test]
fn what_is_required_can_be_set_by_slot_gyro_and_figure() {
    let bounds = |low, high, place, key| Some(Bounds { low, high, from: LimitKey { place, key } });
    let tables = Requirement::tables_3_and_4();
    let text = "[judging.requirement]\nall = { e_norm = [0.8, 2.0], g_z = [] }\nG2 = { g_z = [-5.0, 5.0] }\n\
                [[judging.overrides]]\nserial = \"A\"\nrequirement = { G3 = { e_x = [0.7, 0.8] } }\n";
    let judging = judging_of(&format!("[judging]\nrequirements = true\n{text}")).unwrap();
    let [first, second, third] =
        [Slot::G1, Slot::G2, Slot::G3].map(|slot| judging.requirement(true, slot, "IMU-1", "A"));
    let (of_all, of_g2) = (bounds(0.8, 2.0, None, "requirement.all"), bounds(-5.0, 5.0, None, "requirement.G2"));
    assert_eq!((first.e_norm, first.g[2], second.g[2]), (of_all, None, of_g2));
    assert_eq!((first.e, first.g[..2].to_vec()), (tables[0].e, tables[0].g[..2].to_vec()), "the rest is the tables'");
    let own = bounds(0.7, 0.8, Some(0), "requirement.G3");
    assert_eq!((third.e[0], third.e[1]), (own, tables[2].e[1]));
    assert_eq!(judging.requirement(true, Slot::G3, "IMU-1", "B").e[0], tables[2].e[0], "another gyro's");
    let own = Requirement { e: [own, None, None], ..Requirement::default() };
    assert_eq!(judging.requirement(false, Slot::G3, "IMU-1", "A"), own, "what is named holds for every geometry");
    // The tables are one unit's: by default only what is configured holds.
    let by_default = judging_of(text).unwrap();
    let of_fleet = by_default.requirement(true, Slot::G3, "IMU-1", "B");
    assert_eq!(of_fleet, Requirement { e_norm: of_all, ..Requirement::default() });
    assert_eq!(judging_of("").unwrap().requirement(true, Slot::G1, "IMU-1", "B"), Requirement::default());
}

#[test]
fn a_wrong_rule_is_named() {
    for (text, key, why) in [
        ("[judging.requirement]\nG1 = { e_x = [1.0] }\n", "judging.requirement.G1.e_x", "neither [low, high] nor []"),
        ("[judging.requirement]\nG1 = { e_x = [2.0, 1.0] }\n", "judging.requirement.G1.e_x", "neither"),
        ("[judging.requirement]\nG4 = {}\n", "judging.requirement", "G4"),
        (
            "[[judging.overrides]]\ncoefficient = \"D_I\"\nrequirement = { all = { e_x = [] } }\n",
            "judging.overrides[0].requirement",
            "leave coefficient out",
        ),
        ("[judging.rules]\nstep = -1\n", "judging.rules.step", "positive"),
        ("[judging.rules]\noff = [\"tren\"]\n", "judging.rules.off", "no rule \"tren\""),
        ("[judging.rules]\noff = [\"overdue\"]\n", "judging.rules.off", "interval_days = 0"),
        ("[judging.rules]\nstpe = 1\n", "judging.rules", "stpe"),
        ("[judging.rules]\nstpe = 1\n", "judging.rules", "expected one of `step`, `range`"),
        ("[judging.rules]\ntrend_confidence = 95\n", "judging.rules.trend_confidence", "between 0.5 and 1"),
        ("[[judging.overrides]]\nrules = { trend = 0 }\n", "judging.overrides[0].rules.trend", "positive"),
        (
            "[[judging.overrides]]\ncoefficient = \"D_I\"\nrules = { closure = 1 }\n",
            "judging.overrides[0].rules.closure",
            "leave coefficient out",
        ),
        (
            "[[judging.overrides]]\nrules = { fixed_baseline = { value = 1.0, sd = -1 } }\n",
            "judging.overrides[0].rules.fixed_baseline.sd",
            "negative",
        ),
    ] {
        let error = judging_of(text).map_err(in_english).unwrap_err();
        assert!(error.contains(key) && error.contains(why), "{error}");
    }
}

#[test]
fn hooks_go_to_loopback_only_beside_a_service_that_listens_there_alone() {
    let reaches = |listen: &str, host: &str| {
        let policy = with(&[("GYROWATCH_LISTEN", listen)]).unwrap().target_policy();
        policy.check_url(&format!("http://{host}:9/")).is_ok()
    };
    for host in ["127.0.0.1", "0x7f.1", "[::1]", "[::ffff:127.0.0.1]"] {
        assert!(reaches("127.0.0.1:0", host) && reaches("[::1]:0", host), "{host}");
        assert!(!reaches("0.0.0.0:0", host) && !reaches("192.168.1.5:0", host) && !reaches("[::]:0", host), "{host}");
    }
    let allow = ("GYROWATCH_HOOKS__ALLOW", "10.0.0.0/8, 127.0.0.0/8");
    let policy = with(&[("GYROWATCH_LISTEN", "0.0.0.0:0"), allow]).unwrap().target_policy();
    assert!(policy.check_url("http://127.0.0.1/").is_ok() && policy.check_url("http://192.168.1.5/").is_err());
}

#[test]
fn a_hook_key_that_cannot_be_is_named() {
    for (key, value, named) in [
        ("ALLOW", "10.0.0.0/33", "hooks.allow"),
        ("ATTEMPT_TIMEOUT_S", "16", "hooks.attempt_timeout_s"),
        ("ATTEMPT_TIMEOUT_S", "0", "hooks.attempt_timeout_s"),
        ("CONNECT_TIMEOUT_S", "15.5", "hooks.connect_timeout_s"),
        ("ATTEMPTS_AT_ONCE", "0", "hooks.attempts_at_once"),
        ("RETRY_WAITS_S", "5,-1", "hooks.retry_waits_s[1]"),
        ("RETRY_WAITS_S", "", "hooks.retry_waits_s"),
        ("RETRY_WAITS_S", "90000", "hooks.retry_waits_s[0]"),
        ("RESEND_S", "NaN", "hooks.resend_s"),
        ("OLD_SECRET_HOURS", "-1", "hooks.old_secret_hours"),
        ("EXTERNAL_URL", "gyros.example", "hooks.external_url"),
    ] {
        let error = with(&[(&format!("GYROWATCH_HOOKS__{key}"), value)]).map_err(in_english).unwrap_err();
        assert!(error.contains(named), "{key}={value}: {error}");
    }
    let retry_schedule = Config::defaults().hooks.retry_schedule();
    assert_eq!(retry_schedule, crate::alert::retry_schedule::RetrySchedule::default(), "the default is the standard's");
}

#[test]
fn no_password_is_printed_wherever_it_stands() {
    let set = [
        ("GYROWATCH_DATABASE_URL", "postgres://g@one:5432,two:5433/g?password=hunter2"),
        ("GYROWATCH_HOOKS__SMTP_URL", "smtps://lab:hunter2@mail.example:465"),
        ("GYROWATCH_HOOKS__MAIL_FROM", "gyrowatch@lab.example"),
        ("GYROWATCH_HOOKS__PROXY", "http://lab:hunter2@proxy.example:3128"),
        ("GYROWATCH_HOOKS__EXTERNAL_URL", "https://lab:hunter2@gyros.example"),
    ];
    let printed = Config::in_force(&[], set.map(|(name, value)| (name.to_owned(), value.to_owned()))).unwrap();
    assert!(!printed.contains("hunter2"), "{printed}");
    for shown in ["two:5433/g?password=hidden", "lab:hidden@mail.example", "lab:hidden@proxy.example"] {
        assert!(printed.contains(shown), "{shown} in {printed}");
    }
}

#[test]
fn what_cannot_be_is_refused_and_named() {
    for (text, key, why) in [
        (
            "[plausibility]\nmin_scale_factor = 10\nmax_scale_factor = 1\n",
            "plausibility.min_scale_factor",
            "max_scale_factor",
        ),
        ("[plausibility]\nmax_future_hours = -1\n", "plausibility.max_future_hours", "negative"),
        ("[server]\nshutdown_grace_s = -1\n", "server.shutdown_grace_s", "negative"),
        ("[judging]\ninterval_days = -3\n", "judging.interval_days", "negative"),
        ("[[judging.overrides]]\ninterval_days = -3\n", "judging.overrides[0].interval_days", "negative"),
        ("[judging.noise]\nfitted = \"2026-13-41\"\n", "judging.noise.fitted", "calendar"),
        ("[log]\nfilter = \"loud\"\n", "log.filter", "\"loud\""),
    ] {
        let error = judging_of(text).map_err(in_english).unwrap_err();
        assert!(error.contains(key) && error.contains(why), "{error}");
    }
}
