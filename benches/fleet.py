#!/usr/bin/env python3
"""A fleet of 10^5 gyros: how long its page, a search, another order and a start take, of several programs in one run.

    benches/fleet.py --program before=target/before/gyrowatch --program after=target/release/gyrowatch
                     [--gyros 100000] [--records 4] [--rounds 5] [--requests 40] [--database FILE | --url URL]

The first program fills a database: gyros by three in an IMU, `records` calibrations each, one gyro in ten with a
shift, one in four overdue. Each program gets a copy of it, which it brings up to date, and is started again; then
each page is asked for by turns, `rounds` times `requests`, over one connection each. Printed are the median and the
99th percentile of the whole answer as the client sees it, the time of a start until it is ready, and the memory at
the end. `--database` keeps the database, and fills it only if it is not there. `--url` asks about a database as it is,
one on PostgreSQL too (`gyrowatch copy` makes one of a file). Standard library only; the client
shares the machine.
"""
import argparse, http.client, json, os, random, shutil, subprocess, sys, tempfile, time
from datetime import datetime, timedelta, timezone

INPUT = [0.5773502691896258, -0.4082482904638631, 0.7071067811865475]
SPIN = [0.0, 0.8660254037844387, 0.5]
PAGES = ("/", "/fleet", "/fleet?page=1", "/fleet?page=1200", "/fleet?q=LFG-0005", "/fleet?q=imu-1", "/fleet?q=nobody",
         "/fleet?status=overdue", "/fleet?state=exceeded", "/fleet?status=in_tolerance&page=700", "/fleet?station=ST-3",
         "/fleet?station=ST-3&station_when=ever", "/fleet?rule=baseline", "/fleet?sort=load", "/fleet?sort=eta&page=900",
         "/fleet?sort=age", "/fleet?sort=serial&page=1000", "/fleet?view=imu", "/fleet?view=imu&page=300",
         "/v1/gyros?limit=100", "/v1/gyros?station=ST-3&station_when=ever&limit=100", "/v1/gyros?rule=baseline&limit=100",
         "/v1/gyros?status=overdue&limit=100", "/v1/gyros?status=confirmed&limit=100", "/imus/IMU-00100", "/alerts")
SETTINGS = {"GYROWATCH_LISTEN": "127.0.0.1:0", "GYROWATCH_JUDGING__INTERVAL_DAYS": "45",
            "GYROWATCH_ALERTS__BACKFILL_DAYS": "100000",
            # As the unit file and the image have it.
            "MALLOC_ARENA_MAX": "2"}


class Service:
    """A program on a database."""

    def __init__(self, program, url, folder):
        begun = time.perf_counter()
        environment = {**os.environ, **SETTINGS, "GYROWATCH_DATABASE_URL": url}
        self.process = subprocess.Popen([os.path.abspath(program), "serve"], stdout=subprocess.PIPE, text=True,
                                        cwd=folder, stderr=open(f"{folder}/log", "a"), env=environment)
        self.address = self.process.stdout.readline().split("http://")[1].strip()
        self.connection = http.client.HTTPConnection(self.address, timeout=600)
        while self.ask("GET", "/readyz")[0] != 200:
            time.sleep(0.05)
        self.start = time.perf_counter() - begun

    def ask(self, method, path, body=None):
        self.connection.request(method, path, body, {"content-type": "application/x-ndjson"} if body else {})
        answer = self.connection.getresponse()
        return answer.status, answer.read()

    def memory(self):
        lines = open(f"/proc/{self.process.pid}/status").read().splitlines()
        of = [line for line in lines if line.startswith(("VmRSS", "VmHWM"))]
        return {line.split(":")[0]: int(line.split()[1]) / 1024 for line in of}

    def stop(self):
        self.process.terminate()
        self.process.wait()


