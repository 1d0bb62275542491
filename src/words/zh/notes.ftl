# 采用前须知。

no_attitudes = 没有姿态列：比力与角速度未与姿态核对
no_site = 未给出测试站位置：静态测点的比力按标准重力核对；当地重力相差0.1 %，D_I、D_S即差同样比例
no_line_end = 末行（第{ $line }行）没有换行符：若文件在此被截断，则最后一个数不是{ $value }；请与测试站核对
no_temperatures = 没有温度列：看不到温度效应
withdrawn = 已存储，但不再计入：已作废、被搁置，或已被另一份替代

some_attitudes_missing = { $of }个测点中有{ $count }个没有姿态（{ $dwells }）：这些测点未与姿态核对，且看不到测试站的效应
temperatures_missing = { $of }个测点中有{ $count }个没有温度（{ $dwells }）：取自相邻测点
temperatures_mostly_missing = { $of }个测点中有{ $count }个没有温度（{ $dwells }）：有温度的测点过少，看不到温度效应
standard_errors_missing = { $of }个测点中有{ $count }个没有标准误差（{ $dwells }）：按其余测点的标准误差随时长与角速度的规律补足
and_more = { $named }，另有{ $more }个
temperature_outlier = /dwells/{ $dwell }的温度为{ $celsius } °C，而本次试验的中位数为{ $median } °C：视为传感器的故障值，不计入温度效应
time_unit = 测点时长的中位数为{ $median } s：start_s和duration_s是否以秒为单位？与时间有关的结果会差同样的倍数
time_unit_of_turns = 测点时长的中位数为{ $median } s，转动测点最多只转{ $turn }度，而应为整圈：start_s和duration_s是否以秒为单位？与时间有关的结果会差同样的倍数
temperature_unit = 温度的中位数为{ $median } °C：是否以K或°F为单位？
rate_not_of_attitude = { $of }个静态测点中有{ $off }个的rate_arcsec_s不等于该姿态与测试站纬度下的地球自转角速度：/dwells/{ $dwell }处相差{ $most } arcsec/s
dwells_contradict = { $dwells }的输出与其余各测点矛盾，相差达{ $most } arcsec/s：符号有误、故障值，或行的位置有误？请更正或去掉这些测点后重新发送
output_stuck = { $slot }：自{ $first }起连续{ $count }个测点的输出完全相同（{ $value } pulse/s），而由其余测点拟合的模型预计其有变化：输出是否停滞？请去掉这些测点后重新发送
outputs_coarse = { $slot }：输出以{ $step } pulse/s为步长，仅此即为测点噪声的{ $times }倍，重复测点会落在同一步上。请加长测量或细化计数
no_standard_errors = 没有标准误差：各测点等权，噪声由残差给出
no_repeats = 没有重复测点：只能凭拟合本身区分噪声与模型未含的部分
product_aliased = 未拟合{ $product }，且这些位置无法将其与{ $coefficient }区分：0.01 (°)/(h·g0²)的该项会使{ $coefficient }变化{ $moves } { $coefficient ->
        [D_F] (°)/h
        [D_II] (°)/(h·g0²)
        [D_SS] (°)/(h·g0²)
       *[other] (°)/(h·g0)
    }
