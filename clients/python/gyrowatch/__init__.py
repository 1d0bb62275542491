"""Client of gyrowatch. Needs nothing but Python; `trend_frame` needs pandas.

>>> watch = Gyrowatch("http://127.0.0.1:8080", token="...")
>>> answer = watch.post_record(record)
>>> [(verdict["coefficient"], verdict["status"]) for verdict in answer["verdicts"]]
>>> watch.trend_frame("LFG-0101").plot(y="value")
"""

from __future__ import annotations

import json
import time
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass, field
from typing import Any, Iterator, Mapping, Optional, TYPE_CHECKING

if TYPE_CHECKING:
    import pandas

__version__ = "0.2.0"

Json = dict[str, Any]

#: Answers after which sending the same again may help. What is stored already is recognised by its content.
_AGAIN = frozenset({408, 425, 429, 500, 502, 503, 504, 507})


@dataclass
class Problem(Exception):
    """An answer that is a refusal (RFC 9457). `errors` names the places of a document that are at fault."""

    status: int
    title: str
    detail: str
    errors: list[Json] = field(default_factory=list)

    def __str__(self) -> str:
        return f"{self.status} {self.title}: {self.detail}"


@dataclass
class Gyrowatch:
    """A service. `patience` is how many seconds a request is tried again while the service is away or busy."""

    url: str
    token: Optional[str] = None
    timeout: float = 30.0
    patience: float = 60.0

    def post_record(self, record: Mapping[str, Any]) -> Json:
        """Stores parameters that the station fitted; the answer has `id`, `separations`, `verdicts`, `notes`."""
        return self._post("/v1/records", record)

    def post_campaign(self, campaign: Mapping[str, Any]) -> Json:
        """Stores the dwells of a campaign; the answer has what was fitted to them, too."""
        return self._post("/v1/campaigns", campaign)

    def post_bench_result(self, result: Mapping[str, Any]) -> Json:
        """Stores D_I and D_S of one gyro as a bench has measured them."""
        return self._post("/v1/bench-results", result)

    def gyros(self, **filters: str) -> Iterator[Json]:
        """Every gyro with its newest figures: `status="confirmed"`, for example."""
        return self._pages("/v1/gyros", "gyros", filters)

    def gyro(self, serial: str) -> Json:
        return self._get(f"/v1/gyros/{_quoted(serial)}")

    def imus(self) -> Iterator[Json]:
        return self._pages("/v1/imus", "imus", {})

    def records(self, **filters: str) -> Iterator[Json]:
        """Records and campaigns, the last to arrive first: `imu`, `station`, `from`, `to`."""
        return self._pages("/v1/records", "records", filters)

    def alerts(self, **filters: str) -> Iterator[Json]:
        """Alerts, the newest first: `state="firing"`, `serial`, `rule`, `severity`."""
        return self._pages("/v1/alerts", "alerts", filters)

    def trend(self, serial: str, coefficient: str = "D_I", **filters: str) -> list[Json]:
        """The history of a coefficient, deg/(h g0), oldest first."""
        filters = {"coefficient": coefficient, **filters}
        return list(self._pages(f"/v1/gyros/{_quoted(serial)}/trend", "points", filters))

    def trend_frame(self, serial: str, coefficient: str = "D_I", **filters: str) -> "pandas.DataFrame":
        """`trend` as a table by time."""
        import pandas

        frame = pandas.DataFrame(self.trend(serial, coefficient, **filters))
        frame["calibrated_at"] = pandas.to_datetime(frame["calibrated_at"])
        return frame.set_index("calibrated_at")

    def diagnosis(self, campaign: str) -> Json:
        """What parts the campaign from the model: gap, effects, closure, next dwells."""
        return self._get(f"/v1/campaigns/{_quoted(campaign)}/diagnosis")

    def gyro_diagnosis(self, serial: str) -> Json:
        """Why the gyro's history changed: the gyro, its station, temperature, an event."""
        return self._get(f"/v1/gyros/{_quoted(serial)}/diagnosis")

    def _pages(self, path: str, member: str, filters: Mapping[str, str]) -> Iterator[Json]:
        query = dict(filters)
        while True:
            page = self._get(f"{path}?{urllib.parse.urlencode(query)}" if query else path)
            yield from page[member]
            if page.get("next") is None:
                return
            query["cursor"] = page["next"]

    def _get(self, path: str) -> Json:
        return self._call(path, None)

    def _post(self, path: str, document: Mapping[str, Any]) -> Json:
        return self._call(path, json.dumps(document).encode())

    def _call(self, path: str, body: Optional[bytes]) -> Json:
        headers = {"Accept": "application/json", "User-Agent": f"gyrowatch-python/{__version__}"}
        if body is not None:
            headers["Content-Type"] = "application/json"
        if self.token is not None:
            headers["Authorization"] = f"Bearer {self.token}"
        request = urllib.request.Request(self.url.rstrip("/") + path, data=body, headers=headers)
        until, pause = time.monotonic() + self.patience, 0.5
        while True:
            try:
                with urllib.request.urlopen(request, timeout=self.timeout) as answer:
                    return json.load(answer)
            except urllib.error.HTTPError as refusal:
                problem, after = _problem(refusal), refusal.headers.get("Retry-After")
                wait = float(after) if after and after.isdigit() else pause
                if refusal.code not in _AGAIN or time.monotonic() + wait > until:
                    raise problem from None
            except OSError:
                wait = pause
                if time.monotonic() + wait > until:
                    raise
            time.sleep(wait)
            pause = min(2 * pause, 30.0)


def _quoted(segment: str) -> str:
    return urllib.parse.quote(segment, safe="")


def _problem(refusal: urllib.error.HTTPError) -> Problem:
    text = refusal.read()
    try:
        said = json.loads(text)
        return Problem(refusal.code, said["title"], said.get("detail", ""), said.get("errors", []))
    except (ValueError, KeyError, TypeError):
        return Problem(refusal.code, str(refusal.reason), text[:200].decode(errors="replace"))
