# 测试站自有文件的说明，按代码。

standard_input = 标准输入
at_file = { $file }：{ $fault }
at_map_key = `{ $key }`：{ $fault }

## 文件是什么

file_is_folder = 是文件夹；请给出其中的文件
file_is_empty = 是空文件：未写入任何内容
file_is_zeros = 全为零字节：写入时断电；请取记录仪的副本
file_is_binary = 是未知格式的二进制文件；请让记录仪输出CSV，或转换为CSV
file_is_other = 是{ $name }文件，不是记录；请将采样表导出为CSV
file_is_mat = 是{ $version }版MAT文件，不能读取；在MATLAB中：load('FILE'); save('FILE7.mat', '-v7')
file_is_hdf5 = 是HDF5文件，不能读取；请用h5dump或Python的h5py导出为CSV
file_is_ulog = 是PX4的ULog二进制记录；`pip install pyulog`，再运行`ulog2csv FILE -m sensor_combined`，使用所得CSV
file_is_rosbag = 是ROS bag，不能读取；`rostopic echo -b FILE -p /imu/data > log.csv`，使用所得CSV
file_is_mcap = 是MCAP记录，不能读取；请将IMU话题导出为CSV（例如用Foxglove）
file_is_dataflash = 是ArduPilot的dataflash记录，不能读取；`mavlogdump.py --format csv --types IMU FILE > log.csv`
file_is_tdms = 是LabVIEW的TDMS文件，不能读取；请在Excel中用NI插件打开，另存为xlsx或CSV
file_is_xls = 是旧版Excel或Office文件（.xls）；请另存为.xlsx或CSV
file_is_no_text = 是{ $name }文件，不是文本；请将表另存为CSV，或用`gyrowatch import`发送
file_is_log = 是{ $name }记录；请先用`gyrowatch dwells`生成测试数据
file_is_parquet = 是Parquet文件，本程序编译时未加入读取功能（编译时加`--features parquet`）；在Python中：pandas.read_parquet("FILE").to_csv("log.csv", index=False)
file_is_arrow = 是Arrow（Feather）文件，不能读取；在Python中：pandas.read_feather('FILE').to_csv('FILE.csv', index=False)
file_is_gzip = 是gzip压缩文件；请用`gunzip FILE`解压
file_is_zip = 是zip压缩包；请解压后给出其中的文件
file_is_json = 是JSON，不是采样表；测试数据与标定记录请用`gyrowatch import`
log_too_large = 此处发送的文件最多{ $most }字节（由{ $key }规定）；任意长度的日志请用`gyrowatch dwells`生成试验，含多份文件内容的请用`gyrowatch import`
mat_broken = 是不完整或损坏的MAT文件；请用save('FILE', '-v7')重新保存
npy_broken = 是不完整或损坏的NumPy文件；请用numpy.save或numpy.savez重新保存
npy_pickled = 含Python对象，不能读取；请保存数值：numpy.save("FILE", array.astype(float))
npy_shape = 含{ $dimensions }维数组；记录应每行一个采样、每列一个通道
npy_wide = 将有{ $columns }列、{ $rows }行；记录应每行一个采样、每列一个通道
npy_no_numbers = 没有实数数组
parquet_broken = 不能作为Parquet读取：{ $why }
parquet_codec = 以{ $codec }压缩，不能读取；在Python中：pandas.read_parquet("FILE").to_parquet("log.parquet", compression="snappy")
parquet_no_numbers = 是没有数值列的Parquet文件
xlsx_broken = 不能作为xlsx读取：{ $why }
xlsx_no_table = 工作簿中没有数值表
no_numbers = 是没有数值表的文本（看过{ $lines }行）：仅有表头，或不是日志
no_rows = 没有一行在映射所列各列中都有数值；{ $count }行有空单元格或nan
commas_of_two_kinds = 逗号既作小数点又作分隔：{ $columns }列下有{ $cells }个单元格，无法区分；请让程序用分号分隔各列，或用小数点
zeros_from_here = 此后全为零字节：记录仪写入时断电；请在此处截断文件
rows_unreadable = { $rows }行中有{ $count }行不能读取；第一处：{ $fault }
cell_missing = 该行在此列之前结束
row_too_long = 该行多于{ $cells }个单元格：以逗号分列时的小数逗号，或文字中的分隔符，使其后各格错位
cell_thousands = "{ $value }"中的分隔符可能是小数点，也可能是千位分隔符，无法判断：该列有{ $count }个这样的单元格，其余为整数，没有别的小数；请写成不带千位分隔符的数

