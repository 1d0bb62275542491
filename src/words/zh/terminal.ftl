# 各命令给人看的输出，按代码。表头各列以" | "分开。

terminal_note = 说明：{ $note }

## `diagnose`

terminal_measured_by = { $imu }，{ $station }，{ $at }：{ $verdict }
terminal_no_gap = 没有差异
terminal_explained = 已解释
terminal_partly_explained = 部分解释
terminal_unexplained = 未解释
terminal_gap = 噪声底{ $floor } deg/h（{ $source }）；差异{ $gap } deg/h，仅有噪声时为{ $noise }；约化卡方{ $chi2 }，各项检验的校正p值{ $p }
terminal_model = 模型：{ $terms }
terminal_split = 参照标定：{ $imu }，{ $station }，{ $at }
terminal_split_head = 陀螺 | 差异，deg/h | 参数变化 | 模型结构 | 噪声 | 参数变化p值
terminal_all = 全部
terminal_moved = 参照与本次
terminal_moved_head = 陀螺 | 系数 | 参照 | 本次 | 变化 | 单位
terminal_effects = 指出的效应
terminal_effects_head = 效应 | 陀螺 | 参数 | 数值 | 单位 | 留出闭合率 | p | d | 或同样可能
terminal_effects_key =
    留出闭合率：占可消除差异（留出测点上误差超出噪声底的部分）的比例，附95 %区间；有多个效应时，
    各占其上各项所余的比例：请比较d，不要比较留出闭合率
    p：仅由噪声出现如此结果的概率，已按所有尝试校正；d：可检测度，效应从残差中取走的白化功率的
    平方根（8几乎总能指出，5在三次试验中约有两次）
terminal_alone = 仅{ $slot }：{ $effects }
terminal_signs = 其余
terminal_signs_head = 还有其他迹象 | 陀螺 | p
terminal_candidates = 其他超出噪声的候选
terminal_candidates_head = 候选 | 陀螺 | 单独解释 | 校正p值 | 未采用原因
terminal_tried = 试过而在噪声范围内的效应（各附校正p值；小于{ $level }才指出）
terminal_impact = 计入所指效应前后的一次项漂移系数，(°)/(h·g0)
terminal_impact_head = 陀螺 | 系数 | 原值 | 计入效应后 | 变化 | 占允许范围 | 是否变化
terminal_yes = 是
terminal_within_noise = 否：在噪声范围内
terminal_blind = 盲区
terminal_blind_head = 无法判断的效应 | 可见部分 | 原因 | 需要的条件
terminal_next = 建议下一步测量
terminal_next_head = 朝上 | 朝北 | 转台转速，deg/s | 可区分
terminal_nothing_adopted = 没有指出任何效应：为现用模型
terminal_calibrated_by = { $imu }，{ $station }，{ $at }：{ $verdict }
terminal_closure = 闭合差：两个系数未能解释的G
terminal_closure_head = 陀螺 | D_O，(°)/(h·g0) | 占允许范围 | 仅噪声的p | 绕输入轴转角，° | 若为转角时的D_S
terminal_one_class = 同一等效类，此处无法区分：{ $effects }
terminal_peers = { $serial }；其测试站的其他陀螺{ $peers }只
terminal_not_named_head = 未指出 | 内容 | 原因
terminal_changed = 效应与模型比较
terminal_changed_head = 效应 | 陀螺 | 系数 | 模型 | 本次 | 单位 | p | 是否变化
terminal_no = 否
terminal_cannot_tell = 无法判断
terminal_cannot_tell_why = 无法判断：该陀螺的表现超出模型所含，变化的可能正是这部分
terminal_cannot_tell_beyond = 无法判断：本次试验超出模型见过的温度，该效应在那里可能并非线性
terminal_moved_by = { $slot }的{ $coefficient }：因变化而移动{ $shift } (°)/(h·g0)
terminal_diagnosed = 已诊断{ $count }次试验
terminal_clean = { $count }次在噪声范围内
terminal_count_explained = { $count }次差异已解释
terminal_count_partly = { $count }次差异部分解释
terminal_count_unexplained = { $count }次差异未能用目录解释
terminal_count_outdated = 其中{ $count }次由其他版本的程序诊断
terminal_count_refused = { $count }次无法诊断，未计入
terminal_count_waiting = { $count }次尚未诊断
terminal_findings_head = 效应 | 陀螺 | IMU | 测试站 | 此前最后未出现 | 首次出现 | 最近出现 | 试验数 | 留出闭合率 | D_I | D_S
terminal_or = 或{ $effects }
terminal_of = { $part }，共{ $all }
terminal_to = { $from }至{ $to }
terminal_findings_key =
    试验数：出现该效应／首次出现以来，共该陀螺全部；留出闭合率：留出测点上，该次试验中先指出的效应
    所余可消除差异的留出闭合率，中位数（最小至最大）；
    D_I、D_S：最大变化，(°)/(h·g0)，及占允许范围的比例
