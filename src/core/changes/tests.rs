use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::answer::Attribution;
use super::*;
use crate::core::judge::{Event, Mark, Measured};
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;

const SCATTER: f64 = 1e-3;

struct Fleet {
    rng: ChaCha8Rng,
}

impl Fleet {
    fn seeded(seed: u64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn noise(&mut self) -> f64 {
        Normal::new(0.0, SCATTER).expect("positive").sample(&mut self.rng)
    }

    /// A record a month; every third one at the second station.
    fn gyro(&mut self, records: usize) -> GyroHistory {
        let entries = (0..records)
            .map(|k| HistoryEntry {
                at: UtcMicros(k as i64 * 30 * UtcMicros::DAY),
                station: if k % 3 == 2 { "ST-2".into() } else { "ST-1".into() },
                imu: "IMU-01".into(),
                slot: Slot::G1,
                temperature_c: Some(45.0 + ((k * 7) % 5) as f64),
                d: [3.0, 4.0, 0.1].map(|level| Measured { value: level + self.noise(), sd: Some(SCATTER) }),
            })
            .collect();
        GyroHistory { entries, marks: Vec::new() }
    }
}

fn change(gyro: &mut GyroHistory, column: usize, by: impl Fn(usize, &HistoryEntry) -> f64) {
    for (k, entry) in gyro.entries.iter_mut().enumerate() {
        entry.d[column].value += by(k, entry);
    }
}

fn in_imu(gyro: &mut GyroHistory, number: usize) {
    gyro.entries.iter_mut().for_each(|entry| entry.imu = format!("IMU-{number}").into());
}

fn of(gyro: &GyroHistory, peers: &[GyroHistory], coefficient: Coefficient) -> HistoryDiagnosis {
    let all = diagnose_history(gyro, &peers.iter().collect::<Vec<_>>(), [None; 3]);
    all.into_iter().find(|d| d.coefficient == coefficient).expect("asked of every coefficient")
}

#[test]
fn a_stable_gyro_is_blamed_for_nothing() {
    let named = (0..300).filter(|&seed| {
        let gyro = Fleet::seeded(seed).gyro(24);
        !of(&gyro, &[], Coefficient::DI).causes.is_empty()
    });
    let named = named.count();
    assert!(named <= 9, "{named} of 300 stable histories were given a cause; 1 % was asked for");
}

#[test]
fn ageing_is_named_with_its_slope() {
    let mut gyro = Fleet::seeded(1).gyro(24);
    change(&mut gyro, 0, |k, _| 0.01 * k as f64 * 30.0 / 365.25);
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!(answer.causes[0].cause, ChangeCause::Ageing, "{answer:?}");
    let CauseEstimate { value, sd, .. } = &answer.causes[0].estimate;
    assert!((value - 0.01).abs() < 3.0 * sd, "{value} +- {sd}");
    assert!(*sd < 1e-3);
    assert_eq!(answer.verdict, HistoryVerdict::Explained);
    assert_eq!(of(&gyro, &[], Coefficient::DS).verdict, HistoryVerdict::NoChange);
}

#[test]
fn what_aged_before_a_repair_does_not_age_after_it() {
    let repair = UtcMicros(14 * 30 * UtcMicros::DAY - 5);
    let (mut before, mut after) = (0, 0);
    for seed in 0..40 {
        let mut gyro = Fleet::seeded(500 + seed).gyro(28);
        change(&mut gyro, 1, |k, _| if k < 14 { -0.02 * k as f64 * 30.0 / 365.25 } else { 0.004 });
        gyro.marks.push(Mark::of(repair, Event::Repair));
        let budget = DriftBudget { baseline: gyro.entries[0].d[1].value, limit: 0.01, measured_since: None };
        let answer = super::diagnose_history(&gyro, &[], [Some(budget); 3]).swap_remove(1);
        let ages =
            |tie: &Attribution| answer.causes.iter().any(|one| one.cause == ChangeCause::Ageing && one.tie == *tie);
        before += usize::from(ages(&Attribution::SlopeUntil(repair)));
        after += usize::from(ages(&Attribution::SlopeAfter(repair)) || answer.due.is_some());
    }
    assert!(before >= 36, "the slope before the repair is named in {before} of 40");
    assert!(after <= 1, "one after it in {after} of 40");
}

#[test]
fn ageing_that_begins_late_is_no_step() {
    let (mut right, mut wrong) = (0, 0);
    for seed in 0..40 {
        let mut gyro = Fleet::seeded(700 + seed).gyro(28);
        change(&mut gyro, 0, |k, _| 0.02 * (k as f64 - 17.0).max(0.0) * 30.0 / 365.25);
        let answer = of(&gyro, &[], Coefficient::DI);
        right += usize::from(
            answer.causes.iter().any(|one| one.class.contains(&ChangeCause::Ageing)) && !answer.is_one_step(),
        );
        wrong += usize::from(answer.causes.iter().any(|one| one.class == [ChangeCause::Step]));
    }
    assert!(right >= 36 && wrong <= 2, "ageing is among what is named in {right} of 40, a step alone in {wrong}");
}

#[test]
fn a_bend_that_two_slopes_fit_may_as_well_be_a_wandering_coefficient() {
    let mut twice = 0;
    for seed in 0..40 {
        let mut fleet = Fleet::seeded(4_400 + seed);
        let mut of_imu = |number: usize| {
            let mut gyro = fleet.gyro(24);
            in_imu(&mut gyro, number);
            for (k, entry) in gyro.entries.iter_mut().enumerate() {
                entry.at = UtcMicros(k as i64 * 14 * UtcMicros::DAY);
            }
            gyro
        };
        let (mut gyro, peers) = (of_imu(0), [1, 2, 3, 4, 5, 6, 7, 8].map(&mut of_imu));
        let swing = |days: f64| 0.01 * (std::f64::consts::TAU * days / 365.25 + 0.37 * seed as f64).sin();
        change(&mut gyro, 0, |k, _| swing(14.0 * k as f64));
        let budget = DriftBudget { baseline: gyro.entries[0].d[0].value, limit: 0.01, measured_since: None };
        let others: Vec<&GyroHistory> = peers.iter().collect();
        let answer = super::diagnose_history(&gyro, &others, [Some(budget); 3]).swap_remove(0);
        let slopes: Vec<&NamedCause> = answer.causes.iter().filter(|one| one.cause == ChangeCause::Ageing).collect();
        if slopes.len() > 1 {
            twice += 1;
            assert!(slopes.iter().all(|one| one.class.contains(&ChangeCause::Wandering)), "{seed}: {answer:?}");
            assert!(answer.verdict != HistoryVerdict::Explained && answer.due.is_none(), "{seed}: {answer:?}");
        }
    }
    assert!(twice >= 3, "two slopes are named in {twice} of 40");
}

#[test]
fn a_jump_at_a_transport_is_tied_to_it_and_one_without_an_event_is_only_a_step() {
    let mut gyro = Fleet::seeded(2).gyro(24);
    change(&mut gyro, 1, |k, _| if k >= 11 { 0.02 } else { 0.0 });
    let unknown = of(&gyro, &[], Coefficient::DS);
    assert!(unknown.causes[0].cause == ChangeCause::Step && unknown.is_one_step(), "{unknown:?}");
    gyro.marks.push(Mark::of(UtcMicros(11 * 30 * UtcMicros::DAY - 5), Event::Transport));
    let answer = of(&gyro, &[], Coefficient::DS);
    assert!(
        matches!(answer.causes[0].tie, Attribution::Events(ref events) if events[0].0 == Event::Transport),
        "{answer:?}"
    );
    assert!(answer.causes[0].held_out.is_some_and(|held_out| held_out.closure > 0.9), "{answer:?}");
}

#[test]
fn events_between_two_records_are_named_together_and_a_note_is_none() {
    let mut gyro = Fleet::seeded(2).gyro(24);
    change(&mut gyro, 1, |k, _| if k >= 11 { 0.02 } else { 0.0 });
    let day = |days: f64| UtcMicros(10 * 30 * UtcMicros::DAY).plus_days(days);
    let events = [(Event::Repair, day(3.0)), (Event::Transport, day(9.0))];
    gyro.marks.extend(events.map(|(event, at)| Mark::of(at, event)));
    gyro.marks.extend([5.0, 5.5, 6.0].map(|days| Mark::of(day(days), Event::Note)));
    let answer = of(&gyro, &[], Coefficient::DS);
    assert_eq!(answer.causes[0].tie, Attribution::Events(events.to_vec()), "{answer:?}");
    let said = answer.causes[0].tie.message().to_string();
    assert!(said.contains("repair") && said.contains("transport"), "{said}");
}

#[test]
fn notes_do_not_keep_a_long_history_from_being_averaged() {
    let mut gyro = Fleet::seeded(9).gyro(1000);
    let plain = of(&gyro, &[], Coefficient::DI);
    gyro.marks = gyro.entries.iter().map(|entry| Mark::of(entry.at, Event::Note)).collect();
    assert_eq!(of(&gyro, &[], Coefficient::DI), plain);
    let entries = series::distinct(&gyro.entries);
    let mut series = RecordSeries::of(&entries, 0);
    let transports: Vec<Mark> = gyro.entries.iter().map(|entry| Mark::of(entry.at, Event::Transport)).collect();
    series.condense(&transports);
    assert!(series.len() < 200, "{} rows", series.len());
}

/// Where all that a station measures is measured nowhere else, its drift and their ageing alike are one.
#[test]
fn a_station_of_gyros_that_were_never_elsewhere_is_not_told_from_gyros_that_age_alike() {
    let drift = |_: usize, k: usize| 3e-4 * k as f64;
    let mut gyros = small_fleet(95, 6, drift);
    let class = |gyros: &[GyroHistory]| {
        let answer = of(&gyros[0], &gyros[3..], Coefficient::DI);
        let [cause] = &answer.causes[..] else { panic!("{answer:?}") };
        cause.class.clone()
    };
    assert_eq!(class(&gyros), [ChangeCause::Ageing, ChangeCause::Station]);
    // One IMU that is elsewhere every other time, where it stands still.
    for gyro in &mut gyros[15..] {
        for (k, entry) in gyro.entries.iter_mut().enumerate().filter(|(k, _)| k % 2 == 0) {
            entry.station = "ST-2".into();
            entry.d[0].value -= drift(0, k);
        }
    }
    assert_eq!(class(&gyros), [ChangeCause::Station]);
    // Where it goes on alike, and the other station is re-levelled, which is no slope.
    for gyro in &mut gyros[15..] {
        for (k, entry) in gyro.entries.iter_mut().enumerate().filter(|(k, _)| k % 2 == 0) {
            entry.d[0].value += drift(0, k) - if k >= 12 { 8e-3 } else { 0.0 };
        }
    }
    assert_eq!(class(&gyros), [ChangeCause::Ageing, ChangeCause::Station]);
}

/// A station that begins to drift midway, all its gyros alike: no gyro ages, nothing steps.
#[test]
fn a_station_that_begins_to_drift_midway_drifts_since_then_for_every_gyro() {
    for seed in 0..6 {
        let gyros = small_fleet(2700 + seed, 6, |_, k| 1.3e-3 * (k as f64 - 11.0).max(0.0));
        let found = stations(&gyros).expect("there are records");
        let column = &found.stations[0].columns[0];
        let since = column.drift_since.map(|at| at.days_since(UtcMicros(0)) / 30.0);
        assert!(column.drifts && since.is_some_and(|month| (month - 11.0).abs() < 2.5), "{seed}: {column:?}");
        assert!(column.steps.is_empty() && column.windows.is_empty(), "{seed}: {column:?}");
        for imu in 0..6 {
            let (before, own) = gyros.split_at(3 * imu);
            let peers: Vec<GyroHistory> = before.iter().chain(&own[3..]).cloned().collect();
            let answer = of(&own[0], &peers, Coefficient::DI);
            let [cause] = &answer.causes[..] else { panic!("{seed}: {answer:?}") };
            let is_since = matches!(cause.tie, Attribution::Station { form: StationForm::DriftSince(_), .. });
            assert!(cause.cause == ChangeCause::Station && is_since, "{seed}: {answer:?}");
            assert_eq!(cause.class, [ChangeCause::Ageing, ChangeCause::Station], "they were never elsewhere");
        }
    }
}

/// A table that is wrongly levelled turns each gyro's figures its own way: the median stays, most are off.
#[test]
fn most_gyros_that_are_off_in_different_directions_at_once_are_the_stations() {
    let turned = |gyros: &mut [GyroHistory], days: [i64; 2], but: usize| {
        for (k, gyro) in gyros.iter_mut().enumerate().filter(|(k, _)| k % but > 0) {
            let by = 0.008 * if k % 2 == 0 { 1.0 } else { -1.0 };
            let is_in = |entry: &HistoryEntry| (days[0]..days[1]).contains(&(entry.at.0 / UtcMicros::DAY));
            change(gyro, 0, |_, entry| if is_in(entry) { by } else { 0.0 });
        }
    };
    for seed in 0..20 {
        let clean = of_one_station(2800 + seed, [0, 0]);
        assert_eq!(stations(&clean).expect("records").stations[0].unlike, [], "{seed}");
        let mut gyros = clean.clone();
        turned(&mut gyros, [400, 436], 4);
        let found = stations(&gyros).expect("records").stations.remove(0).unlike;
        let [one] = found[..] else { panic!("{seed}: {found:?}") };
        let day = |at: UtcMicros| at.0 / UtcMicros::DAY;
        assert!(
            (day(one.from) - 400).abs() <= 21 && one.until.is_some_and(|at| (day(at) - 436).abs() <= 21),
            "{one:?}"
        );
        assert!(one.gyros >= 9 && one.of == 18, "{one:?}");
        let alike = of_one_station(2800 + seed, [400, 436]);
        assert_eq!(stations(&alike).expect("records").stations[0].unlike, [], "to one side: a window");
    }
}

/// Such a gyro by itself shows a step, or a time off: the station first. A step of its own that stays when the others
/// come back is its own.
#[test]
fn a_gyro_that_is_off_with_many_others_each_its_own_way_is_its_stations_and_one_that_stays_there_is_not() {
    let [mut station, mut own, mut still] = [0; 3];
    for (seed, [from, until]) in (0..8).flat_map(|seed| [[400, 462], [640, 10_000]].map(|of| (seed, of))) {
        let mut gyros = of_one_station(2850 + seed, [0, 0]);
        for (k, gyro) in gyros.iter_mut().enumerate().filter(|(k, _)| k % 4 > 0) {
            let by = 0.008 * if k % 2 == 0 { 1.0 } else { -1.0 };
            // The last one stays where it is.
            let until = if k == 17 { 10_000 } else { until };
            let is_off = |entry: &HistoryEntry| (from..until).contains(&(entry.at.0 / UtcMicros::DAY));
            change(gyro, 0, |_, entry| if is_off(entry) { by } else { 0.0 });
        }
        let answer = |asked: usize| {
            let (before, after) = gyros.split_at(asked);
            let others: Vec<&GyroHistory> = before.iter().chain(&after[1..]).collect();
            diagnose_history(&after[0], &others, [None; 3]).swap_remove(0)
        };
        for asked in [1, 5, 10, 15] {
            let causes = answer(asked).causes;
            let is_its = |cause: &NamedCause| {
                let may_be_its_own = cause.class.iter().any(|one| *one != ChangeCause::Station);
                matches!(cause.tie, Attribution::Unlike { .. }) && may_be_its_own == (until > 1000)
            };
            station += usize::from(causes.len() == 1 && causes.iter().all(is_its));
        }
        still += usize::from(answer(4).causes.is_empty());
        own += usize::from(until > 1000 || answer(17).is_one_step());
    }
    assert!(station >= 56 && own >= 15 && still >= 15, "{station} of 64, {own} and {still} of 16");
}

/// How often the intervals of a date hold the true one, where a slope begins at a month of `onset`.
fn dates(seeds: std::ops::Range<u64>, onset: impl Fn(u64) -> f64) -> [usize; 4] {
    let [mut all, mut in_80, mut in_95, mut in_time] = [0; 4];
    for seed in seeds {
        let (onset, slope) = (onset(seed), 1.2e-3);
        let mut gyro = Fleet::seeded(seed).gyro(24);
        change(&mut gyro, 0, |k, _| slope * (k as f64 - onset).max(0.0));
        let limit = 1.5 * slope * (23.0 - onset);
        let budget = DriftBudget { baseline: 3.0, limit, measured_since: None };
        let Some(due) = diagnose_history(&gyro, &[], [Some(budget), None, None])[0].due else { continue };
        let truth = 30.0 * (limit / slope - (23.0 - onset));
        let holds = |[early, late]: [Option<f64>; 2]| {
            early.is_none_or(|early| early <= truth) && late.is_none_or(|late| truth <= late)
        };
        all += 1;
        in_80 += usize::from(holds(due.p80));
        in_95 += usize::from(holds(due.p95));
        in_time += usize::from(due.calibrate_by.is_none_or(|by| by <= truth));
    }
    [all, in_80, in_95, in_time]
}

#[test]
fn the_date_of_what_begins_to_age_late_counts_that_its_beginning_is_not_known() {
    let late = dates(8000..8200, |seed| 6.0 + (seed % 10) as f64);
    let early = dates(8200..8300, |_| 0.0);
    eprintln!("of, in 80 %, in 95 %, in time: late {late:?}, early {early:?}");
    for [all, in_80, in_95, in_time] in [late, early] {
        assert!(10 * all >= 900, "{all}");
        assert!(100 * in_80 >= 70 * all && 100 * in_80 <= 92 * all, "{in_80} of {all}");
        assert!(100 * in_95 >= 89 * all && 100 * in_time >= 89 * all, "{in_95}, {in_time} of {all}");
    }
}

#[test]
fn a_move_at_a_reinstallation_cannot_be_told_from_it() {
    let mut gyro = Fleet::seeded(3).gyro(24);
    gyro.marks.push(Mark::of(UtcMicros(10 * 30 * UtcMicros::DAY), Event::Reinstallation));
    for entry in &mut gyro.entries[10..] {
        entry.imu = "IMU-02".into();
        entry.slot = Slot::G3;
        entry.d[2].value += 0.03;
    }
    let answer = of(&gyro, &[], Coefficient::DO);
    assert_eq!(answer.causes[0].class, [ChangeCause::ReMounting, ChangeCause::StepAtEvent]);
}

#[test]
fn temperature_is_named_with_its_sensitivity() {
    let mut gyro = Fleet::seeded(4).gyro(24);
    change(&mut gyro, 0, |_, e| 0.004 * (e.temperature_c.expect("recorded") - 47.0));
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!(answer.causes[0].cause, ChangeCause::Temperature);
    let CauseEstimate { value, sd, .. } = &answer.causes[0].estimate;
    assert!((value - 0.004).abs() < 3.0 * sd && *sd < 4e-4, "{value} +- {sd}");
}

#[test]
fn what_a_station_does_to_all_is_the_stations() {
    let mut fleet = Fleet::seeded(5);
    let mut gyros: Vec<GyroHistory> = (0..8).map(|_| fleet.gyro(18)).collect();
    for (k, gyro) in gyros.iter_mut().enumerate() {
        in_imu(gyro, k);
        change(gyro, 0, |_, e| if &*e.station == "ST-2" { 0.008 } else { 0.0 });
    }
    let answer = of(&gyros[0], &gyros[1..], Coefficient::DI);
    assert_eq!(answer.causes[0].cause, ChangeCause::Station);
    assert_eq!(answer.causes[0].class, [ChangeCause::Station]);
    let CauseEstimate { value, sd, .. } = &answer.causes[0].estimate;
    assert!((value - 0.008).abs() < 3.0 * sd, "{value} +- {sd}");
}

#[test]
fn a_station_change_that_hides_a_step_is_not_the_stations_where_its_other_gyros_stand_still() {
    let mut fleet = Fleet::seeded(6);
    let mut peers: Vec<GyroHistory> = (0..8).map(|_| fleet.gyro(18)).collect();
    peers.iter_mut().enumerate().for_each(|(k, peer)| in_imu(peer, k + 1));
    let mut gyro = fleet.gyro(18);
    in_imu(&mut gyro, 0);
    for (k, entry) in gyro.entries.iter_mut().enumerate() {
        entry.station = if k >= 9 { "ST-2".into() } else { "ST-1".into() };
        entry.d[0].value += if k >= 9 { 0.015 } else { 0.0 };
    }
    let answer = of(&gyro, &peers, Coefficient::DI);
    assert_eq!(answer.causes[0].cause, ChangeCause::Step, "{answer:?}");
    let alone = of(&gyro, &[], Coefficient::DI);
    assert_eq!(
        alone.causes[0].class,
        [ChangeCause::Station, ChangeCause::Step],
        "nothing can tell them apart: {alone:?}"
    );
}

#[test]
fn a_clocked_spin_axis_moves_d_o_with_d_s() {
    let mut gyro = Fleet::seeded(7).gyro(24);
    change(&mut gyro, 1, |k, _| 0.3 * (k as f64 / 4.0).sin());
    let ds: Vec<f64> = gyro.entries.iter().map(|e| e.d[1].value).collect();
    change(&mut gyro, 2, |k, _| 0.05 * (ds[k] - 4.0));
    let answer = of(&gyro, &[], Coefficient::DO);
    assert_eq!(answer.causes[0].cause, ChangeCause::Clocking, "{answer:?}");
    let CauseEstimate { value, sd, .. } = &answer.causes[0].estimate;
    assert!((value - 0.05).abs() < 3.0 * sd, "{value} +- {sd}");
}

#[test]
fn a_wave_that_no_candidate_explains_is_not_called_explained() {
    let mut gyro = Fleet::seeded(8).gyro(36);
    change(&mut gyro, 0, |k, _| 0.01 * (k as f64 * 0.55).sin());
    let answer = of(&gyro, &[], Coefficient::DI);
    assert!(matches!(answer.verdict, HistoryVerdict::Unexplained | HistoryVerdict::PartlyExplained), "{answer:?}");
}

#[test]
fn poor_histories_get_an_answer_without_a_cause() {
    let mut fleet = Fleet::seeded(9);
    for records in 0..8 {
        let gyro = fleet.gyro(records);
        for answer in diagnose_history(&gyro, &[&gyro], [None; 3]) {
            assert!(answer.causes.is_empty() && answer.scatter.is_finite() && answer.remaining_p_value.is_finite());
        }
    }
    let mut constant = fleet.gyro(12);
    for entry in &mut constant.entries {
        entry.d = [Measured { value: 1.5, sd: None }; 3];
    }
    assert!(diagnose_history(&constant, &[], [None; 3]).iter().all(|a| a.verdict == HistoryVerdict::NoChange));
}

/// Peers of other IMUs, `imus` of three gyros each, at the gyro's own stations.
fn peers(fleet: &mut Fleet, imus: usize, records: usize) -> Vec<GyroHistory> {
    let mut all = Vec::new();
    for imu in 0..imus {
        for slot in Slot::ALL {
            let mut peer = fleet.gyro(records);
            in_imu(&mut peer, imu + 1);
            peer.entries.iter_mut().for_each(|entry| entry.slot = slot);
            all.push(peer);
        }
    }
    all
}

/// A gyro of another IMU than its [`peers`], and those.
fn gyro_and_peers(seed: u64, imus: usize, records: usize) -> (GyroHistory, Vec<GyroHistory>) {
    let mut fleet = Fleet::seeded(seed);
    let others = peers(&mut fleet, imus, records);
    let mut gyro = fleet.gyro(records);
    in_imu(&mut gyro, 0);
    (gyro, others)
}

#[test]
fn a_station_that_drifts_or_is_re_levelled_is_not_blamed_on_the_gyro() {
    let drift = |k: usize, entry: &HistoryEntry| if &*entry.station == "ST-1" { 3e-4 * k as f64 } else { 0.0 };
    let step = |k: usize, entry: &HistoryEntry| if &*entry.station == "ST-1" && k >= 12 { 6e-3 } else { 0.0 };
    let changes: [&dyn Fn(usize, &HistoryEntry) -> f64; 2] = [&drift, &step];
    for (seed, what) in (20..26).flat_map(|seed| changes.map(|change| (seed, change))) {
        let (mut gyro, mut others) = gyro_and_peers(seed, 5, 24);
        for one in others.iter_mut().chain([&mut gyro]) {
            change(one, 0, what);
        }
        let answer = of(&gyro, &others, Coefficient::DI);
        assert!(!answer.causes.is_empty(), "{seed}: {answer:?}");
        assert!(answer.causes.iter().all(|cause| cause.class == [ChangeCause::Station]), "{seed}: {answer:?}");
    }
}

/// The first gyro's answer, where two stations drift at once.
fn of_two_that_drift(seed: u64, slopes: [f64; 2], offset: f64) -> HistoryDiagnosis {
    let years = |entry: &HistoryEntry| entry.at.0 as f64 / (365.25 * UtcMicros::DAY as f64);
    let mut gyros = peers(&mut Fleet::seeded(seed), 5, 24);
    for gyro in &mut gyros {
        change(gyro, 0, |_, entry| match &*entry.station {
            "ST-2" => slopes[1] * years(entry) + offset,
            _ => slopes[0] * years(entry),
        });
    }
    of(&gyros[0], &gyros[3..], Coefficient::DI)
}

#[test]
fn slopes_of_two_stations_that_differ_besides_have_the_standard_deviations_that_they_say() {
    for (slopes, offset) in [([5e-3, -5e-3], 0.0), ([5e-3, -5e-3], 6e-3), ([4e-3, 6e-3], 6e-3)] {
        let mut pulls = [vec![], vec![]];
        for answer in (0..100).map(|seed| of_two_that_drift(6000 + seed, slopes, offset)) {
            for cause in &answer.causes {
                let Attribution::Station { form: StationForm::Drift, name, .. } = &cause.tie else { continue };
                let (k, estimate) = (usize::from(&**name == "ST-2"), &cause.estimate);
                pulls[k].push((estimate.value - slopes[k]) / estimate.sd);
            }
        }
        for pulls in pulls {
            let rms = (pulls.iter().map(|pull| pull * pull).sum::<f64>() / pulls.len() as f64).sqrt();
            assert!(pulls.len() >= 98 && (0.8..1.2).contains(&rms), "{slopes:?}, {offset}: {rms} of {}", pulls.len());
        }
    }
}

#[test]
fn two_stations_that_drift_at_once_both_drift() {
    let mut right = 0;
    for (seed, slopes) in (0..20).flat_map(|seed| [(seed, [5e-3, -5e-3]), (seed, [4e-3, 6e-3])]) {
        let answer = of_two_that_drift(4000 + seed, slopes, 0.0);
        let drifts = |cause: &NamedCause| matches!(cause.tie, Attribution::Station { form: StationForm::Drift, .. });
        right += usize::from(answer.causes.len() == 2 && answer.causes.iter().all(drifts));
    }
    assert!(right >= 38, "both drift, and nothing else is named, in {right} of 40");
}

/// Every IMU three gyros and a day of its own in every three weeks; their station reads high from one day to another.
fn of_one_station(seed: u64, [from, until]: [i64; 2]) -> Vec<GyroHistory> {
    let mut fleet = Fleet::seeded(seed);
    let mut gyros: Vec<GyroHistory> = (0..18).map(|_| fleet.gyro(34)).collect();
    for (k, gyro) in gyros.iter_mut().enumerate() {
        in_imu(gyro, k / 3);
        for (i, entry) in gyro.entries.iter_mut().enumerate() {
            let day = 21 * i as i64 + 3 * (k as i64 / 3);
            entry.at = UtcMicros(day * UtcMicros::DAY);
            entry.station = "ST-1".into();
            entry.d[0].value += if (from..until).contains(&day) { 0.004 } else { 0.0 };
        }
    }
    gyros
}

/// Its IMU was there a week before those that show the station high: that record was not.
#[test]
fn the_record_before_a_station_was_off_is_not_taken_for_one_of_it_where_the_gyro_ages() {
    let right = |seed: &u64| {
        let mut gyros = of_one_station(1900 + seed, [591, 614]);
        change(&mut gyros[0], 0, |_, entry| 0.015 * entry.at.0 as f64 / (365.25 * UtcMicros::DAY as f64));
        let own = of(&gyros[0], &gyros[1..], Coefficient::DI);
        let at = |day: i64| UtcMicros(day * UtcMicros::DAY);
        own.causes.iter().any(|cause| match cause.tie {
            Attribution::Station { form: StationForm::Between(from, until), .. } => from > at(588) && until > at(609),
            _ => false,
        })
    };
    let right = (0..20).filter(right).count();
    assert!(right >= 18, "{right} of 20");
}

/// The gyro was there last of all: what its record shows is the station's as much as what the others' do.
#[test]
fn a_station_that_is_off_up_to_now_is_so_for_the_gyro_that_was_there_last() {
    let right = |seed: &u64| {
        let gyros = of_one_station(2300 + seed, [672, 10_000]);
        let own = of(&gyros[17], &gyros[..15], Coefficient::DI);
        let lasts = |cause: &NamedCause| matches!(cause.tie, Attribution::Station { form: StationForm::Step(_), .. });
        !own.causes.is_empty() && own.causes.iter().all(lasts)
    };
    let right = (0..20).filter(right).count();
    assert!(right >= 18, "{right} of 20");
}

#[test]
fn a_station_that_was_off_for_a_fortnight_is_dated_by_the_records_within_it() {
    const HIGH: [i64; 2] = [600, 614];
    let (mut dated, mut beyond, mut blamed) = (0, 0, 0);
    for seed in 0..20 {
        let gyros = of_one_station(900 + seed, HIGH);
        let within = |at: &UtcMicros| (HIGH[0]..HIGH[1]).contains(&(at.0 / UtcMicros::DAY));
        let records = || gyros.iter().flat_map(|gyro| gyro.entries.iter().map(|entry| entry.at));
        let (first, last) = (records().filter(within).min(), records().filter(within).max());
        let after = records().filter(|at| Some(*at) > last).min();
        let column = stations(&gyros).expect("there are records").stations[0].columns[0].clone();
        let between: Vec<[Option<UtcMicros>; 2]> = column.windows.iter().map(|(at, _)| at.map(Some)).collect();
        dated += usize::from(between == [[first, after]] && column.steps.is_empty() && !column.drifts);
        beyond += column.windows.iter().filter(|(_, size)| (size.value - 0.004).abs() > 3.0 * size.sd).count();
        let own = of(&gyros[0], &gyros[1..], Coefficient::DI);
        blamed += usize::from(own.causes.iter().any(|one| one.cause != ChangeCause::Station));
    }
    assert!(dated >= 15 && beyond <= 1 && blamed <= 1, "dated {dated} of 20, beyond 3 sd {beyond}, blamed {blamed}");
}

/// Of a station that two IMUs use, one is the other's only witness.
#[test]
fn a_station_of_two_imus_that_was_off_for_months_is_not_blamed_on_either() {
    let mut right = 0;
    for seed in 0..10 {
        let gyros = of_one_station(3200 + seed, [300, 400]);
        for (own, others) in [(0, 3..6), (3, 0..3)] {
            let answer = of(&gyros[own], &gyros[others.clone()], Coefficient::DI);
            right += usize::from(matches!(&answer.causes[..], [cause] if cause.cause == ChangeCause::Station));
            // Where the other IMU's stand still it is not the station.
            let still = of_one_station(3200 + seed, [0, 0]);
            let answer = of(&gyros[own], &still[others], Coefficient::DI);
            assert!(answer.causes.iter().all(|cause| cause.cause != ChangeCause::Station), "{seed}: {answer:?}");
        }
    }
    assert!(right >= 18, "{right} of 20");
}

#[test]
fn one_peer_that_ages_does_not_make_the_station_drift() {
    let (gyro, mut others) = gyro_and_peers(30, 1, 24);
    for peer in &mut others {
        change(peer, 0, |k, _| 1e-3 * k as f64);
    }
    let answer = of(&gyro, &others, Coefficient::DI);
    assert_eq!(answer.verdict, HistoryVerdict::NoChange, "{answer:?}");
}

#[test]
fn stated_standard_deviations_weigh_the_records() {
    let mut gyro = Fleet::seeded(31).gyro(30);
    let mut noise = Fleet::seeded(32);
    for (k, entry) in gyro.entries.iter_mut().enumerate() {
        entry.d[0].value += 4e-4 * k as f64;
        if k % 3 == 2 {
            entry.d[0].value += 30.0 * noise.noise();
            entry.d[0].sd = Some(30.0 * SCATTER);
        }
    }
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!(answer.causes.first().map(|cause| cause.cause), Some(ChangeCause::Ageing), "{answer:?}");
}

#[test]
fn a_noisy_station_that_does_not_say_so_weighs_as_it_scatters() {
    let (gyro, mut all) = gyro_and_peers(311, 5, 30);
    let mut noise = Fleet::seeded(312);
    all.push(gyro);
    for one in &mut all {
        for (k, entry) in one.entries.iter_mut().enumerate() {
            for d in &mut entry.d {
                d.sd = None;
                d.value += if k % 3 == 2 { 6.0 * noise.noise() } else { 0.0 };
            }
        }
    }
    let named = |all: &[GyroHistory], k: usize| -> usize {
        let others: Vec<&GyroHistory> = all.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, one)| one).collect();
        diagnose_history(&all[k], &others, [None; 3]).iter().filter(|one| !one.causes.is_empty()).count()
    };
    let falsely: usize = (0..all.len()).map(|k| named(&all, k)).sum();
    assert!(falsely <= 1, "{falsely} causes where nothing is");
    let mut gyro = all.pop().expect("pushed");
    change(&mut gyro, 0, |k, _| 1e-4 * k as f64);
    let answer = of(&gyro, &all, Coefficient::DI);
    assert_eq!(answer.causes.first().map(|cause| cause.cause), Some(ChangeCause::Ageing), "{answer:?}");
}

