# 不能执行或不能显示的操作，按代码；问题的标题。

## Titles

title_no_such_record = 没有此标定记录
title_no_such_campaign = 没有此标定试验
title_no_such_bench_result = 没有此单表测试结果
title_no_such_hook = 没有此通知目标
title_no_such_delivery = 没有此投递
title_no_such_token = 没有此令牌
title_no_such_diagnoses = 没有此诊断任务
title_no_such_reference = 没有此参照
title_no_such_path = 没有此路径
title_no_such_page = 没有此页面
title_unknown_gyro = 未知的陀螺
title_unknown_imu = 未知的IMU
title_unknown_alert = 未知的告警
title_unknown_silence = 未知的静默规则
title_differs = 已存储其他内容
title_key_reused = Idempotency-Key已用于其他内容
title_gyro_elsewhere = 陀螺同时在别处标定
title_already_corrected = 已作废或修订
title_not_set_aside = 并非暂不计入
title_nothing_to_adopt = 无可采用或撤销
nothing_to_adopt = 试验 { $id } 的诊断未确定任何原因，或仍在进行
no_model_to_undo = IMU { $imu } 尚未采用模型
title_cannot_be_stored = 不能按原样存储
title_time_taken = 该时刻已有其他标定
title_other_station = 属于其他测试站
title_token_not_valid = 令牌无效
title_token_needed = 需要令牌
title_not_allowed = 不允许
title_try_again = 请重试
title_hook_disabled = 通知目标已停用
title_not_its_turn = 尚未轮到
title_delivery_dropped = 已作废
title_too_many_hooks = 通知目标过多
title_diagnoses_ended = 诊断任务已结束
title_no_such_hypothesis = 没有该假设
title_hypothesis_taken = 该名称已被另一假设占用
title_too_many_hypotheses = 假设过多
title_too_many_silences = 静默规则过多
title_alert_resolved = 告警已恢复
title_no_room = 空间不足
title_cannot_store = 无法存储
title_perhaps_stored = 不确定是否已存储
title_damaged_database = 数据库损坏
title_internal_error = 内部错误
title_not_json = 不是JSON
title_unsupported_media_type = 不支持的媒体类型
title_bad_idempotency_key = Idempotency-Key有误
title_bad_query = 查询参数有误
compare_what = 请在“全部陀螺”页选择2至{ $most }个陀螺，或在IMU页面选择两次标定试验
title_too_large = 过大
title_broken_off = 中断
title_foreign_page = 来自其他网站的页面
title_other_name = 不是本机的名称
title_too_many_wrong_tokens = 错误令牌过多
title_too_many_requests = 请求过多
title_not_ready = 未就绪
title_nothing_to_diagnose = 无可诊断
title_no_reference = 不能作为参照
title_unknown_transfer_coding = 未知的传输编码
title_two_hosts = 两个Host
title_no_host = 没有Host

## What is not there

faults_in_document = 文档有误
unknown_gyro = 没有编号为{ $serial }的陀螺
unknown_imu = 没有名为{ $imu }的IMU
unknown_imu_like = 没有名为{ $imu }的IMU；是否为{ $known }？
unknown_station = 没有名为{ $station }的测试站
no_such_record = 没有标定记录{ $id }
no_such_campaign = 没有标定试验{ $id }
no_such_reference = 没有标定试验或记录{ $id }
no_such_bench_result = 没有单表测试结果{ $id }
no_such_hook = 没有通知目标{ $id }
no_such_delivery = 没有投递{ $id }
no_such_token = 没有令牌{ $id }
no_such_diagnoses = 没有诊断任务{ $id }
unknown_alert = 没有告警{ $id }
unknown_silence = 没有静默规则{ $id }
no_such_path = { $path }处没有内容
not_done_to_alerts = 告警没有“{ $action }”这一操作

## What stands in the way

