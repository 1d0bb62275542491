#!/usr/bin/env python3
"""What the forecast of a stored campaign costs beside its ingest, in one run of one service: by turns campaigns of IMUs
with calibrations before that were campaigns (each is foretold from a fit of those), and of IMUs with as many calibrations
before that were records of fitted parameters (nothing is foretold).

    python3 scripts/bench_forecast.py [GYROWATCH] [TURNS]

Everything else is the same: the same 78 dwells, fitted, stored, judged against as long a history and diagnosed. The time is
that of one connection which posts; the processor time is that of the service until every diagnosis is kept.
"""

import http.client
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

CAMPAIGN = json.loads(
    (pathlib.Path(__file__).parent.parent / "tests/data/practice/campaign-00.json").read_text())
EACH = 25
BEFORE = 5


def processor_seconds(pid):
    of_process = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, of_process[11:13])) / os.sysconf("SC_CLK_TCK")


def instant(day):
    return f"2026-{1 + day // 28:02}-{1 + day % 28:02}T08:00:00Z"


class Service:
    def __init__(self, program, folder):
        environment = {**os.environ, "GYROWATCH_DATABASE_URL": f"sqlite://{folder}/gyrowatch.db",
                       "GYROWATCH_LISTEN": "127.0.0.1:0"}
        self.process = subprocess.Popen([program, "serve"], env=environment, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True)
        line = next(line for line in self.process.stdout if "listens on" in line)
        self.connection = http.client.HTTPConnection(line.rpartition("//")[2].strip())
        self.posted = 0

    def ask(self, method, path, body=None):
        self.connection.request(method, path, body, {"content-type": "application/json"})
        answer = self.connection.getresponse()
        return answer.status, json.loads(answer.read())

    def post(self, imu, day):
        document = {**CAMPAIGN, "imu": f"IMU-{imu}", "measured_at": instant(day)}
        document["gyros"] = [{**gyro, "serial": f"{gyro['serial']}-{imu}"} for gyro in CAMPAIGN["gyros"]]
        status, answer = self.ask("POST", "/v1/campaigns", json.dumps(document))
        assert status == 201, answer
        self.posted += 1
        return answer

    def post_fitted(self, imu, day, fitted):
        """A record of what `fitted`, the answer to a campaign, has found."""
        gyros = []
        for gyro, of in zip(CAMPAIGN["gyros"], fitted["calibration"]["gyros"]):
            figures = {name: of[name] for name in ("slot", "e_pulse_per_arcsec", "e_sd", "g_pulse_per_s_g0", "g_sd")}
            gyros.append({**figures, "serial": f"{gyro['serial']}-{imu}"})
        record = {"imu": f"IMU-{imu}", "station": CAMPAIGN["station"], "calibrated_at": instant(day),
                  "geometry": CAMPAIGN.get("geometry", "skewed"), "gyros": gyros}
        status, answer = self.ask("POST", "/v1/records?confirm=true", json.dumps(record))
        assert status == 201, answer

    def settle(self):
        while self.ask("GET", "/v1/diagnoses/summary")[1]["campaigns"]["diagnosed"] < self.posted:
            time.sleep(0.2)

    def batch(self, imus, day):
        """Milliseconds a post, and of processor time until all is diagnosed, a campaign."""
        before, begun = processor_seconds(self.process.pid), time.perf_counter()
        for imu in imus:
            newest = self.post(imu, day)["id"]
        took = time.perf_counter() - begun
        self.settle()
        used = processor_seconds(self.process.pid) - before
        told = self.ask("GET", f"/v1/campaigns/{newest}/diagnosis")[1]["forecast"].get("compared") is not None
        return [1e3 * seconds / len(imus) for seconds in (took, used)], told


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/gyrowatch"
    turns = int(sys.argv[2]) if len(sys.argv) > 2 else 12
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, folder)
        try:
            foretold = [f"K{k}" for k in range(EACH)]
            for day in range(BEFORE):
                for imu in foretold:
                    fitted = service.post(imu, day)
            service.settle()
            ratios, figures = [], []
            for turn in range(turns):
                day = BEFORE + turn
                others = [f"N{turn}-{k}" for k in range(EACH)]
                for imu in others:
                    for before in range(day):
                        service.post_fitted(imu, before, fitted)
                new, of_new = service.batch(others, day)
                old, of_old = service.batch(foretold, day)
                assert (of_new, of_old) == (False, True)
                figures.append((*new, *old))
                ratios.append((old[0] / new[0], old[1] / new[1]))
        finally:
            service.process.terminate()
            service.process.wait()
    posts, processor = ([ratio[k] for ratio in ratios] for k in (0, 1))
    without_post, without, with_post, with_forecast = (statistics.median(row[k] for row in figures) for k in range(4))
    of = lambda list: f"{statistics.median(list):.2f} (turns {min(list):.2f} to {max(list):.2f})"
    print(f"post of a campaign: {with_post:.2f} ms with a forecast, {without_post:.2f} ms without: ratio {of(posts)}")
    print(f"processor time, diagnosis included: {with_forecast:.1f} ms, {without:.1f} ms: ratio {of(processor)}")


if __name__ == "__main__":
    main()
