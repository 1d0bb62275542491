//! What is said of verdicts, in both languages.

use super::Language;
use crate::core::bench::BenchMethod;
use crate::core::judge::{
    Coefficient, FigureSource, Finding, History, LimitKey, Limits, Measured, Rule, Sample, Seat, Series, State, Unseen,
    Verdict, judge,
};
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;

/// 2026-01-01, and so many days.
fn day(days: f64) -> UtcMicros {
    UtcMicros(1_767_225_600_000_000).plus_days(days)
}

fn verdict(rule: Rule, finding: Finding) -> Verdict {
    Verdict {
        coefficient: Coefficient::DI,
        rule,
        state: State::Exceeded,
        value: Some(0.0251),
        limit: 0.01,
        limit_from: LimitKey::BUDGET,
        sd: Some(0.0007),
        probability: Some(0.9999),
        between: None,
        confirmed: true,
        finding,
    }
}

/// One of each kind.
fn samples() -> Vec<Verdict> {
    let nothing = |rule, finding| Verdict {
        state: State::Indeterminate,
        value: None,
        sd: None,
        probability: None,
        confirmed: false,
        ..verdict(rule, finding)
    };
    let within = |rule, finding| Verdict { state: State::Within, confirmed: false, ..verdict(rule, finding) };
    let trend = |reach, provisional| Finding::Trend {
        cells: 24,
        since: day(0.0),
        until: day(200.0),
        per_year: Measured { value: 0.0052, sd: Some(0.0004) },
        deviation: 0.008,
        horizon_days: 90.0,
        reach,
        provisional,
        of_fleet: !provisional,
    };
    let foretold = |unseen, step: Option<f64>, exceeds| Verdict {
        coefficient: Coefficient::All,
        state: if exceeds { State::Exceeded } else { State::Indeterminate },
        value: Some(1.47),
        limit: 1.23,
        sd: None,
        probability: None,
        confirmed: exceeds,
        ..verdict(
            Rule::Forecast,
            Finding::Forecast { slot: Slot::G2, furthest: Some((41, -4.4)), p: 3e-5, step, campaigns: 1, unseen },
        )
    };
    let shift = Finding::Shift { level: 3.0, before: 27, since: day(20.0), now: 3.0251, scatter: 1e-3, least: 2.5e-3 };
    let lowest = (FigureSource::Bench(BenchMethod::TorqueFeedback), day(1.0), 4.192621);
    let others = [Some("E_z"), Some("|E|"), None];
    vec![
        nothing(Rule::Step, Finding::TooFew { have: 1, need: 2 }),
        nothing(Rule::Agreement, Finding::TooFew { have: 1, need: 2 }),
        nothing(Rule::Trend, Finding::TooFew { have: 1, need: 8 }),
        nothing(Rule::Agreement, Finding::FewWithin { have: 1, need: 2, days: 30.0 }),
        nothing(Rule::Closure, Finding::Moved { since: day(1.0), have: 1, need: 4 }),
        verdict(Rule::Step, Finding::Step { level: 3.0, now: 2.9749 }),
        within(Rule::Step, Finding::Step { level: 3.0, now: 2.9999 }),
        verdict(
            Rule::Range,
            Finding::Range { records: 3, since: day(0.0), lowest: (day(0.0), 3.0), highest: (day(9.0), 3.0251) },
        ),
        Verdict {
            confirmed: false,
            sd: None,
            probability: None,
            ..verdict(Rule::Baseline, Finding::Baseline { level: 3.0, since: Some(day(0.0)), now: 3.0251 })
        },
        verdict(Rule::Closure, Finding::Closure { level: 0.0, since: None, moved: true, now: 0.0251, d_s: Some(5.0) }),
        within(Rule::Trend, Finding::NoTrend { cells: 24, since: day(0.0), step: None }),
        within(Rule::Trend, Finding::NoTrend { cells: 24, since: day(0.0), step: Some(day(9.0)) }),
        Verdict { confirmed: false, ..verdict(Rule::Trend, trend([Some(day(210.0)), Some(day(230.0)), None], false)) },
        within(Rule::Trend, trend([Some(day(100.0)), Some(day(150.0)), Some(day(190.0))], true)),
        Verdict { limit: 0.005, confirmed: false, ..verdict(Rule::Shift, shift) },
        Verdict {
            state: State::Indeterminate,
            limit: 0.03,
            confirmed: false,
            probability: None,
            ..verdict(Rule::Shift, shift)
        },
        Verdict {
            state: State::Indeterminate,
            sd: Some(0.2),
            confirmed: false,
            ..verdict(Rule::RmsSuccessive, Finding::RmsSuccessive { since: day(0.0), explained: Some(0.0072) })
        },
        verdict(
            Rule::BeforeAfter,
            Finding::BeforeAfter { before: (day(0.0), 3.0), from: day(1.0), until: day(2.0), now: 3.0251 },
        ),
        verdict(
            Rule::StationShift,
            Finding::GroupShift { gyros: 16, imus: 6, since: day(0.0), until: day(9.0), shift: -0.0251 },
        ),
        verdict(Rule::ImuShift, Finding::ImuShift { gyros: 3 }),
        verdict(
            Rule::BatchShift,
            Finding::GroupShift { gyros: 9, imus: 3, since: day(0.0), until: day(9.0), shift: 0.0251 },
        ),
        foretold(None, Some(0.0062), true),
        foretold(Some(Unseen::Temperature), Some(0.0062), false),
        foretold(Some(Unseen::Temperature), Some(0.0062), true),
        foretold(None, Some(0.0151), false),
        foretold(None, None, false),
        verdict(
            Rule::Agreement,
            Finding::Agreement { results: 3, lowest, highest: (FigureSource::Separation, day(2.0), 4.217721) },
        ),
        Verdict {
            coefficient: Coefficient::E,
            value: Some(0.89),
            limit: 0.853,
            confirmed: false,
            ..verdict(Rule::Requirement, Finding::Requirement { figure: "E_x", low: 0.843, high: 0.853, others })
        },
        Verdict {
            coefficient: Coefficient::All,
            value: Some(45.5),
            limit: 30.0,
            sd: None,
            probability: None,
            confirmed: false,
            ..verdict(Rule::Overdue, Finding::Overdue { last: day(0.0) })
        },
    ]
}

