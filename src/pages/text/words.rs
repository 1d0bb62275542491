//! The catalogue. Longer than 400 lines because it is one table.

macro_rules! catalogue {
    ($($key:ident: $english:literal, $chinese:literal;)*) => {
        /// The words of one language.
        pub(in crate::pages) struct Text { $(pub $key: &'static str),* }
        pub(super) const ENGLISH: Text = Text { $($key: $english),* };
        pub(super) const CHINESE: Text = Text { $($key: $chinese),* };
    };
}

catalogue! {
    tag: "en", "zh";

    // The frame of every page.
    fleet: "Fleet", "全部陀螺";
    stations: "Stations", "标定台站";
    api: "API", "接口";
    other_language: "中文", "English";
    dark: "Dark", "深色";
    light: "Light", "浅色";
    skip: "Skip to content", "跳到正文";
    navigation: "Pages", "页面导航";
    error_title: "This did not work", "出错了";
    error_back: "Back to the fleet", "返回陀螺总览";

    // Quantities.
    unit: "deg/(h g0)", "°/(h·g0)";
    serial: "Gyro", "陀螺编号";
    imu: "IMU", "惯性组合";
    station: "Station", "台站";
    state: "State", "状态";
    calibrated: "Calibrated", "标定时间";
    method: "Method", "方法";
    date: "Date", "日期";
    range: "Range", "极差";
    meaning_d_i: "mass unbalance along the spin axis, drift per g along I", "沿自转轴的质量不平衡，对应沿I轴的比力";
    meaning_d_s: "mass unbalance along the input axis, drift per g along S", "沿输入轴的质量不平衡，对应沿S轴的比力";
    meaning_d_o: "closure: the mounting, or a true output-axis term", "闭合差：安装偏差或真实的输出轴项";
    meaning_e: "scale factor and direction of the input axis", "标度因数与输入轴方向";
    meaning_g: "g-sensitive terms", "与g有关的项";
    meaning_all: "the gyro as a whole", "整个陀螺";

    // States, rules, events, methods.
    slot: "Slot", "位置";
    within: "within", "合格";
    indeterminate: "undecided", "待定";
    exceeded: "exceeded", "超限";
    warning: "warning", "预警";
    flagged: "flagged by a rule, inside the budget", "规则报警，仍在允许范围内";
    no_record: "not calibrated", "未标定";
    rule_step: "step", "相邻变化";
    rule_range: "range", "极差";
    rule_baseline: "distance from baseline", "偏离基线";
    rule_trend: "trend", "趋势";
    rule_cusum: "lasting shift", "持续偏移";
    rule_rms_successive: "scatter", "离散";
    rule_closure: "closure", "闭合差";
    rule_agreement: "agreement of methods", "方法一致性";
    rule_requirement: "requirement", "指标要求";
    rule_overdue: "overdue", "超期未标";
    event_baseline: "new baseline", "新基线";
    event_repair: "repair", "修理";
    event_reinstallation: "re-installation", "重新安装";
    event_transport: "transport", "运输";
    event_firmware: "firmware", "固件更新";
    event_note: "note", "备注";
    moved: "moved", "更换位置";
    other_station: "other station", "更换台站";
    method_rigid: "rigid", "刚体法";
    method_published: "published, eqs. (8)-(13)", "论文公式(8)-(13)";
    method_bench: "bench", "单表测试";
    method_torque_feedback: "torque feedback", "力矩反馈";
    method_turntable_servo: "turntable servo", "转台伺服";

    // The fleet.
    search: "Search", "搜索";
    search_hint: "serial, IMU or station", "陀螺、惯性组合或台站";
    all_states: "all", "全部";
    overdue: "overdue", "超期";
    none_found: "Nothing fits these filters.", "没有符合条件的陀螺。";
    nothing_yet: "Nothing is stored yet. Post a calibration record to /v1/records, or send files with gyrowatch import.", "尚无数据。请向 /v1/records 提交标定记录，或用 gyrowatch import 发送文件。";
    clear_filters: "Clear filters", "清除筛选";
    worst_first: "worst first", "最差优先";
    days_ago: "days ago", "天前";
    today: "today", "今天";
    violates: "Violates", "违反";
    page_of: "page", "第";
    previous: "Previous", "上一页";
    next: "Next", "下一页";
    gyros: "gyros", "陀螺数";
    last_seen: "Last heard of", "最近上报";
    band_note: "Line: the last calibrations. Grey band: the budget about the baseline. Exceeded: a budget or requirement is broken; warning: only a statistical limit is.", "折线：最近各次标定；灰带：基线上下的允许范围。超限：超出允许范围或指标；预警：仅超出统计控制限。";

    // One gyro.
    history: "History", "历史";
    plot_note: "Bars: one standard deviation. Grey band: the budget about the baseline. Dotted: control limits, three standard deviations of the gyro's own scatter. Drag to zoom, double-click for all.", "误差棒：一倍标准差；灰带：基线上下的允许范围；点线：控制限，为陀螺自身离散的三倍标准差。拖动放大，双击还原。";
    since_baseline: "Since the last baseline", "自最近基线起";
    whole_history: "All", "全部";
    save_picture: "Save picture", "保存图片";
    verdicts: "Verdicts on the newest record", "最新记录的判定";
    verdicts_within: "Rules that are kept:", "合格项：";
    too_few: "with too few records to judge:", "记录不足未判：";
    agreement: "Agreement of methods", "方法一致性";
    agreement_note: "As in Table 5 of the paper: results of every method side by side.", "与论文表5相同：各方法结果并列。";
    not_counted: "for comparison, not in the range", "仅供比较，不计入极差";
    one_result: "One result alone: nothing to compare yet.", "只有一个结果，尚无法比较。";
    events: "What happened to it", "经历";
    no_events: "Nothing is noted.", "无记录。";
    calibrations: "Calibrations", "标定记录";
    older: "Older", "更早";
    newer: "Newest", "最新";
    csv: "CSV", "CSV";
    thinned: "points, thinned to their extremes in each stretch", "个点，按区段保留极值后显示";
    never_calibrated: "Never calibrated in an IMU.", "从未在惯性组合中标定。";
    confirmed: "confirmed by a second campaign", "已由第二次标定证实";

    // One calibration.
    record: "Calibration record", "标定记录";
    campaign: "Campaign", "标定试验";
    measured: "measured", "测试时间";
    received: "Received", "收到";
    identifier: "id", "编号";
    operator: "operator", "操作员";
    dwells: "dwells", "个位置段";
    dwell: "dwell", "位置段";
    diagnose: "Diagnose: where it parts from the error model, and why", "诊断：与误差模型的差异及原因";
    verdicts_of_record: "Verdicts", "判定";
    not_judged: "Nothing is judged.", "无判定。";
    separated: "Separated coefficients", "分离结果";
    as_printed: "as printed", "按原文印刷";
    as_printed_note: "As printed: equations (8) to (13) letter by letter, misprints included, for comparison only. The number in brackets is the equation that applies.", "按原文印刷：公式(8)-(13)逐字照用，含印刷错误，仅供比较。括号内为所用公式编号。";
    closure_rms: "closure rms", "闭合差均方根";
    mounting: "Angles of the input axis", "输入轴角度";
    misalignment: "off nominal", "偏离标称";
    clocking: "clocking of S about I", "S绕I的转角";
    parameters: "Parameters of model (6)", "模型(6)参数";
    requirement_note: "Limits: requirements of Tables 3 and 4 of the paper.", "限值：论文表3与表4的要求。";
    not_determined: "not determined by these dwells", "这些位置段不能确定";
    pass: "pass", "合格";
    fail: "fail", "不合格";
    fit_quality: "Quality of the fit", "拟合质量";
    rank: "rank / parameters", "秩/参数数";
    freedom: "ν", "ν";
    noise: "noise", "噪声";
    sem_factor: "real / stated noise", "实际/标称噪声";
    noise_from: "noise known from", "噪声来源";
    not_seen: "no dwell sees the direction", "任何位置段都看不到的方向";
    fixed_by: "fixed by", "约束条件";
    residuals_by_dwell: "Residuals by dwell", "各位置段残差";
    residuals_note: "Each over its own standard deviation; the band is two of them.", "以各自标准差为单位；灰带为两倍标准差。";
    no_noise: "Nothing gives the noise, so residuals have no scale.", "噪声未知，残差无法归一化。";
    every_residual: "Every residual as a table", "全部残差列表";

    // Diagnoses of many campaigns.
    diagnoses: "Diagnoses", "诊断汇总";
    diagnoses_note: "What the diagnoses of all campaigns say together: which effects, in which gyros, at which stations, since when.", "汇总所有标定试验的诊断：哪些效应、出现在哪些陀螺和台站、始于何时。";
    measured_since: "Measured since", "测试起始";
    measured_until: "Measured until", "测试截止";
    what_was_found: "What was found", "诊断结果";
    campaigns_diagnosed: "Campaigns diagnosed:", "已诊断的标定试验：";
    campaigns: "Campaigns", "试验数";
    coverage_no_gap: "no gap", "无差异";
    coverage_explained: "explained", "已解释";
    coverage_partly_explained: "partly explained", "部分解释";
    coverage_unexplained: "unexplained", "未解释";
    coverage_refused: "nothing to diagnose", "无法诊断";
    coverage_waiting: "not diagnosed yet", "尚未诊断";
    coverage_outdated: "by another version of the program", "由其他版本的程序诊断";
    first_seen: "First with it", "首次出现";
    last_seen_in: "Last with it", "最近出现";
    last_clear: "Last without it before", "此前最后一次未出现";
    gyro_by_gyro: "Gyro by gyro", "逐个陀螺";
    findings_note: "Campaigns: with the effect / since the first one with it / of the gyro. At a station: with the effect / of the gyro there. Closed: of the reducible gap on held-out dwells, the median with the least and the greatest. Shift: the largest by all effects named in a campaign, with its part of the budget; dwells cannot show a smaller one than their noise.", "试验数：出现该效应／首次出现以来／该陀螺全部。台站：出现／该陀螺在此的试验。解释比例：留出位置段上可消除差异的解释比例，中位数及最小、最大值。变化：试验中所有效应造成的最大变化及占允许范围的比例；小于噪声的变化无法显示。";
    or_as_well: "or just as well:", "或同样可能：";
    closed: "Closed", "解释比例";
    not_explained: "Not explained by the catalogue", "目录不能解释的差异";
    doubts_note: "Something remains in these IMUs that no effect of the catalogue accounts for, or not wholly.", "这些惯性组合中仍有目录效应不能或不能完全解释的差异。";
    verdict_word: "Verdict", "结论";
    signs_word: "What shows it", "迹象";
    orders: "Orders", "诊断任务";
    no_orders: "No order yet. New campaigns are diagnosed without one.", "尚无任务。新收到的试验会自动诊断。";
    ordered: "Ordered", "下达";
    which_campaigns: "Which campaigns", "范围";
    progress: "Progress", "进度";
    failed_word: "Failed", "失败";
    ended: "Ended", "结束";
    order_done: "done", "完成";
    order_canceled: "canceled", "已取消";
    order_running: "running", "进行中";
    order_waiting: "waiting", "等待";
    cancel: "Cancel", "取消";
    all_campaigns: "all", "全部";
    again_short: "(again)", "（重新诊断）";
    not_diagnosed: "Not diagnosed, of the order of", "未能诊断，任务下达于";
    new_order: "Diagnose many campaigns", "批量诊断";
    new_order_note: "Behind all other work, on every processor. What is done stays done when the service stops, and the rest is taken up again. What is left empty narrows nothing; dates are days in UTC.", "在其他工作之后以最低优先级运行，使用全部处理器。服务停止时已完成的保留，其余在启动后继续。留空表示不限；日期为UTC日。";
    again_word: "Also those whose diagnosis is up to date", "已是最新诊断的也重新进行";
    start_order: "Start", "开始";

    // A diagnosis.
    diagnosis: "Diagnosis", "诊断";
    diagnosis_waiting: "Other diagnoses are being computed; load the page again in a few seconds.", "正在计算其他诊断，请几秒后刷新。";
    verdict_no_gap: "The model predicts this campaign to within its noise: there is no gap to explain.", "模型与试验数据在噪声范围内一致：没有需要解释的差异。";
    verdict_explained: "There is a gap; what is named below explains it, and nothing significant remains.", "存在差异；下列效应已解释，没有显著剩余。";
    verdict_partly_explained: "There is a gap; what is named below explains part of it, and something significant remains.", "存在差异；下列效应解释了一部分，仍有显著剩余。";
    verdict_unexplained: "There is a gap, and nothing in the catalogue earns the blame.", "存在差异，但目录中没有可以归因的效应。";
    gap_before: "Gap before", "解释前";
    gap_after: "Left after", "解释后";
    noise_floor: "Noise floor", "噪声底";
    sign_of_more: "Sign of more", "还有其他迹象";
    sign_lack_of_fit: "the fit leaves more than repeats scatter", "拟合残差大于重复测量的离散";
    sign_spread: "residuals spread wider than the noise", "残差的离散大于噪声";
    sign_neighbours_in_time: "successive dwells err alike", "相继的位置段误差相似";
    sign_runs_in_time: "dwells of one stretch of time err alike", "同一时段的位置段误差相似";
    sign_same_force: "dwells of one specific force err alike", "比力相同的位置段误差相似";
    sign_orientations: "dwells of neighbouring orientations err alike", "姿态相邻的位置段误差相似";
    sign_similar_rates: "dwells of similar rates err alike", "角速度相近的位置段误差相似";
    sign_orientation_before: "dwells after one and the same orientation err alike", "前一姿态相同的位置段误差相似";
    sign_temperatures: "dwells of similar temperatures err alike", "温度相近的位置段误差相似";
    what_parts_them: "What parts them", "差异来源";
    no_effect: "No effect is named.", "没有指出任何效应。";
    all_together: "All together", "合计";
    adjusted_p: "adjusted p", "校正p值";
    detectability: "detectability", "可检测度";
    cannot_tell_from: "This campaign cannot tell it from:", "本次试验无法与下列效应区分：";
    alone_cannot_tell_from: "alone cannot tell it from:", "单独无法与下列效应区分：";
    parameter: "Parameter", "参数";
    value: "Value", "数值";
    unit_word: "Unit", "单位";
    all_gyros: "all", "全部";
    held_out: "of the reducible gap closed on dwells that were held out:", "的可消除差异在留出的位置段上得到解释：";
    located: "Where", "位置";
    heat_note: "Gyro by dwell. Shade: residual before over its standard uncertainty; full at six.", "陀螺×位置段；颜色深浅为解释前残差与其标准不确定度之比，6倍时最深。";
    heat_map: "residual over uncertainty, gyro by dwell", "各陀螺各位置段残差与不确定度之比";
    place: "Place", "位置";
    share: "Share of the gap", "所占差异";
    against: "Against an earlier calibration", "与以往标定比较";
    against_note: "Root mean square over the dwells, deg/h; the squares of the three parts add up to that of the whole.", "各位置段的均方根，°/h；三部分的平方和等于总差异的平方。";
    none_before: "No calibration of this IMU is earlier; a later one can be chosen.", "该惯性组合没有更早的标定，可以选择较晚的标定。";
    hold_against: "Compare", "比较";
    reference: "Reference", "参照标定";
    whole_gap: "Whole gap", "总差异";
    part_parameters: "Parameters", "参数变化";
    part_structure: "Structure", "模型结构";
    part_noise: "Noise", "噪声";
    p_parameters: "p of the parameters", "参数变化p值";
    now: "Now", "本次";
    what_else: "What else was tried", "其他候选";
    effect: "Effect", "效应";
    closes_alone: "Closes alone", "单独解释";
    why_not: "Why it was not taken", "未采用原因";
    impact: "What it does to the drift coefficients", "对漂移系数的影响";
    impact_within_noise: "They move no drift coefficient beyond its noise.", "所有漂移系数的变化均在噪声范围内。";
    plain: "Plain", "原值";
    with_effects: "With the effects", "计入效应后";
    shift: "Shift", "变化";
    of_budget: "Of the budget", "占允许范围";
    how_far: "Before and after", "解释前后";
    before_after_note: "Hollow: after the fit of the model in use. Filled: with the named effects added. Band: two standard uncertainties.", "空心：按现用模型拟合后；实心：计入所指效应后；灰带：两倍标准不确定度。";
    cannot_be_told: "What this campaign cannot tell", "本次试验无法判断的效应";
    visible: "Visible", "可见部分";
    why: "Why", "原因";
    would_show: "What would show it", "需要的条件";
    measure_next: "What to measure next", "建议下一步测量";
    phase_word: "Phase", "阶段";
    phase_static: "static", "静态";
    phase_rate: "rate", "速率";
    specific_force: "Specific force", "比力";
    rate_word: "Rate", "角速度";
    separates: "Separates", "可区分";
    notes: "Notes", "说明";

    // An IMU; stations.
    gyros_in_it: "Gyros in it", "所装陀螺";
    newest_parameters: "Newest parameters", "最新参数";
    records: "Calibrations", "历次标定";
    kind: "Kind", "类型";
    kind_record: "record", "记录";
    kind_campaign: "campaign", "原始试验";
    station_note: "Of every gyro's last records. Scatter: root mean square of the differences between successive calibrations at this station, over √2. Changes: what D_I and D_S did when a gyro came here from another station.", "取自各陀螺最近的记录。离散：同一台站相邻两次标定之差的均方根除以√2。换台变化：陀螺从其他台站转来时D_I、D_S的变化。";
    scatter: "Scatter", "离散";
    on_arrival: "Change on arrival", "换台变化";
    changes_seen: "changes", "次数";
    calibrations_seen: "Calibrations seen", "计入标定数";

    // Import.
    import: "Import", "导入";
    import_note: "A calibration record, a campaign or a bench result: JSON, one document a line (NDJSON), or a campaign's CSV. Nothing is stored before you have seen what it says.", "标定记录、原始试验或单表测试结果：JSON、逐行NDJSON，或试验CSV。预览确认之前不存储任何内容。";
    choose_file: "Choose a file, or drop it here:", "选择文件，或拖放到此处：";
    or_paste: "Text of the file:", "文件内容：";
    preview: "Preview", "预览";
    no_document: "There is no document in it.", "其中没有任何文件内容。";
    can_be_stored: "can be stored", "项可以存储";
    cannot_be_stored: "cannot, and will not be", "项有误，不会存储";
    store: "Store", "存储";
    store_note: "Storing the same again is harmless.", "重复存储同样内容无妨。";
    result: "Result", "结果";
    line: "Line", "行";
    refused: "refused", "拒绝";
    is_stored: "stored:", "已存储：";
    was_there: "was stored before with the same content:", "此前已存储，内容相同：";

    // Alerts.
    alerts: "Alerts", "警报";
    alerts_open: "Alerts on this gyro", "该陀螺的警报";
    alerts_note: "Newest first. An alert lasts: when it fires again it is the same alert.", "最新在前。警报是持续的：再次触发仍为同一警报。";
    no_alerts: "No alert fits.", "没有符合条件的警报。";
    alert_all: "all", "全部";
    alert_firing: "firing", "触发中";
    alert_acknowledged: "acknowledged", "已确认";
    alert_silenced: "silenced", "已静默";
    alert_resolved: "resolved", "已恢复";
    severity: "Severity", "级别";
    severity_critical: "critical", "严重";
    rule_word: "Rule", "规则";
    any: "any", "不限";
    fired: "Fired", "触发时间";
    said_by: "by", "由";
    until: "until", "至";
    acknowledge: "Acknowledge", "确认";
    acknowledge_title: "Acknowledge an alert", "确认警报";
    acknowledge_what: "Somebody knows: hooks hear no more repeats of this alert until it resolves or grows more severe. Both are still told.", "表示已有人知悉：在恢复或升级之前，不再向通知目标重复发送；恢复与升级仍会通知。";
    silence: "Silence", "静默";
    silence_title: "Silence an alert", "静默警报";
    silence_what: "Nobody is told of this alert before the silence ends. What has changed by then is told at its end.", "静默结束前不通知任何人；期间的变化在结束时通知。";
    silence_days: "For how many days", "静默天数";

    // What somebody does: who, why, and that it is meant.
    actions_word: "Actions", "操作";
    who: "Your name", "姓名";
    reason_word: "Reason", "原因";
    confirm_word: "I have read what this does, and mean it.", "我已阅读以上说明并确认执行。";
    confirmation: "Confirmation", "确认";
    event_time: "When", "时间";
    hook_secret_word: "Secret", "密钥";
    must_confirm: "tick that you mean it", "请勾选确认";
    go_back: "Back without doing it", "返回，不执行";
    add_event: "Add an event", "添加事件";
    start_baseline: "Start a baseline", "开始新基线";
    event_what: "The event is kept for good with your name and reason, and stands in the gyro's history. It resets:", "事件连同姓名与原因永久保存，列入该陀螺的经历。它会重置：";
    resets_nothing: "no rule", "无规则";
    event_word: "Event", "事件";
    event_at: "When (UTC, as 2026-03-01T08:00:00Z; now, if empty)", "时间（UTC，如 2026-03-01T08:00:00Z；留空为现在）";

    // What counts no more.
    void: "Void", "作废";
    void_record: "Void this record", "作废该标定记录";
    void_campaign: "Void this campaign", "作废该标定试验";
    void_bench: "Void this bench result", "作废该单表测试结果";
    void_what: "It counts no more: baselines, trends, verdicts and alerts become what they would be if it had never come. It is kept as it was sent, with your name and reason, and stays to be seen. It cannot be made to count again; what was measured can be sent anew as a revision.", "该结果不再计入：基线、趋势、判定与警报均按从未收到它重新得出。原文连同姓名与原因永久保存，随时可查。作废不可撤销；可以修订的形式重新提交测量结果。";
    voided: "voided", "已作废";
    revised: "revised", "已修订";
    was_voided: "Voided: it counts no more.", "已作废：不再计入。";
    was_revised: "Revised: in its place stands", "已修订，代之以";
    stands_for: "It stands in the place of", "代替";
    replacement: "what stands in its place", "替代记录";
    calibration_of: "calibration of", "标定";
    bench_result: "bench result of", "单表测试";
    bench_results: "Bench results", "单表测试结果";

    // Hooks.
    hooks: "Hooks", "通知目标";
    hooks_note: "Whom the service tells of alerts. A message that cannot be delivered is tried again for days, then kept as a dead letter, which can be sent again.", "服务向这些目标发送警报。投递失败会在数天内重试，仍失败则保留为死信，可重新发送。";
    no_hooks: "No hook is set up: nobody is told of alerts.", "尚未设置通知目标：警报不会通知任何人。";
    hook: "Hook", "目标";
    add_hook: "Add a hook", "添加目标";
    add_hook_what: "From then on it is told of every alert that its filter lets through.", "此后凡通过筛选的警报都会发送给它。";
    delete_hook: "Delete", "删除";
    delete_hook_title: "Delete a hook", "删除目标";
    delete_hook_what: "Nothing more is sent to it. What it was still to be told is thrown away.", "不再向其发送；尚未送达的消息将被丢弃。";
    hook_name: "Name", "名称";
    hook_url: "Address", "地址";
    hook_secret: "Secret (whsec_…; drawn by the service, if empty)", "密钥（whsec_…；留空则由服务生成）";
    hook_secret_shown: "Its secret, shown this once:", "密钥（仅显示一次）：";
    hook_authorization: "Authorization header (optional)", "Authorization 头（可选）";
    hook_rules: "Rules, separated by commas (all, if empty)", "规则，以逗号分隔（留空为全部）";
    hook_gyros: "Gyros, separated by commas (all, if empty)", "陀螺编号，以逗号分隔（留空为全部）";
    hook_severity: "Least severity", "最低级别";
    hook_set_up: "The hook is set up.", "目标已设置。";
    enabled: "enabled", "启用";
    disabled: "disabled", "停用";
    enable: "Enable", "启用";
    disable: "Disable", "停用";
    test_hook: "Send a test", "发送测试";
    open_deliveries: "To be sent", "待发送";
    dead_letters: "Dead letters", "死信";
    deliveries: "Deliveries", "投递记录";
    no_deliveries: "Nothing has been sent yet.", "尚无投递。";
    message: "Message", "消息";
    queued: "Queued", "入队时间";
    attempts: "Attempts", "尝试次数";
    last_attempt: "Last attempt", "最近一次";
    redeliver: "Send again", "重新发送";
    redeliver_dead: "Send all dead letters again", "重新发送全部死信";
    delivery_behind: "behind an earlier one", "排在先前消息之后";
    delivery_waiting: "waiting", "等待";
    delivery_delivered: "delivered", "已送达";
    delivery_dead: "dead letter", "死信";
    delivery_dropped: "dropped", "已丢弃";

    // A report to print.
    report: "Report to print", "打印报告";
    report_of_gyro: "Report on gyro", "陀螺报告";
    report_of_imu: "Report on IMU", "惯性组合报告";
    report_plot_note: "Bars: one standard deviation. Grey band: the budget about the baseline; dashed: the baseline; dotted: control limits, three standard deviations of the gyro's own scatter. Circle: within, hollow if undecided. Triangle: filled outside the budget, hollow inside it but flagged by a rule. Diamond: bench. Upright lines: events, and broken, changes of seat or station.", "误差棒：一倍标准差；灰带：基线允许范围；虚线：基线；点线：控制限（自身离散的三倍标准差）。圆：合格，空心为待定；实心三角：超出允许范围；空心三角：在范围内但有规则报警；菱形：单表测试。竖线：事件；断续竖线：更换位置或台站。";
    printed_at: "As of", "截至";
    identity: "Identity", "基本信息";
    budget_word: "Budget about the baseline", "基线允许范围";
    records_word: "Calibrations stored", "已存标定数";
    judged_by: "Judged by", "判定方法";
    no_open_alerts: "No alert is open.", "没有未恢复的警报。";
    newest_of: "newest", "最新";
    signature: "Name, date, signature", "姓名、日期、签名";

    // Signing in.
    sign_in: "Sign in", "登录";
    sign_out: "Sign out", "退出";
    sign_in_note: "With a token that an administrator has made for you. It is kept until you sign out or some hours have passed.", "请使用管理员为您创建的令牌登录；退出或数小时后失效。";
    token: "Token", "令牌";
    takes_role: "The token that you have signed in with does not reach that far. Sign in with one of the role: ", "您登录所用的令牌权限不足，请使用以下角色的令牌登录：";
    role_station: "station", "台站";
    role_engineer: "engineer", "工程师";
    role_admin: "administrator", "管理员";
    wrong_token: "This token is not valid.", "令牌无效。";
    too_many_tokens: "Too many attempts. Wait a minute.", "尝试次数过多，请一分钟后再试。";
}
