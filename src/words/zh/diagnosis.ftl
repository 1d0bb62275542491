# 试验的诊断。

## 为什么不能诊断

too_many_dwells = { $dwells }个测点超出诊断上限（该陀螺数时为{ $most }个）：请对重复测点取平均，或只诊断其中一部分
no_degrees_of_freedom = { $dwells }个测点对模型的{ $parameters }个参数没有多余观测：无法检验模型
output_is_constant = { $slot }的输出在所有测点中相同
model_without_terms = 模型没有任何项

## 试验缺少什么

dwells_without_temperature = 测点没有温度数据，或有温度的测点不到一半
temperature_is_constant = 温度没有变化
dwells_without_attitude = 测点没有姿态数据
every_rate_is_zero = 所有指令角速度均为零

## Effects and competing hypotheses

effect_axial_compliance = 沿陀螺轴的柔性（D_II、D_SS）
effect_cross_compliance = 支承交叉柔性
effect_cubic_g = 与比力三次方有关的漂移
effect_output_axis_g = 沿输出轴比力引起的漂移
effect_mount_clocking = 陀螺绕输入轴转动安装
effect_hysteresis = 滞后（前一姿态）
effect_g_linear = 与比力成正比的漂移
effect_g_squared = 与比力平方有关的漂移
effect_scale = 标度因子与安装误差
effect_levelling = 转台未调平
effect_azimuth = 转台方位误差
effect_magnetic = 磁场敏感
effect_relevelling = 试验中转台重新调平
effect_reseating = IMU在夹具中重新安装
effect_warmup = 上电预热
effect_time_ramp = 零偏随时间漂移
effect_bias_step = 零偏跳变
effect_outlier_dwell = 个别测点异常
effect_periodic = 周期性扰动
effect_scale_asymmetry = 标度因子正反不对称
effect_scale_quadratic = 标度因子随角速度变化
effect_scale_cubic = 标度因子随角速度平方变化
effect_anisoinertia = 转动惯量不等
effect_g_rate_coupling = 比力与角速度的交叉耦合
effect_temperature_bias = 零偏随温度变化
effect_temperature_g = 与g有关的漂移随温度变化
effect_temperature_scale = 标度因子随温度变化
effect_curve_in_time = 随时间的平滑变化
effect_wander_in_time = 随时间的随机游走
effect_correlated_in_time = 相邻测点共有的噪声
effect_bend_in_time = 随时间的转折
effect_burst = 持续数个测点的短暂扰动
effect_drifting_mass_unbalance = 随时间变化的g敏感性
effect_drifting_scale = 随时间变化的标度因子
effect_part_time = 仅在部分时间起作用的效应
effect_rate_even = 角速度的偶函数
effect_rate_odd = 角速度的奇函数
effect_rate_curve = 沿输入轴角速度的平滑函数
effect_rate_and_force = 与姿态有关的标度因子
effect_static_to_rate = 静止与转动之间的差别
effect_torquer_heating = 对先前各角速度的记忆
effect_rate_before = 对前一角速度的记忆
effect_rate_product = 角速度的乘积
effect_bent_temperature = 随温度的转折
effect_temperature_rate = 对温度变化率的响应
effect_temperature_lag = 对温度的滞后响应
effect_temperature_and_time = 随时间变化的温度响应
effect_temperature_g_squared = 随温度变化的柔性
effect_orientation_harmonics = 高于二次的姿态函数
effect_friction = 与比力正反有关
effect_heading = 与转台方位有关
effect_earth_rate = 地球自转角速度北向分量的误差
effect_orientation_before = 对前一姿态的记忆
effect_stepping_mass_unbalance = 一次性变化的g敏感性
effect_stepping_scale = 一次性变化的标度因子
effect_lagging_sensitivity = 滞后于温度的标度因子或g敏感性
effect_settling_after_rate = 转台转动之后的稳定过程
effect_table_rate = 转台角速度有误（某一转向或某一速率）
effect_lever_arm = 杆臂：IMU不在转台轴线上
effect_drifting_table = 转台的倾斜或方位发生变化
effect_misalignment = 转台既未调平，方位也未对准

## What a campaign must hold for an effect to show

