use super::*;

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
    let wrong = |variables: &[(&str, &str)]| with(variables).unwrap_err().to_string();
    let unknown = wrong(&[("GYROWATCH_SERVER__LISTEM", "127.0.0.1:9")]);
    assert!(unknown.contains("server") && unknown.contains("listem"), "{unknown}");
    let mistyped = wrong(&[("GYROWATCH_JUDGING__BUDGET", "wide")]);
    assert!(mistyped.contains("judging.budget"), "{mistyped}");
    let negative = wrong(&[("GYROWATCH_JUDGING__BUDGET", "-1")]);
    assert!(negative.contains("judging.budget") && negative.contains("positive"), "{negative}");
}

#[test]
fn the_last_matching_override_wins() {
    let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
    let text = "[[judging.overrides]]\nimu = \"IMU-1\"\nbudget = 0.03\n\
                [[judging.overrides]]\nserial = \"A\"\ncoefficient = \"D_S\"\nbudget = 0.04\n";
    std::fs::write(file.path(), text).unwrap();
    let judging = Config::load(&[file.path().to_path_buf()], []).unwrap().judging;
    let limits = judging.limits("IMU-1", "A");
    assert_eq!((limits.d_i.step, limits.d_s.step), (Some(0.03), Some(0.04)));
    assert_eq!(judging.limits("IMU-2", "B").d_s.step, Some(0.01));
}