terminal_doubts = 目录不能解释或不能完全解释
terminal_doubts_head = IMU | 结论 | 陀螺 | 迹象 | 测试站 | 试验数 | 首次 | 最近

## `separate`、`calibrate`

terminal_separated = { $imu }，{ $station }，{ $at }标定
terminal_requirements = E、G与要求比较
terminal_requirements_head = 陀螺 | 编号 | E | G
terminal_drift = 一次项漂移系数，(°)/(h·g0)
terminal_drift_head = 陀螺 | 编号 | 方法 | D_I | D_S | 余量 | 余量为
terminal_published = 论文公式
terminal_as_printed = 按原文印刷
terminal_rms = 残差均方根
terminal_not_skewed = 公式(8)至(13)只适用于斜装
terminal_directions_coincide = 对此E，公式(8)至(13)的输入轴与电机轴方向重合
terminal_mounting = 安装：|E|的单位为pulse/arcsec；输入轴各角的单位为°；转角为D_O实际为0时电机轴绕输入轴的转角
terminal_mounting_head = 陀螺 | |E| | alpha x | alpha y | alpha z | 偏离标称 | 转角
terminal_calibrated = { $imu }，{ $station }，{ $at }：{ $dwells }个测点，模型{ $model }
terminal_causes = 原因：{ $causes }。
terminal_gap_beside_fit = { $verdict }对D_I、D_S的影响：gyrowatch diagnose { $file }
terminal_fit = 拟合
terminal_fit_head = 陀螺 | 编号 | E | 秩 | 自由度 | 约化卡方 | 失拟p值 | 噪声，deg/h | 噪声来源
terminal_fit_source = { $source }，倍数{ $factor }
terminal_gauge = 约束：{ $gauge }
terminal_parameters = 参数
terminal_parameters_head = 陀螺 | 参数 | 数值 | 单位 | 备注
terminal_not_determined = 这些测点不能确定
terminal_effect = 效应
terminal_residuals = 最大残差（测点从0起数）
terminal_residuals_head = 测点 | 陀螺 | 阶段 | pulse/s | deg/h | 标准差倍数 | 杠杆值
terminal_uncertainties = 标准不确定度，(°)/(h·g0)
terminal_uncertainties_head = 陀螺 | 系数 | 标准差 | 噪声 | 调平 | 方位 | 夹具 | 差异 | 合成
terminal_uncertainties_unstated = 未说明测试站的不确定度：标准差中不含调平、方位与夹具。
terminal_not_separated = { $slot }（{ $serial }）未分离：{ $reason }
terminal_campaigns = { $imu }：{ $count }次试验
terminal_campaigns_head = 试验 | 测试站 | 测量时间 | 陀螺 | D_I | D_S
terminal_copies = { $first }与{ $second }：所有输出逐位相同；是否为同一次测量改了时间？请去掉其中之一
terminal_repeats = 各次试验之间
terminal_repeats_head = 陀螺 | 系数 | n | 均值 | 单位 | 所述标准差 | 分散 | 分散/所述 | p | 超出部分
terminal_repeats_nothing = 没有由两次试验确定的量。
terminal_repeats_none = 各次试验间没有系数的差别超过所述标准差（p >= 0.05，已按个数校正）。
terminal_reseated = { $file }：相对{ $first }，所有输入轴共同转过一个角度，如同IMU重新安装：绕其x、y、z轴{ $about_x }、{ $about_y }、{ $about_z } arcsec。
terminal_reseated_explains = 这解释了{ $gyros }的D_O变化。
terminal_repeats_beyond = 各次试验的差别超过所述标准差（p < 0.05，已按个数校正），均值的标准差已计入：{ $coefficients }。

