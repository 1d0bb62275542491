//! Why a verdict is what it is (`core/judge/reason.rs`), as an alert keeps it: a finding, the limit, how certain it is.

use super::Sentence;

pub(super) const SENTENCES: &[Sentence] = &[
    // What is added to all of it.
    ("{} It does not count any more: the record was voided or revised.", "{0}该记录已作废或修订，不再计入。"),
    (
        "{} It does not count: the record is set aside until somebody confirms its time.",
        "{0}该记录暂不计入，待人工确认时间。",
    ),
    // The whole: the finding, and one or two sentences after it.
    ("{}; the limit is {} {}. {}", "{0}；限值为{1} {2}。{3}"),
    ("{}; the limit is {} {}.", "{0}；限值为{1} {2}。"),
    (
        "With a standard deviation of {} the true value exceeds it with a probability of {}: the uncertainty straddles \
         the limit.",
        "标准差为{0}，真值超限的概率{1}：不确定度跨越限值。",
    ),
    (
        "With a standard deviation of {} the true value exceeds it with a probability of {} %. {}",
        "标准差为{0}，真值超限的概率{1} %。{2}",
    ),
    (
        "With a standard deviation of {} the true value exceeds it with a probability of {} %.",
        "标准差为{0}，真值超限的概率{1} %。",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {}: the uncertainty straddles \
         the limit.",
        "标准差为{0}，真值超限的概率{1}：不确定度跨越限值。",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {} %. {}",
        "标准差为{0}，真值超限的概率{1} %。{2}",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {} %.",
        "标准差为{0}，真值超限的概率{1} %。",
    ),
    ("No standard deviation is known: the figures are compared as they stand. {}", "标准差未知，按数值直接比较。{0}"),
    ("No standard deviation is known: the figures are compared as they stand.", "标准差未知，按数值直接比较。"),
    (
        "No single one is to blame: without the highest or the lowest it is exceeded too.",
        "并非由单个结果造成：去掉最高或最低值后仍超限。",
    ),
    ("A second campaign confirms it.", "第二次标定予以证实。"),
    ("more than {}", "大于{0}"),
    ("less than {}", "小于{0}"),
    ("days", "天"),
    ("standard deviations", "倍标准差"),
    ("deg/(h g0)", "°/(h·g0)"),
    // What each rule saw.
    ("{}: the rule {} needs {} records, {} is there.", "{0}：规则需要{2}个记录，现有{3}个。"),
    ("{}: the rule {} needs {} records, {} are there.", "{0}：规则需要{2}个记录，现有{3}个。"),
    ("{}: the rule {} needs {} results within {} days, {} is there.", "{0}：规则需要{3}天内{2}个结果，现有{4}个。"),
    ("{}: the rule {} needs {} results within {} days, {} are there.", "{0}：规则需要{3}天内{2}个结果，现有{4}个。"),
    ("{}: the rule {} needs {} results, {} is there.", "{0}：规则需要{2}个结果，现有{3}个。"),
    ("{}: the rule {} needs {} results, {} are there.", "{0}：规则需要{2}个结果，现有{3}个。"),
    (
        "{} changed by {} from {} on {} to {} and lies {} from {} on {}",
        "{0}自{3}以来变化{1}，由{2}变为{4}，与{7}的{6}相差{5}",
    ),
    ("{} changed by {} from {} on {} to {}", "{0}自{3}以来变化{1}，由{2}变为{4}"),
    (
        "{} spans {} over {} records of {} days, from {} on {} to {} on {}",
        "{0}在{3}天内{2}个记录的极差为{1}，最低{4}（{5}），最高{6}（{7}）",
    ),
    (
        "{} spans {} over {} results, from {} ({} on {}) to {} ({} on {})",
        "{0}的{2}个结果极差为{1}，最低{3}（{4}，{5}），最高{6}（{7}，{8}）",
    ),
    ("separation", "分离"),
    ("torque_feedback", "力矩反馈"),
    ("turntable_servo", "转台伺服"),
    (
        "The closure {} moved by {} from its baseline {}, as a turn of {} arcmin about the input axis would: mounting \
         rather than mass unbalance",
        "闭合差{0}偏离基线{2}，相差{1}，相当于绕输入轴转动{3}角分：更可能是安装变化，而非质量不平衡",
    ),
    (
        "The closure {} moved by {} from its baseline {}: mounting rather than mass unbalance",
        "闭合差{0}偏离基线{2}，相差{1}：更可能是安装变化，而非质量不平衡",
    ),
    (
        "The closure {} moved by {} from its baseline {}, as a turn of {} arcmin about the input axis would: mounting, or an \
         output-axis term, rather than D_I or D_S",
        "闭合差{0}偏离基线{2}，相差{1}，相当于绕输入轴转动{3}角分：更可能是安装变化或输出轴项，而非D_I或D_S",
    ),
    (
        "The closure {} moved by {} from its baseline {}: mounting, or an output-axis term, rather than D_I or D_S",
        "闭合差{0}偏离基线{2}，相差{1}：更可能是安装变化或输出轴项，而非D_I或D_S",
    ),
    (
        "The closure {} moved by {} from its baseline {}, as a turn of {} arcmin about the input axis would",
        "闭合差{0}偏离基线{2}，相差{1}，相当于绕输入轴转动{3}角分",
    ),
    ("The closure {} moved by {} from its baseline {}", "闭合差{0}偏离基线{2}，相差{1}"),
    ("{} lies {} from its baseline {}", "{0}偏离基线{2}，相差{1}"),
    ("{} (mean of the first records from {})", "{0}（自{1}起最初几个记录的平均）"),
    ("{} (fixed)", "{0}（固定）"),
    (
        "{}: the {} records since {} establish no slope (a change of level on {} explains them better)",
        "{0}：自{2}以来的{1}个记录未显示斜率（{3}的水平变化更能解释）",
    ),
    ("{}: the {} records since {} establish no slope", "{0}：自{2}以来的{1}个记录未显示斜率"),
    (
        "{} drifts by {} a year ({} to {}) over the {} records from {} to {}, when it lay {} from its baseline; carried on \
         from there it would reach the budget about {} ({} to {}), and lie {} off after {} days",
        "{0}自{5}至{6}的{4}个记录中每年漂移{1}（{2}至{3}），期末偏离基线{7}；由此外推，约在{8}达到允许范围（{9}至{a}），{c}天后偏离{b}",
    ),
    (
        "{} drifts by {} a year ({} to {}) over the {} records from {} to {}, when it lay {} from its baseline; it has \
         passed the budget, and carried on from there it would lie {} off after {} days",
        "{0}自{5}至{6}的{4}个记录中每年漂移{1}（{2}至{3}），期末偏离基线{7}；已超出允许范围；由此外推，{9}天后偏离{8}",
    ),
    // As alerts that older versions have stored say it.
    (
        "{} drifts by {} a year ({} to {}) over the {} records since {}; now {} from its baseline, it reaches the budget \
         about {} ({} to {}), and in {} days lies {} off",
        "{0}自{5}以来的{4}个记录中每年漂移{1}（{2}至{3}）；现偏离基线{6}，约在{7}达到允许范围（{8}至{9}），{a}天后将偏离{b}",
    ),
    (
        "{} has lain above its level for {} records, since {}: the cumulative sum is {} standard deviations, and a stable \
         gyro passes the limit once in {} records",
        "{0}自{2}起连续{1}个记录处于其水平之上：累积和为{3}倍标准差，稳定的陀螺平均每{4}个记录才超过一次限值",
    ),
    (
        "{} has lain below its level for {} records, since {}: the cumulative sum is {} standard deviations, and a stable \
         gyro passes the limit once in {} records",
        "{0}自{2}起连续{1}个记录处于其水平之下：累积和为{3}倍标准差，稳定的陀螺平均每{4}个记录才超过一次限值",
    ),
    (
        "{}: the root mean square of successive differences since {} is {}, of which the campaigns' standard deviations \
         explain {}",
        "{0}：自{1}以来相邻差的均方根为{2}，其中标定的标准差可解释{3}",
    ),
    ("{}: the root mean square of successive differences since {} is {}", "{0}：自{1}以来相邻差的均方根为{2}"),
    ("{} = {} lies within {} to {}", "{0} = {1}，在{2}至{3}范围"),
    (
        "{} = {} lies outside {} to {}, and so do {} more figures of {}",
        "{0} = {1}，超出{2}至{3}范围，{5}另有{4}项同样超出",
    ),
    (
        "{} = {} lies outside {} to {}, and so does {} more figure of {}",
        "{0} = {1}，超出{2}至{3}范围，{5}另有{4}项同样超出",
    ),
    ("{} = {} lies outside {} to {}", "{0} = {1}，超出{2}至{3}范围"),
    ("Last calibrated on {}, {} days ago", "上次标定于{0}，距今{1}天"),
];