#[test]
fn a_step_after_which_no_other_imu_was_there_may_be_the_stations() {
    let (mut gyro, mut others) = gyro_and_peers(313, 5, 24);
    for one in others.iter_mut().chain([&mut gyro]) {
        one.entries.iter_mut().for_each(|entry| entry.station = "ST-1".into());
    }
    change(&mut gyro, 0, |k, _| if k >= 16 { 6e-3 } else { 0.0 });
    assert_eq!(of(&gyro, &others, Coefficient::DI).causes[0].class, [ChangeCause::Step], "the others stand still");
    others.iter_mut().for_each(|one| one.entries.truncate(14));
    assert_eq!(
        of(&gyro, &others, Coefficient::DI).causes[0].class,
        [ChangeCause::Station, ChangeCause::Step],
        "nobody else was there"
    );
}

#[test]
fn records_without_a_temperature_stay_in_with_what_they_have() {
    let mut gyro = Fleet::seeded(33).gyro(24);
    change(&mut gyro, 0, |_, e| 0.002 * (e.temperature_c.expect("recorded") - 47.0));
    for k in [3, 17] {
        gyro.entries[k].temperature_c = None;
    }
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!((answer.causes[0].cause, answer.records), (ChangeCause::Temperature, 24), "{answer:?}");
    assert!(matches!(answer.causes[0].tie, Attribution::Temperature { missing: 2, .. }));
    let CauseEstimate { value, sd, .. } = &answer.causes[0].estimate;
    assert!((value - 0.002).abs() < 3.0 * sd && *sd < 4e-4, "{value} +- {sd}");
}