needed_for_axial_compliance = 斜置陀螺，且比力偏离本体轴的测点
needed_for_cross_compliance = 比力偏离本体轴的测点（45°棱边，30°与60°倾斜）
needed_for_cubic_g = 比力偏离本体轴的测点
needed_for_output_axis_g = D_S发生变化的历史中G的闭合差；测点残差永远看不到它
needed_for_mount_clocking = D_S发生变化的历史中G的闭合差；测点残差永远看不到它
needed_for_hysteresis = 同一姿态之前的姿态各不相同的测点次序
needed_for_g_linear = 至少三个独立的比力方向
needed_for_g_squared = 沿至少三个轴的比力；在1 g下有一个组合即为零偏
needed_for_scale = 绕三个轴的角速度
needed_for_levelling = 姿态数据，且每个面有多个方位
needed_for_azimuth = 姿态数据，且每个面有多个方位
needed_for_magnetic = 姿态数据与速率测点：否则它与地球自转无法区分
needed_for_relevelling = 姿态数据，且前后均有多个方位的测点
needed_for_reseating = 静态与速率测点，或前后均有多个面的测点
needed_for_warmup = 上电后不久的测点，时间常数之内应有数个
needed_for_time_ramp = 与比力、角速度、温度都不同步的测点次序
needed_for_bias_step = 跳变前后各有数个测点
needed_for_outlier_dwell = 足够多的测点，使拟合不依赖其中任何一个
needed_for_periodic = 周期大于测点间隔的两倍且短于整个试验
needed_for_scale_asymmetry = 正反两个方向的转动
needed_for_scale_quadratic = 正反两个方向各四个以上的角速度
needed_for_scale_cubic = 正反两个方向各四个以上的角速度
needed_for_anisoinertia = 转轴在I、S两轴上均有分量的角速度
needed_for_g_rate_coupling = 每个转轴正、反朝上各一次
needed_for_temperature_bias = 变化过程不同于时间的温度数据
needed_for_temperature_g = 在每组同类姿态之内都有变化的温度数据
needed_for_temperature_scale = 温度数据与速率测点
needed_for_ones_own = 使其方程与模型已有各项不同的测点

## Signs that more remains

sign_lack_of_fit = 拟合残差大于重复测量的离散
sign_spread = 残差的离散大于噪声
sign_neighbours_in_time = 相继的测点误差相似
sign_runs_in_time = 同一时段的测点误差相似
sign_same_specific_force = 比力相同的测点误差相似
sign_neighbouring_orientations = 姿态相邻的测点误差相似
sign_similar_rates = 角速度相近的测点误差相似
sign_same_orientation_before = 前一姿态相同的测点误差相似
sign_similar_temperatures = 温度相近的测点误差相似
sign_harmonics = 已命名的正弦含有谐波
sign_dwell_beside_structure = 除其他结构外，有一个测点异常
sign_several_bad_dwells = 不止一个测点异常
sign_one_shape_is_not_enough = 同一效应需以两个时刻或周期出现两次
sign_wandering_in_time = 一种或两种随时间的变化几乎可由一种漂移代替
sign_noise_with_memory = 噪声有记忆：零偏在测点之间游走
sign_not_constant = 已命名的效应在整个试验中不恒定
sign_commands_rounded = 所列原因可能只是指令值的舍入
sign_goes_with_a_variable = 残差随某个变量变化
sign_many_causes_at_once = 命名的效应多于解释差异所需
sign_tests_together = 单项检验均不显著，但合起来显著

## Why a candidate was not taken

design_does_not_show_it = 本次试验设计看不到该效应
one_class_with = 本次试验无法将其与“{ $effect }”区分，以后者代表两者
beyond_plausible_size = 其大小超出合理范围
not_significant = 不显著（校正后p = { $p }；要求 < { $level }）
closes_nothing_held_out = 对留出的测点没有任何改善
several_outlier_dwells = 有数个测点各自异常：这不是个别测点异常
not_with_noise_growth_open = 若不限定噪声随角速度的增长，它便不成立
not_in_joint_fit = 全部一起拟合后它不成立
not_in_joint_fit_beside = 在“{ $effect }”之外，全部一起拟合后它不成立
too_many_causes = 模型中已有{ $count }个原因：需要更多原因的差异尚未弄清
too_small_beside = 与“{ $effect }”相比它很小，可能只是后者拟合后的残余：请先消除后者，再重新诊断
explains_less_than = 它与“{ $effect }”解释的是同样的测点，但解释得较差，此外没有其他贡献
explained_outside_catalogue = 目录之外的“{ $effect }”能更好地解释同样的测点

## Why an effect cannot be identified

hard_to_tell_from_g_linear = 在这些测点中，与比力成正比的漂移占去其{ $share } %的能量（主角{ $angle }°）。其中恰好看不到的部分最多可使D_I、D_S偏移{ $sds }倍标准差
seen_in_closure_of_g_only = D_O·a_O包含在G之内，只在G的闭合差中显现
temperature_too_steady = 温度变化范围仅{ $span } K：小于{ $least } { $unit }时多半看不到，而陀螺通常不超过{ $most }
absorbed_by_model = 现用模型在本次试验的每个测点中都将其吸收
mostly_absorbed_by_model = 现用模型在本次试验的每个测点中吸收其能量，只剩{ $share }

## Notes of a diagnosis

