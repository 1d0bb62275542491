//! Why a verdict is what it is (`core/judge/reason.rs`), as an alert keeps it: a finding, the limit, how certain it is.

use super::Sentence;

pub(super) const SENTENCES: &[Sentence] = &[
    // Sentence by sentence, as `core/judge/reason.rs` writes them.
    ("Confirmed by a second campaign.", "第二次标定已证实。"),
    ("Not due to a single result.", "并非由单个结果造成。"),
    ("No standard deviation is known: compared as it stands.", "标准差未知，按数值直接比较。"),
    ("P(out of tolerance) {} %.", "超差概率{0} %。"),
    (
        "Too uncertain to judge: standard deviation {} against a limit of {}.",
        "不确定度过大，无法判断：标准差{0}，限值{1}。",
    ),
    (
        "Too uncertain to judge: three standard deviations are more than the budget.",
        "不确定度过大，无法判断：三倍标准差大于允许范围。",
    ),
    ("Limits from {}.", "限值来自{0}。"),
    ("Limit {} {} (three standard deviations; least {}).", "限值为{0} {1}（三倍标准差；下限来自{2}）。"),
    ("Limit {} {} ({}): {} %.", "限值为{0} {1}（{2}），为其{3} %。"),
    ("Limit {} {} ({}).", "限值为{0} {1}（{2}）。"),
    ("{}: not enough data for {}.", "{0}：“{1}”数据不足。"),
    ("step", "相邻变化"),
    ("range", "极差"),
    ("baseline", "偏离基线"),
    ("trend", "趋势"),
    ("shift", "持续偏移"),
    ("before_after", "试验前后"),
    ("rms_successive", "离散"),
    ("closure", "闭合差"),
    ("agreement", "方法一致性"),
    ("It needs {} weeks with records and has {}.", "需要{0}个有记录的周，现有{1}个。"),
    ("It needs {} records and has {}.", "需要{0}个记录，现有{1}个。"),
    ("It needs {} results and has {}.", "需要{0}个结果，现有{1}个。"),
    ("It needs {} results within {} days and has {}.", "需要{1}天内{0}个结果，现有{2}个。"),
    ("{}: the gyro was moved to another IMU or slot before {}.", "{0}：陀螺在{1}之前换到另一惯组或位置。"),
    ("Its level there needs {} records and has {}.", "新水平需要{0}个记录，现有{1}个。"),
    ("{} is {} above the records before (median {}).", "{0}比此前记录（中位数{2}）高{1}。"),
    ("{} is {} below the records before (median {}).", "{0}比此前记录（中位数{2}）低{1}。"),
    (
        "{} is {} above its baseline {} (median of three records from {}).",
        "{0}比基线{2}（自{3}起三个记录的中位数）高{1}。",
    ),
    (
        "{} is {} below its baseline {} (median of three records from {}).",
        "{0}比基线{2}（自{3}起三个记录的中位数）低{1}。",
    ),
    ("{} is {} above its baseline {} (fixed).", "{0}比基线{2}（固定）高{1}。"),
    ("{} is {} below its baseline {} (fixed).", "{0}比基线{2}（固定）低{1}。"),
    ("That level began when the gyro was moved to another IMU or slot.", "该水平自陀螺换到另一惯组或位置起算。"),
    ("A turn of {} arcmin about the input axis does the same.", "相当于绕输入轴转动{0}角分。"),
    ("Likely the mounting or an output-axis term, not D_I or D_S.", "更可能是安装变化或输出轴项，而非D_I或D_S。"),
    (
        "{} spans {} over {} records since {}: {} on {} and {} on {}.",
        "{0}自{3}以来{2}个记录的极差为{1}：{4}（{5}）与{6}（{7}）。",
    ),
    (
        "{} spans {} over {} results: {} ({} on {}) and {} ({} on {}).",
        "{0}的{2}个结果极差为{1}：{3}（{4}，{5}）与{6}（{7}，{8}）。",
    ),
    (
        "{}: no trend in the {} weekly means since {}; a step on {} fits better.",
        "{0}：自{2}以来的{1}个周平均值未见趋势；{3}的阶跃更能解释。",
    ),
    ("{}: no trend in the {} weekly means since {}.", "{0}：自{2}以来的{1}个周平均值未见趋势。"),
    ("{} drifts by {} a year ({} weekly means from {} to {}).", "{0}每年漂移{1}（{3}至{4}的{2}个周平均值）。"),
    ("It has passed its budget.", "已超出允许范围。"),
    ("It reaches its budget about {} (95 %: {} to never).", "约在{0}达到允许范围（95 %：{1}至永不）。"),
    ("It reaches its budget about {} (95 %: {} to {}).", "约在{0}达到允许范围（95 %：{1}至{2}）。"),
    ("Its deviation from the baseline is {} and will be {} after {} days.", "现偏离基线{0}，{2}天后为{1}。"),
    ("Dates are provisional: the course is younger than 24 weekly means.", "日期为暂定：变化过程短于24个周平均值。"),
    ("The noise constants are defaults, not the fleet's.", "噪声常数为默认值，并非由本机群拟合。"),
    (
        "{}: the newest three weekly means, since {}, are {} above the level {} of the {} before.",
        "{0}：自{1}起最近三个周平均值比此前{4}个的水平{3}高{2}。",
    ),
    (
        "{}: the newest three weekly means, since {}, are {} below the level {} of the {} before.",
        "{0}：自{1}起最近三个周平均值比此前{4}个的水平{3}低{2}。",
    ),
    (
        "{}: the rms of successive differences since {} is {}, without the most deviating record.",
        "{0}：自{1}以来去掉偏离最大的一个记录后，相邻差的均方根为{2}。",
    ),
    ("Stated standard deviations explain {}.", "给出的标准差可解释{0}。"),
    (
        "{} is {} above its last record before the environmental test ({} on {}).",
        "{0}比环境试验前最后一个记录（{2}，{3}）高{1}。",
    ),
    (
        "{} is {} below its last record before the environmental test ({} on {}).",
        "{0}比环境试验前最后一个记录（{2}，{3}）低{1}。",
    ),
    ("The test took from {} to {}.", "试验自{0}至{1}。"),
    ("{} = {} is inside {} to {}.", "{0} = {1}，在{2}至{3}范围。"),
    ("{} = {} is outside {} to {}.", "{0} = {1}，超出{2}至{3}范围。"),
    ("Also outside: {}.", "同样超出：{0}。"),
    ("Last calibrated on {}, {} days ago.", "上次标定于{0}，距今{1}天。"),
    ("{} +- {} pulse/arcsec", "{0} ± {1} pulse/arcsec"),
    ("{} +- {} pulse/(s g0)", "{0} ± {1} pulse/(s g0)"),
    ("{} +- {} deg/(h g0)", "{0} ± {1} (°)/(h·g0)"),
    ("{} deg/(h g0)", "{0} (°)/(h·g0)"),
    // As alerts that older versions have stored say it. What is added to all of it.
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
        "标准差为{0}，真值超差的概率{1}：不确定度跨越限值。",
    ),
    (
        "With a standard deviation of {} the true value exceeds it with a probability of {} %. {}",
        "标准差为{0}，真值超差的概率{1} %。{2}",
    ),
    (
        "With a standard deviation of {} the true value exceeds it with a probability of {} %.",
        "标准差为{0}，真值超差的概率{1} %。",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {}: the uncertainty straddles \
         the limit.",
        "标准差为{0}，真值超差的概率{1}：不确定度跨越限值。",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {} %. {}",
        "标准差为{0}，真值超差的概率{1} %。{2}",
    ),
    (
        "With a standard deviation of {} the true value lies beyond it with a probability of {} %.",
        "标准差为{0}，真值超差的概率{1} %。",
    ),
    ("No standard deviation is known: the figures are compared as they stand. {}", "标准差未知，按数值直接比较。{0}"),
    ("No standard deviation is known: the figures are compared as they stand.", "标准差未知，按数值直接比较。"),
    (
        "No single one is to blame: without the highest or the lowest it is exceeded too.",
        "并非由单个结果造成：去掉最高或最低值后仍超差。",
    ),
    ("A second campaign confirms it.", "第二次标定予以证实。"),
    ("more than {}", "大于{0}"),
    ("less than {}", "小于{0}"),
    ("days", "天"),
    ("standard deviations", "倍标准差"),
    ("deg/(h g0)", "(°)/(h·g0)"),
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