#[test]
fn a_coefficient_that_wanders_is_not_explained() {
    let explained = (0..100).filter(|&seed| {
        let mut fleet = Fleet::seeded(1000 + seed);
        let mut gyro = fleet.gyro(24);
        let mut walk = 0.0;
        for entry in &mut gyro.entries {
            walk += 1.5 * fleet.noise();
            entry.d[0].value += walk;
        }
        of(&gyro, &[], Coefficient::DI).verdict == HistoryVerdict::Explained
    });
    let explained = explained.count();
    assert!(explained <= 4, "{explained} of 100 random walks were explained");
}

#[test]
fn ageing_and_the_step_that_takes_it_back_are_both_named() {
    let (mut at_event, mut by_itself) = (0, 0);
    for seed in 0..40 {
        let mut gyro = Fleet::seeded(2000 + seed).gyro(26);
        change(&mut gyro, 0, |k, _| SCATTER * (0.7 * k as f64 - if k >= 13 { 10.0 } else { 0.0 }));
        let named = |gyro: &GyroHistory| {
            let mut named: Vec<_> = of(gyro, &[], Coefficient::DI).causes.iter().map(|one| one.cause).collect();
            named.sort_unstable();
            named
        };
        let mut both = [ChangeCause::Ageing, ChangeCause::Step];
        both.sort_unstable();
        by_itself += usize::from(named(&gyro) == both);
        gyro.marks.push(Mark::of(UtcMicros(13 * 30 * UtcMicros::DAY - 5), Event::Transport));
        let mut both = [ChangeCause::Ageing, ChangeCause::StepAtEvent];
        both.sort_unstable();
        at_event += usize::from(named(&gyro) == both);
    }
    assert!(at_event >= 36, "with an event {at_event} of 40");
    assert!(by_itself >= 30, "without one {by_itself} of 40");
}