#[test]
fn each_finding_is_said_in_both_languages() {
    let said: Vec<[String; 2]> =
        samples().iter().map(|verdict| Language::ALL.map(|language| language.reason(verdict).into_owned())).collect();
    let expected = [
        [
            "D_I: not enough data for step. It needs 2 records and has 1.",
            "D_I：“相邻变化”数据不足，需要2个记录，现有1个。",
        ],
        [
            "D_I: not enough data for agreement of methods. It needs 2 results and has 1.",
            "D_I：“方法一致性”数据不足，需要2个结果，现有1个。",
        ],
        [
            "D_I: not enough data for trend. It needs 8 weeks with records and has 1.",
            "D_I：“趋势”数据不足，需要8个有记录的周，现有1个。",
        ],
        [
            "D_I: not enough data for agreement of methods. It needs 2 results within 30 days and has 1.",
            "D_I：“方法一致性”数据不足，需要30天内2个结果，现有1个。",
        ],
        [
            "D_I: the gyro was moved to another IMU or slot before 2026-01-02. Its level there needs 4 records and has 1.",
            "D_I：陀螺在2026-01-02之前换到另一IMU或位置。新水平需要4个记录，现有1个。",
        ],
        [
            "D_I is 0.0251 +- 0.0007 deg/(h g0) below the records before (median 3.0000). Limit 0.0100 deg/(h g0) (judging.budget): 251 %. Confirmed by a second campaign. P(out of tolerance) > 99.9 %.",
            "D_I比此前记录（中位数3.0000）低0.0251 ± 0.0007 (°)/(h·g0)。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。第二次标定已证实。超差概率> 99.9 %。",
        ],
        ["In tolerance.", "合格。"],
        [
            "D_I spans 0.0251 +- 0.0007 deg/(h g0) over 3 records since 2026-01-01: 3.0000 on 2026-01-01 and 3.0251 on 2026-01-10. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. Not due to a single result. P(out of tolerance) > 99.9 %.",
            "D_I自2026-01-01以来3个记录的极差为0.0251 ± 0.0007 (°)/(h·g0)：3.0000（2026-01-01）与3.0251（2026-01-10）。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。并非由单个结果造成。超差概率> 99.9 %。",
        ],
        [
            "D_I is 0.0251 deg/(h g0) above its baseline 3.0000 (median of three records from 2026-01-01). Limit 0.0100 deg/(h g0) (judging.budget): 251 %. No standard deviation is known: compared as it stands.",
            "D_I比基线3.0000（自2026-01-01起三个记录的中位数）高0.0251 (°)/(h·g0)。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。标准差未知，按数值直接比较。",
        ],
        [
            "D_I is 0.0251 +- 0.0007 deg/(h g0) above its baseline 0.0000 (fixed). That level began when the gyro was moved to another IMU or slot. A turn of +17.3 arcmin about the input axis does the same. Likely the mounting or an output-axis term, not D_I or D_S. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. Confirmed by a second campaign. P(out of tolerance) > 99.9 %.",
            "D_I比基线0.0000（固定）高0.0251 ± 0.0007 (°)/(h·g0)。该水平自陀螺换到另一IMU或位置起算。相当于绕输入轴转动+17.3角分。更可能是安装变化或输出轴项，而非D_I或D_S。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。第二次标定已证实。超差概率> 99.9 %。",
        ],
        ["No trend.", "未见趋势。"],
        ["No trend: a step fits better.", "未见趋势，阶跃更能解释。"],
        [
            "D_I drifts by +0.0052 +- 0.0004 deg/(h g0) a year (24 weekly means from 2026-01-01 to 2026-07-20). It reaches its budget about 2026-08-19 (95 %: 2026-07-30 to never). Its deviation from the baseline is +0.0080 and will be 0.0251 +- 0.0007 deg/(h g0) after 90 days. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. P(out of tolerance) > 99.9 %.",
            "D_I每年漂移+0.0052 ± 0.0004 (°)/(h·g0)（2026-01-01至2026-07-20的24个周平均值）。约在2026-08-19达到允许范围（95 %：2026-07-30至永不）。现偏离基线+0.0080，90天后为0.0251 ± 0.0007 (°)/(h·g0)。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。超差概率> 99.9 %。",
        ],
        [
            "D_I drifts by +0.0052 +- 0.0004 deg/(h g0) a year (24 weekly means from 2026-01-01 to 2026-07-20). It has passed its budget. Its deviation from the baseline is +0.0080 and will be 0.0251 +- 0.0007 deg/(h g0) after 90 days. Dates are provisional: the course is younger than 24 weekly means. The noise constants are defaults, not the fleet's. Limit 0.0100 deg/(h g0) (judging.budget). P(out of tolerance) > 99.9 %.",
            "D_I每年漂移+0.0052 ± 0.0004 (°)/(h·g0)（2026-01-01至2026-07-20的24个周平均值）。已超出允许范围。现偏离基线+0.0080，90天后为0.0251 ± 0.0007 (°)/(h·g0)。日期为暂定：变化过程短于24个周平均值。噪声常数为默认值，并非由本机群拟合。限值为0.0100 (°)/(h·g0)（judging.budget）。超差概率> 99.9 %。",
        ],
        [
            "D_I: the newest three weekly means, since 2026-01-21, are 0.02510 +- 0.00070 deg/(h g0) above the level 3.00000 of the 27 before. Limit 0.00500 deg/(h g0) (three standard deviations; at least 0.00250, by judging.budget). P(out of tolerance) > 99.9 %.",
            "D_I：自2026-01-21起最近三个周平均值比此前27个的水平3.00000高0.02510 ± 0.00070 (°)/(h·g0)。限值为0.00500 (°)/(h·g0)（三倍标准差；下限0.00250由judging.budget得出）。超差概率> 99.9 %。",
        ],
        [
            "D_I: the newest three weekly means, since 2026-01-21, are 0.0251 +- 0.0007 deg/(h g0) above the level 3.0000 of the 27 before. Limit 0.0300 deg/(h g0) (three standard deviations; at least 0.00250, by judging.budget). Too uncertain to judge: three standard deviations are more than the budget.",
            "D_I：自2026-01-21起最近三个周平均值比此前27个的水平3.0000高0.0251 ± 0.0007 (°)/(h·g0)。限值为0.0300 (°)/(h·g0)（三倍标准差；下限0.00250由judging.budget得出）。不确定度过大，无法判断：三倍标准差大于允许范围。",
        ],
        [
            "D_I: the rms of successive differences since 2026-01-01 is 0.0251 +- 0.2000 deg/(h g0), without the most deviating record. Stated standard deviations explain 0.0072. Limit 0.0100 deg/(h g0) (judging.budget). Too uncertain to judge: standard deviation 0.2000 against a limit of 0.0100.",
            "D_I：自2026-01-01以来去掉偏离最大的一个记录后，相邻差的均方根为0.0251 ± 0.2000 (°)/(h·g0)。给出的标准差可解释0.0072。限值为0.0100 (°)/(h·g0)（judging.budget）。不确定度过大，无法判断：标准差0.2000，限值0.0100。",
        ],
        [
            "D_I is 0.0251 +- 0.0007 deg/(h g0) above its last record before the environmental test (3.0000 on 2026-01-01). The test took from 2026-01-02 to 2026-01-03. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. Confirmed by a second campaign. P(out of tolerance) > 99.9 %.",
            "D_I比环境试验前最后一个记录（3.0000，2026-01-01）高0.0251 ± 0.0007 (°)/(h·g0)。试验自2026-01-02至2026-01-03。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。第二次标定已证实。超差概率> 99.9 %。",
        ],
        [
            "The median D_I of 16 gyros of 6 IMUs is 0.0251 +- 0.0007 deg/(h g0) below their baselines (2026-01-01 to 2026-01-10). It is the station, or what these gyros share. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. The shift is beyond the whole budget. P(out of tolerance) > 99.9 %.",
            "6个IMU 16个陀螺的D_I中位数比各自基线低0.0251 ± 0.0007 (°)/(h·g0)（2026-01-01至2026-01-10）。原因在测试站，或在这些陀螺的共同之处。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。偏移超出整个允许范围。超差概率> 99.9 %。",
        ],
        [
            "All 3 gyros of the IMU have moved at once from their baselines in D_I, by 0.0251 +- 0.0007 deg/(h g0) or more. It is the IMU, its mounting or that calibration, rather than one gyro. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. A second campaign has confirmed it of one of them. P(out of tolerance) > 99.9 %.",
            "IMU的全部3个陀螺的D_I同时偏离各自基线，至少0.0251 ± 0.0007 (°)/(h·g0)。原因在IMU、其安装或该次标定，而不在某一个陀螺。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。其中一个陀螺已由第二次标定证实。超差概率> 99.9 %。",
        ],
        [
            "The median D_I of 9 gyros of 3 IMUs of the batch is 0.0251 +- 0.0007 deg/(h g0) above their baselines (2026-01-01 to 2026-01-10). Other gyros calibrated within 60 days are less than half as far off by their median. Limit 0.0100 deg/(h g0) (judging.budget): 251 %. The shift is beyond the whole budget. P(out of tolerance) > 99.9 %.",
            "本批次3个IMU 9个陀螺的D_I中位数比各自基线高0.0251 ± 0.0007 (°)/(h·g0)（2026-01-01至2026-01-10）。60天内标定的其他陀螺，中位数偏离不到其一半。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。偏移超出整个允许范围。超差概率> 99.9 %。",
        ],
        [
            "G2 is furthest from the forecast of the adopted model, by an rms of 1.47 standard deviations (p = 3e-5 over all gyros). Dwell 41 is furthest, by -4.4 standard deviations. Limit 1.23 standard deviations: chance exceeds it in 0.2 % of campaigns. The model is of one campaign: what usually changes between campaigns may be all of it. Confirmed by a second campaign.",
            "G2与已采用模型的预报相差最大，均方根为1.47 倍标准差（全部陀螺 p = 3e-5）。偏离最大的是第41个测点，-4.4倍标准差。限值为1.23 倍标准差：0.2 %的标定因偶然超出。模型仅来自一次标定：差异可能只是各次标定之间的通常变化。第二次标定已证实。",
        ],
        [
            "G2 is furthest from the forecast of the adopted model, by an rms of 1.47 standard deviations (p = 3e-5 over all gyros). Dwell 41 is furthest, by -4.4 standard deviations. Limit 1.23 standard deviations: chance exceeds it in 0.2 % of campaigns. It says nothing: the model has not seen such temperatures.",
            "G2与已采用模型的预报相差最大，均方根为1.47 倍标准差（全部陀螺 p = 3e-5）。偏离最大的是第41个测点，-4.4倍标准差。限值为1.23 倍标准差：0.2 %的标定因偶然超出。无法判断：模型未见过这样的温度。",
        ],
        [
            "G2 is furthest from the forecast of the adopted model, by an rms of 1.47 standard deviations (p = 3e-5 over all gyros). Dwell 41 is furthest, by -4.4 standard deviations. Limit 1.23 standard deviations: chance exceeds it in 0.2 % of campaigns. The model has not seen such temperatures, but no effect of plausible size reaches that far beyond what it has. The model is of one campaign: what usually changes between campaigns may be all of it. Confirmed by a second campaign.",
            "G2与已采用模型的预报相差最大，均方根为1.47 倍标准差（全部陀螺 p = 3e-5）。偏离最大的是第41个测点，-4.4倍标准差。限值为1.23 倍标准差：0.2 %的标定因偶然超出。模型未见过这样的温度，但合理大小的效应外推不到这么远。模型仅来自一次标定：差异可能只是各次标定之间的通常变化。第二次标定已证实。",
        ],
        [
            "G2 is furthest from the forecast of the adopted model, by an rms of 1.47 standard deviations (p = 3e-5 over all gyros). Dwell 41 is furthest, by -4.4 standard deviations. Limit 1.23 standard deviations: chance exceeds it in 0.2 % of campaigns. It says nothing: only a step of D_I and D_S of 0.015 deg/(h g0) or more is sure to show.",
            "G2与已采用模型的预报相差最大，均方根为1.47 倍标准差（全部陀螺 p = 3e-5）。偏离最大的是第41个测点，-4.4倍标准差。限值为1.23 倍标准差：0.2 %的标定因偶然超出。无法判断：D_I、D_S的阶跃达到0.015 (°)/(h·g0)才必然可见。",
        ],
        [
            "G2 is furthest from the forecast of the adopted model, by an rms of 1.47 standard deviations (p = 3e-5 over all gyros). Dwell 41 is furthest, by -4.4 standard deviations. Limit 1.23 standard deviations: chance exceeds it in 0.2 % of campaigns. It says nothing: no step of D_I and D_S would show.",
            "G2与已采用模型的预报相差最大，均方根为1.47 倍标准差（全部陀螺 p = 3e-5）。偏离最大的是第41个测点，-4.4倍标准差。限值为1.23 倍标准差：0.2 %的标定因偶然超出。无法判断：D_I、D_S的任何阶跃都不可见。",
        ],
        [
            "D_I spans 0.0251 +- 0.0007 deg/(h g0) over 3 results: 4.1926 (torque feedback on 2026-01-02) and 4.2177 (separation on 2026-01-03). Limit 0.0100 deg/(h g0) (judging.budget): 251 %. Not due to a single result. P(out of tolerance) > 99.9 %.",
            "D_I的3个结果极差为0.0251 ± 0.0007 (°)/(h·g0)：4.1926（力矩反馈，2026-01-02）与4.2177（分离，2026-01-03）。限值为0.0100 (°)/(h·g0)（judging.budget），为其251 %。并非由单个结果造成。超差概率> 99.9 %。",
        ],
        [
            "E_x = 0.890 +- 0.0007 pulse/arcsec is outside 0.843 to 0.853. Also outside: E_z, |E|. Limits from judging.budget. P(out of tolerance) > 99.9 %.",
            "E_x = 0.890 ± 0.0007 pulse/arcsec，超出0.843至0.853范围。同样超出：E_z、|E|。限值来自judging.budget。超差概率> 99.9 %。",
        ],
        [
            "Last calibrated on 2026-01-01, 45.5 days ago. Limit 30.0 days (judging.budget): 152 %.",
            "上次标定于2026-01-01，距今45.5天。限值为30.0 天（judging.budget），为其152 %。",
        ],
    ];
    for (said, expected) in said.iter().zip(expected) {
        assert_eq!(said, &expected);
    }
    assert_eq!(said.len(), expected.len());
}

