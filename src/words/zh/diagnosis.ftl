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

## 为什么不能与参照比较

reference_of_other_imu = 参照标定属于惯性组合{ $reference }，而本次试验属于{ $campaign }
reference_of_other_geometry = 参照标定与本次试验的构型不同
reference_without_gyro = 参照标定在{ $slot }处没有陀螺，而本次试验中为{ $serial }
reference_of_other_gyro = 参照标定在{ $slot }处为陀螺{ $reference }，而本次试验中为{ $campaign }
no_reference_for_bench_test = 单表测试不与参照标定比较
reference_determines_nothing = 参照标定不能确定现用模型的任何参数
