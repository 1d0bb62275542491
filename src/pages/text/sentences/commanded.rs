//! What is noted of a campaign's dwells, or refused about what was commanded.

use super::Sentence;

pub(super) const SENTENCES: &[Sentence] = &[
    ("{}. Measured: {}; the noise of these gyros hides it", "{0}。实测：{1}；这些陀螺的噪声将其掩盖"),
    ("{}. Measured: {}", "{0}。实测：{1}"),
    ("either {}, or {}, or {}", "可能有三：{0}；或{1}；或{2}"),
    ("either {}, or {}", "可能有二：{0}；或{1}"),
    // Causes.
    (
        "unit, sign or axes of specific_force_g0 or rate_arcsec_s are wrong",
        "specific_force_g0或rate_arcsec_s的单位、符号或轴有误",
    ),
    (
        "the specific force is reversed: it must point up, away from the Earth, in a static dwell",
        "比力反号：静态测点的比力应向上，背离地心",
    ),
    (
        "the rates are reversed: send them positive for a turn about the positive axis by the right-hand rule",
        "角速度反号：绕正轴按右手定则转动为正",
    ),
    (
        "the latitude has the wrong sign, in site.latitude_deg or where the rates were made: north is positive",
        "纬度符号有误（site.latitude_deg，或计算角速度时所用的纬度）：北纬为正",
    ),
    (
        "North-East-Down is mixed with East-North-Up: attitude, specific force and rate must all be made with nav = East-North-Up",
        "北东地与东北天混用：姿态、比力与角速度都应以东北天为导航系",
    ),
    (
        "the attitude is inverted: send the quaternion with v_body = C(q) v_nav",
        "姿态求逆：四元数应满足 v_body = C(q) v_nav",
    ),
    (
        "the Earth's rate is left out of the rates: send inertial rates; with attitudes and a site \"rates\": \"table\" lets the service add it",
        "角速度中缺少地球自转：请给出惯性角速度；已知姿态与测试站位置时，可用 \"rates\": \"table\" 由服务加上",
    ),
    ("the rates of {} are in {}: send them in arcsec/s", "{0}的角速度单位为{1}：请以arcsec/s给出"),
    ("all dwells", "所有测点"),
    ("static dwells", "静态测点"),
    ("rate dwells", "速率测点"),
    ("the {} axis of {} is reversed", "{1}的{0}轴反向"),
    ("the {} and {} axes of {} are exchanged", "{2}的{0}轴与{1}轴互换"),
    ("specific_force_g0 and rate_arcsec_s", "specific_force_g0与rate_arcsec_s"),
    (
        "the rates are those of latitude {} deg: correct site.latitude_deg or the rates",
        "角速度对应的纬度为{0}°：请更正site.latitude_deg或角速度",
    ),
    (
        "the rates are made with an Earth that turns at {} arcsec/s: use 15.041, that of a sidereal day",
        "角速度按地球自转{0} arcsec/s计算：应为15.041（恒星日）",
    ),
    (
        "the rates of static dwells are made with other headings than the attitudes: send the Earth's rate at each attitude",
        "静态测点的角速度与姿态的方位不符：请给出各姿态下的地球自转角速度",
    ),
    ("the specific force is in {}: send it in g0 = 9.80665 m/s^2", "比力的单位为{0}：请以g0 = 9.80665 m/s²给出"),
    (
        "the specific force is normalised to 1: multiply it by the site's gravity in g0",
        "比力已归一化为1：应乘以测试站重力（g0）",
    ),
    (
        "the specific force is {} times gravity: correct it, or state the gravity of the site in site.gravity_g0",
        "比力为重力的{0}倍：请更正，或在site.gravity_g0中给出测试站重力",
    ),
    // What was measured.
    (
        "|rate_arcsec_s| is {} arcsec/s at rest in {}; the Earth turns at 15.041",
        "{1}静止时|rate_arcsec_s|为{0} arcsec/s；地球自转为15.041",
    ),
    ("w.f/|f| is {} arcsec/s at rest in {}; Omega sin(latitude) is {}", "{1}静止时w·f/|f|为{0} arcsec/s；Ω·sinL为{2}"),
    (
        "in {} the table turns, but rate_arcsec_s is not along specific_force_g0 or is slower than any table ({} arcsec/s)",
        "{0}转台在转动，而rate_arcsec_s不沿specific_force_g0，或慢于任何转台（{1} arcsec/s）",
    ),
    (
        "rate_arcsec_s is {} arcsec/s from the Earth's rate at the attitude in {}",
        "{1}的rate_arcsec_s与该姿态下的地球自转相差{0} arcsec/s",
    ),
    ("the outputs are {} arcsec/s from the model in the root mean square", "输出与模型的均方根差为{0} arcsec/s"),
    ("|specific_force_g0| is {} g0 in {}; gravity is {} g0", "{1}的|specific_force_g0|为{0} g0；重力为{2} g0"),
    ("the vertical of the attitude is {} deg from specific_force_g0 in {}", "{1}的姿态垂线偏离specific_force_g0 {0}°"),
    ("this dwell", "该测点"),
    ("{} of {} dwells", "{1}个测点中的{0}个"),
    // Rates of the table.
    ("must be inertial or table, is {}", "应为inertial或table之一，实为{0}"),
    (
        "the service adds the Earth's rate where site and attitude are known; missing: {}",
        "已知测试站位置与姿态时，服务才能加上地球自转；缺少：{0}",
    ),
    ("site; {}", "测试站位置；{0}"),
    ("attitude in {} static dwells, the first {}", "{0}个静态测点的姿态，首个为{1}"),
    // Columns.
    (
        "no attitude in {} of {} dwells ({}): these were not checked against it, and effects of the station cannot be seen",
        "{1}个测点中有{0}个没有姿态（{2}）：这些测点未与姿态核对，且看不到测试站的效应",
    ),
    (
        "no temperature in {} of {} dwells ({}): it is taken from the dwells beside them",
        "{1}个测点中有{0}个没有温度（{2}）：取自相邻测点",
    ),
    (
        "no temperature in {} of {} dwells ({}): with so few, effects of temperature cannot be seen",
        "{1}个测点中有{0}个没有温度（{2}）：有温度的测点过少，看不到温度效应",
    ),
    (
        "no standard errors in {} of {} dwells ({}): they get the median of the others, scaled to their duration",
        "{1}个测点中有{0}个没有标准误差（{2}）：取其余测点的中位数，并按时长换算",
    ),
    ("{} and {} more", "{0}，另有{1}个"),
    (
        "the temperature of {} is {} deg C where the campaign's median is {} deg C: taken for a fault value of the sensor and left \
         out of temperature effects",
        "{0}的温度为{1} °C，而本次试验的中位数为{2} °C：视为传感器的故障值，不计入温度效应",
    ),
];
