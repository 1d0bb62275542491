# 文档中的错误，按代码。

## Tables

no_table = 没有表格：“# 键: 值”各行之下应有一行列名，其后每个测点一行
table_unreadable = 表格无法读取：{ $why }
not_a_number = “{ $value }”不是数
decimal_comma = “{ $value }”用逗号作小数点；小数点请用“.”
not_finite = 应为有限数，实为“{ $value }”
not_slot_and_serial = “{ $text }”不是“位置 编号”的形式，例如 G1 LFG-0101
utf16 = 文件为UTF-16；请另存为UTF-8（表格软件中的“CSV UTF-8”）
not_utf8_text = 不是UTF-8文本：请另存为UTF-8（表格软件中的“CSV UTF-8”）
not_utf8_from = 从第{ $byte }字节起不是UTF-8
not_utf8 = 不是UTF-8：{ $why }

## Names, texts, times

empty_text = 不能为空
too_many_characters = 最多{ $most }个字符，实有{ $have }个
control_character = 不能含有控制字符{ $character }
invisible_character = 不能含有不可见字符{ $character }；请重新输入名称
not_day_or_rfc3339 = 应为日期（UTC），例如 2026-03-01，或RFC 3339时间，例如 2026-03-01T16:00:00+08:00
not_rfc3339 = 应为RFC 3339时间，例如 2026-03-01T08:00:00Z 或 2026-03-01T16:00:00+08:00
no_utc_offset = 应注明与UTC的时差：Z，或例如 +08:00
utc_offset_range = 与UTC的时差应在-23:59与+23:59之间
not_in_calendar = 不是历法中的日期与时间
before_year_0 = 不能早于UTC公元0年
no_leap_second = 该时刻没有闰秒，却写了第60秒
after_last_time = 晚于{ $last }，即可存储的最晚时间
before_earliest = 早于{ $earliest }，即`plausibility.earliest`所接受的最早时间
clock_never_set = 为未校时、自1970-01-01起计的时钟所给；请校正测试站时钟后按真实时间发送，或从`plausibility.clock_epochs`中去掉该日期
time_in_future = 比服务时钟超前{ $hours }小时以上

## Numbers

wrong_length = 应有{ $need }个元素，实有{ $have }个
magnitude_at_most = 应为绝对值不超过{ $most }的有限数，实为{ $value }
temperature_range = 应为-273.15至1000 °C之间的温度，实为{ $value }
deviation_range = 应为0至{ $most }之间的标准差，实为{ $value }
latitude_range = 应在-90与90之间，实为{ $value }
station_uncertainty_range = 应为0至{ $most }角秒的标准不确定度，实为{ $value }
gravity_range = 应为以g0（9.80665 m/s²）计的当地重力，0.9至1.1，实为{ $value }
gravity_of_no_place = 是{ $value } g0，纬度{ $latitude }°处没有这样的重力：该处正常重力为{ $normal } g0，可接受{ $least }至{ $most }。请写当地重力（m/s²）除以9.80665的值，或改正纬度
no_direction = 应有方向
not_unit_vector = 应为单位矢量，其长度为{ $length }
not_perpendicular = 应与输入轴垂直，实际夹角为{ $angle }°
not_unit_quaternion = 应为单位四元数[w, x, y, z]，其模为{ $length }
scale_factor_range = |E| = { $norm } pulse/arcsec，超出{ $low }至{ $high }（由`plausibility.min_scale_factor`与`plausibility.max_scale_factor`规定）；单位是否不同？
direction_of_another = 其方向偏离构型给{ $slot }规定的输入轴{ $angle }°，最多允许{ $most }°；它与{ $other }的输入轴相符：是否互换了？
direction_off_axis = 其方向偏离构型给{ $slot }规定的输入轴{ $angle }°，最多允许{ $most }°
drift_range = |G/E| = { $value } (°)/(h·g0)，超出{ $most }（由`plausibility.max_drift_deg_per_h_g0`规定）；单位是否不同？
coefficient_range = { $value } (°)/(h·g0)超出{ $most }（由`plausibility.max_drift_deg_per_h_g0`规定）；单位是否不同？
baseline_range = 绝对值应不超过{ $most } (°)/(h·g0)，实为{ $value }
not_positive = 应为正数，实为{ $value }
negative = 不能为负，实为{ $value }
negative_start = 不能为负（从第一个测点起计），实为{ $value }
sem_not_positive = 标准误差应为正（至少{ $least } pulse/s），实为{ $value }

