//! Why a verdict is what it is, in Chinese. English is the core's own (`core/judge/reason.rs`); both say the same things in
//! the same order.

use super::words::CHINESE;
use crate::core::judge::{Coefficient, Finding, Rule, Source, State, Verdict, turn_arcmin};
use crate::core::time::UtcMicros;

/// One or two sentences.
pub(in crate::pages) fn in_chinese(verdict: &Verdict) -> String {
    let mut text = finding(verdict);
    if matches!(verdict.finding, Finding::TooFew { .. } | Finding::FewWithin { .. }) {
        return text + "。";
    }
    text += &format!("；限值为{:.*}{}。", digits(verdict.limit), verdict.limit, unit(verdict));
    text += &certainty(verdict);
    if verdict.confirmed {
        text += match verdict.rule {
            Rule::Range | Rule::Agreement => "并非由单个结果造成：去掉最高或最低值后仍超限。",
            _ => "第二次标定予以证实。",
        };
    }
    text
}

fn finding(verdict: &Verdict) -> String {
    let (name, p) = (verdict.coefficient.name(), digits(verdict.limit));
    let value = verdict.value.unwrap_or(0.0);
    match verdict.finding {
        Finding::TooFew { have, need } => format!("{name}：规则需要{need}个记录，现有{have}个"),
        Finding::FewWithin { have, need, days } => format!("{name}：规则需要{days}天内{need}个结果，现有{have}个"),
        Finding::Step { since, before, now, confirms } => {
            let step = now - before;
            let mut text = format!("{name}自{}以来变化{step:+.p$}，由{before:.p$}变为{now:.p$}", since.date());
            if let Some((at, level)) = confirms {
                text += &format!("，与{}的{level:.p$}相差{:+.p$}", at.date(), now - level);
            }
            text
        }
        Finding::Range { records, days, lowest, highest } => format!(
            "{name}在{days}天内{records}个记录的极差为{value:.p$}，最低{:.p$}（{}），最高{:.p$}（{}）",
            lowest.1,
            lowest.0.date(),
            highest.1,
            highest.0.date()
        ),
        Finding::Baseline { level, since, now } => {
            format!("{name}偏离基线{level:.p$}{}，相差{:+.p$}", origin(since), now - level)
        }
        Finding::Closure { level, since, now, d_s } => {
            let moved = now - level;
            let turn = turn_arcmin(moved, d_s);
            let turn = turn.map_or_else(String::new, |turn| format!("，相当于绕输入轴转动{turn:+.1}角分"));
            let cause = if verdict.state == State::Exceeded {
                "：更可能是安装变化或输出轴项，而非D_I或D_S"
            } else {
                ""
            };
            format!("闭合差{name}偏离基线{level:.p$}{}，相差{moved:+.p$}{turn}{cause}", origin(since))
        }
        Finding::NoTrend { records, since, step } => {
            let mut text = format!("{name}：自{}以来的{records}个记录未显示斜率", since.date());
            if let Some(at) = step {
                text += &format!("（{}的水平变化更能解释）", at.date());
            }
            text
        }
        Finding::Trend { records, since, until, per_day, deviation, horizon_days, reach } => {
            let [low, slope, high] = per_day.map(|per_day| per_day * 365.25);
            let [first, middle, last] = reach.map(UtcMicros::date);
            let ahead = if reach[1] <= until {
                "已超出允许范围；由此外推，".to_owned()
            } else {
                format!("由此外推，约在{middle}达到允许范围（{first}至{last}），")
            };
            format!(
                "{name}自{}至{}的{records}个记录中每年漂移{slope:+.p$}（{low:+.p$}至{high:+.p$}），期末偏离基线{deviation:+.p$}；\
                 {ahead}{horizon_days:.0}天后偏离{value:.p$}",
                since.date(),
                until.date()
            )
        }
        Finding::Cusum { records, onset, upward, records_per_false_alarm } => format!(
            "{name}自{}起连续{records}个记录处于其水平{}：累积和为{value:.p$}倍标准差，稳定的陀螺平均每\
             {records_per_false_alarm}个记录才超过一次限值",
            onset.date(),
            if upward { "之上" } else { "之下" }
        ),
        Finding::RmsSuccessive { since, explained } => {
            let mut text = format!("{name}：自{}以来相邻差的均方根为{value:.p$}", since.date());
            if let Some(explained) = explained {
                text += &format!("，其中标定的标准差可解释{explained:.p$}");
            }
            text
        }
        Finding::Agreement { results, lowest, highest } => format!(
            "{name}的{results}个结果极差为{value:.p$}，最低{:.p$}（{}，{}），最高{:.p$}（{}，{}）",
            lowest.2,
            source(lowest.0),
            lowest.1.date(),
            highest.2,
            source(highest.0),
            highest.1.date()
        ),
        Finding::Requirement { figure, low, high, others_outside } => {
            let place = if (low..=high).contains(&value) { "在" } else { "超出" };
            let mut text = format!("{figure} = {value:.p$}，{place}{low:.p$}至{high:.p$}范围");
            if others_outside > 0 {
                text += &format!("，{name}另有{others_outside}项同样超出");
            }
            text
        }
        Finding::Overdue { last } => format!("上次标定于{}，距今{value:.1}天", last.date()),
    }
}