## `model fit`、`predict`、`gap`

terminal_fit_short = { $at }：{ $verdict }；预报将相差其余部分
terminal_fit_left_out = { $effect }未计入：这些试验不能确定它；docs/diagnosis.md说明各效应所需的条件
terminal_no_temperature = 无温度
terminal_model_of = { $imu }：{ $coefficients }个系数，取自{ $campaigns }次试验，{ $first }至{ $last }，参考温度：{ $reference }
terminal_model_gyros = 陀螺：deg/h、(°)/(h·g0)、pulse/arcsec、deg/sqrt(h)
terminal_model_gyros_head = 陀螺 | 编号 | D_F | D_I | D_S | D_O | |E| | 噪声N
terminal_model_plain = 模型(6)之外没有效应
terminal_model_effects = 效应
terminal_model_effects_head = 效应 | 陀螺 | 系数 | 数值 | 单位
terminal_forecast = { $imu }，{ $station }，{ $at }：由{ $model }的模型预报（{ $campaigns }次试验，{ $count ->
    [0] 没有效应
   *[other] { $effects }
}）
terminal_promised = 模型预计：{ $closes }
terminal_seen = 实测：{ $closes }
terminal_closes = 效应解释预报误差的{ $closure } %（95 %区间{ $low }至{ $high } %）；计入前{ $before } deg/h，计入后{ $after } deg/h
terminal_closes_nothing = 没有可解释的差异：不计效应时误差已在噪声范围内；计入前{ $before } deg/h，计入后{ $after } deg/h
terminal_nothing_to_close = 没有可解释的差异
terminal_foretold_head = 测点 | 陀螺 | 输出，pulse/s | 标准差 | 其中噪声
terminal_not_foretold = 未预报
terminal_to_measure = 最能补充模型所缺的测点
terminal_to_measure_head = 测点 | a，g0 | w，arcsec/s | 信息，nat | 标准差/噪声
terminal_forecast_measured = 实测：{ $state }。{ $count }个输出的误差/标准差均方根{ $rms }，p { $p }；PIT均匀性p { $pit }
terminal_forecast_outside = 超出预报
terminal_forecast_met = 与预报相符
terminal_forecast_not_judged = 无法判定
terminal_forecast_gyros_head = 陀螺 | 误差/标准差均方根 | p
terminal_missed = { $count }个输出与预报不符
terminal_missed_head = 不符测点 | 陀螺 | z
terminal_model_6 = 模型(6)
terminal_noise_floor = 噪声底
terminal_steps_head = 模型 | 预报误差，deg/h | 标准差倍数
terminal_gap_none = { $imu }：没有试验可以预报；需要同一组陀螺更早的试验
terminal_gap_of = { $imu }：各次试验的预报误差
terminal_gap_head = 试验 | 模型 | 预报误差，deg/h | 标准差倍数 | 留出闭合率
terminal_gap_plain = 没有采用任何效应。`gyrowatch model fit`可寻找效应。

## `dwells`

terminal_dwells_head = 测点 | 阶段 | 开始 s | 时长 s | 比力 g0 | 输出 pulse/s | ± pulse/s

## `import`, `revise`, `void`