## Gyros and campaigns

gyros_one_to_three = 应有一至三个陀螺，实有{ $have }个
slot_taken = { $slot }已被{ $place }占用
serial_taken = { $serial }已在{ $place }中列出
named_twice = { $name }重复列出
no_axes_for = 构型没有给出{ $slot }的轴
unknown_slot = 应为G1、G2或G3，实为“{ $value }”
unknown_test = 未知的试验“{ $value }”；试验种类为imu、torque_feedback、turntable_servo
bench_one_gyro = { $test }试验只有一个陀螺，此处有{ $have }个
unknown_term = 未知的项“{ $value }”；可用的项为bias、g_linear、g_squared、scale
no_terms = 至少应列出一项
unknown_phase = 应为static或rate，实为“{ $value }”
no_dwells = 至少应有一个测点
out_of_time_order = 时间次序有误：始于{ $start } s，而{ $place }始于{ $earlier } s
overlaps = 与{ $place }重叠：始于{ $start } s，而后者终于{ $end } s
force_not_gravity = 静态测点中其长度为{ $length } g0；{ $reference }为{ $gravity } g0，允许偏差{ $percent } %
static_too_fast = { $rate } arcsec/s对静态测点过快（地球自转为15.04）；阶段是否应为rate？
attitude_contradicts_force = 与比力矛盾：由它得到的垂线偏离specific_force_g0 { $angle }°（v_body = C(q) v_nav，导航系为东北天）
rates_inertial_or_table = 应为inertial或table之一，实为“{ $value }”
earth_rate_needs = 已知测试站位置与姿态时，服务才能加上地球自转；缺少：{ $missing }
attitudes_missing = { $count }个静态测点的姿态，首个为{ $first }
missing_member = 缺少`{ $member }`
no_drift_stated = 缺少`g_pulse_per_s_g0`（或已除以|E|的`g_deg_per_h_g0`）
two_drifts_stated = `g_pulse_per_s_g0`与`g_deg_per_h_g0`只能给出一个
axes_stated_twice = 轴或按位置给出，或为夹具给出一次，不能兼有
missing_beside = 给出`{ $member }`时也必须给出

## Bench tests

is_no_bench_test = 不是单表测试
is_bench_test = 是单表测试，不能代替系统级标定试验

## Models

effect_without_size = { $effect }没有合理大小的上限；有上限的效应：{ $effects }
unknown_effect = 目录中没有效应“{ $effect }”；可选：{ $effects }
no_gyros_named = 至少应列出一个陀螺
must_be = 应为{ $wanted }，实为“{ $value }”
must_be_one_of = 应为{ $known }之一，实为“{ $value }”
shape_for = { $effect }应为{ $wanted }
shape_not_finite = 应为有限数，且时间常数或周期应为正

## Events, baselines, silences

nothing_fixed = 应给出D_I、D_S或两者
goes_with = 须与{ $member }同时给出
baseline_reason = 应说明对陀螺做了什么
only_environmental = 只用于environmental_test，不用于{ $event }
which_test = 应说明是哪种试验，如振动或温度循环
test_end = 应给出试验结束时间
end_before_begin = 早于试验开始时间
to_before_from = 早于from
silence_matches_nothing = 至少应给出serial、imu、station、rule之一：不能一次静默全部告警
unknown_rule = 没有规则“{ $rule }”
not_in_future = 应为将来的时间
station_of_role = 仅对角色{ $of }的令牌起限制作用：角色{ $role }不限于某一测试站，请不要给出
until_before_since = 不应早于起始时间