def record(rng, imu, number, levels, at):
    gyros = []
    for slot, (d_i, d_s, shift) in enumerate(levels, 1):
        d_i, d_s = d_i + shift * (number > 2) + rng.gauss(0, 6e-4), d_s + rng.gauss(0, 6e-4)
        drift = [d_i * i + d_s * s for i, s in zip(INPUT, SPIN)]
        gyros.append({"slot": f"G{slot}", "serial": f"LFG-{3 * imu + slot:06}", "e_pulse_per_arcsec": INPUT,
                      "g_pulse_per_s_g0": drift, "g_sd": [6e-4] * 3, "e_sd": [3e-6] * 3})
    return {"imu": f"IMU-{imu:05}", "station": f"ST-{1 + imu % 5}",
            "calibrated_at": at.isoformat().replace("+00:00", "Z"),
            "geometry": {f"G{slot}": {"input": INPUT, "spin": SPIN} for slot in (1, 2, 3)}, "gyros": gyros}


def fill(service, gyros, records):
    rng, imus = random.Random(1), (gyros + 2) // 3
    level = lambda: (rng.uniform(-5, 5), rng.uniform(-5, 5), 0.05 if rng.random() < 0.1 else 0.0)
    levels = [[level() for _ in range(3)] for _ in range(imus)]
    now, lines, begun = datetime.now(timezone.utc).replace(microsecond=0), [], time.perf_counter()
    for number in range(records):
        for imu in range(imus):
            at = now - timedelta(days=30 * (records - 1 - number) + 60 * imu / imus, minutes=10)
            lines.append(json.dumps(record(rng, imu, number, levels[imu], at)))
            if len(lines) == 2000 or (number, imu) == (records - 1, imus - 1):
                # It may have been closed while the lines were made.
                service.connection.close()
                status, text = service.ask("POST", "/v1/import", "\n".join(lines))
                assert status in (200, 207) and text.count(b'"status":201') == len(lines), text[:500]
                lines = []
    print(f"{3 * imus} gyros, {imus * records} records in {time.perf_counter() - begun:.0f} s", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", action="append", required=True, metavar="NAME=PATH")
    parser.add_argument("--gyros", type=int, default=100_000)
    parser.add_argument("--records", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--requests", type=int, default=40)
    parser.add_argument("--database")
    parser.add_argument("--url")
    asked = parser.parse_args()
    programs = dict(program.split("=", 1) for program in asked.program)
    with tempfile.TemporaryDirectory() as folder:
        database = os.path.abspath(asked.database or f"{folder}/fleet.db")
        if not asked.url and not os.path.exists(database):
            service = Service(next(iter(programs.values())), f"sqlite://{database}", folder)
            fill(service, asked.gyros, asked.records)
            service.stop()
        services = {}
        for name, program in programs.items():
            own = asked.url or f"sqlite://{folder}/{name}.db"
            if not asked.url:
                shutil.copyfile(database, f"{folder}/{name}.db")
            upgrade = Service(program, own, folder)
            upgrade.stop()
            starts = []
            for _ in range(asked.rounds):
                service = Service(program, own, folder)
                starts.append(service.start)
                service.stop()
            services[name] = Service(program, own, folder)
            after = sorted(starts)[len(starts) // 2]
            print(f"{name:<8} the first start {upgrade.start:.2f} s, each after it {after:.2f} s", flush=True)
        times, refused = {}, {}
        for _ in range(asked.rounds):
            for path in PAGES:
                for name, service in services.items():
                    # It may have been closed while others were asked.
                    service.connection.close()
                    service.ask("GET", "/readyz")
                    for _ in range(asked.requests):
                        begun = time.perf_counter()
                        status, _ = service.ask("GET", path)
                        times.setdefault((path, name), []).append(1e3 * (time.perf_counter() - begun))
                        # Too slow an answer is given up.
                        refused[path, name] = refused.get((path, name), 0) + (status == 503)
                        assert status in (200, 503), (path, status)
        for path in PAGES:
            row = []
            for name in services:
                of = sorted(times[path, name])
                high = of[min(len(of) - 1, int(0.99 * len(of)))]
                row.append(f"{name} p50 {of[len(of) // 2]:7.1f} ms  p99 {high:7.1f} ms"
                           + f" ({refused[path, name]} given up)" * (refused[path, name] > 0))
            print(f"{path:<36} {'   '.join(row)}", flush=True)
        for name, service in services.items():
            memory = " ".join(f"{key} {value:.0f} MB" for key, value in service.memory().items())
            print(f"{name:<8} memory {memory}", flush=True)
            service.stop()


if __name__ == "__main__":
    main()