terminal_tally = 存入{ $stored }份，已有{ $known }份，拒收{ $refused }份
terminal_together = 合计：{ $tally }
terminal_refused = 拒收{ $count }份
terminal_no_coefficients = 没有D_I与D_S：{ $reason }
terminal_verdicts = 判定：{ $counts }
terminal_counted = { $status }{ $count }项
terminal_watching = 正在监视{ $folder }，发送至{ $service }
terminal_revise_asked = { $file }：请在{ $beside }中写明由谁替换已存储的内容，以及原因
terminal_revise_unsaid = { $file }：需要`author: 姓名`一行与`reason: 原因`一行
file_empty = 为空
file_document_too_large = 是超过{ $bytes }字节的单个文档；请每行发送一个文档
file_of_several = 含{ $count }个文档：请各置一个文件，逐个发送
file_of_lines = 每行一个文档：请逐个发送
file_of_no_kind = 既不是标定记录（`gyros`）、标定试验（`dwells`），也不是台架结果（`method`）
file_nothing_to_print = 不是记录或台架结果的表格：没有可打印的内容
file_last_line_open = 最后一行没有换行符
terminal_link = { $file }：是符号链接，不予跟随
terminal_file_refused = 拒收
terminal_stays = { $trouble }；文件留在原处，稍后再试
terminal_again = { $trouble }；半分钟内继续重试
terminal_digest_late = 告警接口将在一刻钟后得知仍在触发的告警：{ $trouble }
terminal_interrupted = 中断；再次运行同一命令即可继续
terminal_replaced = 不再计入：已由{ $record }替代（{ $author }：{ $reason }）
terminal_voided = 不再计入：已作废（{ $author }：{ $reason }）
terminal_set_aside = 不计入：搁置，待确认时间
terminal_is_stored = 与已存储的{ $id }相同
terminal_is_withdrawn = 已存为{ $id }，且{ $standing }
terminal_put_back = `gyrowatch revise FILE --of { $id } --author NAME --reason WHY`可恢复
terminal_stands = 已替代{ $old }，编号{ $new }
terminal_revise_none = IMU { $imu }没有存储任何数据：请用`gyrowatch import`存储{ $time }的这份
terminal_revise_absent = IMU { $imu }在{ $time }没有存储；最近的为{ $nearest }。请改正时间，或用--of ID指明错误的那份；新的请用`gyrowatch import`存储
terminal_was_new = 此IMU在该时间没有存储；已存为{ $id }。若要替代另一时间的，请将其作废
terminal_is_voided = { $id }已作废
terminal_bench_revise = 是台架结果：请用`gyrowatch void ID --author NAME --reason WHY`作废错误的一份，再用`gyrowatch import`发送
replace_bench = 若此份正确，请用`gyrowatch void { $id } --author NAME --reason WHY`作废另一份，再发送一次

## 数据库与令牌