#[test]
fn an_outlier_is_named_and_left_out() {
    let mut gyro = Fleet::seeded(34).gyro(24);
    gyro.entries[9].d[0].value += 0.05;
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!(answer.outliers.iter().map(|one| one.at).collect::<Vec<_>>(), [gyro.entries[9].at]);
    assert_eq!(answer.verdict, HistoryVerdict::NoChange, "{answer:?}");
    // It does not move the line that is drawn of what is explained.
    assert!(answer.course.iter().all(|drawn| (drawn.explained - 3.0).abs() < 3.0 * SCATTER), "{:?}", answer.course);
}

#[test]
fn the_budget_is_reached_when_the_slope_reaches_it() {
    let mut gyro = Fleet::seeded(35).gyro(24);
    change(&mut gyro, 0, |k, _| 5e-4 * k as f64);
    let budget = DriftBudget { baseline: 3.0, limit: 0.02, measured_since: None };
    let answer = &diagnose_history(&gyro, &[], [Some(budget), None, None])[0];
    let due = answer.due.expect("it ages");
    let truth = 30.0 * (0.02 / 5e-4 - 23.0);
    assert!((due.days - truth).abs() < 120.0, "{due:?}, {truth}");
    let [[early_80, late_80], [early_95, late_95]] =
        [due.p80, due.p95].map(|ends| ends.map(|end| end.expect("closed")));
    assert!(early_95 < early_80 && early_80 < due.days && due.days < late_80 && late_80 < late_95, "{due:?}");
    assert!((early_95..=late_95).contains(&truth), "{due:?}, {truth}");
    assert!(due.calibrate_by.is_some_and(|by| early_95 < by && by < early_80), "{due:?}");
}

