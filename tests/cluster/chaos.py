#!/usr/bin/env python3
"""Kills the processes of a service on PostgreSQL and S3 while it works, and checks that nothing is lost.

    tests/cluster/postgres python tests/cluster/chaos.py target/release/contuse --jobs 500 --between-kills 1 --refusal 10
    python tests/cluster/chaos.py target/release/contuse --sqlite --jobs 500 --between-kills 1

An API without workers and some workers share a database and an object store (moto, from PyPI, behind a proxy that can refuse). A random
process is killed (SIGKILL) at intervals and started again; the database is restarted once; the object store refuses for some seconds.
Then every acknowledged job has ended once, with the digest of an undisturbed run, and its recording is whole. With --sqlite one process
has all, and is killed.
"""

import argparse
import collections
import concurrent.futures
import contextlib
import hashlib
import http.client
import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid

from s3 import BUCKET, CREDENTIALS, free_port, object_store

SPEEDS = [-10.0, -11.0, -12.0, -13.0]
ELEMENTS = 10
ENDED = {"succeeded", "failed", "cancelled"}


def scene(speed: float) -> dict:
    """A soft block that hits a wall: a run of some tenths of a second, or less if it has fewer elements."""
    block = {"kind": "block", "min_m": [0, 0, 1e-4], "max_m": [0.01, 0.01, 0.0101], "elements": [ELEMENTS] * 3}
    material = {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e6}
    body = {
        "name": "block",
        "role": "projectile",
        "velocity_m_per_s": [0, 0, speed],
        "mesh": {"generator": block},
        "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": material}],
    }
    wall = {"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}
    return {"name": "small", "end_time_s": 2e-3, "bodies": [body], "planes": [wall], "solver": {"error_bars": "none"}}


class Proxy:
    """Forwards TCP connections, or closes them while it refuses."""

    def __init__(self, target: int):
        self.target, self.refuses, self.open = target, False, set()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self) -> None:
        while True:
            client, _ = self.listener.accept()
            if self.refuses:
                client.close()
                continue
            server = socket.create_connection(("127.0.0.1", self.target))
            self.open |= {client, server}
            for ends in [(client, server), (server, client)]:
                threading.Thread(target=self.copy, args=ends, daemon=True).start()

    def copy(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(1 << 16):
                sink.sendall(piece)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            self.open.discard(end)
            end.close()

    def refuse(self, seconds: float) -> None:
        self.refuses = True
        for end in list(self.open):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        time.sleep(seconds)
        self.refuses = False


class Process:
    """A process of the service, which can be killed and started again."""

    def __init__(self, log: str, environment: dict, *command: str):
        self.log, self.environment, self.command = log, environment, command
        self.start()

    def start(self) -> None:
        with open(self.log, "ab") as log:
            self.child = subprocess.Popen(self.command, env=self.environment, stdout=log, stderr=log)

    def kill(self) -> None:
        self.child.send_signal(signal.SIGKILL)
        self.child.wait()

    def stop(self) -> None:
        while self.child.poll() is not None:
            self.start()
            time.sleep(1)
        self.child.terminate()
        code = self.child.wait(30)
        # One that has just been started may not listen for the signal yet.
        assert code in (0, -signal.SIGTERM), f"{self.command} did not end in order: {code}"


class Client:
    """Calls a service until it answers."""

    def __init__(self, port: int):
        self.port = port

    def once(self, method: str, path: str, body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            connection.request(method, path, body, {k.replace("_", "-"): v for k, v in headers.items()})
            answer = connection.getresponse()
            return answer.status, answer.read()
        finally:
            connection.close()

    def call(self, method: str, path: str, body: bytes | None = None, **headers: str) -> bytes:
        deadline = time.monotonic() + 120
        while True:
            with contextlib.suppress(OSError, http.client.HTTPException):
                status, answer = self.once(method, path, body, **headers)
                if status < 300:
                    return answer
                assert status in (429, 503), f"{method} {path}: {status} {answer!r}"
            assert time.monotonic() < deadline, f"{method} {path} is not answered"
            time.sleep(0.2)

    def submit(self, speed: float, key: str) -> str:
        body = json.dumps(scene(speed)).encode()
        return json.loads(self.call("POST", "/v1/jobs", body, Content_Type="application/json", Idempotency_Key=key))["id"]

    def job(self, job: str) -> dict:
        return json.loads(self.call("GET", f"/v1/jobs/{job}"))

    def wait(self, jobs: list[str], seconds: float) -> None:
        deadline = time.monotonic() + seconds
        for job in jobs:
            while (state := self.job(job)["state"]) not in ENDED:
                assert time.monotonic() < deadline, f"job {job} is still {state}"
                time.sleep(0.2)

    def post_one_key(self) -> str:
        """100 equal posts with one key are one job: its id."""
        key = uuid.uuid4().hex
        with concurrent.futures.ThreadPoolExecutor(20) as pool:
            ids = set(pool.map(lambda _: self.submit(SPEEDS[0], key), range(100)))
        assert len(ids) == 1, f"{len(ids)} jobs of one key"
        return ids.pop()


def undisturbed(program: str, folder: str) -> dict[float, str]:
    """Digests of the recordings of one process with its own folder."""
    port = free_port()
    command = [program, "serve", "--data", f"{folder}/alone", "--listen", f"127.0.0.1:{port}"]
    service, client = Process(f"{folder}/alone.log", dict(os.environ), *command), Client(port)
    try:
        jobs = {speed: client.submit(speed, uuid.uuid4().hex) for speed in SPEEDS}
        client.post_one_key()
        client.wait(list(jobs.values()), 60)
        return {speed: client.job(job)["recording"]["sha256"] for speed, job in jobs.items()}
    finally:
        service.stop()


def database() -> str:
    """Address of a schema of its own."""
    address, name = os.environ["CONTUSE_TEST_POSTGRES"], f"chaos_{uuid.uuid4().hex}"
    subprocess.run(["psql", "-q", address, "-c", f"CREATE SCHEMA {name}"], check=True)
    return f"{address}?options=-csearch_path%3D{name}"


def disturb(arguments, processes: list[Process], proxy: Proxy | None, done: collections.Counter, over: threading.Event) -> None:
    """Kills a process at intervals until the jobs are over; at the third kill a database restarts, at the fifth a store refuses."""
    chance = random.Random(arguments.seed)
    while not over.wait(arguments.between_kills):
        # What ended by itself, since a store did not answer when it started, starts again as under any supervisor.
        for process in {chance.choice(processes), *(other for other in processes if other.child.poll() is not None)}:
            process.kill()
            process.start()
        done["kills"] += 1
        if proxy is None:
            continue
        if done["kills"] == 3:
            subprocess.run(os.environ["CONTUSE_TEST_POSTGRES_RESTART"], shell=True, check=True)
            done["restarts of the database"] += 1
        if done["kills"] == 5:
            threading.Thread(target=refuse, args=(arguments, proxy, done), daemon=True).start()


def refuse(arguments, proxy: Proxy, done: collections.Counter) -> None:
    proxy.refuse(arguments.refusal)
    done["refusals of the store"] += 1


def submit_until(arguments, client: Client, pool: concurrent.futures.Executor, done: collections.Counter) -> dict[str, float]:
    """Jobs with the speeds of their scenes: as many as asked for, and again as many until every fault has been."""
    jobs = {}
    while not jobs or not (arguments.sqlite or done["refusals of the store"]):
        speeds = [SPEEDS[i % len(SPEEDS)] for i in range(arguments.jobs)]
        ids = pool.map(lambda speed: client.submit(speed, uuid.uuid4().hex), speeds)
        batch = dict(zip(ids, speeds, strict=True))
        jobs |= batch
        client.wait(list(batch), arguments.patience)
    return jobs


def check(client: Client, jobs: dict[str, float], digests: dict[float, str]) -> int:
    """Every job ended once, with the digest of its scene, and its recording is whole. The number of attempts beyond the first ones."""
    again = 0
    for job, speed in jobs.items():
        row = client.job(job)
        assert row["state"] == "succeeded", f"{job}: {row['state']} {row['failure']}"
        assert row["recording"]["sha256"] == digests[speed], f"{job}: another digest"
        recording = client.call("GET", f"/v1/jobs/{job}/recording")
        assert hashlib.sha256(recording).hexdigest() == digests[speed], f"{job}: its recording is not whole"
        lines = client.call("GET", f"/v1/jobs/{job}/events").decode().splitlines()
        ends = [line for line in lines if line.removeprefix("event: ") in ENDED]
        assert ends == ["event: succeeded"], f"{job}: ended {len(ends)} times"
        again += row["attempts"] - 1
    return again


def count(client: Client) -> int:
    """Number of jobs of all states, from the metrics."""
    lines = client.call("GET", "/metrics").decode().splitlines()
    return sum(int(float(line.split()[-1])) for line in lines if line.startswith("contuse_jobs{"))


def work_once(processes: list[Process], client: Client, command: list[str], environment: dict) -> None:
    """One process a job, as a scheduler starts it: its exit code says what happened."""
    for process in processes:
        process.stop()
    job = client.submit(SPEEDS[0], uuid.uuid4().hex)
    codes = [subprocess.run([*command, "--once"], env=environment, stdout=subprocess.DEVNULL).returncode for _ in range(2)]
    assert codes == [0, 7], f"exit codes {codes}"
    assert client.job(job)["state"] == "succeeded"


def main() -> None:
    global ELEMENTS
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--jobs", type=int, default=40)
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--between-kills", type=float, default=1.5, help="seconds")
    parser.add_argument("--refusal", type=float, default=4, help="seconds")
    parser.add_argument("--patience", type=float, default=120, help="seconds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--elements", type=int, default=ELEMENTS, help="along each edge of the block")
    parser.add_argument("--sqlite", action="store_true", help="one process with its own folder, and no other server")
    arguments = parser.parse_args()
    ELEMENTS = arguments.elements
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as servers:
        proxy = None if arguments.sqlite else Proxy(servers.enter_context(object_store()))
        digests = undisturbed(arguments.program, folder)
        port = free_port()
        environment = os.environ | {"CONTUSE_MAX_ATTEMPTS": "100"}
        if proxy:
            environment |= CREDENTIALS | {
                "CONTUSE_DATABASE": database(),
                "CONTUSE_BLOBS": f"s3://{BUCKET}/runs",
                "CONTUSE_LEASE_S": "2",
                "AWS_ENDPOINT_URL": f"http://127.0.0.1:{proxy.port}",
            }
        own_workers, other_workers = ("0", arguments.workers) if proxy else (str(arguments.workers), 0)
        serve = [arguments.program, "serve", "--workers", own_workers, "--data", f"{folder}/api", "--listen", f"127.0.0.1:{port}"]
        worker = [arguments.program, "worker", "--workers", "1", "--data"]
        api, client = Process(f"{folder}/api.log", environment, *serve), Client(port)
        workers = [Process(f"{folder}/{i}.log", environment, *worker, f"{folder}/{i}") for i in range(other_workers)]
        try:
            begun, over, done = time.monotonic(), threading.Event(), collections.Counter()
            with concurrent.futures.ThreadPoolExecutor(5) as pool:
                disturbed = pool.submit(disturb, arguments, [api, *workers], proxy, done, over)
                try:
                    jobs = submit_until(arguments, client, pool, done)
                finally:
                    over.set()
            disturbed.result()
            seconds = time.monotonic() - begun
            again = check(client, jobs, digests)
            assert len(jobs) == count(client), f"{len(jobs)} jobs acknowledged, {count(client)} kept"
            client.wait([client.post_one_key()], arguments.patience)
            if proxy:
                assert done["restarts of the database"] == done["refusals of the store"] == 1
                work_once(workers, client, [*worker, f"{folder}/once"], environment)
            faults = ", ".join(f"{n} {what}" for what, n in done.items())
            print(f"{len(jobs)} jobs in {seconds:.0f} s, {again} attempts again; {faults}: all ended once, all recordings whole")
        except BaseException:
            for name in sorted(os.listdir(folder)):
                if name.endswith(".log"):
                    with open(f"{folder}/{name}", errors="replace") as log:
                        print(f"--- {name}\n{''.join(log.readlines()[-40:])}", file=sys.stderr)
            raise
        finally:
            for process in [api, *workers]:
                process.kill()


if __name__ == "__main__":
    main()