## 列

log_column_unknown = 没有名为"{ $name }"的列；现有：{ $known }
log_column_like = 没有名为"{ $name }"的列；是否应为"{ $like }"？现有：{ $known }
log_column_number = 没有第{ $number }列；记录有{ $columns }列
log_column_twice = 有多列名为"{ $name }"；请用列号指明
log_columns_unnamed = 记录没有表头，没有名为"{ $name }"的列；请用列号1至{ $columns }
log_other_layout = 的列与{ $first }不同；前后相接的记录须有相同的列
log_twice = 与{ $other }的{ $rows }行完全相同，会重复计算：每个记录只给出一次
log_repeats = 重复了{ $other }的{ $seconds } s（其时钟的{ $from } s至{ $to } s），会重复计算：请从其中一个记录中删去这一段，或只给出一个记录
log_overlaps = 始于{ $from }，而{ $other }在{ $seconds } s之后（{ $to }）才结束，重叠部分会重复计算：请删去本记录开头的{ $seconds } s，或只给出其中一个。若时钟曾被拨回，请以`rate_hz`代替`time`
logs_in_order = 记录未按时间顺序给出，已按时间顺序读取：{ $logs }
log_unused = 映射中没有用到第{ $log }个记录；请在其列处写`log = { $log }`
logs_apart = 各记录没有共同的时间；它们是同时记录的吗？

## 映射

map_unreadable = 映射不能读取：{ $why }
map_unanswered = "?"须填写：记录中没有说明
map_missing = 映射与命令行中都没有`{ $key }`
map_no_columns = 没有给出列
map_column_count = 须给出{ $need }列，现为{ $have }列
map_each = `{ $name }`须为一个数或每列一个数；现有{ $have }个，对应{ $columns }列
map_gyros = `gyros`有{ $gyros }个，`output`有{ $outputs }列
map_known_e = `known_e`有{ $have }行，陀螺有{ $gyros }个
map_log = 没有第{ $log }个记录：命令行给出了{ $logs }个
map_logs = 映射对应同时记录的{ $logs }个文件；现给出{ $have }个
map_no_time = `time`与`rate_hz`都没有给出：每秒多少个采样？
map_unit_missing = 缺少单位，表头也没有说明；可用：{ $known }
map_unit_unknown = "{ $unit }"不是此量的单位；可用：{ $known }。原始码值须给出`scale`与`offset`，以及换算后的单位
map_unit_of_header = 映射写{ $unit }，记录表头写{ $header }；哪个正确？
map_unit_of_header_alone = 表头写“{ $header }”，不是此量的单位；请在映射中用`unit`说明数值的单位：{ $known }
map_site_missing = 缺少`site`：没有纬度与重力就不知道给定的输入
unit_of_header = { $key }按表头取为{ $unit }
unit_of_map = { $key }按映射取为{ $unit }
unit_of_map_alone = { $key }按映射取为{ $unit }；表头写“{ $header }”，不是已知的单位

## 时间

date_unclear = “{ $value }”中分不清日与月；请写作2026-11-24（yyyy-mm-dd），或用`rate_hz`代替`time`
time_unread = 时间"{ $value }"无法读取；请写成08:15:00.5、2026-11-24T08:15:00或20261124T081500（可带时区或Z），或以`rate_hz`代替`time`
time_back = 时间倒退{ $seconds } s，从{ $from }到{ $to }：一个文件中有两个记录，或时钟被重设；请在此处分为两个文件
time_coarse = { $rows }个采样中有{ $repeated }个与前一时刻相同：时钟分辨率不足；请去掉`time`，给出`rate_hz`
time_wrapped = 时钟重新开始{ $count }次（午夜或计数器溢出），已接续
clock_of_another_date = 是{ $stated }，而记录的时钟从{ $from }到{ $to }。请改正；若记录用Unix时间或带时差，可以不写。若时钟有误，请以`rate_hz`代替`time`
clock_unset = 记录的时钟为{ $from }，像是从未校准：`measured_at`取映射中的{ $stated }
time_unlikely = 每{ $step } s一个采样、记录长{ $days }天、稳定段通常{ $usual } s，不是标定试验：`time`（或`rate_hz`）的单位与映射或表头所写不符
samples_lost = { $rows }个采样中在{ $gaps }处缺失{ $lost }个；均值取自现有采样
samples_repeated = { $count }个采样与前一时刻相同，已剔除
samples_disordered = { $count }个采样次序颠倒，不到两个采样间隔
samples_frozen = 冻结：某输出或比力有{ $runs }次读数不变，最长连续{ $count }个采样，已剔除（{ $spans } s）：传感器或记录仪是否停滞？
output_dead = 第{ $output }路输出始终为{ $value }：该陀螺或其列无信号
rows_incomplete = { $count }行有空单元格，已剔除
rows_left_out = { $count }行不是数据，已剔除
rows_left_out_at = { $count }行不是数据行，未采用；第一处：{ $fault }
temperatures_left_out = { $count }个温度为传感器故障值（跳变超过20 °C又恢复），未采用
counter_wrapped = 计数器重新开始{ $count }次（16、24或32位），已接续
counter_reset = 计数器{ $count }次归零后继续计数：是否被复位，或满量程不是16、24、32位？归零处的采样不计入测点
counter_unclear = { $bits }位计数器相邻采样的变化约为其量程的一半（{ $count }次），无法判断它重新开始了几次：请提高采样率，或记录每次采样的脉冲数，或用更宽的计数器
samples_alternate = `{ $key }`第{ $column }路的采样在两个数值间交替（{ $one }，{ $other }）：是否两套IMU写在一个文件中？请分成各自的文件
log_of_several = 列{ $column }中有{ $ids }：一个文件中有多套IMU的数据行；请分成各自的文件