#[test]
fn ten_thousand_records_and_records_of_one_instant_get_an_answer() {
    let mut fleet = Fleet::seeded(36);
    let mut gyro = fleet.gyro(10_000);
    change(&mut gyro, 0, |k, _| 1e-6 * k as f64);
    let answer = of(&gyro, &[], Coefficient::DI);
    assert_eq!((answer.records, answer.causes[0].cause), (10_000, ChangeCause::Ageing), "{answer:?}");
    let mut at_once = fleet.gyro(24);
    for (k, entry) in at_once.entries.iter_mut().enumerate() {
        (entry.at, entry.d[0].value) = (UtcMicros(k as i64 * UtcMicros::SECOND), 3.0 + 0.01 * k as f64);
    }
    let of_a_day = of(&at_once, &[], Coefficient::DI);
    assert_eq!((of_a_day.verdict, of_a_day.is_of_a_day), (HistoryVerdict::TooFew, true), "24 s are no time to age in");
    let mut without = fleet.gyro(24);
    without.entries.iter_mut().for_each(|entry| entry.temperature_c = None);
    assert_eq!(of(&without, &[], Coefficient::DS).verdict, HistoryVerdict::NoChange);
}

#[test]
fn gyros_that_only_ever_moved_together_tell_the_stations_apart_and_not_their_own_steps() {
    let (mut gyro, mut others) = gyro_and_peers(37, 4, 24);
    for one in others.iter_mut().chain([&mut gyro]) {
        for (k, entry) in one.entries.iter_mut().enumerate() {
            entry.station = if k >= 12 { "ST-2".into() } else { "ST-1".into() };
            entry.d[0].value += if k >= 12 { 8e-3 } else { 0.0 };
        }
    }
    let answer = of(&gyro, &others, Coefficient::DI);
    assert_eq!(answer.causes.iter().map(|cause| cause.cause).collect::<Vec<_>>(), [ChangeCause::Station], "{answer:?}");
}

