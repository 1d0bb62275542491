//! What is noted about a record.

use super::Sentence;

pub(super) const SENTENCES: &[Sentence] = &[
    (
        "the time is near {}, where clocks that were never set begin: set aside until somebody confirms the time",
        "时间接近{0}，即未校时时钟的起点：暂不计入，待人工确认时间",
    ),
    (
        "the time is decades from the other records of its gyros, of which the nearest is of {}: set aside until somebody confirms the time",
        "时间与其陀螺的其他记录相差数十年，最近的记录为{0}：暂不计入，待人工确认时间",
    ),
    (
        "earlier records are decades before this one and were set aside until somebody confirms their times: {}",
        "更早的记录比本记录早数十年，已暂不计入，待人工确认其时间：{0}",
    ),
    (
        "the time is {} hours ahead of the service's clock: is the station's clock right?",
        "时间比服务时钟超前{0}小时：测试站时钟是否正确？",
    ),
    (
        "{} is new in {}, which had {} before; the nearest known serial is {}",
        "{0}首次出现于{1}，该位置此前为{2}；最接近的已知编号为{3}",
    ),
    ("{} is new in {}, which had {} before", "{0}首次出现于{1}，该位置此前为{2}"),
    ("the new IMU {} looks like the known IMU {}", "新惯组编号{0}与已知惯组编号{1}形似"),
    ("the new station {} looks like the known station {}", "新测试站名{0}与已知测试站名{1}形似"),
    ("the new serial {} looks like the known serial {}", "新陀螺编号{0}与已知陀螺编号{1}形似"),
    ("serials are exchanged: {}", "陀螺编号互换：{0}"),
    ("{} has the figures of {}, {}", "{0}的数据属于{1}，{2}"),
    ("{} has the figures of {}", "{0}的数据属于{1}"),
    (
        "all gyros ({}) are off their last levels by more than {} budgets: are these the figures of another unit?",
        "全部陀螺（{0}）同时偏离各自上次水平{1}个允许值以上：是否为另一套惯组的数据？",
    ),
    (
        "{}: identical to record {} of {}; is it the same measurement with another time?",
        "{0}：与{2}的记录{1}逐位相同；是否为同一次测量改了时间？",
    ),
    ("{} of {} is {} times what it was before: is it in another unit?", "{1}的{0}为此前的{2}倍：单位是否有误？"),
    ("{} of {} is {} times what it was before: is it in {}?", "{1}的{0}为此前的{2}倍：单位是否为{3}？"),
    ("{} was in {} in its last record and is in {} now", "{0}上次记录时在{1}，现在{2}"),
    // Columns of a campaign.
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
