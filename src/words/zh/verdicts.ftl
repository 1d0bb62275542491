# 判定的理由：先是规则所见，再是限值，最后是确定程度。

in_tolerance = 合格。
no_trend = 未见趋势。
no_trend_but_step = 未见趋势，阶跃更能解释。

too_few = { $name }：“{ $rule }”数据不足，需要{ $need }{ $of ->
    [results] 个结果
    [weeks] 个有记录的周
   *[records] 个记录
}，现有{ $have }个。
too_few_within = { $name }：“{ $rule }”数据不足，需要{ $days }天内{ $need }个结果，现有{ $have }个。
too_few_since_moved = { $name }：陀螺在{ $since }之前换到另一IMU或位置。新水平需要{ $need }个记录，现有{ $have }个。

step = { $name }比此前记录（中位数{ $level }）{ $side ->
    [below] 低
   *[above] 高
}{ $value }。
range = { $name }自{ $since }以来{ $records }个记录的极差为{ $value }：{ $lowest }（{ $lowest_at }）与{ $highest }（{ $highest_at }）。
baseline = { $name }比基线{ $level }（{ $origin }）{ $side ->
    [below] 低
   *[above] 高
}{ $value }。
level_from = 自{ $since }起三个记录的中位数
level_fixed = 固定
closure = { $name }比基线{ $level }（{ $origin }）{ $side ->
    [below] 低
   *[above] 高
}{ $value }。
closure_moved = 该水平自陀螺换到另一IMU或位置起算。
closure_turn = 相当于绕输入轴转动{ $turn }角分。
closure_cause = 更可能是安装变化或输出轴项，而非D_I或D_S。
trend = { $name }每年漂移{ $rate }（{ $since }至{ $until }的{ $cells }个周平均值）。
trend_passed = 已超出允许范围。
trend_reaches = 约在{ $at }达到允许范围（95 %：{ $first }至{ $last }）。
never = 永不
trend_ahead = 现偏离基线{ $deviation }，{ $days }天后为{ $value }。
trend_provisional = 日期为暂定：变化过程短于24个周平均值。
trend_default_noise = 噪声常数为默认值，并非由本机群拟合。
shift = { $name }：自{ $since }起最近三个周平均值比此前{ $before }个的水平{ $level }{ $side ->
    [below] 低
   *[above] 高
}{ $value }。
rms_successive = { $name }：自{ $since }以来去掉偏离最大的一个记录后，相邻差的均方根为{ $value }。
rms_explained = 给出的标准差可解释{ $explained }。
before_after = { $name }比环境试验前最后一个记录（{ $level }，{ $at }）{ $side ->
    [below] 低
   *[above] 高
}{ $value }。试验自{ $from }至{ $until }。
station_shift = { $imus }个IMU { $gyros }个陀螺的{ $name }中位数比各自基线{ $side ->
    [below] 低
   *[above] 高
}{ $value }（{ $since }至{ $until }）。原因在测试站，或在这些陀螺的共同之处。
batch_shift = 本批次{ $imus }个IMU { $gyros }个陀螺的{ $name }中位数比各自基线{ $side ->
    [below] 低
   *[above] 高
}{ $value }（{ $since }至{ $until }）。
batch_beside_others = { $days }天内标定的其他陀螺，中位数偏离不到其一半。
imu_shift = IMU的全部{ $gyros }个陀螺的{ $name }同时偏离各自基线，至少{ $value }。原因在IMU、其安装或该次标定，而不在某一个陀螺。
forecast = { $slot }与已采用模型的预报相差最大，均方根为{ $value }（全部陀螺 p { $p }）。
forecast_dwell = 偏离最大的是第{ $dwell }个测点，{ $z }倍标准差。
between_stations = 其标准差中{ $sd }为测试站之间的复现性。
whole_budget = 偏移超出整个允许范围。
agreement = { $name }的{ $results }个结果极差为{ $value }：{ $lowest }与{ $highest }。
result_of_method = { $value }（{ $method }，{ $at }）
requirement = { $figure } = { $value }，{ $place ->
    [inside] 在
   *[outside] 超出
}{ $low }至{ $high }范围。
requirement_others = 同样超出：{ $figures }。
overdue = 上次标定于{ $last }，距今{ $days }天。