#[test]
fn a_fleet_of_stations_has_repeatability_offset_and_gyro_by_station() {
    let mut fleet = Fleet::seeded(38);
    let mut gyros = peers(&mut fleet, 10, 30);
    let mut own = Fleet::seeded(39);
    for gyro in &mut gyros {
        let [first, second] = [(); 2].map(|()| 2.0 * own.noise());
        change(gyro, 0, |_, e| if &*e.station == "ST-2" { 0.006 + second } else { first });
    }
    let found = stations(&gyros).expect("there are records");
    assert_eq!((&*found.against, found.stations.len()), ("ST-1", 2));
    let second = &found.stations[1];
    assert_eq!((&*second.name, second.records, second.gyros, second.imus), ("ST-2", 100, 30, 10));
    let column = &second.columns[0];
    let offset = column.offset.expect("gyros were at both");
    assert!((offset.value - 0.006).abs() < 3.0 * offset.sd && offset.sd < 1e-3, "{offset:?}");
    let of = |spread: Option<Spread>| spread.expect("enough figures").interval;
    let holds = |[low, high]: [f64; 2], truth: f64| low <= truth && truth <= high && high < 2.0 * truth;
    assert!(holds(of(column.repeatability), SCATTER), "{column:?}");
    assert!(holds(of(column.by_gyro), 2.0 * SCATTER), "{column:?}");
    assert!(holds(of(found.stations[0].columns[0].by_gyro), 2.0 * SCATTER), "of the reference too");
    let [low, high] = of(second.columns[1].by_gyro);
    assert!(low == 0.0 && high < SCATTER, "D_S has none: {low} to {high}");
    assert!(!column.drifts && column.steps.is_empty(), "{column:?}");
}