## 测点

no_interval = 在{ $seconds } s的记录中没有不短于{ $least } s的静止或匀速段。测试需要保持不动的位置；映射中的`min_s`可允许更短的段
intervals_below_min = { $fault }。另有{ $count }个平稳段短于{ $least } s（最长{ $longest } s）而未采用：映射中的`min_s`可保留它们
moves = 在{ $seconds } s的记录中没有静止段：输出始终在平滑变化。测试需要保持不动的位置
one_interval = 整个记录是一个位置上的一段，长{ $seconds } s（平均输出{ $means }）。测试需要多个位置：请按次序给出全部记录
one_orientation = { $count }个测点的取向都相同：拟合不能得出D_I与D_S
intervals_short = { $count }个稳定段比其他段短得多，视为停顿（{ $starts } s …）；映射中较小的`min_s`可保留它们
intervals_too_short = { $count }个平稳段短于{ $least } s（最长{ $longest } s），未采用；映射中的`min_s`可保留它们
intervals_split = 按其他测点的固定节拍切分了{ $count }处长段：同一位置连续测了两次
after_clipping = { $clipped }。除去这些后：{ $fault }
intervals_clipped = { $count }个段饱和，未采用：输出或比力处于量程端点（{ $starts } s …）
intervals_turning = 剔除{ $count }个转动段：不知道转台转速；请给出`rate`、`table`或--programme
intervals_all_edge = 剔除{ $count }个段：只有边缘；映射中的`cut_s`可少切
all_turning = IMU在每一段中都在转动，且不知道转速；请给出`rate`、`table`或--programme。若静止，则`output`缺少`offset`
turns_not_whole = { $count }个转动测点不足一整圈：地球自转水平分量留在其中的部分小于其噪声
turns_too_short = { $count }个转动区间未采用：不足一整圈，且无从得知起始方位，其平均值中的地球自转水平分量最多达{ $most } arcsec/s。请转满整圈，或记录转台角度或姿态
turns_left = 转台在{ $count }个时段内匀速转动（共{ $seconds } s），因上述原因未形成测点：{ $spans } s
turns_unsteady = { $count }个匀速转动时段未形成测点（共{ $seconds } s）：即使去掉地球自转在转动中的影响，输出仍不稳定：{ $spans } s
swings_unsteady = { $count }个时段未形成测点（共{ $seconds } s），其输出变化不超过转动中地球自转所能引起的范围：{ $spans } s
intervals_tumbling = 剔除{ $count }个转台绕非铅垂轴转动的时段：其中重力方向不固定
averaged_rows = { $count }行视为均值，每行一个测点
averaged_durations = 时长为假定（每行一秒）：请给出`duration`，或`samples`与`rate_hz`
averaged_counts = 均值的输出须为速率（pulse/s、deg/s等），或整行的`pulse`并给出`duration`
averaged_many = 超过{ $most }行：这是采样而不是均值；请去掉`averaged`
averaged_turning = { $of }行中有{ $count }行的输出属于转动，而不知道转台转速：请在映射中给出`rate`，或用--programme
averaged_errors = 其标准误差未知：映射中的`standard_error`指明所在列
averaged_beside = 均值须在同一表中：`averaged`不能与`log`同用
averaged_duration = 时长须为正，现为{ $seconds } s
averaged_error = 标准误差须为正，现为{ $value }
averaged_attitude = 姿态四元数的模应为1，现为{ $length }：这四列对吗？
rates_inertial = 三个角速率视为惯性空间角速率，含地球自转；`rate`中写`inertial = false`则相反
rates_table = 三个角速率视为转台角速率，不含地球自转；`rate`中写`inertial = true`则相反
rates_unknown = 最小角速率为{ $least } arcsec/s，既非静止也非地球自转：请在`rate`中写`inertial = true`或`false`
map_of_averages = `{ $key }`用于均值表：缺少`averaged = true`
map_column_again = 列"{ $name }"被指定两次

