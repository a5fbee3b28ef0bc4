#!/usr/bin/env python3
"""Runs a command with an S3 server of its own on loopback, in memory (moto, from PyPI), which goes with it:

    tests/cluster/s3.py cargo test --features cluster --test cluster -- s3

The command finds the bucket in CONTUSE_TEST_BLOBS, endpoint and credentials in AWS_*.
"""

import contextlib
import http.client
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator

CREDENTIALS = {"AWS_ACCESS_KEY_ID": "tests", "AWS_SECRET_ACCESS_KEY": "tests", "AWS_REGION": "us-east-1"}
BUCKET = "contuse"


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


@contextlib.contextmanager
def object_store() -> Iterator[int]:
    """Port of a server with a bucket."""
    port = free_port()
    command = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(300):
            with contextlib.suppress(OSError):
                connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
                connection.request("PUT", f"/{BUCKET}")
                assert connection.getresponse().status == 200
                break
            time.sleep(0.1)
        else:
            raise SystemExit("the S3 server does not answer: pip install -r tests/cluster/requirements.txt")
        yield port
    finally:
        server.kill()
        server.wait()


if __name__ == "__main__":
    with object_store() as port:
        address = {"CONTUSE_TEST_BLOBS": f"s3://{BUCKET}/tests", "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}"}
        sys.exit(subprocess.run(sys.argv[1:], env=os.environ | CREDENTIALS | address).returncode)
