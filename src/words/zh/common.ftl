# 各处共用。代码与接口中的相同，含义不再更改。

beside = { $first }与{ $second }
