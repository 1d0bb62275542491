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
terminal_effects_head = 效应 | 陀螺 | 参数 | 数值 | 单位 | 解释比例 | p | d | 或同样可能
terminal_effects_key =
    解释比例：占可消除差异（留出测点上误差超出噪声底的部分）的比例，附95 %区间；有多个效应时，
    各占其上各项所余的比例：请比较d，不要比较解释比例
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
terminal_moved_by = { $slot }的{ $coefficient }：因变化而移动{ $shift } (°)/(h·g0)
terminal_diagnosed = 已诊断{ $count }次试验
terminal_clean = { $count }次在噪声范围内
terminal_count_explained = { $count }次差异已解释
terminal_count_partly = { $count }次差异部分解释
terminal_count_unexplained = { $count }次差异未能用目录解释
terminal_count_outdated = 其中{ $count }次由其他版本的程序诊断
terminal_count_refused = { $count }次无法诊断，未计入
terminal_count_waiting = { $count }次尚未诊断
terminal_findings_head = 效应 | 陀螺 | IMU | 测试站 | 此前最后未出现 | 首次出现 | 最近出现 | 试验数 | 解释比例 | D_I | D_S
terminal_or = 或{ $effects }
terminal_of = { $part }，共{ $all }
terminal_to = { $from }至{ $to }
terminal_findings_key =
    试验数：出现该效应／首次出现以来，共该陀螺全部；解释比例：留出测点上，该次试验中先指出的效应
    所余可消除差异的解释比例，中位数（最小至最大）；
    D_I、D_S：最大变化，(°)/(h·g0)，及占允许范围的比例
terminal_doubts = 目录不能解释或不能完全解释
terminal_doubts_head = IMU | 结论 | 陀螺 | 迹象 | 测试站 | 试验数 | 首次 | 最近

## `dwells`

terminal_dwells_head = 测点 | 阶段 | 开始 s | 时长 s | 比力 g0 | 输出 pulse/s | ± pulse/s

## `import`, `revise`, `void`

terminal_tally = 存入{ $stored }份，已有{ $known }份，拒收{ $refused }份
terminal_together = 合计：{ $tally }
terminal_refused = 拒收{ $count }份
terminal_no_coefficients = 没有D_I与D_S：{ $reason }
terminal_verdicts = 判定：{ $counts }
terminal_counted = { $status }{ $count }项
terminal_interrupted = 中断；再次运行同一命令即可继续
terminal_replaced = 不再计入：已由{ $record }替代（{ $author }：{ $reason }）
terminal_voided = 不再计入：已作废（{ $author }：{ $reason }）
terminal_set_aside = 不计入：搁置，待确认时间
terminal_is_stored = 与已存储的{ $id }相同
terminal_is_withdrawn = 已存为{ $id }，且{ $standing }
terminal_put_back = `gyrowatch revise FILE --of { $id } --author NAME --reason WHY`可恢复
terminal_stands = 已替代{ $old }，编号{ $new }
terminal_was_new = 此惯性组合在该时间没有存储；已存为{ $id }。若要替代另一时间的，请将其作废
terminal_is_voided = { $id }已作废
terminal_bench_revise = 是台架结果：请用`gyrowatch void ID --author NAME --reason WHY`作废错误的一份，再用`gyrowatch import`发送
replace_bench = 若此份正确，请用`gyrowatch void { $id } --author NAME --reason WHY`作废另一份，再发送一次