## 给定的输入

commanded_unknown = 不知道给定的输入：请给出--programme，或在映射中给出`table`、`attitude`或`force`
commanded_heading = 各位置的方位未知，而脉冲输出的陀螺敏感地球自转的水平分量：请给出--programme，或在映射中给出`table`或`attitude`
commanded_heading_seen = 陀螺噪声小，足以看到地球自转的水平分量，而各位置的方位未知：请给出--programme，或在映射中给出`table`或`attitude`
force_other_unit = 比力在一般测点中长{ $length } g0：像是{ $unit }，与映射不符
force_no_unit = 比力在一般测点中长{ $length } g0，不是任何单位的重力：这些是加速度计的列吗？
force_varies = 静止时比力长度为{ $least }至{ $most } g0：是否有一列属于其他传感器，或某列的标度有误？
e_held = 没有以已知转速转动，E取定值：绕标称输入轴一个脉冲为一角秒

## 测试程序

programme_empty = 测试程序没有行
programme_attitude = 位置由`up`与`north`给出，或由attitude_w、_x、_y、_z全部给出
programme_parallel = "{ $up }"向上与"{ $north }"向北相互平行
at_programme_column = { $name }列：{ $fault }
not_an_axis = "{ $text }"不是载体轴；请写+X、-X、+Y、-Y、+Z、-Z或三个数
not_an_earth_axis = "{ $text }"不是地球方向；请写east、north或up，反向加负号
programme_count = 找到{ $intervals }段，测试程序有{ $rows }行；没有`force`、`rate`或时间，无法对应
intervals_alike = { $fault }。相邻且输出相同的段可能是同一测点，被缺失、时钟重设或扰动分开：第{ $places }段。若如此，请在测试程序中为每一部分各写一行
pauses_long = { $fault }。段与段之间的长间隔中可能有一个不稳定的测点：第{ $places }段之间。若该测点已丢失，请从测试程序中删去该行
programme_other = { $intervals }段与测试程序{ $rows }行中只有{ $matched }个在垂线、转速与次序上相符：是否为另一程序，或轴互换？
programme_undecided = { $intervals }段与测试程序{ $rows }行有多种对应方式，与垂线、转速、输出及记录时钟同样吻合，无法判断缺哪几行；请给出每行的`start_s`与`duration_s`
programme_clock_unit = 测试程序的时刻乘以{ $factor }才与记录吻合：`start_s`与`duration_s`的单位是否不是s？
programme_clock_unused = 测试程序的时刻与记录不吻合，未采用：按行的次序对应
outputs_contradict_in = 测点{ $dwells }的转台角度或符号与输出矛盾，其余吻合。计入这些测点时误差模型的残差为噪声的{ $times }倍：是否行互换，或不是本记录的程序？
outputs_contradict = 转台角度或符号与输出矛盾：{ $of }个测点的误差模型残差为噪声的{ $times }倍，最大者为测点{ $dwells }。请检查转台的轴、符号与零位，行的次序，以及输出是否饱和
output_other_unit = { $slot }为{ $scale }脉冲/角秒，而测量角速率的陀螺应为1：`output`像是{ $unit }
output_other_scale = { $slot }为{ $scale }脉冲/角秒，而测量角速率的陀螺应为1：`output`的单位不对，或指令转速差此倍数
programme_missing = 测试程序{ $rows }行中有{ $count }行在记录中没有对应段，其中{ $turning }行为转动：第{ $which }行
programme_exchanged = 记录有{ $count }段，与测试程序的行数相同，但第{ $rows }行与其段不符：是行互换，还是缺一段而又多一段？给出`start_s`与`duration_s`即可确定
programme_left = { $count }段不在测试程序中，已剔除
programme_clock = 测试程序始于记录的{ $seconds } s
programme_ambiguous = 程序的时刻从日志的{ $one } s起算与从{ $other } s起算同样吻合，相差一个测点：请在映射中写明`force`或`rate`，或记录完整的程序
rate_other_unit = 日志的`rate`像是{ $unit }：所有转动中，程序、转台角度、姿态或地球自转使输出产生的波动都表明如此。请在映射中改正其单位
rate_at_rest = 记录的`rate`在每个静止测点均为{ $rates }°/s，而从{ $least }°/s起视为转动：请在映射中写为`rate`的`offset`，单位同该列
time_other_unit = `time`像是{ $unit }：若如此，所有转动中输出的波动都与地球自转相符。请在映射中改正其单位
time_unproved = 每{ $step } s一个采样、稳定段{ $usual } s：无法判断`time`的单位，因为没有转动显示地球自转。如过长，请在映射中改正其单位
scale_unproved = 无法判断`output`的单位，因为不知方位：静止时的地球自转可显示其标度及`rate`的标度。请给出--programme，或在映射中写明`table`或`attitude`
programme_rates = { $of }个测点中有{ $count }个，日志中的转速与程序矛盾；第一个在{ $start } s：是否为另一程序，或符号有误？
turns_at_another_rate = 在{ $count }次转动中，输出随地球自转的起伏所示的转速与测试程序不同（{ $turns }）：是否有一行的转速写错？
turns_by_one_factor = 在全部{ $count }次转动中，输出随地球自转的起伏所示的转速与测试程序相差约{ $percent }%。日志的时钟（`rate_hz`、`time`）或全部转速有此误差；|E|也有此误差，除非仅时钟有误且输出不是脉冲计数
programme_contradicted = { $of }个测点中有{ $count }个加速度计与测试程序不符；第一处在{ $start } s，相差{ $degrees }°：轴、符号或次序有误
cells_alike = 第{ $from }至{ $to }行有{ $count }个单元格错误相同；第一处：{ $fault }
cells_alike_of_line = 第{ $line }行有{ $count }个单元格错误相同；第一处：{ $fault }
dwells_told = 表头写有{ $told }个测点，表中有{ $have }个：尚未写完，或被截断
stored_otherwise = { $what }在{ $at }已有存储（编号{ $id }），且完全不同
stored_otherwise_at = { $what }在{ $at }已有存储（编号{ $id }），数值不同：差异在{ $places }
replace_it = 若此份正确，`gyrowatch revise FILE --author 姓名 --reason 原因`可替换{ $id }
not_one_calibration = 必须是一份标定记录或一份标定试验

