"""Runs against the service at GYROWATCH_URL, which must be empty: python3 -m unittest discover -s tests"""

import copy
import json
import os
import pathlib
import sys
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

    def test_a_trend_is_a_table(self) -> None:
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("pandas is not installed")
        frame = self.watch.trend_frame(self.record["gyros"][0]["serial"], "D_S")
        self.assertEqual(len(frame), 3)
        self.assertTrue((frame["method"] == "rigid").all())

    def test_a_refusal_names_the_place(self) -> None:
        with self.assertRaises(Problem) as caught:
            self.watch.post_record({**self.record, "imu": 7})
        self.assertEqual((caught.exception.status, caught.exception.errors[0]["pointer"]), (422, "/imu"))

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
