#!/usr/bin/env python3
"""What the comparison of stations costs beside ingest: records of which some begin to exceed a limit, beside quiet ones.

    benches/station_look.py --program target/release/gyrowatch [--gyros 300,9000] [--every 20] [--records 2000]

Each fleet has five calibrations a gyro within 60 days by five stations; then `records` more are posted over 16
connections, by turns quiet and with one gyro of every `every`-th record beginning to exceed its budget, upon which the
service looks at the newest calibrations of the whole fleet. Printed are the rates and their ratio, fleet by fleet: how
it falls with the fleet is the look's. Standard library only; the client shares the machine.
"""
import argparse, http.client, json, random, statistics, tempfile, threading, time
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime, timedelta, timezone

from fleet import Service, record

QUIET, MOVED = [(3.0, 4.0, 0.0)] * 3, [(3.0, 4.0, 0.05)] + [(3.0, 4.0, 0.0)] * 2


def post(address, bodies):
    own = threading.local()

    def one(body):
        if not hasattr(own, "connection"):
            own.connection = http.client.HTTPConnection(address)
        own.connection.request("POST", "/v1/records", body,
                               {"content-type": "application/json", "prefer": "return=minimal"})
        answer = own.connection.getresponse()
        answer.read()
        assert answer.status == 201, answer.status

    begun = time.perf_counter()
    with ThreadPoolExecutor(16) as pool:
        list(pool.map(one, bodies))
    return len(bodies) / (time.perf_counter() - begun)


def main():
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--program", required=True)
    asked.add_argument("--gyros", default="300,9000")
    asked.add_argument("--every", type=int, default=20)
    asked.add_argument("--records", type=int, default=2000)
    asked.add_argument("--rounds", type=int, default=3)
    asked = asked.parse_args()
    rng, now = random.Random(1), datetime.now(timezone.utc)
    for gyros in map(int, asked.gyros.split(",")):
        imus = gyros // 3
        with tempfile.TemporaryDirectory() as folder:
            service = Service(asked.program, f"sqlite://{folder}/look.db", folder)
            for week in range(5):
                lines = [json.dumps(record(rng, imu, 0, QUIET, now - timedelta(days=55 - 7 * week, seconds=imu)))
                         for imu in range(imus)]
                status, text = service.ask("POST", "/v1/import", "\n".join(lines))
                assert status == 200, text[:300]
            rates, sent = {"quiet": [], "exceeding": []}, 0
            for turn in range(2 * asked.rounds):
                name, bodies = ("quiet", "exceeding")[turn % 2], []
                for number in range(asked.records):
                    moved = turn % 2 == 1 and number % asked.every == 0
                    at = now - timedelta(days=20) + timedelta(seconds=10 * sent)
                    bodies.append(json.dumps(record(rng, sent % imus, 3 if moved else 0, MOVED if moved else QUIET, at)))
                    sent += 1
                rates[name].append(post(service.address, bodies))
            service.stop()
        quiet, exceeding = (statistics.median(rates[name]) for name in ("quiet", "exceeding"))
        print(f"{gyros} gyros: {quiet:.0f} records/s quiet, {exceeding:.0f} with one gyro of every {asked.every}th "
              f"record exceeding, ratio {exceeding / quiet:.2f}", flush=True)


if __name__ == "__main__":
    main()
