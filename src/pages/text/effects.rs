//! The causes of the catalogue of effects in words.

use super::Text;
use crate::core::effects::Effect;

impl Text {
    /// A short name of the effect; the catalogue's own words where it has none here.
    pub fn effect(&self, effect: Effect) -> &'static str {
        let names = NAMES.iter().find(|(id, ..)| *id == effect.id());
        names.map_or(effect.entry().cause, |(_, english, chinese)| if self.tag == "zh" { chinese } else { english })
    }
}

const NAMES: [(&str, &str, &str); 24] = [
    ("g_linear", "drift linear in specific force", "与比力成正比的漂移"),
    ("g_squared", "drift with the square of specific force", "与比力平方有关的漂移"),
    ("scale", "scale factor and misalignment", "标度因数与安装误差"),
    ("temperature_bias", "bias changes with temperature", "零偏随温度变化"),
    ("temperature_g", "g-sensitivity changes with temperature", "与g有关的漂移随温度变化"),
    ("temperature_scale", "scale factor changes with temperature", "标度因数随温度变化"),
    ("warmup", "warm-up after power-up", "上电预热"),
    ("time_ramp", "bias drifts with time", "零偏随时间漂移"),
    ("bias_step", "bias jumps once", "零偏跳变"),
    ("outlier_dwell", "outlier dwell", "个别测点异常"),
    ("periodic", "a periodic disturbance", "周期性扰动"),
    ("hysteresis", "hysteresis (previous attitude)", "滞后（前一姿态）"),
    ("scale_asymmetry", "scale factor differs with the sign of rate", "标度因数正反不对称"),
    ("scale_quadratic", "scale factor changes with rate", "标度因数随角速度变化"),
    ("scale_cubic", "scale factor changes with the square of rate", "标度因数随角速度平方变化"),
    ("anisoinertia", "unequal moments of inertia", "转动惯量不等"),
    ("g_rate_coupling", "product of specific force and rate", "比力与角速度的交叉耦合"),
    ("levelling", "the table is not level", "转台未调平"),
    ("azimuth", "azimuth error of the table", "转台方位误差"),
    ("magnetic", "sensitivity to the magnetic field", "磁场敏感"),
    ("cross_compliance", "cross-axis compliance", "支承交叉柔性"),
    ("cubic_g", "drift with the cube of specific force", "与比力三次方有关的漂移"),
    ("output_axis_g", "drift with specific force along O", "沿输出轴比力引起的漂移"),
    ("mount_clocking", "the gyro is turned about its input axis", "陀螺绕输入轴转动安装"),
];