terminal_copied_head = 表 | 行数 | 已复制 | 校验和 | 结果
terminal_same = 一致
terminal_different = 不一致
terminal_copied = 已将{ $from }复制到{ $to }：行数与校验和一致
terminal_copy_differs = 副本与文件当前内容不符；应以空数据库重新开始
terminal_holdings = 完整；{ $records }个记录，{ $bench_results }个单表测试结果，{ $gyros }个陀螺的{ $figures }次标定
terminal_verified = 重新计算了{ $records }个记录、{ $separations }次分离、{ $verdicts }个判定、{ $bench_results }个单表测试结果
terminal_lists_verified = 列表中{ $gyros }个陀螺已与其存储内容比较
terminal_lists_not_compared = 陀螺列表尚未生成，或按其他限值生成：未比较，启动服务时将会生成
terminal_not_compared = { $verdicts }个判定所用的限值与现行限值不同，或由判定方法不同的早期版本作出，或其记录已不再计入：未比较
terminal_differ = { $count }处与重新计算的结果不符。若仅判定不符，在该记录之前为其陀螺登记一次`note`事件，即会重新判定；否则恢复verify未发现问题的最新备份
terminal_exported = { $gyros }个陀螺的{ $rows }行
terminal_token_made = 令牌{ $id }（{ $name }，{ $role }）：请立即保存，仅显示这一次
terminal_no_token_id = “{ $id }”不是令牌的标识；token list列出全部令牌
terminal_token_revoked = 令牌{ $id }已撤销
terminal_token_revoked_before = 令牌{ $id }此前已撤销
terminal_database = 数据库{ $url }
terminal_not_backed_up = 未能备份{ $database }
terminal_not_restored = 未能将{ $file }恢复到{ $database }
terminal_not_copied = 未能将{ $from }复制到{ $to }
terminal_export_form = { $file }：既不是.csv也不是.parquet；请给出--format
terminal_nameless = 记录{ $record }的IMU或测试站没有名称：请用gyrowatch verify检查数据库
terminal_no_parquet = 此程序编译时未含Parquet：cargo build --release --features parquet
terminal_no_answer = { $address }没有应答：{ $why }
terminal_answers = { $address }应答{ $status }：{ $why }
terminal_no_database = 没有数据库{ $database }
terminal_other_database = { $listen }处的服务使用的数据库不是{ $database }，后者不存在。请用GYROWATCH_DATABASE_URL或--config指明服务的数据库
terminal_new_database = 没有数据库{ $database }，现在新建。使用其他数据库的服务不认识此令牌：请用GYROWATCH_DATABASE_URL或--config指明那个数据库
terminal_tokens_head = 标识 | 名称 | 角色 | 测试站 | 创建时间 | 状态
terminal_revoked = 撤销于{ $at }
terminal_expired = 过期于{ $at }
terminal_until = 有效至{ $at }
terminal_valid = 有效
terminal_any = 不限
terminal_noise_means = 两次事件之间{ $coefficients }个系数的{ $cells }个周均值；{ $moving }个因有漂移而除外
terminal_noise_spacing = 相隔{ $weeks }个有记录的周（{ $days }天）：由{ $differences }个差值得离散{ $spread } (°)/(h·g0)
terminal_noise_fitted = 拟合：离散{ $scatter } (°)/(h·g0)，相关系数{ $phi }，随机游走{ $walk } (°)/(h·g0)/√年。写入配置的值（按100个周均值的权重向默认值收缩）：
terminal_noise_unfitted = 历史太短，无法拟合：继续使用默认值。
terminal_noise_stations_alike = 由历史看不出测试站之间的差异：between_stations保持为0。
store_full = 磁盘已满
store_unusable = 数据库不能读写：{ $why }
store_locked = 数据库被另一进程锁定
store_in_use = 另一个gyrowatch正在使用数据库{ $database }；请先停止它，或使用另一个文件
store_not_durable = 未能确认写入已落盘：{ $why }；请检查磁盘后重新启动
store_unreachable = 无法连接数据库：{ $why }
store_unanswered = 一次提交没有得到应答，也无法查询其结果：{ $why }
store_overtaken = 另一程序已先写入：{ $why }
store_refused = 数据库拒绝：{ $why }
store_other = 数据库

## 数据库的文件与服务器

file_absent = 没有此文件
file_there = 已经存在，不会覆盖
file_foreign = 不是gyrowatch的数据库
file_newer = 由更新版本的gyrowatch写成
file_older = 由较旧版本的gyrowatch写成：请先用它启动一次服务
file_name_not_utf8 = 文件名不是UTF-8
file_of_server = { $database }不是文件：服务器上的数据库用其自带工具pg_dump与pg_restore备份和恢复
no_directory = 没有文件夹{ $directory }：请先创建
directory_closed = 此账户不能在{ $directory }中写入，而数据库及其锁存放在该处
address_parameter = 无法识别其URL中的参数`{ $parameter }`；可设置的内容见配置
address_foreign = 不是数据库的地址
address_read_only = target_session_attrs={ $value }：服务需要写入，只接受any、read-write或primary
server_absent = 该处无程序监听；PostgreSQL是否运行在database.url的主机与端口？（{ $why }）
server_foreign = 应答者不是PostgreSQL：{ $why }
server_busy = 未能及时得到空闲连接
server_cells_lost = 已失去待写的单元
server_connection_lost = 连接已断开
server_pooled = 数据库之前的连接池按事务分配连接：请为此数据库设置pool_mode = session，或在database.url中直接写数据库的地址
copy_direction = 只能从sqlite://复制到postgres://
copy_of_other = 数据库中已有{ $file }的一部分：请继续复制该文件，或改用空的数据库
copy_not_empty = 数据库不是空的：{ $table }中已有数据
copy_unfinished = 向数据库的复制尚未完成：请再次运行gyrowatch copy
secrets_key_missing = 缺少GYROWATCH_SECRETS_KEY：{ $of }的密钥已加密；请用存储时的密钥启动
secrets_key_other = GYROWATCH_SECRETS_KEY不是加密{ $of }时所用的密钥