## Hooks

expected_members = 应有1至{ $most }个成员，如{"{"}"errcode": 0{"}"}
expected_pair = 应为“成员 = 值”，如errcode = 0；所给为{ $given }
too_many_entries = 最多{ $most }项，实有{ $have }项
unknown_severity = 应为warning或critical
secret_is_drawn = 由服务生成密钥，不能再给出secret
authorization_form = 应为1至{ $most }个可见ASCII字符
no_secret_drawn = 无法生成密钥，请自行给出：{ $why }
secret_prefix = 应以{ $prefix }开头
secret_base64 = { $prefix }之后应为base64
secret_length = 密钥应为{ $least }至{ $most }字节，实为{ $have }字节
url_too_long = 最多{ $most }个字符
not_a_url = 不是网址：{ $why }
url_scheme = 应以 http:// 或 https:// 开头，而不是 { $scheme }:
mail_scheme = 应形如mailto:wei.li@lab.example
no_mail_address = 不是电子邮件地址：{ $value }
too_many_recipients = 收件人最多{ $most }个
url_credentials = 不能含有用户名或密码：凡能列出通知目标者都会看到；请填写Authorization头
url_fragment = 不能有片段（#…）：它不会被发送
url_port_0 = 不能使用端口0
url_no_host = 应写明主机
url_no_scheme = 应以 http:// 或 https:// 开头
url_port_range = 端口应为1至65535
url_ip_address = IP地址不存在；IPv6地址应写在方括号中，例如 http://[::1]:9093/
url_host_name = 主机名无效：只能使用字母、数字、连字符和点

## The simulator

not_a_standard_deviation = { $value }不是标准差
not_zero_or_more = { $value }不是非负数
must_not_be_zero = 不能为零
no_noise_no_detectability = 没有噪声就没有可检测性：请给出大小
size_or_detectability = 应给出有限的大小或为正的可检测性
not_positive_time = { $value }不是正的时间
acts_never = { $value }不是试验中的一段：请给出两个时间份额，先小后大
beyond_last_dwell = { $dwell }超出{ $dwells }个测点的范围
names_no_gyro = 没有列出本次试验的陀螺
unknown_geometry = “{ $value }”既非skewed也非orthogonal
unknown_model_term = “{ $value }”不是模型的项
scenario_test = “{ $value }”不是imu、torque_feedback或turntable_servo
scenario_slot = “{ $value }”不是位置；位置为G1、G2、G3
scenario_latitude = { $value }不在-90与90之间
has_no_direction = 没有方向
not_positive_gravity = { $value }不是正的重力
no_positions_or_rates = 既无位置也无速率
not_positive_seconds = { $value }不是正的秒数
not_a_rate = { $value }不是非零的角速度
at_least_1 = 至少为1

## Where in a table, before what is wrong there