#[test]
fn a_station_with_one_gyro_and_records_without_temperature_get_what_can_be_told() {
    let mut fleet = Fleet::seeded(40);
    let mut lone = fleet.gyro(24);
    lone.entries.iter_mut().for_each(|entry| entry.temperature_c = None);
    change(&mut lone, 0, |_, e| if &*e.station == "ST-2" { 0.006 } else { 0.0 });
    let answer = of(&lone, &[], Coefficient::DI);
    assert_eq!(answer.causes[0].cause, ChangeCause::Station, "{answer:?}");
    assert!(!answer.causes.iter().any(|cause| cause.class.contains(&ChangeCause::Temperature)), "{answer:?}");
    let found = stations(std::slice::from_ref(&lone)).expect("there are records");
    assert_eq!((found.stations.len(), found.stations[1].imus), (2, 1));
    let column = &found.stations[1].columns[0];
    assert!(column.by_gyro.is_none() && column.offset.is_some_and(|of| of.gyros == 1), "{column:?}");
    for records in 0..3 {
        let few = fleet.gyro(records);
        let found = stations(std::slice::from_ref(&few));
        assert_eq!(found.is_none(), records == 0);
        assert!(found.into_iter().flat_map(|found| found.stations).all(|one| one.columns[0].offset.is_none()));
    }
}

/// `imus` IMUs of three gyros at one station, of which `moves` are changed by `by`.
fn small_fleet(seed: u64, imus: usize, by: impl Fn(usize, usize) -> f64) -> Vec<GyroHistory> {
    let mut fleet = Fleet::seeded(seed);
    let mut gyros: Vec<GyroHistory> = peers(&mut fleet, imus, 24);
    for (k, gyro) in gyros.iter_mut().enumerate() {
        gyro.entries.iter_mut().for_each(|entry| entry.station = "ST-1".into());
        change(gyro, 0, |record, _| by(k / 3, record));
    }
    gyros
}

#[test]
fn a_gyro_that_stands_still_is_not_moved_by_a_station_that_moves_others() {
    let step = |imu: usize, k: usize| if imu > 0 && k >= 11 { 0.01 } else { 0.0 };
    let slope = |imu: usize, k: usize| if imu > 0 { 5e-4 * k as f64 } else { 0.0 };
    let changes: [(usize, &dyn Fn(usize, usize) -> f64); 3] = [(3, &step), (3, &slope), (6, &step)];
    for (seed, (imus, by)) in (60..65).flat_map(|seed| changes.map(|of| (seed, of))) {
        let gyros = small_fleet(seed, imus, by);
        let answer = of(&gyros[0], &gyros[3..], Coefficient::DI);
        assert_eq!(answer.verdict, HistoryVerdict::NoChange, "{seed}, {imus} IMUs: {answer:?}");
    }
}

#[test]
fn gyros_that_age_each_by_itself_do_not_make_the_station_drift() {
    for seed in 70..76 {
        let gyros = small_fleet(seed, 6, |imu, k| 3e-4 * (1.0 + 0.3 * imu as f64) * k as f64);
        let found = stations(&gyros).expect("there are records");
        assert!(!found.stations[0].columns[0].drifts, "{seed}: {found:?}");
        let answer = of(&gyros[0], &gyros[3..], Coefficient::DI);
        let [cause] = &answer.causes[..] else { panic!("{seed}: {answer:?}") };
        assert_eq!(cause.cause, ChangeCause::Ageing, "{seed}: {answer:?}");
        assert!((cause.estimate.value / (3e-4 * 365.25 / 30.0) - 1.0).abs() < 0.5, "{seed}: {answer:?}");
    }
}

/// IMUs of two stations, each once at the other; `by` IMU, record and whether that is at the first station.
fn with_one_visit_each(seed: u64, by: impl Fn(usize, usize, bool) -> f64) -> Vec<GyroHistory> {
    let mut gyros = peers(&mut Fleet::seeded(seed), 8, 24);
    for (number, gyro) in gyros.iter_mut().enumerate() {
        let imu = number / 3;
        for (k, entry) in gyro.entries.iter_mut().enumerate() {
            let is_first = (imu < 4) != (k == 3 + (5 * imu) % 19);
            entry.station = if is_first { "ST-1".into() } else { "ST-2".into() };
            entry.d[0].value += by(imu, k, is_first);
        }
    }
    gyros
}