differs = 相同时间与对象已有其他内容（编号{ $id }），差异在{ $places }
differs_further = 相同时间与对象已有其他内容（编号{ $id }），差异在{ $places }，另有{ $further }处
differs_in_everything = 相同时间与对象已有其他内容（编号{ $id }），二者完全不同，如一为记录、一为标定试验
differs_here = 与已存储的内容不同
key_reused = Idempotency-Key此前已用于其他内容（编号{ $id }）
gyro_elsewhere = 陀螺{ $serial }在同一时刻已有另一次标定（编号{ $id }）
already_corrected = { $id }已被作废或修订
corrected_otherwise = { $id }已被作废或修订：作者、原因或内容不同
not_set_aside = { $id }并非暂不计入，无需确认
another_imu = 与所替换者不属于同一IMU
time_taken = 该IMU在该时刻已有另一次标定（编号{ $id }）
other_station = 该令牌只能用于测试站{ $station }
setup_over = 已有令牌，初始密钥不再有效
no_random_numbers = 操作系统无法提供随机数
hook_disabled = 通知目标{ $id }已停用，请先启用
delivery_dropped = 投递{ $id }已作废：仍在触发的告警已重新通知
still_behind = 投递{ $id }尚未轮到：同一告警的先前消息尚待发送
secret_needed = standard-webhooks必须签名：请给出新的密钥
target_of_other_kind = email类钩子的地址应为mailto:，其他类应为http://或https://
too_many_hooks = 已有{ $most }个通知目标，不能再多
diagnoses_ended = 诊断任务{ $id }已结束，无需取消
no_such_hypothesis = 没有参与比较的假设 { $name }
hypothesis_taken = 另有假设 { $name } 正在参与比较：请先将其撤下，或为本假设另取标识
hypotheses_too_many = 已有 { $most } 个假设参与比较，达到上限：请先撤下一个
alert_resolved = 告警{ $id }已恢复，无需确认
too_many_silences = 已有{ $most }条静默规则生效，不能再多
event_there = 同一时刻已有同类事件，但说明不同
baseline_there = 同一时刻已有基线，但原因不同

## The service itself

busy = 等待写入的请求过多
stopping = 服务正在停止
disk_full = 服务的磁盘已满，未存储任何内容
cannot_write = 服务的数据库暂时不能写入，未存储任何内容
perhaps_stored = 服务的数据库在存储过程中断开，无法得知是否已存储：测量数据可重新发送；通知目标、令牌及其他操作请先查看
disk_failed = 服务的磁盘故障，修复之前不接受任何内容
database_damaged = 数据库损坏：{ $what }
store_no_database = 该文件不是SQLite数据库（{ $why }）
service_failed = 服务出错，原因见服务日志
body_not_json = { $id }的内容不是JSON
body_unreadable = { $id }的内容无法读取
audit_not_json = 审计记录{ $id }不是JSON
not_fitted = 标定试验无法拟合
token_lost = 令牌已生成但无法读回，请吊销
model_lost = 模型已采用但无法读回，原因见服务日志
not_written = 答复无法写出
line_not_answered = 该行没有得到答复
line_not_read = 该行没有读取
not_reading = 读取：{ $why }
not_writing = 写入：{ $why }
writer_silent = 写入线程{ $seconds } s内没有应答
no_delivery_worker = 投递线程没有运行
answer_took_too_long = 答复用时过长，请稍后重试

## Requests

wrong_method = 该路径不接受此方法，见Allow
path_not_utf8 = 路径不是UTF-8：名称按UTF-8编码，字母和数字以外的每个字节写作%XX
too_long_body = 请求体最多{ $most }字节（由{ $key }规定）
too_long_import = 一次导入最多{ $most }字节（由{ $key }规定）；此行之前的内容已有答复
too_long_line = 一行最多{ $most }字节（由{ $key }规定）
belongs_to_records = 这是标定记录：请发送到 /v1/records
belongs_to_campaigns = 这是原始标定试验：请发送到 /v1/campaigns
belongs_to_bench_results = 这是单表测试结果：请发送到 /v1/bench-results
content_type_missing = Content-Type应为{ $wanted }，实未给出
content_type = Content-Type应为{ $wanted }，实为{ $found }
content_type_charset = JSON采用UTF-8，而非{ $charset }；请转换编码，并从Content-Type中去掉charset
content_encoding = 不接受Content-Encoding { $encoding }；请按原样或以gzip发送
body_broke_off = 请求体没有完整到达，或者不是首部所说的gzip
idempotency_key_form = 应为1至255个可见ASCII字符
idempotency_key_not_taken = 此处不接受Idempotency-Key：只有记录、标定数据和单表测试结果可以使用。请去掉后发送；重发之前请先查看列表
parameter_one_of = { $parameter }应为{ $known }之一，实为{ $value }
unknown_parameter = 未知的参数`{ $parameter }`；可用的参数为“{ $known }”
no_parameters = 未知的参数`{ $parameter }`；此处不接受任何参数
parameter_twice = { $parameter }给出了两次
parameter_missing = 缺少参数{ $parameter }
parameter_whole = { $parameter }必须是整数
parameter_number = { $parameter }必须是数
parameter_flag = { $parameter }必须是true或false
form_unreadable = 表单无法读取
query_unreadable = 地址中的查询部分无法读取
parameter_range = { $parameter }应为{ $least }至{ $most }，实为{ $value }
parameter_fault = { $parameter }：{ $fault }
every_counts_only = every不能与voided=include或levels=include同用
columns_of_json = columns不能与format=csv或every同用
last_alone = last不能与limit或cursor同用
from_after_to = from晚于to
invalid_cursor = cursor无效
cursor_of_other_list = 该cursor属于另一列表或另一排序；请取上一页的`next`
transfer_coding = 如有Transfer-Encoding，应为chunked且仅一次
one_host = 应只有一个Host
host_needed = HTTP/1.1需要Host

