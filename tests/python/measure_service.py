#!/usr/bin/env python3
"""Measures a service that is started for it: latency of a durable 202, small jobs per second, memory and processor time.

    measure_service.py target/release/contuse --clients 16 --jobs 400
"""

import argparse
import http.client
import json
import os
import re
import resource
import signal
import subprocess
import tempfile
import threading
import time

# A soft block of 64 elements that hits a wall: some 10 ms a run.
SCENE = {
    "name": "small",
    "end_time_s": 4e-4,
    "bodies": [
        {
            "name": "block",
            "role": "projectile",
            "velocity_m_per_s": [0, 0, -10],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 1e-4], "max_m": [0.01, 0.01, 0.0101], "elements": [4, 4, 4]}},
            "parts": [
                {
                    "part": "block",
                    "density_kg_per_m3": 1000,
                    "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e6},
                }
            ],
        }
    ],
    "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
    "solver": {"error_bars": "none"},
}

# The same, hardly moving: it runs for minutes.
LONG = {**SCENE, "end_time_s": 10.0, "bodies": [{**SCENE["bodies"][0], "velocity_m_per_s": [0, 0, -1e-4]}]}


def percentiles(times: list[float]) -> str:
    times = sorted(times)
    at = {share: times[min(len(times) - 1, int(share * len(times)))] for share in (0.5, 0.9, 0.99)}
    return ", ".join(f"p{share * 100:.0f} {1e3 * value:.1f} ms" for share, value in at.items())


def fsyncs(folder: str, count: int = 200) -> list[float]:
    """Time of writing and syncing a page of 4 kB, as SQLite does for each commit."""
    times = []
    with open(os.path.join(folder, "fsync"), "wb", buffering=0) as file:
        for _ in range(count):
            file.write(bytes(4096))
            begun = time.perf_counter()
            os.fsync(file.fileno())
            times.append(time.perf_counter() - begun)
    return times


def submit(address: str, count: int, latencies: list[float], scene: dict = SCENE) -> None:
    connection = http.client.HTTPConnection(address)
    body = json.dumps(scene)
    for _ in range(count):
        begun = time.perf_counter()
        connection.request("POST", "/v1/jobs", body, {"content-type": "application/json"})
        answer = connection.getresponse()
        answer.read()
        if answer.status != 202:
            raise SystemExit(f"answered {answer.status}")
        latencies.append(time.perf_counter() - begun)


def ended(address: str) -> int:
    connection = http.client.HTTPConnection(address)
    connection.request("GET", "/metrics")
    text = connection.getresponse().read().decode()
    connection.close()
    counts = re.findall(r'contuse_jobs_ended_total\{state="(\w+)"\} (\d+)', text)
    if any(int(count) for state, count in counts if state != "succeeded"):
        raise SystemExit(f"not all succeeded: {counts}")
    return sum(int(count) for _, count in counts)


def post(address: str, clients: int, jobs: int) -> list[float]:
    latencies: list[float] = []
    threads = [threading.Thread(target=submit, args=(address, jobs // clients, latencies)) for _ in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return latencies


def processor_s() -> float:
    """Processor time of the services that have ended, and of their runs."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class Service:
    """`contuse serve` on a data folder of its own."""

    def __init__(self, program: str, data: str, workers: int) -> None:
        serve = [program, "serve", "--listen", "127.0.0.1:0", "--data", data, "--workers", str(workers)]
        serve += ["--max-queued", "100000", "--grace-s", "0"]
        environment = {**os.environ, "RUST_LOG": "error"}
        self.process = subprocess.Popen(serve, stdout=subprocess.PIPE, env=environment)
        self.address = self.process.stdout.readline().decode().strip().removeprefix("listening on http://")

    def __enter__(self) -> "Service":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()

    def stop_runs(self) -> None:
        """Stops the processes of the runs once there is one."""
        runs: list[str] = []
        while not runs:
            time.sleep(0.1)
            ps = subprocess.run(["ps", "--ppid", str(self.process.pid), "-o", "pid="], stdout=subprocess.PIPE, text=True, check=False)
            runs = ps.stdout.split()
        for run in runs:
            os.kill(int(run), signal.SIGSTOP)

    def peak_mb(self) -> float:
        with open(f"/proc/{self.process.pid}/status", encoding="utf-8") as status:
            return int(re.search(r"VmHWM:\s+(\d+) kB", status.read()).group(1)) / 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--clients", type=int, default=16)
    parser.add_argument("--jobs", type=int, default=400)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=".") as folder:
        with Service(arguments.program, os.path.join(folder, "idle"), 1) as service:
            # The only worker has a long job, whose process stands still: the others wait, and only their submission takes time.
            submit(service.address, 1, [], LONG)
            service.stop_runs()
            latencies = post(service.address, arguments.clients, arguments.jobs)
            if ended(service.address):
                raise SystemExit("a run was not held")
            print(f"202 at {arguments.clients} clients, nothing else running: {percentiles(latencies)}")
        print(f"fsync of 4 kB on the same disk: {percentiles(fsyncs(folder))}")
        before = processor_s()
        with Service(arguments.program, os.path.join(folder, "busy"), arguments.workers) as service:
            begun = time.perf_counter()
            latencies = post(service.address, arguments.clients, arguments.jobs)
            while (count := ended(service.address)) < len(latencies):
                time.sleep(0.02)
            took = time.perf_counter() - begun
            print(f"202 at {arguments.clients} clients, beside their runs: {percentiles(latencies)}")
            print(f"{count} small jobs end to end: {took:.2f} s, {count / took:.1f} jobs/s with {arguments.workers} worker(s)")
            print(f"peak memory of the service: {service.peak_mb():.0f} MB")
        print(f"processor time of service and runs: {1e3 * (processor_s() - before) / count:.1f} ms a job")


if __name__ == "__main__":
    main()
