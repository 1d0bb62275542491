# 试验的诊断。

## 为什么不能诊断

no_degrees_of_freedom = { $dwells }个测点对模型的{ $parameters }个参数没有多余观测：无法检验模型
output_is_constant = { $slot }的输出在所有测点中相同
model_without_terms = 模型没有任何项

## 试验缺少什么

dwells_without_temperature = 测点没有温度数据
temperature_is_constant = 温度没有变化
dwells_without_attitude = 测点没有姿态数据
every_rate_is_zero = 所有指令角速度均为零
