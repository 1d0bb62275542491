# 履历诊断：系数数月间为何变化，测试站有何影响。

## 原因

cause_station = 测试站
cause_ageing = 老化
cause_step_at_event = 事件处阶跃
cause_re_mounting = 重新安装处阶跃
cause_temperature = 温度
cause_clocking = 电机轴绕输入轴转位
cause_wandering = 无原因的游走
cause_step = 无事件记录的阶跃

## 原因的依据

change_slope = 持续斜率
change_slope_until = { $day }修理之前的持续斜率
change_slope_after = { $day }修理之后的持续斜率
change_slope_since = { $day }起的持续斜率
change_event = { $day }的{ $event }
change_events = { $events }（其间没有记录，无法区分）
change_moved = 由{ $from }移至{ $to }
change_temperature = 以{ $mean }摄氏度为中心
change_temperature_gaps = 以{ $mean }摄氏度为中心；{ $missing }条记录无温度
change_station_offset = { $station }与{ $against }读数不同
change_station_drift = { $station }漂移
change_station_drift_since = { $station }自{ $day }起漂移
change_station_step = { $station }于{ $day }阶跃
change_station_between = { $station }自{ $from }至{ $until }期间偏离
station_unlike = 自{ $from }至{ $until }，其许多陀螺偏离且方向各异（{ $of }只中{ $gyros }只）：检查调平与轴向。
station_unlike_since = 自{ $from }起，其许多陀螺偏离且方向各异（{ $of }只中{ $gyros }只）：检查调平与轴向。
station_unlike_brief = { $of }只陀螺中{ $gyros }只，方向各异
change_station_unlike = 自{ $from }至{ $until }，{ $station }的{ $of }只陀螺中{ $gyros }只偏离，方向各异
change_station_unlike_since = 自{ $from }起，{ $station }的{ $of }只陀螺中{ $gyros }只偏离，方向各异
change_proportion = D_O与D_S成比例
change_instant = { $after }与{ $before }之间

## 候选原因未采用的理由

change_not_separable = 与已确定的原因无法区分
change_not_significant = 不显著（校正后p为{ $p }）
change_no_better_than_wandering = 不优于系数游走（p为{ $p }）
change_others_deny = 本陀螺{ $own }，该测试站其他{ $gyros }只陀螺为{ $others } ± { $sd }

## 对系数的结论

history_too_few = 仅有{ $records }条记录：数据不足，无法区分变化与标定散布。
history_of_a_day = 一天内的{ $records }条记录：时间太短，无法区分变化与标定散布。
history_looked_at = { $records }条记录中取{ $looked_at }条，均布于全部时间。
history_no_change = 变化未超出标定散布。
history_explained = 已解释，剩余为散布。
history_explained_by_step = 可用原因不明的阶跃描述，剩余为散布。
history_partly_explained = 部分解释：系数也可能有无记录原因的变化。
history_unexplained = 未解释：系数有变化，无记录的原因。
history_excess = 剩余变化为{ $sd } (°)/(h·g0)，而标定噪声为{ $expected }。
history_cause = { $cause }：{ $detail }，{ $value } ± { $sd } { $unit }
history_class = 现有记录无法将其与下列原因区分：{ $others }。
history_closure = 在留出的记录上解释了变化的{ $closure }（{ $low }至{ $high }）。
history_outlier_newest = { $day }的最新记录偏离此前记录{ $deviation }，未采用：仅凭一次记录无法区分阶跃与差错。
history_outlier = { $day }的记录偏离相邻记录{ $deviation }，未采用。
history_wander_random_walk = 游走：每根号年{ $size } (°)/(h·g0)。
history_wander_walk_by_record = 游走：每条记录{ $size } (°)/(h·g0)。
history_wander_flicker = 游走（1/f噪声）：共{ $size } (°)/(h·g0)。
history_due = 将于{ $day }达到允许范围（80 %：{ $early }至{ $late }）。
history_due_open = 将于{ $day }达到允许范围（80 %：{ $early }起，上限不定）。
history_calibrate_by = 请在{ $day }之前标定：只要变化仍为直线，此前以95 %的概率在允许范围内。
history_calibrate_now = 请立即标定：自{ $day }起不再以95 %的概率处于允许范围内。
history_due_past = 按其变化，已于{ $day }达到允许范围。
history_due_by_trend = （趋势规则按各周实测均值外推：{ $day }。）

## 测试站

title_no_such_station = 未知测试站
no_such_station = 没有测试站{ $name }