/// Every number of the English reason stands in the Chinese one, whatever the rule.
#[test]
fn both_languages_say_the_same_figures() {
    let measured = |value| Measured { value, sd: Some(1e-3) };
    let mut verdicts = samples();
    // One that passes the budget, and one that has not reached it yet.
    for slope in [0.004, 0.0006] {
        let d = |k: usize| if k < 8 { 1.0 } else { 1.0 + slope * (k - 7) as f64 };
        let sample = |k: usize| Sample {
            at: UtcMicros(k as i64 * 9 * UtcMicros::DAY),
            seat: Seat { imu: u32::from(k > 18), ..Seat::default() },
            station: 0,
            d: [measured(d(k)), measured(-d(k)), measured(0.01 * d(k))],
        };
        let samples = Series::from((0..24).map(sample).collect::<Vec<_>>());
        for k in [2, 10, 19, 23] {
            judge(&History::whole(&samples, k), k, &Limits::default(), &mut verdicts);
        }
    }
    assert!(verdicts.len() > 60);
    let numbers = |text: &str| {
        let mut found: Vec<String> = text
            .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-' || c == '+'))
            .map(|number| number.trim_matches(['.', '-', '+']).to_owned())
            .filter(|number| !number.is_empty())
            .collect();
        // The unit's own index, written otherwise in Chinese.
        found.retain(|number| number != "0");
        found.sort();
        found
    };
    for verdict in verdicts {
        let [english, chinese] = Language::ALL.map(|language| language.reason(&verdict));
        assert_eq!(numbers(&english), numbers(&chinese), "{english}\n{chinese}");
        // The key of a limit is a name; a unit of pulses and IMU are the same in both.
        let names = ["judging.budget", "D_I", "D_S", "IMU", "pulse/arcsec", "arcsec"];
        let words = names.iter().fold(chinese.into_owned(), |text, name| text.replace(name, ""));
        let words: Vec<&str> = words.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| word.len() > 2).collect();
        assert!(words.is_empty(), "{words:?} in {verdict}");
    }
}