fn source(source: Source) -> &'static str {
    match source {
        Source::Separation => "分离",
        Source::Bench(method) => CHINESE.method(method.name()),
    }
}

fn origin(since: Option<UtcMicros>) -> String {
    since.map_or_else(|| "（固定）".to_owned(), |at| format!("（自{}起最初几个记录的平均）", at.date()))
}

fn certainty(verdict: &Verdict) -> String {
    match (verdict.sd, verdict.probability) {
        (Some(sd), Some(probability)) => {
            let p = sd_digits(sd, verdict.limit);
            let chance = match probability {
                p if p > 0.999 => "大于99.9 %".to_owned(),
                p if p < 0.001 => "小于0.1 %".to_owned(),
                p => format!("{:.1} %", 100.0 * p),
            };
            let open = if verdict.state == State::Indeterminate { "：不确定度跨越限值" } else { "" };
            format!("标准差为{sd:.p$}，真值超限的概率{chance}{open}。")
        }
        _ if matches!(verdict.rule, Rule::Cusum | Rule::Trend | Rule::Overdue) => String::new(),
        _ => "标准差未知，按数值直接比较。".to_owned(),
    }
}

fn unit(verdict: &Verdict) -> &'static str {
    match (verdict.rule, verdict.coefficient) {
        (Rule::Overdue, _) => "天",
        (Rule::Cusum, _) => "倍标准差",
        (Rule::Requirement, Coefficient::E) => " pulse/arcsec",
        (Rule::Requirement, _) => " pulse/(s g0)",
        _ => " °/(h·g0)",
    }
}

/// Decimals that show a thousandth of the limit.
fn digits(limit: f64) -> usize {
    if limit == 0.0 { 6 } else { (3.0 - limit.abs().log10().floor()).clamp(0.0, 12.0) as usize }
}

/// As many decimals as the limit, and more where they would show less than two digits of the standard deviation.
fn sd_digits(sd: f64, limit: f64) -> usize {
    let two = if sd > 0.0 { (1.0 - sd.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    digits(limit).max(two)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::history::{BASELINE_RECORDS, History, Measured, Sample};
    use crate::core::judge::{Limits, Series, judge};

    /// Every number of the English reason stands in the Chinese one, whatever the rule.
    #[test]
    fn both_languages_say_the_same_figures() {
        let measured = |value| Measured { value, sd: Some(1e-3) };
        let mut verdicts = Vec::new();
        // One that passes the budget, and one that has not reached it yet.
        for slope in [0.004, 0.0004] {
            let d = |k: usize| if k < 8 { 1.0 } else { 1.0 + slope * (k - 7) as f64 };
            let sample = |k: usize| Sample {
                at: UtcMicros(k as i64 * 9 * UtcMicros::DAY),
                d: [measured(d(k)), measured(-d(k)), measured(0.01 * d(k))],
            };
            let samples = Series::from((0..24).map(sample).collect::<Vec<_>>());
            let history = History::of(&samples, &samples[..BASELINE_RECORDS], &[]);
            for k in [2, 10, 23] {
                judge(&history, k, &Limits::default(), &mut verdicts);
            }
        }
        assert!(verdicts.len() > 60);
        for words in ["it has passed the budget", "it would reach the budget"] {
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
            let words: Vec<&str> =
                spoken.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| word.len() > 2).collect();
            assert!(words.is_empty(), "{words:?} in {spoken}");
        }
    }
}