guess_head = 由{ $logs }推测：请逐行核对，并填写所有“?”。
guess_time_example = 如2026-03-01T08:00:00Z
guess_geometry = 或"skewed"，或按通道给出各轴
guess_site = 测试站的
guess_few_rows = 行数很少：若每行已是平均值，请写averaged = true，并给出duration或samples
guess_no_output = 没有像陀螺输出的列
guess_time_unread = 列{ $column }既不是数，也不是带日期的时间（2026-11-24 08:15:00）：请改写，或给出每秒采样数
guess_time_unsteady = 列{ $column }名为时间，但不是稳定递增：请给出每秒采样数
guess_time_counts = 列{ $column }是行号，不是时间：请给出每秒采样数
guess_no_time = 没有稳定递增的列：请给出每秒采样数
guess_time_or_temperature = 列"T"递增，但可能是温度：请写为`time`或`temperature`；若不是时间，请给出采样率
guess_time = 每行增加{ $step }；按{ $unit }为每秒{ $hz }个采样
guess_time_ticks = 每行增加{ $step }；按每个计数{ $count } { $unit }为每秒{ $hz }个采样
guess_clock = 时刻或日期：按秒读取，每行增加{ $step }
guess_time_unit = 每行增加{ $step }，单位不明：按s为每秒{ $of_s }个采样，按ms为{ $of_ms }个
guess_rate = 名为角速率且不是陀螺的：当作转台角速率
guess_header = 表头注明{ $unit }
guess_output_unit = 陀螺的单位不明：pulse/s、pulse、deg/s、rad/s等
guess_gravity = 多数行的模为{ $length }，即以{ $unit }为单位的重力
guess_no_gravity = 其模按任何单位都不是重力：请用scale和offset说明一个计数是多少
guess_celsius = 名为温度；当作摄氏度