## Who may do what

no_token = 需要令牌：请发送Authorization: Bearer，或登录
not_here = 尚未生成令牌，此前服务只应答本机
proxied = 前有反向代理而尚未生成令牌，任何人都可能在请求：请用`gyrowatch token create NAME --role admin`生成
wrong_token = 未知的令牌
revoked_token = 令牌已吊销
expired_token = 令牌已过期
signed_out = 登录已失效，请重新登录
too_many_failures = 该地址错误令牌过多
too_many_requests = 该令牌每秒请求过多
access_unreadable = 暂时无法读取访问权限
role_needed = 需要角色{ $needed }，而令牌的角色为{ $role }
first_token_needed = 需要角色{ $role }的令牌，但尚未生成：请用`gyrowatch token create NAME --role admin`生成第一个，或以Authorization: Bearer发送日志所示的初始密钥
foreign_page = 请求来自其他网站的页面
other_name = 生成第一个令牌之前，服务只应答localhost与环回地址：其他名称可能被其他网站的页面利用

## How sending to a hook went

address_refused = 不允许访问{ $address }：{ $why }
outside_networks = 不在配置的网络之内
loopback_refused = 仅当服务自身监听环回地址时才允许环回地址
leads_to_the_proxy = 经代理访问时，它指向代理主机自身或其凭据
cloud_credentials = 云主机在该地址存放凭据
link_local = 链路本地地址存放云主机元数据
no_destination = 不是目的地址
no_single_host = 不是单一主机
name_unknown = { $name }无法解析：{ $why }
name_empty = { $name }没有解析到地址
name_forbidden = { $name }解析到禁止的地址：{ $why }
target_gone = 目标于{ $at }答复410 Gone
redirected = 答复{ $status }，指向{ $to }：不跟随重定向，请填写最终地址
answered = 答复{ $status }
with_answer = { $what }：{ $answer }
answered_but = 答复{ $status }，但{ $why }
answer_not_object = 内容不是JSON对象
answer_lacks = 缺少{ $member }
answer_differs = { $member }为{ $value }，不是{ $wanted }
answer_cut = 答复在{ $bytes }字节后截断
answer_broke_off = 答复中断：{ $why }
answer_did_not_end = 答复在{ $seconds } s内没有结束
no_connection_within = { $seconds } s内未能连接
no_answer_in_time = 没有及时答复
no_answer_within = { $seconds } s内没有答复
no_mail_server = 没有配置邮件服务器：请设置hooks.smtp_url和hooks.mail_from
mail_failed = 邮件服务器：{ $why }
recipient_not_served = { $recipient }：{ $why }
tls_failed = TLS失败：{ $why }
no_connection = 未能连接：{ $why }
no_http_answer = 没有HTTP答复：{ $why }
file_not_found = 没有此文件或文件夹（系统错误{ $number }）
file_exists = 文件已存在（系统错误{ $number }）
permission_denied = 没有权限（系统错误{ $number }）
is_a_directory = 是文件夹（系统错误{ $number }）
not_a_directory = 不是文件夹（系统错误{ $number }）
read_only_files = 文件系统只读（系统错误{ $number }）
no_space_left = 磁盘已满（系统错误{ $number }）
address_in_use = 地址已被占用（系统错误{ $number }）
connection_refused = 该处没有程序在监听（连接被拒绝，系统错误{ $number }）
connection_reset = 连接被对方中断（系统错误{ $number }）
no_route_to_host = 没有到该主机的路由（系统错误{ $number }）
no_route_to_network = 没有到该网络的路由（系统错误{ $number }）
certificate_of_unknown_authority = 证书由本机不认识的机构签发；请在hooks.ca_file中给出该机构的证书，对`import`用--ca-file
certificate_of_an_authority = 对方出示的是机构证书（CA:TRUE），`openssl req -x509`默认如此。请换用服务器证书：加`-addext basicConstraints=critical,CA:FALSE`，或由机构签发
certificate_not_in_time = 证书今天无效；请对照其日期与本机时钟
certificate_for_other_name = 证书属于另一主机名
no_tls_there = 该处应答的不是TLS；可能应为 http://
hung_up = 连接在答复之前关闭
not_http = 该处应答的不是HTTP
no_such_name = 没有这个名称
no_name_server = 没有域名服务器答复本机
stored_message_unreadable = 存储的消息无法读取：{ $why }
stored_message_empty = 其中没有告警
end_of_what_was_never_told = 目标从未收到该告警，因此不发送其结束消息
header_control_character = 请求头含有控制字符

## Diagnoses and events

computation_broke_off = 计算中断，原因见服务日志
event_needed = 请选择事件

## Several at once

several = { $faults }
no_alert_selected = 未选择告警