noise_from_repeats_and_residuals = 未给出标准误差：噪声取自重复测量与残差
commands_rounded = { $of ->
    [force] 比力以{ $step } g0为步长给出：仅舍入就使{ $slot }达到一个测点噪声的{ $times }倍。请写出更多位数
    [sent] 角速度以{ $step } arcsec/s为步长给出，仅舍入就会使{ $slot }达到一个测点噪声的{ $times }倍：已代之以测试站的精确地球角速度。请写出更多位数
   *[rate] 角速度以{ $step } arcsec/s为步长给出：仅舍入就使{ $slot }达到一个测点噪声的{ $times }倍。请写出更多位数
}
no_pure_error = 没有重复的测点：无法用纯误差检验噪声
described_by = 剩余部分与{ $variable }有关；这是描述，不是原因
described_by_two = 剩余部分与{ $first }或{ $second }有关；这是描述，不是原因
variable_time = 时间
variable_temperature = 温度
variable_rate_of_temperature = 温度变化率
variable_up_direction = 朝上的方向
variable_heading = 方位
variable_rate_level = 角速度大小
variable_rate_axis = 角速度的轴与方向
variable_rate_history = 此前的角速度
variable_previous_orientation = 前一姿态
variable_orientation_age = 当前姿态已保持的时间
variable_phase = 静止或转动
variable_time_and_force = 时间与比力的共同作用
variable_time_and_rate = 时间与角速度的共同作用
variable_temperature_and_force = 温度与比力的共同作用
variable_temperature_and_rate = 温度与角速度的共同作用
variable_time_and_heading = 时间与方位的共同作用
variable_temperature_and_heading = 温度与方位的共同作用
variable_temperature_and_time = 温度与时间的共同作用
variable_single_dwells = 少数个别停留点
field_direction_untold = 场（{ $effect }）的方向不能确定：在这些测点中，其北向部分与E、G不可区分。因此不给出计入它之后的D_I与D_S；转动的测点或site.magnetic_field_nav可以确定方向
acts_in_part = { $effect }仅在部分试验中起作用：从{ $from }到{ $to } h
noise_shared = 各陀螺噪声相关：相关系数最高{ $correlation }
noise_memory = 噪声有记忆（概率{ $probability }）：游走约{ $size }度每小时
noise_of_duration = 噪声随时长的{ $power }次幂下降，而标准误差未反映
noise_of_rate = 最快角速度时噪声为静止时的{ $bound ->
        [least] { $times }倍或更大
        [most] { $times }倍或更小
       *[other] { $times }倍
    }，而标准误差未反映
noise_of_time = 结束时噪声为开始时的{ $bound ->
        [least] { $times }倍或更大
        [most] { $times }倍或更小
       *[other] { $times }倍
    }，而标准误差未反映
standard_errors_understated = { $slots }：输出（包括重复测点）的散布是给定标准误差的{ $times }倍。标准误差偏小，或随时间变化的并非噪声

## Against a reference

reference_of_other_imu = 参照标定属于IMU { $reference }，而本次试验属于{ $campaign }
reference_of_other_geometry = 参照标定与本次试验的构型不同
reference_without_gyro = 参照标定在{ $slot }处没有陀螺，而本次试验中为{ $serial }
reference_with_other_gyro = 参照标定在{ $slot }处为陀螺{ $reference }，而本次试验中为{ $campaign }
bench_test_has_no_reference = 单表测试不与参照标定比较
nothing_in_common = 参照标定不能确定现用模型的任何参数
e_is_held = { $slot }：本次试验中E保持不变，不作比较
not_determined_by_reference = { $slot }：参照标定不能确定{ $parameters }，已重新拟合
effects_fitted_anew = 现用模型中的效应在每次试验中重新拟合，不作比较
reference_without_noise_of_d0 = 参照为标定记录：没有给出D0与P的噪声
reference_taken_as_exact = 参照标定没有给出标准差：视为准确值

## IMU模型与预报