limit_is = 限值为{ $limit }（{ $from }）。
limit_exceeded = 限值为{ $limit }（{ $from }），为其{ $percent } %。
limit_of_three_sd = 限值为{ $limit }（三倍标准差；下限{ $least }由{ $from }得出）。
limits_from = 限值来自{ $from }。
limit_of_forecast = 限值为{ $limit }：{ $percent } %的标定因偶然超出。

second_campaign = 第二次标定已证实。
second_campaign_of_one = 其中一个陀螺已由第二次标定证实。
not_a_single_result = 并非由单个结果造成。
too_uncertain = 不确定度过大，无法判断：标准差{ $sd }，限值{ $limit }。
too_uncertain_for_shift = 不确定度过大，无法判断：三倍标准差大于允许范围。
probability_beyond = 超差概率{ $percent } %。
no_standard_deviation = 标准差未知，按数值直接比较。
held_within = 已回到限值之内：一次标定低于{ $below }（限值的{ $percent } %），或{ $campaigns }次标定在限值之内，告警才结束。
held_requirement = 已回到要求之内：{ $campaigns }次标定符合要求，告警才结束。
held_undecided = 已不能确定：一次标定在限值之内，告警才结束。
forecast_unseen = 无法判断：模型未见过{ $what }。
forecast_beyond_plausible = 模型未见过{ $what }，但合理大小的效应外推不到这么远。
forecast_wide = 无法判断：D_I、D_S的阶跃达到{ $step }才必然可见。
forecast_says_nothing = 无法判断：D_I、D_S的任何阶跃都不可见。
forecast_of_one_campaign = 模型仅来自一次标定：差异可能只是各次标定之间的通常变化。
unseen_temperature_outside_model = 这样的温度
unseen_rate_outside_model = 这样的转速
unseen_attitudes_outside_model = 这样的姿态
unseen_campaign_before_model = 它之前的情况
unseen_effect_not_foretold = 其某个效应所需的量
unseen_effect_of_other_station = 这个测试站

decided_before = 按当时判定；此后限值或履历已变化。
does_not_count = 不再计入：该记录已作废或修订。
does_not_count_yet = 暂不计入：待人工确认。

rule_step = 相邻变化
rule_range = 极差
rule_baseline = 偏离基线
rule_trend = 趋势
rule_cusum = 累积和
rule_rms_successive = 离散
rule_closure = 闭合差
rule_agreement = 方法一致性
rule_requirement = 指标要求
rule_overdue = 超期
rule_shift = 持续偏移
rule_before_after = 试验前后
rule_station_shift = 测试站偏移
rule_forecast = 预报
rule_imu_shift = IMU偏移
rule_batch_shift = 批次偏移

# 推送的一行。
alert_fires = { $serial }：{ $coefficient } { $rule } 告警（{ $severity }）
mail_test = 钩子{ $hook }的测试：一切正常
alert_is_resolved = { $serial }：{ $coefficient } { $rule } 已恢复

# 行首的数值。
share_of_limit = 限值的{ $percent } %
in_days = { $days }天后

# 由判定得出的建议，由人决定。
suggestion_release = 放行：凡可判定的规则均合格。
suggestion_more_records = 再次标定：记录过少，无法判定，或尚无基线。
suggestion_check_record = 先核对最新记录，有误则修订或作废：编号可能写错，或其数值可能属于另一只陀螺，或采用了别的单位。
suggestion_check_station = 先检查测试站：变化归因于测试站，它所测的其他陀螺也随之变化。
suggestion_calibrate = 标定：已超过标定间隔。
suggestion_lower_uncertainty = 以更小的不确定度再次标定：目前无法判定。
suggestion_find_cause = 查明变化原因：陀螺的离散大于各次记录的不确定度，减小不确定度也无法判定。
suggestion_retest = 复测：再做一次标定即可判定。
suggestion_shorten_interval = 提前标定：下次标定前可能达到允许范围。
suggestion_calibrate_now = 立即标定：按其变化，不再以95 %的概率处于允许范围内。
suggestion_watch = 继续观察：在允许范围内漂移。
suggestion_check_mounting = 检查安装：仅D_O超差。若曾重新安装，请记录；否则复测。
suggestion_remove = 拆下：没有稳定的水平。
suggestion_remove_or_accept = 拆下。若仅跳变一次且此后稳定，可认可新水平：注明原因开始新基线。
suggestion_accept_or_remove = 认可新水平（注明原因开始新基线），或拆下：已记录的事件可解释其变化。