## 与存储时不同之处

damages = { $faults }
checksums_missing = 缺少校验和表checksum
table_unsummed = 表{ $table }没有校验和
table_of_other_length = 表{ $table }有{ $have }行，写入的是{ $written }行
table_changed = 表{ $table }中有一行与写入时不同
summed_table_missing = 有校验和的一个表已不存在
row_refers_to_none = 表{ $table }中有一行指向不存在的行
calendar_entries = 日历中有{ $count }项不属于任何记录
fault_of_record = 记录{ $id }：{ $fault }
fault_of_bench_result = 单表测试结果{ $id }：{ $fault }
fault_of_gyro = 陀螺{ $serial }：{ $fault }
in_index_only = 只存在于索引中
record_elsewhere = 其IMU将它列在别处
text_not_as_stored = 其原文与存储时不同
text_unreadable = 其原文无法读取
under_other_imu = 存储在IMU { $stored }之下，原文为{ $sent }
under_other_station = 存储在测试站{ $stored }之下，原文为{ $sent }
under_other_time = 存储的时间与原文不同
head_missing = 在表head中缺失
head_differs = 表head中为{ $found }，由所存内容应为{ $expected }
not_of_model_in_force = 不是按其IMU的现行模型给出
history_missing = 在其履历中缺失
history_of_another = 其履历给出的记录、IMU、位置或测试站不同
figures_differ = 存储的是{ $stored }，重新计算得{ $again }（D_I、D_S、D_O，(°)/(h·g0)，等等）
verdicts_missing = 没有判定
verdict_differs = 规则{ $rule }对{ $coefficient }的判定为{ $stored }，重新计算得{ $again }
state_differs = 其状态与各判定不符
bench_differs = 存储的是{ $stored }，原文为{ $sent }（D_I与D_S，(°)/(h·g0)）

## 不能执行

terminal_scenario = 仿真场景
terminal_csv_of_experiment = --csv只用于--preset { $preset }
terminal_count_needs_dir = --count需要以--dir指定写入的文件夹
terminal_experiment_takes = { $preset }含七次试验：只接受--seed、--count，以及--dir或--csv
terminal_seeds_end = 种子最大为{ $last }
model_effects_of_imu = 模型文件的效应用于IMU标定试验；此为单表测试
effect_cannot_act = { $effect }在此仿真场景中不起作用：{ $missing }
effect_without_estimate = { $slot }的{ $effect }没有{ $coefficient }的估计值
none_of_these_gyros = 试验中没有这些陀螺
hypothesis_unseen = 此试验设计看不到{ $effect }：模型将其全部吸收，或试验没有噪声
hypothesis_of_model = --hypothesis：所用模型中另有一个{ $id }；请更改其中一个的id
hypothesis_undefined = --hypothesis：{ $id }：{ $lack }（{ $place }）：{ $equation }在此处除以零，或开方、取对数无定义。请改写，使每个测点都有值
terminal_not_reached = 有指标未达到
terminal_key_sealed = { $count }次试验的答案已封存：SHA-256 { $seal }
terminal_key_revealed = 答案已公开：{ $file }
terminal_key_read = 答案{ $file }：SHA-256 { $seal }
terminal_is_campaign = 这是标定试验：请用`gyrowatch calibrate`标定，它同时分离各陀螺
terminal_is_record = 这是标定记录：请用`gyrowatch separate`分离
terminal_is_bench_result = 这是单表测试结果，已含D_I与D_S；`gyrowatch import`可将其发送至服务
terminal_record_without_dwells = 记录没有测点；--model、--hypothesis、--adopt、--report与--reference用于标定试验
terminal_order_canceled = 诊断任务{ $id }已取消；未诊断的试验：{ $count }次
terminal_not_diagnosed = { $count }次试验中有{ $failed }次未能诊断
terminal_order_goes_on = 诊断任务{ $id }在服务中继续；再次运行同一命令即可接续
terminal_gap_needs_campaigns = 给出模型文件时，请列出与之比较的试验
terminal_hypothesis_by_id = --hypothesis：请在--effects中给出其id；试验是否显示它，由`diagnose --hypothesis`回答
terminal_one_occasion = --effects：{ $effect }属于发生它的那次试验；auto会在该试验中找到它
terminal_part_of_g = --effects：{ $effect }是G的一部分，模型已包含
terminal_no_model_file = { $faults }；也没有此名称的模型文件
terminal_holds_no_model = { $file }：不是模型文件，只替换模型文件；请另取名称
terminal_model_without_imu = { $file }：只有效应，没有IMU的系数；`gyrowatch model fit`可生成含系数的文件
terminal_too_large = 大于{ $most }字节
terminal_file_replaced = 已替换{ $file }
terminal_files_replaced = 已替换{ $folder }中的{ $count }个文件
terminal_no_template = 没有{ $format }格式的{ $of }：见`gyrowatch template --help`
terminal_workbook_out = 请用--out FILE写出工作簿
terminal_diagnosis_failed = { $imu }的{ $campaign }（{ $at }）：{ $reason }