at_line = 第{ $line }行：{ $fault }
at_line_key = 第{ $line }行（{ $key }）：{ $fault }
at_cell = 第{ $line }行第{ $column }列（{ $name }）：{ $fault }
at_column = 第{ $line }行第{ $column }列：{ $fault }
at_head_line = 表头“# { $key }: …”：{ $fault }
unknown_column = 未知的列“{ $name }”
unknown_column_like = 未知的列“{ $name }”；是否应为“{ $known }”？
unknown_column_with_unit = 未知的列“{ $name }”；是否应为“{ $known }”？单位已在列名中：请换算为该单位
quote_open = 此处的引号没有结束：文件是否被截断？
quote_within = 结束引号之后还有文字：单元格内的引号须写两次，或先结束该单元格
second_column = 重复的列“{ $name }”
missing_columns = 缺少列{ $names }
columns_and_gyros = { $field }有{ $columns }列，而表头列出{ $gyros }个陀螺
cells_under_columns = { $columns }列下有{ $cells }个单元格
cells_decimal_comma = { $columns }列下有{ $cells }个单元格；{ $number }是否用逗号作小数点？小数点请用“.”
empty_cell = 为空
row_without_output = { $fault }：某陀螺没有输出时，请删去该行
row_without_value = { $fault }：不知其值时，该行{ $field }的各列都应留空
unknown_separator = 各列以“{ $found }”分隔：请改用逗号、分号或制表符
map_names = 映射文件所指有误：{ $fault }
map_column_missing = 映射文件取{ $name }自列“{ $column }”，而表中无此列
map_column_shared = 映射文件从同一列“{ $column }”取{ $names }：一列只能对应其中之一
table_foreign = 没有一列属于测试数据（{ $names }…）。样本或均值记录请用`gyrowatch dwells`，记录表或台架结果表请用`gyrowatch import --map`
table_of_records = 这些列像是记录或台架结果（{ $names }），但表头为自定：请在映射文件的`[columns]`中指明，并用`gyrowatch import --map MAP.toml FILE`发送
table_is_of_records = 这是记录或台架结果的表，不是标定试验：用`gyrowatch import FILE`发送，加--print可打印其内容
head_without_mark = “{ $text }”属于表头：请以“# ”开始该行
table_without_rows = 表只有表头，没有数据行
time_not_in_format = “{ $value }”不符合时间格式{ $format }
differs_from_line = 与同一记录的第{ $first }行不一致
serial_twice = { $serial }已在第{ $first }行：每个陀螺一行
unknown_key = 未知的键“{ $key }”；可用的键为{ $known }
key_twice = { $key }重复给出
key_below_header = { $key }位于列名行之下：键须写在列名行之上，且一个文件只含一次标定试验。另一次标定试验请单独成文件

## Parts of other messages

site_gravity = 测试站重力
standard_gravity = 标准重力（未给出测试站位置）
site_missing = 测试站位置
absent = 不给出
absent_or = 不给出或{ $shape }
a_gyro_of_the_effect = 该效应所列陀螺之一
whole_document = 文档
verbatim = { $text }

## JSON

not_json = 不是JSON：{ $why }
value_not_json = 不是JSON：{ $why }
several_documents = 此处只接受一个JSON文档，却有多个相接（POST /v1/import与`gyrowatch import`可接受多个，每行一个）：第二个始于{ $place }
at_place = { $place }：{ $fault }
line_and_column = 第{ $line }行第{ $column }列
in_column = 第{ $column }列
invalid_type = 应为{ $expected }，实为{ $found }
invalid_value = 应为{ $expected }，实为{ $found }
invalid_length = 应为{ $expected }，实有{ $have }个元素
member_twice = `{ $member }`重复给出
unknown_member = 未知的成员`{ $member }`；可用的成员为“{ $known }”
no_members_here = 未知的成员`{ $member }`；此处没有成员
unknown_value = 未知的取值`{ $value }`；可用的取值为“{ $known }”
json_ends_early = 内容在{ $within }完结之前就已结束
json_expected_value = 此处应有一个值
json_expected_ident = 此处应为 true、false 或 null
json_expected_colon = 此处应为“:”
json_expected_comma_or_brace = 此处应为“,”或“{"}"}”
json_expected_comma_or_bracket = 此处应为“,”或“]”
json_key_not_string = 成员名应为字符串
json_trailing_characters = 结尾有多余的字符
json_trailing_comma = 多余的逗号
json_invalid_number = 数的写法有误
json_number_out_of_range = 数超出范围
json_invalid_escape = 转义写法有误
json_escape_ends_early = 转义写法不完整
json_lone_surrogate = 转义写法不完整：代理对缺少后半部分
json_invalid_code_point = 不是有效的Unicode码点
json_control_character = 字符串中有控制字符
json_too_deep = 嵌套过深
json_value = 值
json_string = 字符串{ $value }
json_integer = 整数{ $value }
json_number = 数{ $value }
json_boolean = 布尔值{ $value }
json_null = 空值null
json_object = 对象
json_array = 数组
json_a_string = 字符串
json_a_number = 数
json_a_count = 非负整数
json_an_integer = 整数
json_a_boolean = 布尔值
json_numbers = 数的数组
json_three_numbers = 3个数的数组
json_geometry = “skewed”、“orthogonal”或给出各位置轴的对象