no_campaign_to_fit = 没有可供拟合的试验
bench_test_has_no_model = 单表试验不能建立IMU模型
campaigns_of_other_imu = 试验分属IMU { $first }与{ $other }
campaigns_of_other_geometry = 各次试验的构型不同：请去掉其一，或更正其geometry
campaigns_of_other_gyro = { $slot }先为{ $first }，后为{ $other }：一个模型只含同一组陀螺
campaigns_of_other_gyros = 各次试验中陀螺的安装位置不同：请去掉其一
campaigns_of_other_held = 各次试验给定的{ $slot }的E（known_e_pulse_per_arcsec）不同：请去掉其一，或都拟合E
campaigns_of_one_instant = 有两次试验的时间相同：请去掉其一，或更正其measured_at
model_without_noise = { $slot }：噪声无从得知：没有标准误差，没有重复测点，也没有多余测点
nothing_to_foretell_from = 此前没有装有同一组陀螺的试验：无从预报
model_of_other_imu = 模型属于IMU { $model }，而本次试验属于{ $campaign }
model_of_other_geometry = 模型与本次试验的构型不同
bench_test_has_no_forecast = 单表试验没有预报
model_without_gyros = 本次试验的陀螺均不在模型中
model_is_of_imu = 系数属于IMU { $model }，不属于 { $imu }；去掉 identified 后可采用其各项与效应
model_fitted_to_campaign = 模型即由本次试验拟合得到，不构成预报
effect_not_foretold = { $effect }未计入预报：{ $why }
effect_of_other_station = { $effect }未计入预报：该效应在另一测试站发现
effect_of_ones_own = { $words }
gyro_exchanged_since = { $slot }原为{ $then }，现为{ $now }：未计入预报
gyro_not_in_model = { $slot }（{ $serial }）不在模型中：未计入预报
temperature_outside_model = 超出模型范围：{ $least }至{ $most } °C；模型的试验为{ $low }至{ $high } °C
rate_outside_model = 超出模型范围：速率达{ $now } arcsec/s；模型的试验最大为{ $seen }
attitudes_outside_model = 超出模型范围：{ $dwells }个测点的姿态与模型试验的任一姿态相差20°以上
campaign_before_model = 本次试验早于模型
ageing_unknown = 仅有一次试验，不能说明系数逐次的变化：标准差中未计入此项
model_found_in_other_imu = 模型属于IMU { $model }；其效应在{ $campaign }的本次试验中重新拟合
model_found_in_other_gyro = 建立模型时{ $slot }为{ $then }，现为{ $now }：效应对其重新拟合
model_of_other_gyros = 与该IMU最近一次试验不符：{ $why }
covariance_is_no_triangle = 应为{ $need }行的下三角，实为{ $have }行，或行长不符
covariance_is_not_positive = 不是协方差：存在负特征值
sd_is_not_of_covariance = 与协方差中相应位置的平方根不符
gyro_without_noise_or_scale = E与噪声应大于零
span_is_reversed = 第一个值{ $low }大于第二个值{ $high }：应依次给出最低值与最高值
reference_was_not_seen = 超出其标定的温度范围（{ $low }至{ $high } °C）：应以gyrowatch model fit重新拟合模型
reference_without_temperatures = 其标定没有温度（/identified/validity/temperature_c）：应删去
is_not_the_coefficient = 与/identified/coefficients中的系数{ $name }不一致：应以gyrowatch model fit重新拟合模型

## What noise is known from

noise_sem = 标准误差
noise_repeats_sem = 标准误差与重复测量
noise_repeats_residuals_sem = 标准误差、重复测量与残差
noise_residuals_sem = 标准误差与残差
noise_repeats = 重复测量
noise_residuals = 残差
noise_repeats_residual = 重复测量与残差
noise_residual = 残差
noise_stated = 给定值
noise_none = 无

## What a diagnosis comes to

diagnosis_no_gap = 没有差异：模型对本次试验拟合后，残差不超过噪声。
diagnosis_explained = 差异已由下列原因解释，残差已达噪声底。
diagnosis_partly_explained = 差异部分由下列原因解释，仍有显著残差。
diagnosis_unexplained = 差异未得到解释：目录中没有能说明它的效应。
diagnosis_by_pattern = 残差并不大于噪声所应留下的残差。差异体现在残差随测点的形态上，而不是大小上。

## 记录的闭合差说明什么

closure_without_deviations = 记录未给出E与G的标准差：闭合差超出允许范围即计入
closure_is_not_tested = 每个陀螺仅有的一个数由其自身闭合：没有可留出的数据，本记录对两种解释均未作检验
closure_of_change = { $slot } { $change }
closure_after_change = 在D_S变化后（{ $changes } (°)/(h·g0)）再次标定：转角引起的D_O随D_S按比例变化，真实的D_O不变；陀螺自身的诊断据其履历检验这一点
closure_seated_again = 拆下陀螺重新安装并重新标定IMU：安装座的转角随重新安装而改变，真实的D_O保持不变
closure_on_bench = 在以壳体基准面定S轴的夹具上作单表测试：得到陀螺自身轴系中的D_S与D_O

## 未应验的预报

campaign_outside_forecast = 本次试验超出预报：{ $slot } 误差与标准差之比的均方根 { $rms }，各陀螺合计 p { $p }。模型之外的某项已改变。
campaign_outside_forecast_changed = 本次试验超出预报：{ $slot } 误差与标准差之比的均方根 { $rms }，各陀螺合计 p { $p }。已采用的系数已改变：{ $effects }。
