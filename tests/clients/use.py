"""Uses the generated client against the service at GYROWATCH_URL, which must be empty; mypy reads it too."""

import copy
import json
import os
import pathlib

from gyrowatch_client import AuthenticatedClient
from gyrowatch_client.api.campaigns import get_campaign_diagnosis, post_campaign
from gyrowatch_client.api.gyros import get_gyros, get_trend
from gyrowatch_client.api.records import post_record
from gyrowatch_client.models import CampaignAnswer, CampaignBody, DiagnosisBody, GetTrendCoefficient, Gyros
from gyrowatch_client.models import MinimalAnswer, Problem, RecordBody, Trend
from gyrowatch_client.types import UNSET, Unset

data = pathlib.Path(os.environ["GYROWATCH_TEST_DATA"])
client = AuthenticatedClient(base_url=os.environ["GYROWATCH_URL"], token=os.environ["GYROWATCH_TOKEN"])
record = json.loads((data / "paper.json").read_text())

for day in (1, 2):
    sent = copy.deepcopy(record) | {"calibrated_at": f"2026-03-0{day}T08:00:00Z"}
    posted = post_record.sync(client=client, body=RecordBody.from_dict(sent), prefer="return=minimal")
    assert isinstance(posted, MinimalAnswer) and posted.id, posted

seen: list[str] = []
cursor: str | Unset = UNSET
while True:
    page = get_gyros.sync(client=client, imu=record["imu"], limit=2, cursor=cursor)
    assert isinstance(page, Gyros), page
    seen += [gyro.serial for gyro in page.gyros]
    assert all(gyro.latest and gyro.latest.calibrated_at.day == 2 for gyro in page.gyros)
    if page.next_ is None:
        break
    cursor = page.next_
assert seen == [gyro["serial"] for gyro in record["gyros"]], seen

trend = get_trend.sync(seen[0], client=client, coefficient=GetTrendCoefficient.D_I)
assert isinstance(trend, Trend), trend
assert [point.calibrated_at.day for point in trend.points] == [1, 2]
assert abs(trend.points[0].value - 2.957643) < 1e-6, trend.points[0].value

campaign = CampaignBody.from_dict(json.loads((data / "practice" / "campaign-00.json").read_text()))
stored = post_campaign.sync(client=client, body=campaign)
assert isinstance(stored, CampaignAnswer) and isinstance(stored.id, str), stored
diagnosis = get_campaign_diagnosis.sync(stored.id, client=client)
assert isinstance(diagnosis, DiagnosisBody) and diagnosis.verdict, diagnosis

far = copy.deepcopy(record) | {"calibrated_at": "2999-01-01T00:00:00Z"}
answer = post_record.sync_detailed(client=client, body=RecordBody.from_dict(far))
problem = answer.parsed
assert answer.status_code == 422 and isinstance(problem, Problem) and not isinstance(problem.errors, Unset), answer
assert (problem.errors[0].pointer, problem.errors[0].code) == ("/calibrated_at", "time_in_future"), problem
print("used from Python")