## What a campaign does not determine

no_drift_fitted = 模型没有g_linear项：未拟合与加速度有关的漂移
no_scale_fitted = E既未拟合（没有scale项）也未给出（known_e_pulse_per_arcsec）：G仍以pulse/(s·g0)计，无法得到以(°)/(h·g0)计的一次项漂移系数D_I、D_S
parameters_undetermined = 这些测点不能确定{ $parameters }；{ $needs }
scale_in_noise = E淹没在噪声中：|E|只有其标准差的{ $ratio }倍
untold_field = E与G中含有场的北向部分，这些测点不能将其分开；转动的测点可以分开
implausible_scale = 拟合得到的E不可能：{ $why }
zero_scale = E为零：没有方向，也不能用来除G
quotient_not_finite = E、G或二者之商不是有限数
points_away = E偏离其标称输入轴{ $angle }°：极性接反或位置有误
not_a_bench_test = 不是单表测试
no_fixture_axes = 没有给出{ $slot }的夹具轴
bench_undetermined = 这些测点不能确定{ $parameters }：比力应绕输入轴与电机轴取多个方向
bench_no_scale = 标度因子既未给出（known_e_pulse_per_arcsec）也看不到：各测点沿输入轴的地球自转分量几乎不变
bench_scale_or_squares = 这些位置不能同时确定标度因子与D_II、D_SS：请给出known_e_pulse_per_arcsec，或在更多航向测量，或在model中去掉g_squared
bench_not_as_stated = 输出对地球自转的响应是所给known_e_pulse_per_arcsec的{ $found }倍：请检查输出与该项的符号和单位以及纬度；不给出该项则拟合E
not_a_table_rate = 输出对地球自转的响应为{ $found }，而以arcsec/s计的转台角速度应为1或-1；若输出为其他单位，请给出known_e_pulse_per_arcsec
no_servo_sign = 转台转动与陀螺漂移同向还是反向在地球自转中看不出来：请给出known_e_pulse_per_arcsec，即带符号的输入轴单位矢量

## What was commanded against the Earth

