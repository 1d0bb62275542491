//! Why a verdict is what it is, in Chinese. English is the core's own (`core/judge/reason.rs`); both say the same things in
//! the same order.

use super::words::CHINESE;
use crate::core::judge::{Coefficient, Finding, Rule, Source, State, Status, Verdict, digits, sd_digits, turn_arcmin};
use crate::core::time::UtcMicros;

/// A few short sentences.
pub(in crate::pages) fn in_chinese(verdict: &Verdict) -> String {
    let mut text = finding(verdict);
    if verdict.value.is_none() {
        return text;
    }
    text += &limit(verdict);
    if verdict.confirmed {
        text += match verdict.rule {
            Rule::Range | Rule::Agreement => "并非由单个结果造成。",
            _ => "第二次标定已证实。",
        };
    }
    text + &certainty(verdict)
}

fn finding(verdict: &Verdict) -> String {
    let (name, p) = (verdict.coefficient.name(), digits(verdict.limit));
    let (value, rule) = (value(verdict), CHINESE.rule(verdict.rule));
    match verdict.finding {
        Finding::TooFew { have, need } => {
            let what = match verdict.rule {
                Rule::Agreement => "个结果",
                Rule::Shift | Rule::Trend => "个有记录的周",
                _ => "个记录",
            };
            format!("{name}：“{rule}”数据不足，需要{need}{what}，现有{have}个。")
        }
        Finding::FewWithin { have, need, days } => {
            format!("{name}：“{rule}”数据不足，需要{days}天内{need}个结果，现有{have}个。")
        }
        Finding::Moved { since, have, need } => {
            format!("{name}：陀螺在{}之前换到另一惯组或位置，新水平需要{need}个记录，现有{have}个。", since.date())
        }
        Finding::Step { level, now } => {
            format!("{name}比此前记录（中位数{level:.p$}）{}{value}。", side(now - level))
        }
        Finding::Range { records, since, lowest, highest } => format!(
            "{name}自{}以来{records}个记录的极差为{value}：{:.p$}（{}）与{:.p$}（{}）。",
            since.date(),
            lowest.1,
            lowest.0.date(),
            highest.1,
            highest.0.date()
        ),
        Finding::Baseline { level, since, now } => {
            format!("{name}比基线{level:.p$}{}{}{value}。", origin(since), side(now - level))
        }
        Finding::Closure { level, since, moved, now, d_s } => {
            let mut text = format!("{name}比基线{level:.p$}{}{}{value}。", origin(since), side(now - level));
            if moved {
                text += "该水平自陀螺换到另一惯组或位置起算。";
            }
            if let Some(turn) = turn_arcmin(now - level, d_s) {
                text += &format!("相当于绕输入轴转动{turn:+.1}角分。");
            }
            if verdict.state == State::Exceeded {
                text += "更可能是安装变化或输出轴项，而非D_I或D_S。";
            }
            text
        }
        Finding::NoTrend { cells, since, step } => {
            let step = step.map_or_else(String::new, |at| format!("；{}的阶跃更能解释", at.date()));
            format!("{name}：自{}以来的{cells}个周平均值未见趋势{step}。", since.date())
        }
        Finding::Trend { .. } => trend(verdict),
        Finding::Shift { level, before, since, now, .. } => format!(
            "{name}：自{}起最近三个周平均值比此前{before}个的水平{level:.p$}{}{value}。",
            since.date(),
            side(now - level)
        ),
        Finding::RmsSuccessive { since, explained } => {
            let explained =
                explained.map_or_else(String::new, |explained| format!("给出的标准差可解释{explained:.p$}。"));
            format!("{name}：自{}以来去掉偏离最大的一个记录后，相邻差的均方根为{value}。{explained}", since.date())
        }
        Finding::BeforeAfter { before, from, until, now } => format!(
            "{name}比环境试验前最后一个记录（{:.p$}，{}）{}{value}。试验自{}至{}。",
            before.1,
            before.0.date(),
            side(now - before.1),
            from.date(),
            until.date()
        ),
        Finding::Agreement { results, lowest, highest } => {
            let of = |(from, at, result): (Source, UtcMicros, f64)| {
                format!("{result:.p$}（{}，{}）", source(from), at.date())
            };
            format!("{name}的{results}个结果极差为{value}：{}与{}。", of(lowest), of(highest))
        }
        Finding::Requirement { figure, low, high, others } => {
            let inside = verdict.value.is_some_and(|value| (low..=high).contains(&value));
            let mut text =
                format!("{figure} = {value}，{}{low:.p$}至{high:.p$}范围。", if inside { "在" } else { "超出" });
            let others: Vec<&str> = others.into_iter().flatten().collect();
            if !others.is_empty() {
                text += &format!("同样超出：{}。", others.join("、"));
            }
            text
        }
        Finding::Overdue { last } => {
            format!("上次标定于{}，距今{:.1}天。", last.date(), verdict.value.unwrap_or(0.0))
        }
    }
}

fn trend(verdict: &Verdict) -> String {
    let Finding::Trend { cells, since, until, per_year, deviation, horizon_days, reach, provisional, of_fleet } =
        verdict.finding
    else {
        return String::new();
    };
    let (name, p) = (verdict.coefficient.name(), digits(verdict.limit));
    let sd = per_year.sd.unwrap_or(0.0);
    let mut text = format!(
        "{name}每年漂移{:+.p$} ± {sd:.p$}{}（{}至{}的{cells}个周平均值）。",
        per_year.value,
        unit(verdict),
        since.date(),
        until.date()
    );
    match reach {
        [_, Some(middle), _] if middle <= until => text += "已超出允许范围。",
        [Some(first), Some(middle), last] => {
            let last = last.map_or_else(|| "永不".to_owned(), |last| last.date().to_string());
            text += &format!("约在{}达到允许范围（95 %：{}至{last}）。", middle.date(), first.date());
        }
        _ => {}
    }
    text += &format!("现偏离基线{deviation:+.p$}，{horizon_days:.0}天后为{}。", value(verdict));
    if provisional {
        text += "日期为暂定：变化过程短于24个周平均值。";
    }
    if !of_fleet {
        text += "噪声常数为默认值，并非由本机群拟合。";
    }
    text
}

