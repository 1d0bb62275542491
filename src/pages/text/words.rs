//! The catalogue.

macro_rules! catalogue {
    ($($key:ident: $english:literal, $chinese:literal;)*) => {
        /// The words of one language.
        pub(in crate::pages) struct Text { $(pub $key: &'static str),* }
        pub(super) const ENGLISH: Text = Text { $($key: $english),* };
        pub(super) const CHINESE: Text = Text { $($key: $chinese),* };
    };
}

catalogue! {
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
    plot_note: "Bars: one standard deviation. Grey band: the budget about the baseline. Drag to zoom, double-click for all.", "误差棒：一倍标准差；灰带：基线上下的允许范围。拖动放大，双击还原。";
    since_baseline: "Since the last baseline", "自最近基线起";
    whole_history: "All", "全部";
    save_picture: "Save picture", "保存图片";
    verdicts: "Verdicts on the newest record", "最新记录的判定";
    verdicts_within: "rules that are kept", "项合格";
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
}