commanded = { $likely }。实测：{ $measured }
commanded_hidden = { $likely }。实测：{ $measured }；这些陀螺的噪声将其掩盖
either_of_two = 可能有二：{ $first }；或{ $second }
either_of_three = 可能有三：{ $first }；或{ $second }；或{ $third }
commanded_wrong = specific_force_g0或rate_arcsec_s的单位、符号或轴有误
force_reversed = 比力反号：静态测点的比力应向上，背离地心
rates_reversed = 角速度反号：绕正轴按右手定则转动为正
latitude_reversed = 纬度符号有误（site.latitude_deg，或计算角速度时所用的纬度）：北纬为正
ned_for_enu = 北东地与东北天混用：姿态、比力与角速度都应以东北天为导航系
attitude_inverted = 姿态求逆：四元数应满足 v_body = C(q) v_nav
earth_rate_left_out = 角速度中缺少地球自转：请给出惯性角速度；已知姿态与测试站位置时，可用 "rates": "table" 由服务加上
rate_unit = { $dwells }的角速度单位为{ $unit }：请以arcsec/s给出
all_dwells = 所有测点
static_dwells = 静态测点
rate_dwells = 速率测点
axis_reversed = { $vectors }的{ $axis }轴反向
axes_exchanged = { $vectors }的{ $first }轴与{ $second }轴互换
force_and_rate = specific_force_g0与rate_arcsec_s
other_latitude = 角速度对应的纬度为{ $degrees }°：请更正site.latitude_deg或角速度
other_earth_rate = 角速度按地球自转{ $rate } arcsec/s计算：应为15.041（恒星日）
other_headings = 静态测点的角速度与姿态的方位不符：请给出各姿态下的地球自转角速度
force_unit = 比力的单位为{ $unit }：请以g0 = 9.80665 m/s²给出
force_normalised = 比力已归一化为1：应乘以测试站重力（g0）
force_scale = 比力为重力的{ $ratio }倍：请更正，或在site.gravity_g0中给出测试站重力
measured_static_rate = { $share }静止时|rate_arcsec_s|为{ $value } arcsec/s；地球自转为15.041
measured_vertical_rate = { $share }静止时w·f/|f|为{ $value } arcsec/s；Ω·sinL为{ $expected }
measured_turning_rate = { $share }转台在转动，而rate_arcsec_s不沿specific_force_g0，或慢于任何转台（{ $value } arcsec/s）
measured_heading = { $share }的rate_arcsec_s与该姿态下的地球自转相差{ $value } arcsec/s
measured_output = 输出与模型的均方根差为{ $value } arcsec/s
measured_senses = { $share }的输出所示输入轴与静态测量点所示相差最多{ $value }度
output_scale = 转台转动时{ $gyros }的输出单位与静止时不同，或超出量程：所有测点的输出请以pulse/s给出
measured_scale = { $share }中输出对角速度的响应为静止时的{ $value }倍
measured_gravity = { $share }的|specific_force_g0|为{ $value } g0；重力为{ $expected } g0
measured_attitude = { $share }的姿态垂线偏离specific_force_g0 { $value }°
this_dwell = 该测点
share_of_dwells = { $of }个测点中的{ $count }个
effect_not_seen = 此试验设计看不到{ $effect }：请给出大小
needs_directions = 需要其他比力方向的测点
needs_rates = 需要其他角速度的测点
needs_directions_and_rates = 需要其他比力方向与其他角速度的测点

## 自拟假设

equation_too_long = 有 { $have } 个字符；方程最多 { $most } 个：请拆成几个假设
equation_too_deep = 第 { $place } 个字符处，括号、函数、符号和幂的嵌套超过 { $most } 层：请把里面的乘开
equation_unexpected = 第 { $place } 个字符是“{ $found }”，此处应为{ $wanted }
equation_ends = 方程结束处应为{ $wanted }
equation_value = 数、名称或左括号
equation_operator = +、-、*、/ 或 ^（乘积须写 *）
equation_closing = 右括号
equation_number = 第 { $place } 个字符处的“{ $found }”不是有限的数
equation_function = 第 { $place } 个字符处的“{ $name }”不是函数；可用 { $known }
equation_name = 第 { $place } 个字符处的“{ $name }”不是测点的量；可用 { $known }、以 k 开头的系数，以及一个带 [range] 的参数
equation_coefficients = 有 { $have } 个系数；可有 1 至 { $most } 个：以 k 开头的名称，如 k * T * w_I
equation_without_parameter = 不含“{ $name }”，却给了它的范围：请使用它，或去掉范围
equation_units_differ = 第 { $place } 个字符处，单位 { $left } 与 { $right } 相加减：单位相同才能相加
equation_pure_number = 第 { $place } 个字符处应为纯数，却有单位 { $unit }：请除以同单位的量，如 exp(-t/tau)
equation_over_zero = 第 { $place } 个字符处除以零
equation_not_linear = 第 { $place } 个字符处系数不只是因子：请把非线性的部分写成带 [range] 的参数
equation_free_term = 第 { $place } 个字符处有一项没有系数：请乘以一个系数，或去掉该项
equation_no_drift = 结果的单位是 { $unit }，而漂移的单位是 deg/h：系数的单位须为 { $needed }
equation_not_finite = 方程在测点{ $dwell }没有有限值
unknown_unit = “{ $value }”不是单位；单位由 { $known } 组成，如 deg/(h g0 K)
range_empty = 从 { $from } 到 { $to }：两端须为有限的数，且后者较大
range_through_zero = 从 { $from } 到 { $to } 经过零，方程在零处无值：请给出大于零的范围
range_name = “{ $name }”是测点的量、系数或不是名称：请给参数另取名称
hypothesis_sizes = plausible 与 typical 须为正的有限数，typical 由小到大且不超过 plausible
hypothesis_id = “{ $value }”须由小写字母、数字和下划线组成，以字母开头，最多 { $most } 个
hypothesis_id_taken = “{ $value }”已是目录中的效应或其竞争者：请另取标识
hypothesis_words = 须为一行文字，最多 { $most } 个字符
hypothesis_one_range = 有 { $have } 个参数，只能有一个：请给其余的参数赋值，或分别写成假设
hypothesis_too_long = 文件最多 { $most } 字节
too_many_hypotheses = 程序启动以来已询问 { $most } 个不同的假设：请重新启动

