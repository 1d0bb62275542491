//! What a diagnosis and a fit say.

use super::Sentence;

pub(super) const SENTENCES: &[Sentence] = &[
    // Against an earlier calibration.
    ("{}: E is held in this campaign and not compared", "{0}：本次试验中E保持不变，不作比较"),
    ("{}: the reference does not determine {}; fitted anew", "{0}：参照标定不能确定{1}，已重新拟合"),
    (
        "the effects of the model in use are fitted anew in each campaign and not compared",
        "现用模型中的效应在每次试验中重新拟合，不作比较",
    ),
    ("the reference is a record: it states no noise of D0 and P", "参照为标定记录：没有给出D0与P的噪声"),
    ("the reference states no standard deviations: it is taken to be exact", "参照标定没有给出标准差：视为准确值"),
    // Equations, where words stand in them.
    ("{}, over |E|", "{0}，除以|E|"),
    ("{}, {} unknown", "{0}，{1}未知"),
    ("k after an unknown instant", "k，自某一未知时刻起"),
    ("k in one unknown dwell", "k，在某一未知位置段"),
    ("k a_O of the dwell before; nothing in the first dwell", "前一位置段的k a_O；第一个位置段中为零"),
    (
        "k . C b, b the horizontal direction of the field; its vertical part lies inside G",
        "k . C b，b为磁场的水平方向；其垂直分量包含在G之内",
    ),
    ("{}: scale factor x (1 + {})", "{0}：标度因数 × (1 + {1})"),
    // Why a candidate was not taken.
    ("the design does not show it", "本次试验设计看不到该效应"),
    ("this campaign cannot tell it from {}, which stands for both", "本次试验无法将其与“{0}”区分，以后者代表两者"),
    ("its size would be beyond what is plausible", "其大小超出合理范围"),
    ("it closes nothing of dwells that were held out", "对留出的测点没有任何改善"),
    (
        "noise alone shows as much somewhere in {} of campaigns; a name asks for less than {}",
        "仅凭噪声，约有{0}的试验会在某处出现同样大小的迹象；指名要求小于{1}",
    ),
    (
        "several dwells stand out, each by itself: that is not one bad dwell",
        "有数个位置段各自异常：这不是个别位置段异常",
    ),
    ("it did not hold with the growth of the noise with rate left open", "若不限定噪声随角速度的增长，它便不成立"),
    ("it did not hold with everything fitted together", "全部一起拟合后它不成立"),
    (
        "{} causes are in the model already: what needs more has not been understood",
        "模型中已有{0}个原因：需要更多原因的差异尚未弄清",
    ),
    ("beside {} it did not hold with everything fitted together", "在“{0}”之外，全部一起拟合后它不成立"),
    (
        "it explains the same dwells as {} less well, and nothing beside it",
        "它与“{0}”解释的是同样的位置段，但解释得较差，此外没有其他贡献",
    ),
    ("{}, outside the catalogue, explains the same dwells better", "目录之外的“{0}”能更好地解释同样的位置段"),
    // What cannot be told.
    (
        "g_linear takes {} % of its power in these dwells (principal angle {} deg): the two are hard to tell apart, and \
         what is just too small to be seen of it shifts D_I and D_S by up to {} of their standard deviations",
        "在这些位置段中，与比力成正比的漂移占去其{0} %的能量（主角{1}°）：两者难以区分；其中恰好看不到的部分最多可使D_I、D_S偏移{2}倍标准差",
    ),
    ("D_O a_O lies inside G; it shows in the closure of G only", "D_O·a_O包含在G之内，只在G的闭合差中显现"),
    ("the model in use absorbs it in every dwell of this campaign", "现用模型在本次试验的每个位置段中都将其吸收"),
    (
        "the model in use absorbs all but {} of its power in every dwell of this campaign",
        "现用模型在本次试验的每个位置段中吸收其能量，只剩{0}",
    ),
    ("the dwells carry no temperature", "位置段没有温度数据"),
    ("the temperature is constant", "温度没有变化"),
    ("the dwells carry no attitude", "位置段没有姿态数据"),
    ("every commanded rate is zero", "所有指令角速度均为零"),
    // What would show an effect.
    (
        "dwells with specific force off the body axes (edges at 45 deg, tilts of 30 and 60 deg)",
        "比力偏离本体轴的位置段（45°棱边，30°与60°倾斜）",
    ),
    ("dwells with specific force off the body axes", "比力偏离本体轴的位置段"),
    (
        "the closure of G over a history in which D_S changes; dwell residuals never show it",
        "D_S发生变化的历史中G的闭合差；位置段残差永远看不到它",
    ),
    (
        "an order of dwells in which the orientation before differs for one and the same orientation",
        "同一姿态之前的姿态各不相同的位置段次序",
    ),
    ("at least three independent directions of specific force", "至少三个独立的比力方向"),
    (
        "specific force along at least three axes; at 1 g one combination is the bias",
        "沿至少三个轴的比力；在1 g下有一个组合即为零偏",
    ),
    ("rates about three axes", "绕三个轴的角速度"),
    ("attitudes, with several azimuths a face", "姿态数据，且每个面有多个方位"),
    ("attitudes and rate dwells: without them it is Earth rate", "姿态数据与速率位置段：否则它与地球自转无法区分"),
    ("dwells early after power-up, several within tau", "上电后不久的位置段，时间常数之内应有数个"),
    (
        "an order of dwells that specific force, rate and temperature do not follow",
        "与比力、角速度、温度都不同步的位置段次序",
    ),
    ("several dwells on either side", "跳变前后各有数个位置段"),
    ("enough dwells that one is not needed for the fit", "足够多的位置段，使拟合不依赖其中任何一个"),
    (
        "periods longer than two intervals between dwells and shorter than the campaign",
        "周期大于位置段间隔的两倍且短于整个试验",
    ),
    ("rotation in both senses", "正反两个方向的转动"),
    ("four or more rates in both senses", "正反两个方向各四个以上的角速度"),
    ("rates about axes that have components along both I and S", "转轴在I、S两轴上均有分量的角速度"),
    ("each rate axis with its up-direction both ways", "每个转轴正、反朝上各一次"),
    ("a temperature column whose course differs from time's", "变化过程不同于时间的温度数据"),
    ("a temperature column that varies within each orientation family", "在每组同类姿态之内都有变化的温度数据"),
    ("a temperature column and rate dwells", "温度数据与速率位置段"),
    // Signs that more remains.
    ("a smooth course in time", "随时间的平滑变化"),
    ("a random walk in time", "随时间的随机游走"),
    ("noise that neighbouring dwells share", "相邻位置段共有的噪声"),
    ("a bend in time", "随时间的转折"),
    ("a passing disturbance of several dwells", "持续数个位置段的短暂扰动"),
    ("g-sensitivity that changes with time", "随时间变化的g敏感性"),
    ("a scale factor that changes with time", "随时间变化的标度因数"),
    ("a bend in temperature", "随温度的转折"),
    ("a response to the rate of change of temperature", "对温度变化率的响应"),
    ("a late response to temperature", "对温度的滞后响应"),
    ("a response to temperature that changes with time", "随时间变化的温度响应"),
    ("compliance that follows temperature", "随温度变化的柔性"),
    ("a function of orientation beyond second degree", "高于二次的姿态函数"),
    ("a dependence on the sense of specific force", "与比力正反有关"),
    ("a dependence on the table's heading", "与转台方位有关"),
    ("an error of the Earth's rate along north", "地球自转角速度北向分量的误差"),
    ("an even function of rate", "角速度的偶函数"),
    ("an odd function of rate", "角速度的奇函数"),
    ("a smooth function of the rate along the input axis", "沿输入轴角速度的平滑函数"),
    ("a scale factor that depends on orientation", "与姿态有关的标度因数"),
    ("a difference between standing and turning", "静止与转动之间的差别"),
    ("a memory of the orientation before", "对前一姿态的记忆"),
    ("a memory of the rates before", "对先前各角速度的记忆"),
    ("a memory of the rate before", "对前一角速度的记忆"),
    // Notes of a diagnosis.
    (
        "{}: the campaign does not determine E; the nominal input axis and {} pulse/arcsec are used",
        "{0}：本次试验不能确定E；采用标称输入轴与{1} pulse/arcsec",
    ),
    (
        "no standard errors are stated: the noise is taken from repeats and residuals",
        "未给出标准误差：噪声取自重复测量与残差",
    ),
    (
        "the stated standard errors are larger than the dwells scatter ({}): where they are wrong, sigmas that rest on \
         them are too large, and a small gap may not be seen",
        "给定的标准误差大于位置段的实际散布（{0}）：若其有误，以其为据的标准差偏大，且小的差异可能无法发现",
    ),
    (
        "repeated dwells scatter {} times as much as the stated standard errors say: those are too small, or what changes from one \
         time to the next is no noise",
        "重复的位置段的散布是给定标准误差的{0}倍：标准误差偏小，或随时间变化的并非噪声",
    ),
    (
        "no dwell repeats another: there is no pure error to check the noise against",
        "没有重复的位置段：无法用纯误差检验噪声",
    ),
    (
        "no attitude column: specific force and rate were not checked against the attitude",
        "没有姿态列：比力与角速度未与姿态核对",
    ),
    (
        "rate_arcsec_s of {} of {} static dwells is not the Earth's at their attitude and the site's latitude: by {} arcsec/s in {}",
        "{1}个静态位置段中有{0}个的rate_arcsec_s不等于该姿态与测试站纬度下的地球自转角速度：{3}处相差{2} arcsec/s",
    ),
    (
        "no site: the specific force of static dwells was checked against standard gravity",
        "未给出测试站位置：静态位置段的比力按标准重力核对",
    ),
    ("no temperature column: effects of temperature cannot be seen", "没有温度列：看不到温度效应"),
    // Notes of its campaign: a diagnosis keeps them in English.
    (
        "no attitude in {} of {} dwells ({}): these were not checked against it, and effects of the station cannot be seen",
        "{1}个测点中有{0}个没有姿态（{2}）：这些测点未与姿态核对，且看不到测试站的效应",
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
        "no temperature in {} of {} dwells ({}): it is taken from the neighbouring dwells",
        "{1}个测点中有{0}个没有温度（{2}）：取自相邻测点",
    ),
    (
        "the temperature of {} is {} deg C; the campaign's median is {} deg C.",
        "{0}的温度为{1} °C，而本次试验的中位数为{2} °C：",
    ),
    ("Taken for a fault value of the sensor and left out of temperature effects", "视为传感器的故障值，不计入温度效应"),
    // Notes of a fit.
    (
        "no standard errors: all dwells have equal weight and the residuals give the noise",
        "没有标准误差：各位置段等权，噪声由残差给出",
    ),
    (
        "the residuals at the fastest rate are {} times those at rest; sigmas follow them",
        "最高角速度下的残差为静止时的{0}倍；标准差随之变化",
    ),
    (
        "no repeated dwells: nothing but the fit itself tells noise from what the model leaves out",
        "没有重复位置段：只能凭拟合本身区分噪声与模型未含的部分",
    ),
    (
        "{}: residuals exceed the noise; the model leaves something out (see diagnose)",
        "{0}：残差大于噪声，模型有所遗漏（见诊断）",
    ),
    ("the effects of the model are left out: {}", "模型中的附加效应未计入：{0}"),
    (
        "{}: {} is left out of the fit: these dwells cannot tell it from the other terms",
        "{0}：{1}未参与拟合：这些位置段不能将其与其他项区分",
    ),
    ("{} is left out of the fit: {}", "{0}未参与拟合：{1}"),
    // Where noise is known from.
    ("sem", "标准误差"),
    ("repeats+sem", "标准误差与重复测量"),
    ("repeats+residuals+sem", "标准误差、重复测量与残差"),
    ("residuals+sem", "标准误差与残差"),
    ("repeats", "重复测量"),
    ("residuals", "残差"),
    ("repeats+residual", "重复测量与残差"),
    ("residual", "残差"),
    ("stated", "给定值"),
    ("stated standard errors", "给定的标准误差"),
    ("none", "无"),
    // Why effects of the model were left out.
    ("the output of {} is the same in every dwell", "{0}的输出在所有位置段中相同"),
];
