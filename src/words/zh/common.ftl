# 各处共用。代码与接口中的相同，含义不再更改。

beside = { $first }与{ $second }

measured = { $value } { $unit }
measured_with_sd = { $value } ± { $sd } { $unit }
unit_drift = (°)/(h·g0)
unit_drift_a_year = (°)/(h·g0)/年
unit_drift_a_kelvin = (°)/(h·g0)/K
unit_days = 天
unit_standard_deviations = 倍标准差
unit_pulse_per_arcsec = pulse/arcsec
unit_pulse_per_second = pulse/(s·g0)

status_in_tolerance = 合格
status_not_enough_data = 数据不足
status_too_uncertain = 不确定度过大
status_borderline = 临界
status_overdue = 超期
status_drifting = 漂移预警
status_unconfirmed = 待复测
status_out_of_tolerance = 超差
status_confirmed = 已证实

severity_warning = 预警
severity_critical = 严重

event_baseline = 新基线
event_repair = 修理
event_reinstallation = 重新安装
event_transport = 运输
event_firmware = 固件更新
event_note = 备注
event_environmental_test = 环境试验
event_retired = 退役
event_in_storage = 入库
event_decision_release = 决定：放行
event_decision_retest = 决定：复测
event_decision_remove = 决定：拆下
event_decision_withdrawn = 决定：撤回上一决定

method_rigid = 刚体法
method_published = 论文公式(8)-(13)
method_separation = 分离
method_torque_feedback = 力矩反馈
method_turntable_servo = 转台伺服