## 配置

config_unreadable = 无法读取配置：{ $why }
config_key = 配置项{ $key }：{ $fault }
config_at_least = 至少应为{ $least }，实为{ $value }
config_above_0 = 应大于0且不超过{ $most }，实为{ $value }
config_between = 应在{ $least }与{ $most }之间，实为{ $value }
config_negative = 不应为负，实为{ $value }
config_above_max = 应小于{ $max }（{ $most }），实为{ $value }
config_log_filter = “{ $value }”不是日志级别：可用off、error、warn、info、debug、trace；仅针对某个模块时写作{ $value }=debug
config_unread = 环境变量{ $name }不会被读取，不起作用：配置项写作GYROWATCH_节__键
config_unread_like = 环境变量{ $name }不会被读取，不起作用；可能是指{ $meant }
config_http = 应以http://或https://开头，实为{ $value }
config_proxy = 应为http://主机:端口、`environment`，或留空表示不用代理
config_mail_server = 应为smtps://用户:密码@主机:端口，或smtp://主机:端口?tls=required
config_mail_from = 应为邮件地址，如gyrowatch@lab.example
config_mail_authority = 无法使用CA证书：{ $why }
config_of_whole_gyro = 针对整个陀螺：不要给出coefficient
config_in_the_open = 其他机器可以访问{ $address }，而HTTP会以明文传送令牌与记录。请设置server.tls_certificate与server.tls_key，或设server.plain_http = "{ $value }"
config_plain_http = 应为空或“{ $wanted }”
config_base_path = 应为空或形如/gyrowatch，实为“{ $value }”
config_database = 应以sqlite://或postgres://开头，实为“{ $value }”；文件形如sqlite://gyrowatch.db
config_secrets_key = 应为32字节，用十六进制（64位）或base64书写；留空表示不用密钥
config_from_0_below_1 = 应不小于0且小于1，实为{ $value }
unknown_toml_key = 未知的键`{ $key }`，可用的有{ $known }
config_address = IP地址与端口，如127.0.0.1:8080（仅限本机）、[::1]:8080或0.0.0.0:8080
config_networks = 网段或地址，如10.0.0.0/8,192.168.1.5,fd12::/16
config_numbers = 数，如5,30,120
config_instant = 日期或RFC 3339时间，如“1950-01-01”或“1950-01-01T00:00:00Z”
config_bounds = { $bounds }既不是[下限, 上限]，也不是表示无要求的[]
config_off_requirement = 规则requirement由judging.requirements = false关闭，或在judging.requirement中逐项关闭
config_off_overdue = 规则overdue由interval_days = 0关闭
