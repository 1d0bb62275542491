"""Client of gyrowatch. Needs nothing but Python; `trend_frame` needs pandas.

>>> watch = Gyrowatch("http://127.0.0.1:8080", token="...")
>>> answer = watch.post_record(record)
>>> [(verdict["coefficient"], verdict["status"]) for verdict in answer["verdicts"]]
>>> watch.trend_frame("LFG-0101").plot(y="value")
"""

from __future__ import annotations

import datetime
import http.client
import json
import os
import time
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass, field
from typing import Any, Iterator, Mapping, Optional, TYPE_CHECKING, Union

if TYPE_CHECKING:
    import pandas

__version__ = "0.2.0"

Json = dict[str, Any]

#: What a filter may be; `None` is none. `from` is a word of Python's own: `from_`.
Filter = Union[str, int, bool, datetime.date, None]

#: Answers after which sending the same again may help. What is stored already is recognised by its content.
_AGAIN = frozenset({408, 425, 429, 500, 502, 503, 504, 507})


@dataclass
class Problem(Exception):
    """An answer that is a refusal (RFC 9457). `code` and `parameters` are for programs, `title` and `detail` for
    people; `errors` names the places of a document that are at fault, `existing` what is stored already."""

    status: int
    title: str
    detail: str
    errors: list[Json] = field(default_factory=list)
    code: Optional[str] = None
    parameters: Json = field(default_factory=dict)
    existing: Optional[str] = None

    def __str__(self) -> str:
        return f"{self.status} {self.title}: {self.detail}"


def _language() -> Optional[str]:
    """`en` or `zh`, as LC_ALL, LC_MESSAGES or LANG say: the first that is set."""
    set_ones = filter(None, map(os.environ.get, ("LC_ALL", "LC_MESSAGES", "LANG")))
    language = next(set_ones, "")[:2].lower()
    return language if language in ("en", "zh") else None


