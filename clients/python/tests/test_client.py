"""Runs against the service at GYROWATCH_URL, which must be empty: python3 -m unittest discover -s tests"""

import copy
import datetime
import json
import os
import pathlib
import socket
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))
import gyrowatch
from gyrowatch import Gyrowatch, Problem

DATA = pathlib.Path(os.environ["GYROWATCH_TEST_DATA"])


class Client(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.watch = Gyrowatch(os.environ["GYROWATCH_URL"], patience=10)
        cls.record = json.loads((DATA / "paper.json").read_text())
        for day in range(1, 4):
            record = copy.deepcopy(cls.record)
            record["calibrated_at"] = f"2026-03-0{day}T08:00:00Z"
            cls.answer = cls.watch.post_record(record)

    def test_what_was_posted_is_read_again(self) -> None:
        self.assertAlmostEqual(self.answer["separations"][0]["d_i"]["value"], 2.957643, places=6)
        serial = self.record["gyros"][0]["serial"]
        points = self.watch.trend(serial, limit="2")
        self.assertEqual([point["calibrated_at"][:10] for point in points], ["2026-03-01", "2026-03-02", "2026-03-03"])
        self.assertEqual(self.watch.gyro(serial)["serial"], serial)
        self.assertIn(serial, [gyro["serial"] for gyro in self.watch.gyros(limit="1")])
        self.assertEqual(len(list(self.watch.records(imu=self.record["imu"], limit="2"))), 3)
        self.assertIn(self.record["imu"], [imu["imu"] for imu in self.watch.imus()])
        self.assertEqual(list(self.watch.alerts(state="firing")), [])

    def test_a_trend_that_would_have_no_points_is_refused(self) -> None:
        for name in ["columns", "every", "format"]:
            with self.assertRaises(ValueError):
                self.watch.trend("LFG-0101", **{name: "month"})

    def test_a_trend_is_a_table(self) -> None:
        try:
            import pandas  # noqa: F401
        except ImportError:
            if os.environ.get("GYROWATCH_TEST_PANDAS") == "required":
                raise
            self.skipTest("pandas is not installed")
        serial = self.record["gyros"][0]["serial"]
        frame = self.watch.trend_frame(serial, "D_S")
        self.assertEqual(len(frame), 3)
        self.assertTrue((frame["method"] == "rigid").all())
        from_ = datetime.datetime(2026, 3, 2, tzinfo=datetime.timezone.utc)
        self.assertEqual(len(self.watch.trend_frame(serial, "D_S", from_=from_)), 2)
        last = self.watch.trend_frame(serial, "D_S", to=datetime.date(2026, 3, 2))
        self.assertEqual(len(last), 2)
        nothing = self.watch.trend_frame(serial, "D_S", from_=datetime.date(2036, 1, 1))
        self.assertEqual((len(nothing), list(nothing.columns)), (0, list(frame.columns)))
        held = self.watch.trend_frame(serial, "D_S", levels="include")
        self.assertTrue(((held["lower"] < held["value"]) & (held["value"] < held["upper"])).all())
        self.assertAlmostEqual((held["upper"] - held["baseline"]).iloc[0], 0.01)
        self.assertEqual((str(nothing.index.tz), nothing["value"].dtype), (str(frame.index.tz), frame["value"].dtype))

    def test_a_refusal_names_the_place(self) -> None:
        with self.assertRaises(Problem) as caught:
            self.watch.post_record({**self.record, "imu": 7})
        self.assertEqual((caught.exception.status, caught.exception.errors[0]["pointer"]), (422, "/imu"))
        with self.assertRaises(Problem) as caught:
            self.watch.gyro("nobody's")
        self.assertEqual((caught.exception.code, caught.exception.parameters), ("unknown_gyro", {"serial": "nobody's"}))

    def test_words_are_in_the_language_asked_for_or_that_of_the_environment(self) -> None:
        before = {name: os.environ.pop(name, None) for name in ("LC_ALL", "LC_MESSAGES", "LANG")}
        try:
            self.assertIsNone(Gyrowatch(self.watch.url).language)
            os.environ["LANG"] = "zh_CN.UTF-8"
            chinese = Gyrowatch(self.watch.url)
            os.environ["LC_ALL"] = "C"
            self.assertIsNone(Gyrowatch(self.watch.url).language)
        finally:
            for name, value in before.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value
        for watch, is_english in [(chinese, False), (Gyrowatch(self.watch.url, language="en"), True)]:
            with self.assertRaises(Problem) as caught:
                watch.gyro("nobody's")
            self.assertEqual(caught.exception.title.isascii(), is_english)

    def test_a_token_is_not_shown_and_may_come_from_a_file(self) -> None:
        watch = Gyrowatch("http://127.0.0.1:9", token="gw_secret\n")
        self.assertEqual(watch.token, "gw_secret")
        self.assertNotIn("secret", repr(watch))
        for wrong in ["gw_one two", "gw_one\ntwo", "gw_\u00fc"]:
            with self.assertRaises(ValueError):
                Gyrowatch("http://127.0.0.1:9", token=wrong)

    def test_an_answer_that_broke_off_is_asked_for_again(self) -> None:
        answers = [b"HTTP/1.1 200 OK\r\nContent-Length: 90\r\n\r\n{", b"HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{\"on\": 1}"]
        with socket.create_server(("127.0.0.1", 0)) as listener:
            def serve() -> None:
                for answer in answers:
                    with listener.accept()[0] as connection:
                        connection.recv(4096)
                        connection.sendall(answer)

            threading.Thread(target=serve, daemon=True).start()
            watch = Gyrowatch(f"http://127.0.0.1:{listener.getsockname()[1]}", patience=10)
            self.assertEqual(watch.gyro("LFG-0101"), {"on": 1})

    def test_a_campaign_is_diagnosed(self) -> None:
        campaign = json.loads((DATA / "practice" / "campaign-00.json").read_text())
        posted = self.watch.post_campaign(campaign)
        self.assertIn("verdict", self.watch.diagnosis(posted["id"]))

    def test_a_service_that_is_away_is_waited_for_and_then_named(self) -> None:
        begun = time.monotonic()
        with self.assertRaises(OSError):
            Gyrowatch("http://127.0.0.1:9", patience=1).gyro("LFG-0101")
        self.assertLess(time.monotonic() - begun, 5)

    def test_the_version_is_that_of_the_service(self) -> None:
        self.assertEqual(self.watch._get("/healthz")["version"].split()[0], gyrowatch.__version__)


if __name__ == "__main__":
    unittest.main()
