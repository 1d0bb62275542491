#!/usr/bin/env python3
"""How cost grows: with the history, the gyros, the records of a month, the connections, the dwells, the processors and the servers on one PostgreSQL.

    scripts/bench_growth.py [--program target/release/gyrowatch] [--values 1000000]

Every figure is a ratio to the first of its row as well. `--values` is the largest history, in coefficient values (two a gyro
and calibration): 10^7 take some minutes to import. Standard library only; the client shares the machine, and so does PostgreSQL,
which is left out where Debian's is not installed.
"""
import argparse, asyncio, contextlib, glob, http.client, json, multiprocessing, os, shutil, socket, subprocess, sys, tempfile, time
from datetime import datetime, timedelta, timezone

# Not where clocks that were never set begin: such records are set aside.
START = datetime(2010, 1, 1, 8, tzinfo=timezone.utc)
PAPER = json.load(open("tests/data/paper.json"))
SECONDS = 3


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Service:
    """The service on a database of its own, or as one of several on `database`, as long as the block lasts."""

    def __init__(self, program, processors=None, database=None):
        self.dir = tempfile.TemporaryDirectory(prefix="gyrowatch-growth-")
        self.port = free_port()
        environment = dict(os.environ, GYROWATCH_LISTEN=f"127.0.0.1:{self.port}",
                           GYROWATCH_DATABASE_URL=database or f"sqlite://{self.dir.name}/g.db")
        command = [program, "serve"] if processors is None else ["taskset", "-c", f"0-{processors - 1}", program, "serve"]
        self.log = open(f"{self.dir.name}/log", "w")
        self.process = subprocess.Popen(command, env=environment, stdout=self.log, stderr=self.log)

    def __enter__(self):
        try:
            for _ in range(200):
                try:
                    self.connect().close()
                    return self
                except OSError:
                    time.sleep(0.05)
            sys.exit("the service does not answer")
        except BaseException:
            self.stop()
            raise

    def __exit__(self, *_):
        self.stop()

    def connect(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=600)
        connection.connect()
        connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection

    def stop(self):
        self.process.terminate()
        self.process.wait()
        self.log.close()
        self.dir.cleanup()


def record(imu, number):
    one = json.loads(json.dumps(PAPER))
    one["imu"] = f"IMU-{imu:05}"
    one["calibrated_at"] = (START + timedelta(hours=6 * number, seconds=imu)).isoformat()
    for gyro in one["gyros"]:
        gyro["serial"] = f"L{imu:05}-{gyro['slot']}"
        gyro["g_pulse_per_s_g0"][0] += 1e-5 * (number % 13)
    return json.dumps(one)


def send_lines(service, imus, first, last):
    """Every IMU's calibrations from number `first` to before `last`; seconds that it took."""
    connection, begun = service.connect(), time.perf_counter()
    lines, stored = [], 0

    def flush():
        nonlocal lines, stored
        connection.request("POST", "/v1/import", "\n".join(lines), {"content-type": "application/x-ndjson"})
        text = connection.getresponse().read().decode()
        assert text.count('"status":201') == len(lines), text[:300]
        stored, lines = stored + len(lines), []

    for number in range(first, last):
        for imu in range(imus):
            lines.append(record(imu, number))
            if len(lines) == 5000:
                flush()
    if lines:
        flush()
    connection.close()
    return stored / (time.perf_counter() - begun)


def closed_loop(port, method, path, bodies, seconds):
    """Requests that one connection gets answered; None as a body where there is none."""
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.connect()
    connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    times, until, number = [], time.perf_counter() + seconds, 0
    while time.perf_counter() < until:
        body = bodies(number) if callable(bodies) else bodies
        begun = time.perf_counter()
        connection.request(method, path, body, {"content-type": "application/json"})
        answer = connection.getresponse()
        answer.read()
        assert answer.status in (200, 201), answer.status
        times.append(time.perf_counter() - begun)
        number += 1
    return sorted(times)


