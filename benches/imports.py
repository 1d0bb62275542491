#!/usr/bin/env python3
"""One import after another against several at once: records a second, the longest request, memory.

    benches/imports.py --program target/release/gyrowatch [--records 48000] [--batch 1000] [--at-once 4] [--rounds 3]

The same records, in the same batches, go into a new database over one connection, and into another over `at-once`,
each connection with IMUs of its own, by turns `rounds` times. Beside them a fleet page is asked for every 50 ms.
Printed are medians over the rounds, and of requests the longest of all. Standard library only; the client shares the machine.
"""
import argparse, json, os, random, sys, tempfile, threading, time
from datetime import datetime, timedelta, timezone
from http.client import HTTPConnection

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from fleet import Service, record


def batches_of(connection, records, batch):
    """Batches of one connection, in order of time: a hundred IMUs in turn."""
    rng, now = random.Random(connection), datetime.now(timezone.utc).replace(microsecond=0)
    levels = [[(rng.uniform(-5, 5), rng.uniform(-5, 5), 0.0) for _ in range(3)] for _ in range(100)]
    lines = []
    for k in range(records):
        at = now - timedelta(hours=records - k)
        lines.append(json.dumps(record(rng, 100 * connection + k % 100, k // 100, levels[k % 100], at)))
    return ["\n".join(lines[k:k + batch]) for k in range(0, records, batch)]


def timed(address, requests, took, until=None):
    connection = HTTPConnection(address, timeout=600)
    for method, path, body in requests:
        begun = time.perf_counter()
        connection.request(method, path, body, {"content-type": "application/x-ndjson"} if body else {})
        answer = connection.getresponse()
        text = answer.read()
        took.append(time.perf_counter() - begun)
        assert answer.status in (200, 207) and (not body or text.count(b'"status":201') == body.count("\n") + 1), text[:500]
        if until is not None:
            if until.wait(0.05):
                return


def run(program, by_connection):
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, f"sqlite://{folder}/imports.db", folder)
        imports, pages, done = [], [], threading.Event()
        watcher = threading.Thread(target=timed, args=(service.address, iter(lambda: ("GET", "/fleet", None), 0), pages, done))
        senders = [threading.Thread(target=timed, args=(service.address, [("POST", "/v1/import", b) for b in batches], imports))
                   for batches in by_connection]
        watcher.start()
        begun = time.perf_counter()
        for sender in senders:
            sender.start()
        for sender in senders:
            sender.join()
        took = time.perf_counter() - begun
        done.set()
        watcher.join()
        memory = service.memory()["VmHWM"]
        service.stop()
        return took, max(imports), max(pages), memory


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--records", type=int, default=48_000)
    parser.add_argument("--batch", type=int, default=1_000)
    parser.add_argument("--at-once", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    several = [batches_of(k, asked.records // asked.at_once, asked.batch) for k in range(asked.at_once)]
    one = [[batches[k] for k in range(len(several[0])) for batches in several]]
    seen = {"one": [], "several": []}
    for _ in range(asked.rounds):
        for name, by_connection in (("one", one), ("several", several)):
            seen[name].append(run(asked.program, by_connection))
    median = lambda of: sorted(of)[len(of) // 2]
    for name, runs in seen.items():
        took, imports, pages, memory = zip(*runs)
        print(f"{name:<8} {asked.records / median(took):7.0f} records/s  longest import {max(imports) * 1e3:5.0f} ms  "
              f"longest page {max(pages) * 1e3:5.0f} ms  memory {median(memory):4.0f} MB", flush=True)
    ratios = [a[0] / b[0] for a, b in zip(seen["one"], seen["several"])]
    print(f"several over one: {median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")


if __name__ == "__main__":
    main()