## 与服务通信

terminal_no_address = “{ $address }”不是服务的地址，地址形如http://127.0.0.1:8080
terminal_no_certificate = { $file }：不含PEM证书
terminal_token_read_again = 令牌被拒，已重新读取{ $file }
terminal_cannot_reach = 无法连接{ $address }：{ $why }
terminal_foreign_answer = 应答不是来自gyrowatch
terminal_batch_refused = 整批被拒收：{ $why }
terminal_answers_missing = 发送了{ $sent }行，只有{ $answered }行得到应答
terminal_is_folder = { $folder }是文件夹；请列出其中的文件，或用--watch监视
terminal_no_folder = { $folder }应为文件夹，不能是符号链接或文件
terminal_cannot_move = 无法将其移到{ $file }
terminal_nothing_to_void = 没有标识为“{ $id }”的记录、标定试验或单表测试结果

## `serve`、`demo`

terminal_listens = gyrowatch服务地址：{ $url }
terminal_cannot_listen = 无法监听{ $address }（server.listen）
terminal_cannot_use = 无法使用数据库{ $database }（database.url）
terminal_token_first = 无法监听{ $address }（server.listen）：尚无令牌，任何人都可进行任何操作。请先创建令牌：gyrowatch token create NAME --role admin
terminal_not_ended = 并非全部工作都在{ $seconds } s（server.shutdown_grace_s）内结束：未应答的内容可能没有存储
terminal_demo_on = 位于{ $address }的演示（--listen可指定其他地址，端口0为任一空闲端口）
terminal_demo_not_posted = 未能发送演示数据：{ $why }
terminal_demo_posted = 已通过API发送{ $count }个记录、单表测试结果与履历事件
terminal_demo_pages =
    全部陀螺            { $base }/
    D_I上升的陀螺       { $base }/gyros/LFG-0004
    上升的原因          { $base }/gyros/LFG-0004/diagnosis
    允差内老化的陀螺    { $base }/gyros/LFG-0014
    D_S跳变的陀螺       { $base }/gyros/LFG-0008
    修理并移装的陀螺    { $base }/gyros/LFG-0011
    待诊断的原始试验    { $base }/imus/IMU-21
    表5：两种方法对照   { $base }/gyros/PAPER-T5-G1
    趋势（CSV）         { $base }/v1/gyros/LFG-0004/trend?coefficient=D_I&format=csv
    API说明与试用       { $base }/docs

    按Ctrl-C停止；数据保留在文件中。

## `simulate`