fn side(difference: f64) -> &'static str {
    if difference < 0.0 { "低" } else { "高" }
}

/// With its standard deviation and unit.
fn value(verdict: &Verdict) -> String {
    let (value, p) = (verdict.value.unwrap_or(0.0), digits(verdict.limit));
    let sd = verdict.sd.map_or_else(String::new, |sd| {
        let p = sd_digits(sd, verdict.limit);
        format!(" ± {sd:.p$}")
    });
    format!("{value:.p$}{sd}{}", unit(verdict))
}

fn source(source: Source) -> &'static str {
    match source {
        Source::Separation => "分离",
        Source::Bench(method) => CHINESE.method(method.name()),
    }
}

fn origin(since: Option<UtcMicros>) -> String {
    since.map_or_else(|| "（固定）".to_owned(), |at| format!("（自{}起三个记录的中位数）", at.date()))
}

fn limit(verdict: &Verdict) -> String {
    let (limit, p, unit, from) = (verdict.limit, digits(verdict.limit), unit(verdict), verdict.limit_from);
    match verdict.finding {
        Finding::Requirement { .. } => format!("限值来自{from}。"),
        Finding::Shift { least, .. } if limit > least => {
            format!("限值为{limit:.p$}{unit}（三倍标准差；下限来自{from}）。")
        }
        _ => {
            let percent = 100.0 * verdict.value.unwrap_or(0.0) / limit;
            let part = if verdict.state == State::Exceeded && percent < 1e5 {
                format!("，为其{percent:.0} %")
            } else {
                String::new()
            };
            format!("限值为{limit:.p$}{unit}（{from}）{part}。")
        }
    }
}

fn certainty(verdict: &Verdict) -> String {
    let by_clock_or_chart = matches!(verdict.rule, Rule::Shift | Rule::Trend | Rule::Overdue | Rule::Cusum);
    match (verdict.status(), verdict.sd, verdict.probability) {
        (Status::TooUncertain, ..) if verdict.rule == Rule::Shift => {
            "不确定度过大，无法判断：三倍标准差大于允许范围。".to_owned()
        }
        (Status::TooUncertain, Some(sd), _) => {
            let (p, of_limit) = (sd_digits(sd, verdict.limit), digits(verdict.limit));
            format!("不确定度过大，无法判断：标准差{sd:.p$}，限值{:.of_limit$}。", verdict.limit)
        }
        (_, _, Some(probability)) => {
            let chance = match probability {
                p if p > 0.999 => "> 99.9 %".to_owned(),
                p if p < 0.001 => "< 0.1 %".to_owned(),
                p => format!("= {:.1} %", 100.0 * p),
            };
            format!("超差概率{chance}。")
        }
        (_, None, None) if !by_clock_or_chart => "标准差未知，按数值直接比较。".to_owned(),
        _ => String::new(),
    }
}

fn unit(verdict: &Verdict) -> &'static str {
    match (verdict.rule, verdict.coefficient) {
        (Rule::Overdue, _) => "天",
        (Rule::Cusum, _) => "倍标准差",
        (Rule::Requirement, Coefficient::E) => " pulse/arcsec",
        (Rule::Requirement, _) => " pulse/(s g0)",
        _ => " (°)/(h·g0)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{History, Limits, Measured, Sample, Seat, Series, judge};

    /// Every number of the English reason stands in the Chinese one, whatever the rule.
    #[test]
    fn both_languages_say_the_same_figures() {
        let measured = |value| Measured { value, sd: Some(1e-3) };
        let mut verdicts = Vec::new();
        // One that passes the budget, and one that has not reached it yet.
        for slope in [0.004, 0.0006] {
            let d = |k: usize| if k < 8 { 1.0 } else { 1.0 + slope * (k - 7) as f64 };
            let sample = |k: usize| Sample {
                at: UtcMicros(k as i64 * 9 * UtcMicros::DAY),
                seat: Seat { imu: u32::from(k > 18), ..Seat::default() },
                d: [measured(d(k)), measured(-d(k)), measured(0.01 * d(k))],
            };
            let samples = Series::from((0..24).map(sample).collect::<Vec<_>>());
            for k in [2, 10, 19, 23] {
                judge(&History::whole(&samples, k), k, &Limits::default(), &mut verdicts);
            }
        }
        assert!(verdicts.len() > 60);
        for words in ["It has passed its budget", "It reaches its budget about"] {
            assert!(verdicts.iter().any(|verdict| verdict.reason().contains(words)), "{words}");
        }
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
            let (english, chinese) = (verdict.reason(), in_chinese(&verdict));
            assert_eq!(numbers(&english), numbers(&chinese), "{english}\n{chinese}");
            assert!(!chinese.is_ascii());
            // What an alert keeps in English is said in Chinese from the English.
            let spoken = CHINESE.spoken(&english);
            assert_eq!(numbers(&english), numbers(&spoken), "{english}\n{spoken}");
            // The key of a limit is a name.
            let spoken = spoken.replace("judging.budget", "").replace("D_I", "").replace("D_S", "");
            let words: Vec<&str> =
                spoken.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| word.len() > 2).collect();
            assert!(words.is_empty(), "{words:?} in {spoken}");
        }
    }
}