def row(title, unit, figures):
    base = figures[0][1]
    print(f"{title}\n  " + "   ".join(f"{name}: {value:.4g} {unit} ({value / base:.2f})" for name, value in figures), flush=True)


def median(times):
    return times[len(times) // 2]


def with_history(program, most):
    """One fleet of 100 IMUs whose history grows: import, then a trend, the fleet's page and a record."""
    imus, done = 100, 0
    rates, trends, pages, records = [], [], [], []
    values = 10_000
    with Service(program) as service:
        while values <= most:
            calibrations = max(values // (6 * imus), 1)
            rates.append((f"10^{len(str(values)) - 1} values", send_lines(service, imus, done, calibrations)))
            done = calibrations
            name = rates[-1][0]
            trend = f"/v1/gyros/L00001-G1/trend?coefficient=D_I&last={min(1000, calibrations)}"
            trends.append((name, 1e6 * median(closed_loop(service.port, "GET", trend, None, SECONDS))))
            pages.append((name, 1e3 * median(closed_loop(service.port, "GET", "/", None, SECONDS))))
            posted = closed_loop(service.port, "POST", "/v1/records", lambda k: record(50_000, len(records) * 8_000 + k), SECONDS)
            records.append((name, len(posted) / SECONDS))
            values *= 10
    row("history: import", "records/s", rates)
    row("history: up to the last 1,000 points of a gyro", "us", trends)
    row("history: the fleet's page", "ms", pages)
    row("history: records over one connection", "/s", records)


def with_gyros(program):
    rates, pages, records = [], [], []
    for imus in (1, 34, 334, 3334):
        name = f"{3 * imus} gyros"
        with Service(program) as service:
            rates.append((name, send_lines(service, imus, 0, max(20_000 // imus, 3))))
            pages.append((name, 1e3 * median(closed_loop(service.port, "GET", "/", None, SECONDS))))
            posted = closed_loop(service.port, "POST", "/v1/records", lambda k: record(k % imus, 25_000 + k // imus), SECONDS)
        records.append((name, len(posted) / SECONDS))
    row("gyros: import of 20,000 records or three a gyro", "records/s", rates)
    row("gyros: the fleet's page", "ms", pages)
    row("gyros: records over one connection", "/s", records)


def sender(port, imu, seconds):
    return closed_loop(port, "POST", "/v1/records", lambda k: record(imu, k), seconds)


def with_connections(program):
    rates, tails = [], []
    for connections in (1, 4, 16, 64, 256):
        with Service(program) as service, multiprocessing.Pool(connections) as pool:
            times = sorted(sum(pool.starmap(sender, [(service.port, imu, SECONDS) for imu in range(connections)]), []))
        rates.append((str(connections), len(times) / SECONDS))
        tails.append((str(connections), 1e3 * times[int(0.99 * len(times))]))
    row("connections: records", "/s", rates)
    row("connections: p99", "ms", tails)


def with_processors(program):
    rates = []
    for processors in (1, 2):
        with Service(program, processors) as service, multiprocessing.Pool(16) as pool:
            times = sum(pool.starmap(sender, [(service.port, imu, SECONDS) for imu in range(16)]), [])
        rates.append((str(processors), len(times) / SECONDS))
    row("processors of the service (the client has both): records over 16 connections", "/s", rates)


def at_second(second):
    one = json.loads(json.dumps(PAPER))
    one["calibrated_at"] = (START + timedelta(seconds=second)).isoformat()
    return json.dumps(one)


def interleaved(port, share, first, seconds):
    """Of sixteen connections that send the calibrations of one IMU, each every sixteenth: some overtake others."""
    return closed_loop(port, "POST", "/v1/records", lambda k: at_second(first + 16 * k + share), seconds)


def with_density(program):
    """One IMU that is calibrated every second or so: what its last 30 days hold grows."""
    ordered, overtaking, stored, second = [], [], 0, 0
    with Service(program) as service, multiprocessing.Pool(16) as pool:
        for count in (1_000, 10_000, 100_000, 300_000):
            connection = service.connect()
            while stored < count:
                lines = [at_second(second + k) for k in range(min(5000, count - stored))]
                connection.request("POST", "/v1/import", "\n".join(lines), {"content-type": "application/x-ndjson"})
                assert connection.getresponse().read().count(b'"status":201') == len(lines)
                stored, second = stored + len(lines), second + len(lines)
            connection.close()
            times = closed_loop(service.port, "POST", "/v1/records", lambda k: at_second(second + k), SECONDS)
            ordered.append((f"{count} records", len(times) / SECONDS))
            stored, second = stored + len(times), second + len(times)
            times = sum(pool.starmap(interleaved, [(service.port, share, second, SECONDS) for share in range(16)]), [])
            overtaking.append((f"{count} records", len(times) / SECONDS))
            stored, second = stored + len(times), second + 2 * len(times)
    row("density: records of one IMU over one connection, so many in its last 30 days", "/s", ordered)
    row("density: over 16 connections", "/s", overtaking)


class PostgreSQL:
    """A cluster of its own as long as the block lasts, as the user postgres where this one is root: the server refuses root.

    It asks nobody who he is, so it listens on no port: only who may enter its directory reaches it."""

    def __init__(self, bin):
        self.bin, self.dir = bin, tempfile.mkdtemp(prefix="gyrowatch-growth-pg-")
        self.user = ["runuser", "-u", "postgres", "--"] if os.geteuid() == 0 else []

    def __enter__(self):
        try:
            if self.user:
                shutil.chown(self.dir, "postgres")
            initdb = [f"{self.bin}/initdb", "--pgdata", f"{self.dir}/data", "--username", "bench", "--auth", "trust"]
            subprocess.run([*self.user, *initdb], check=True, stdout=subprocess.DEVNULL)
            self.control("start", "--wait", "--log", f"{self.dir}/log", "--options",
                         f"-k {self.dir} -c listen_addresses='' -c max_connections=200")
            return self
        except BaseException:
            self.stop()
            raise

    def __exit__(self, *_):
        self.stop()

    def control(self, *command):
        command = [*self.user, f"{self.bin}/pg_ctl", "--pgdata", f"{self.dir}/data", *command]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    def database(self, name):
        subprocess.run([f"{self.bin}/createdb", "-h", self.dir, "-U", "bench", name], check=True)
        return f"postgres://bench@localhost/{name}?host={self.dir}"

    def stop(self):
        try:
            if os.path.exists(f"{self.dir}/data/postmaster.pid"):
                self.control("stop", "--mode", "immediate")
        finally:
            shutil.rmtree(self.dir)


def newest_postgresql():
    """The directory of its programs, by the number of the version, for which 9.6 lies before 17; None where there is none."""
    installed = {tuple(map(int, bin.split("/")[-2].split("."))): bin for bin in glob.glob("/usr/lib/postgresql/[0-9]*/bin")}
    return installed[max(installed)] if installed else None


def with_servers(program):
    """Records over 24 connections, each to one of the servers by turns. Longer than the others: an empty database takes a second to begin."""
    bin = newest_postgresql()
    if bin is None:
        return print("servers: postgresql is not installed")
    rates, tails, seconds = [], [], 5 * SECONDS
    with PostgreSQL(bin) as cluster:
        for count in (1, 2, 3):
            database = cluster.database(f"servers{count}")
            with contextlib.ExitStack() as running, multiprocessing.Pool(24) as pool:
                services = [running.enter_context(Service(program, database=database)) for _ in range(count)]
                work = [(services[imu % count].port, imu, seconds) for imu in range(24)]
                times = sorted(sum(pool.starmap(sender, work), []))
            rates.append((str(count), len(times) / seconds))
            tails.append((str(count), 1e3 * times[int(0.99 * len(times))]))
    row("servers on one PostgreSQL: records over 24 connections", "/s", rates)
    row("servers on one PostgreSQL: p99", "ms", tails)


async def far(source, target, one_way):
    """Hands on what arrives at one socket to the other, `one_way` seconds later each way."""
    loop = asyncio.get_running_loop()

    async def hand_on(reader, writer):
        try:
            while data := await reader.read(1 << 16):
                loop.call_later(one_way, writer.write, data)
        except OSError:
            pass
        loop.call_later(one_way, writer.close)

    async def serve(reader, writer):
        onward = await asyncio.open_unix_connection(target)
        await asyncio.gather(hand_on(reader, onward[1]), hand_on(onward[0], writer))

    async with await asyncio.start_unix_server(serve, source) as server:
        await server.serve_forever()


def with_far_servers(program):
    """Records over 16 connections to each server, and the database a round trip of 10 ms away from all: what a server cannot do faster alone."""
    bin = newest_postgresql()
    if bin is None:
        return print("far servers: postgresql is not installed")
    rates, tails, seconds = [], [], 5 * SECONDS
    with PostgreSQL(bin) as cluster:
        for count in (1, 2, 4):
            folder = f"{cluster.dir}/far{count}"
            os.mkdir(folder)
            sockets = [f"{place}/.s.PGSQL.5432" for place in (folder, cluster.dir)]
            way = multiprocessing.Process(target=lambda: asyncio.run(far(*sockets, 0.005)), daemon=True)
            way.start()
            database = cluster.database(f"far{count}").replace(cluster.dir, folder)
            with contextlib.ExitStack() as running, multiprocessing.Pool(16 * count) as pool:
                services = [running.enter_context(Service(program, database=database)) for _ in range(count)]
                work = [(services[imu % count].port, imu, seconds) for imu in range(16 * count)]
                times = sorted(sum(pool.starmap(sender, work), []))
            way.kill()
            rates.append((str(count), len(times) / seconds))
            tails.append((str(count), 1e3 * times[int(0.99 * len(times))]))
    row("servers 10 ms from one PostgreSQL: records over 16 connections each", "/s", rates)
    row("servers 10 ms from one PostgreSQL: p99", "ms", tails)


# Presets of the simulator, and what is changed in them.
DESIGNS = (("24-bare", {}), ("24-position", {}), ("24-position", {"repeats": 20, "cycles": 3}), ("long", {}))


def with_dwells(program):
    """Simulated campaigns without a hidden cause: the command line's time less that of doing nothing."""
    empty = seconds_of([program, "--version"])
    fits, diagnoses = [], []
    with tempfile.TemporaryDirectory() as folder:
        file, scenario = f"{folder}/campaign.json", f"{folder}/scenario.toml"
        for preset, changed in DESIGNS:
            text = subprocess.run([program, "simulate", "--preset", preset, "--print-scenario"], check=True, capture_output=True, text=True).stdout
            for key, value in changed.items():
                text = "".join(f"{key} = {value}\n" if line.startswith(f"{key} =") else line for line in text.splitlines(True))
            with open(scenario, "w") as written:
                written.write(text)
            subprocess.run([program, "simulate", "--scenario", scenario, "--seed", "5", "--out", file], check=True)
            name = f"{len(json.load(open(file))['dwells'])} dwells"
            fits.append((name, 1e3 * (seconds_of([program, "calibrate", file]) - empty)))
            if preset != "24-bare":  # 24 positions alone leave too little to hold the model against
                diagnoses.append((name, 1e3 * (seconds_of([program, "diagnose", file]) - empty)))
    row("dwells: calibrate", "ms", fits)
    row("dwells: diagnose", "ms", diagnoses)


def seconds_of(command):
    times = []
    for _ in range(5):
        begun = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - begun)
    return median(sorted(times))


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--program", default="target/release/gyrowatch")
    options.add_argument("--values", type=int, default=1_000_000)
    asked = options.parse_args()
    with_dwells(asked.program)
    with_connections(asked.program)
    with_processors(asked.program)
    with_servers(asked.program)
    with_far_servers(asked.program)
    with_gyros(asked.program)
    with_density(asked.program)
    with_history(asked.program, asked.values)


if __name__ == "__main__":
    main()