preset_24_position = 24个位置、6次重复与48个速率测点，次序随机：共78个三分钟的测点
preset_24_bare = 24个位置各一次，次序固定，没有速率测点，E已给出：可得出D_I与D_S的最少测点
preset_36_position = 24个位置与12个45°棱向位置，6次重复，48个速率测点
preset_60_position = 24个位置、棱向位置、30°与60°倾斜位置，6次重复，48个速率测点
preset_long = 1008个测点：60位置程序共八遍，四次通电，零偏漂移，输出按脉冲计数
preset_orthogonal_mems = 三只正交陀螺，整脉冲计数，没有速率测点，没有温度，没有标准误差
preset_paper_experiment = 表5：各陀螺先做单表测试，再一同装入IMU标定，然后再做单表测试
terminal_ranges = 首次单表测试、IMU标定与再次单表测试三个结果的极差；自种子{ $seed }起{ $count }次仿真试验
terminal_ranges_head = 陀螺 | 系数 | 方法 | 中位数 | 95 % | 最大 | 小于1.301e-3
terminal_ranges_below = 一次试验的六个极差均小于{ $headline } (°)/(h·g0)：

## `blindcheck`

terminal_hypothesis = 此设计的试验中的{ $id }：{ $found }
terminal_named_never = 所列大小均未达到{ $share }的识别率：请给出更大的d
terminal_named_from = 自{ $size } { $unit }起，识别率达{ $share }
terminal_named_shown = 自{ $size } { $unit }起，识别率达{ $share }；自{ $surely }起有统计证实
terminal_named_unshown = 自{ $size } { $unit }起，{ $trials }次中识别{ $hits }次，即{ $interval }（95 %区间），不足以证实{ $share }：请用--count { $least }或更多
terminal_hypothesis_head = d | 最大系数（中位数） | 试验数 | 识别 | 95 %区间 | 仅在等价类中 | 其他效应
terminal_hard_to_tell = 此处难以与之区分：{ $effects }
terminal_where_not = 不含该效应时：{ $trials }次中识别{ $hits }次（{ $rate }，95 %区间{ $interval }）；识别出任何效应{ $anything }次
terminal_undiagnosed = 没有结果：{ $why }
terminal_blind_campaigns = { $count }次试验，答案SHA-256 { $seal }
terminal_blind_key = 识别：指出该效应本身，或指出试验无法再区分而含有该效应的等效类
terminal_goals_head = 情形 | 命中 | 次数 | 比率 | 95 %区间 | 指标
terminal_fleet_goals_head = 项目 | 命中 | 次数 | 比率 | 95 %区间 | 指标
terminal_reached = 达到
terminal_short_of_it = 未达到
terminal_by_effect_head = 单个效应的识别：按效应 | 命中 | 次数 | 比率 | 95 %区间
terminal_by_design_head = 按位置组合 | 命中 | 次数 | 比率 | 95 %区间
terminal_by_errors_head = 按标准误差 | 命中 | 次数 | 比率 | 95 %区间
terminal_by_family_head = 目录之外，部分解释或未解释 | 命中 | 次数 | 比率 | 95 %区间
terminal_confusion_head = 隐藏的效应 | 指出的效应（-为未指出）及次数
terminal_named_instead_head = 隐藏的原因 | 误指的原因（-为未指出）及次数
terminal_blind_times = 一次诊断：中位数{ $median } ms，99 %分位{ $p99 } ms，最长{ $most } ms；全部试验：{ $seconds } s
terminal_kinds_head = 类别 | 试验数 | 确信而误 | 存疑而误 | 可见者全部识别 | 部分可见而称全部解释 | 留出闭合率在其区间内 | 有差异而未指出 | 说明噪声 | 已描述 | 中位数，ms | 没有结果
terminal_blind_fleets = 种子{ $seed }的{ $fleets }组陀螺，{ $seconds } s
terminal_speed =
    { $gyros }只陀螺，各{ $records }个记录：{ $threads }个线程用时{ $fleet_s } s
    一只陀螺，{ $of_one }个记录，40只同组陀螺：{ $one_ms } ms（中位数），{ $slowest_ms } ms（最长）

## 参数的值

argument_one_of = 应为{ $known }之一
argument_presets = 预设有{ $known }
argument_positive = 应为正数
argument_count = 应为从1起的整数
argument_seconds = 应为0至3600之间的秒数