@dataclass
class Gyrowatch:
    """A service. `patience` is how many seconds a request is tried again while the service is away or busy, `language`
    that of `detail` in what it refuses: `en` or `zh`."""

    url: str
    token: Optional[str] = field(default=None, repr=False)
    timeout: float = 30.0
    patience: float = 60.0
    language: Optional[str] = field(default_factory=_language)

    def __post_init__(self) -> None:
        if self.token is not None:
            self.token = self.token.strip()
            if not self.token.isascii() or not self.token.isprintable() or " " in self.token:
                raise ValueError("the token has a blank or a character within it that no token has")

    def post_record(self, record: Mapping[str, Any]) -> Json:
        """Stores parameters that the station fitted; the answer has `id`, `separations`, `verdicts`, `notes`."""
        return self._post("/v1/records", record)

    def post_campaign(self, campaign: Mapping[str, Any]) -> Json:
        """Stores the dwells of a campaign; the answer has what was fitted to them, too."""
        return self._post("/v1/campaigns", campaign)

    def post_bench_result(self, result: Mapping[str, Any]) -> Json:
        """Stores D_I and D_S of one gyro as a bench has measured them."""
        return self._post("/v1/bench-results", result)

    def gyros(self, **filters: Filter) -> Iterator[Json]:
        """Every gyro with its newest figures: `status`, `station`, `imu`, `batch`, `rule`, `changed_since`, `sort` ..."""
        return self._pages("/v1/gyros", "gyros", filters)

    def gyro(self, serial: str) -> Json:
        return self._get(f"/v1/gyros/{_quoted(serial)}")

    def imus(self) -> Iterator[Json]:
        return self._pages("/v1/imus", "imus", {})

    def records(self, **filters: Filter) -> Iterator[Json]:
        """Records and campaigns, the last to arrive first: `imu`, `station`, `from_`, `to`."""
        return self._pages("/v1/records", "records", filters)

    def alerts(self, **filters: Filter) -> Iterator[Json]:
        """Alerts, the newest first: `state="firing"`, `serial`, `rule`, `severity`."""
        return self._pages("/v1/alerts", "alerts", filters)

    def trend(self, serial: str, coefficient: str = "D_I", **filters: Filter) -> list[Json]:
        """The history of a coefficient, deg/(h g0), oldest first: `method`, `from_`, `to`, `last`, `voided`, `levels`."""
        if filters.keys() & {"columns", "every", "format"}:
            raise ValueError("a trend is read as points: columns, every and format are for other programs")
        path, filters = f"/v1/gyros/{_quoted(serial)}/trend", {"coefficient": coefficient, **filters}
        return list(self._pages(path, "points", filters))

    def trend_frame(self, serial: str, coefficient: str = "D_I", **filters: Filter) -> "pandas.DataFrame":
        """`trend` as a table by time, with `value` and `sd` in deg/(h g0); without a row where there is no point.
        `levels="include"` adds `baseline`, `lower` and `upper`."""
        import pandas

        points = self.trend(serial, coefficient, **filters)
        frame = pandas.DataFrame([{**point.pop("level", {}), **point} for point in points])
        if frame.empty:
            frame = pandas.DataFrame({name: pandas.Series(dtype=kind) for name, kind in _TREND.items()})
        frame["calibrated_at"] = pandas.to_datetime(frame["calibrated_at"], utc=True, format="ISO8601")
        return frame.set_index("calibrated_at")

    def diagnosis(self, campaign: str) -> Json:
        """What parts the campaign from the model: gap, effects, closure, next dwells."""
        return self._get(f"/v1/campaigns/{_quoted(campaign)}/diagnosis")

    def gyro_diagnosis(self, serial: str) -> Json:
        """Why the gyro's history changed: the gyro, its station, temperature, an event."""
        return self._get(f"/v1/gyros/{_quoted(serial)}/diagnosis")

    def _pages(self, path: str, member: str, filters: Mapping[str, Filter]) -> Iterator[Json]:
        query = {name.rstrip("_"): _written(value) for name, value in filters.items() if value is not None}
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
        if self.language is not None:
            headers["Accept-Language"] = self.language
        if body is not None:
            headers["Content-Type"] = "application/json"
        if self.token is not None:
            headers["Authorization"] = f"Bearer {self.token}"
        request = urllib.request.Request(self.url.rstrip("/") + path, data=body, headers=headers)
        until, pause = time.monotonic() + self.patience, 0.5
        while True:
            try:
                with urllib.request.urlopen(request, timeout=self.timeout) as answer:
                    said: Json = json.load(answer)
                    return said
            except urllib.error.HTTPError as refusal:
                problem, after = _problem(refusal), refusal.headers.get("Retry-After")
                wait = float(after) if after and after.isdigit() else pause
                if refusal.code not in _AGAIN or time.monotonic() + wait > until:
                    raise problem from None
            except (OSError, http.client.HTTPException):  # away, or gone in the middle of its answer
                wait = pause
                if time.monotonic() + wait > until:
                    raise
            time.sleep(wait)
            pause = min(2 * pause, 30.0)


#: Columns of a trend without points.
_TREND = {
    "calibrated_at": "object", "value": "float64", "sd": "float64", "method": "object", "imu": "object",
    "slot": "object", "station": "object", "record": "object", "state": "object", "status": "object",
}


def _written(value: Filter) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime.datetime) and value.tzinfo is None:
        raise ValueError(f"{value} has no time zone")
    # A day is taken as it is: as the last one it counts as a whole.
    return value.isoformat() if isinstance(value, datetime.date) else str(value)


def _quoted(segment: str) -> str:
    return urllib.parse.quote(segment, safe="")


def _problem(refusal: urllib.error.HTTPError) -> Problem:
    try:
        text = refusal.read()
    except http.client.IncompleteRead as half:
        text = half.partial
    try:
        said = json.loads(text)
        known = ("errors", "code", "parameters", "existing")
        more = {name: said[name] for name in known if said.get(name) is not None}
        return Problem(refusal.code, said["title"], said.get("detail", ""), **more)
    except (ValueError, KeyError, TypeError, AttributeError):
        return Problem(refusal.code, str(refusal.reason), text[:200].decode(errors="replace"))