cubic_moves = { $cubic }使{ $coefficient }变化{ $moves }
cubic_aliased = 未拟合三次项。每项取{ $size } (°)/(h·g0³)时会被计入D_I、D_S，以(°)/(h·g0)计：{ $moved }
drift_aliased = 位置随时间有规律地变化：每小时{ $drift } (°)/h的漂移会隐藏在各系数中，使D_I变化{ $d_i }、D_S变化{ $d_s } (°)/(h·g0)。请按随机顺序测量
drift_aliased_of_gyro = { $slot }：姿态随时间有规律地变化：整个试验中{ $drift } (°)/h的漂移小到无法察觉，却会使D_I变化{ $d_i }、D_S变化{ $d_s } (°)/(h·g0)。请按随机顺序测量
d_f_in_gauge = D_F以D_II + D_SS = 0为前提，绕输出轴的翻滚无法检验：两者之和每有0.01 (°)/(h·g0²)，D_F即变化{ $moves } (°)/h，标准差未计入
noise_grows_with_rate = 最高角速度下的残差为静止时的{ $times }倍；标准差随之变化
residuals_shared = 各陀螺残差相关：相关系数最高{ $correlation }。它们共有噪声，或有模型遗漏的效应
residuals_remember = 时间相近的残差相关（概率{ $probability }），幅度约{ $size }度每小时：噪声有记忆，或有模型遗漏的效应；标准差已计入
standard_errors_overstated = 给定的标准误差大于测点的实际散布（{ $gyros }）：若其有误，以其为据的标准差偏大，且小的差异可能无法发现
overstated_times = { $slot }为{ $times }倍
overstated_by_far = { $slot }远大于
standard_errors_scatter = 给定的标准误差相对时长与角速度的规律散布{ $percent } %，而残差更符合该规律：每个标准误差只由少数值估计，权值已向该规律靠拢
residuals_exceed_noise = { $slots }：残差大于噪声，模型有所遗漏（见诊断）
residuals_exceed_noise_or_law = { $slots }：残差大于给定的噪声。或者{ $law }，或者模型有所遗漏（见诊断）
effect_left_out = { $effect }未参与拟合：{ $why }
effect_left_out_of_gyro = { $slot }：{ $effect }未参与拟合：{ $why }
effect_contradicted = { $slot }：这些测点与模型中的{ $effect }矛盾，自身又不如模型确定得准：参考温度下D_I、D_S的不确定度随之增大。请采用包含这些测点的模型
effect_at_reference = { $effect }在参考温度下不为零，且不属于模型(6)的漂移：D_I、D_S未计入这一部分
station_contradicted = 残差形似一个转动（{ $part }），为测试站给定值（{ $stated } arcsec）的{ $times }倍；标准差已按此大小计入
station_left_out = 标准差未计入给定的测试站不确定度（{ $parts }）：{ $why }
station_needs_scale = { $slot }的E既未给定也不能确定
effects_left_out = 模型中的附加效应未计入：{ $why }
held_as_in_model = 取模型中的值，这些测点不能更准确地确定它
any_temperature = 未给出温度，而模型已知其影响：标准差已计入-40至85 °C间任一温度的影响。请给出temperature_c
any_temperature_of_record = 未给出温度，而IMU模型将D_I、D_S归算到一个温度：标准差已计入-40至85 °C间任一温度的影响。请给出temperature_c
not_restated = { $slot }：D_I、D_S保持测量值：IMU模型中的{ $effect }属于另一陀螺，或为各陀螺共有
not_told_apart = 这些测点不能将其与其他项区分
north_part_not_told = 仅其北向部分，这些测点不能将其与E、G区分
latitude_sign = 各陀螺的D_I均接近{ $shift } (°)/(h·g0)，恰为纬度正负号有误所致：测试站在北纬（+）还是南纬（-）？
gravity_off = 静态测点的|specific_force_g0|与测试站重力相差{ $percent } %（负号为偏小）：D_I、D_S反向差同样比例，最大{ $moves } (°)/(h·g0)（{ $slot }）
latitude_off = 静态测点的rate_arcsec_s对应纬度{ $degrees } °，与测试站所给纬度不符：若角速度有误，D_I即差{ $moves } (°)/(h·g0)
held_scale = E的方向取给定值，视为准确：若差{ $arcsec } arcsec，D_I或D_S即变化{ $moves } (°)/(h·g0)（{ $slot }）。请在station_uncertainty.fixture_arcsec中给出其不确定度
held_scale_size = |E|取给定值，视为准确：若差{ $percent } %，D_I或D_S即变化{ $moves } (°)/(h·g0)（{ $slot }），标准差未计入
nominal_axis = { $slot }：本次试验不能确定E；采用标称输入轴与{ $scale } pulse/arcsec

time_near_epoch = 时间接近{ $epoch }，即未校时时钟的起点：暂不计入，待确认时间
time_far_from_others = 时间与其陀螺的其他记录相差数十年（最近的记录为{ $nearest }）：暂不计入，待确认时间
earlier_in_doubt = 更早的记录时间存疑，已暂不计入
others_set_aside = 更早的记录比本记录早数十年，已暂不计入，待确认其时间：{ $records }
record_of_day = { $record }（{ $day }）
suspect = { $station }在该时段的测量存疑（{ $author }：{ $reason }）：暂不计入，待人工确认
same_time_set_aside = 同一IMU、同一时间另有内容不同的记录暂不计入，其中只能计入一条：{ $records }
ahead_of_now = 时间比服务时钟超前{ $hours }小时：测试站时钟是否正确？
year_in_doubt = 时间远早于其陀螺的最新记录；若为{ $year }年则为最新：年份是否正确？
new_serial = { $serial }首次出现于{ $slot }，该位置此前为{ $had }
new_serial_like = { $serial }首次出现于{ $slot }，该位置此前为{ $had }；最接近的已知编号为{ $nearest }
look_alike = { $of ->
    [imu] 新IMU编号{ $name }与已知IMU编号{ $known }形似
    [station] 新测试站名{ $name }与已知测试站名{ $known }形似
   *[serial] 新陀螺编号{ $name }与已知陀螺编号{ $known }形似
}
serials_exchanged = 陀螺编号互换：{ $fits }
figures_of = { $serial }的数据属于{ $other }
other_unit = 全部陀螺（{ $serials }）同时偏离各自上次水平{ $budgets }个允许值以上：是否为另一套IMU的数据、采用了别的单位，或测试地点的纬度或其正负号有误？
identical_figures = { $serials }：与{ $at }的记录{ $record }逐位相同；是否为同一次测量改了时间？
unit_factor = { $serials }的{ $quantity }为此前的{ $times }倍：单位是否有误？
unit_factor_of = { $serials }的{ $quantity }为此前的{ $times }倍：单位是否为{ $unit }？
sign_reversed = { $serials }的{ $quantity }与此前符号相反：输出或比力是否取反？
uncertainty_factor = { $serials }给出的标准差为此前的{ $times }倍：e_sd或g_sd的单位是否有误？
overlaps_in_time = { $serials }：与{ $at }的测试{ $record }时间重叠。时间或陀螺编号是否有误？
another_gyro = { $serials }的D_I、D_S均偏离上次水平{ $budgets }个允许值以上：是否为另一只陀螺使用了同一编号？
moved = { $serial }上次记录时在{ $from_imu } { $from_slot }，现在{ $to_imu } { $to_slot }