#[test]
fn one_visit_to_another_station_tells_gyros_that_age_alike_from_a_station_that_drifts() {
    let own = |gyros: &[GyroHistory]| -> Vec<HistoryDiagnosis> {
        let of_imu = |imu: usize| {
            let others: Vec<GyroHistory> = gyros[..3 * imu].iter().chain(&gyros[3 * imu + 3..]).cloned().collect();
            of(&gyros[3 * imu], &others, Coefficient::DI)
        };
        (0..4).map(of_imu).collect()
    };
    for seed in 3100..3106 {
        let rate = |imu: usize| 5e-4 * [0.8, 1.2, 1.0, 1.1][imu % 4];
        let gyros = with_one_visit_each(seed, |imu, k, _| if imu < 4 { rate(imu) * k as f64 } else { 0.0 });
        for answer in own(&gyros) {
            let [cause] = &answer.causes[..] else { panic!("{seed}: {answer:?}") };
            assert!(cause.cause == ChangeCause::Ageing && answer.outliers.is_empty(), "{seed}: {answer:?}");
        }
        let found = stations(&gyros).expect("there are records");
        assert!(found.stations.iter().all(|station| !station.columns[0].drifts), "{seed}: {found:?}");
        let gyros = with_one_visit_each(seed, |_, k, is_first| if is_first { 5e-4 * k as f64 } else { 0.0 });
        for answer in own(&gyros) {
            let is_its = |cause: &NamedCause| cause.cause == ChangeCause::Station;
            assert!(!answer.causes.is_empty() && answer.causes.iter().all(is_its), "{seed}: {answer:?}");
        }
        assert!(stations(&gyros).is_some_and(|found| found.stations[0].columns[0].drifts), "{seed}");
    }
}

#[test]
fn what_varies_far_more_than_other_gyros_do_is_not_called_scatter() {
    for seed in 0..40 {
        let mut fleet = Fleet::seeded(7000 + seed);
        let others = peers(&mut fleet, 8, 24);
        let answer_of = |times: f64| {
            let mut gyro = Fleet::seeded(8000 + seed).gyro(24);
            in_imu(&mut gyro, 0);
            gyro.entries.iter_mut().for_each(|entry| entry.d[0].value = 3.0 + times * (entry.d[0].value - 3.0));
            of(&gyro, &others, Coefficient::DI)
        };
        let answer = answer_of(17.0);
        assert_ne!(answer.verdict, HistoryVerdict::NoChange, "{seed}: {answer:?}");
        assert!(answer.excess.is_some() || !answer.causes.is_empty() || answer.wander.is_some(), "{seed}: {answer:?}");
        for times in [1.0, 2.0] {
            assert_eq!(answer_of(times).excess, None, "{seed}, {times}");
        }
    }
}

#[test]
fn scatter_beyond_what_is_stated_is_no_wandering() {
    let wanders = (0..60).filter(|&seed| {
        let mut gyro = Fleet::seeded(2000 + seed).gyro(24);
        gyro.entries.iter_mut().for_each(|entry| entry.d[0].sd = Some(1e-4 * SCATTER));
        of(&gyro, &[], Coefficient::DI).verdict != HistoryVerdict::NoChange
    });
    let wanders = wanders.count();
    assert!(wanders <= 3, "{wanders} of 60 histories of white noise were called something else");
}

#[test]
fn a_closure_covers_what_an_onset_that_was_searched_for_explains() {
    let (mut covered, mut all) = (0, 0);
    for seed in 0..120 {
        let truth = |k: usize| 1e-3 * (k as f64 - 12.0).max(0.0);
        let mut gyro = Fleet::seeded(3000 + seed).gyro(24);
        change(&mut gyro, 0, |k, _| truth(k));
        let answer = of(&gyro, &[], Coefficient::DI);
        let [cause] = &answer.causes[..] else { continue };
        let Some(held_out) = cause.held_out else { continue };
        let origin = gyro.entries[0].at;
        let explained = |entry: &HistoryEntry| cause.estimate.value * cause.tie.regressor(entry, origin);
        let power = |values: Vec<f64>| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
        };
        let error = gyro.entries.iter().enumerate().map(|(k, entry)| truth(k) - explained(entry)).collect();
        let share = 1.0 - power(error) / power((0..24).map(truth).collect());
        covered += usize::from((held_out.interval[0]..=held_out.interval[1]).contains(&share));
        all += 1;
    }
    assert!(all >= 110 && 100 * covered >= 86 * all, "{covered} of {all}");
}

#[test]
fn days_count_from_the_newest_record_of_a_long_history() {
    let mut gyro = Fleet::seeded(80).gyro(1000);
    change(&mut gyro, 0, |k, _| 2e-4 * k as f64);
    let budget = DriftBudget { baseline: 3.0, limit: 0.3, measured_since: None };
    let due = diagnose_history(&gyro, &[], [Some(budget), None, None])[0].due.expect("it ages");
    let truth = 30.0 * (0.3 / 2e-4 - 999.0);
    let [early, late] = due.p95.map(|end| end.expect("closed"));
    assert!((early..=late).contains(&truth) && late - early < 200.0, "{due:?}, {truth}");
}

#[test]
fn stations_are_compared_where_gyros_lead_from_one_to_the_other_and_each_group_has_its_own_reference() {
    let mut fleet = Fleet::seeded(81);
    let mut gyros = peers(&mut fleet, 4, 24);
    for entry in gyros[6..].iter_mut().flat_map(|gyro| &mut gyro.entries) {
        entry.station = if &*entry.station == "ST-1" { "ST-3".into() } else { "ST-4".into() };
    }
    let found = stations(&gyros).expect("there are records");
    let known: Vec<bool> = found.stations.iter().map(|one| one.columns[0].offset.is_some()).collect();
    assert_eq!((&*found.against, &known[..]), ("ST-3", &[false, true, false, true][..]));
    let against = |k: usize| found.stations[k].against.as_deref();
    assert_eq!([0, 1, 2, 3].map(against), [None, Some("ST-1"), None, Some("ST-3")]);
    // Nor is it what offsets count from, however busy.
    let mut alone = fleet.gyro(400);
    alone.entries.iter_mut().for_each(|entry| entry.station = "ST-9".into());
    gyros.push(alone);
    let found = stations(&gyros).expect("there are records");
    assert!(&*found.against == "ST-3" && found.stations[4].columns[0].offset.is_none(), "{}", found.against);
    assert!(found.stations[1].columns[0].offset.is_some() && found.stations[3].columns[0].offset.is_some());
}

#[test]
fn a_step_within_what_is_averaged_is_one_step() {
    for seed in 90..94 {
        let mut gyro = Fleet::seeded(seed).gyro(1000);
        change(&mut gyro, 0, |k, _| if k >= 405 { 0.02 } else { 0.0 });
        let answer = of(&gyro, &[], Coefficient::DI);
        let [cause] = &answer.causes[..] else { panic!("{seed}: {answer:?}") };
        assert_eq!(cause.cause, ChangeCause::Step, "{seed}: {answer:?}");
        let CauseEstimate { value, sd, .. } = cause.estimate;
        assert!((value - 0.02).abs() < 4.0 * sd, "{seed}: {answer:?}");
    }
}

#[test]
fn a_class_lists_its_causes_in_the_order_of_their_names() {
    assert!(ChangeCause::ALL.is_sorted());
    assert!(ChangeCause::ALL.map(ChangeCause::name).is_sorted());
}
