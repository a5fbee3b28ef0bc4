"""The nginx example of docs/operations.md for single sign-on, in front of a service that runs: CONTUSE=target/release/contuse.

nginx is real, and its configuration that of the documentation, but for ports, certificates and tokens. Who is signed in is said by a
cookie to a stand-in for oauth2-proxy, which answers as that does: 202 with the address of the user, or 401.
"""

import http.client
import http.server
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CONTUSE = os.environ.get("CONTUSE", ROOT / "target/release/contuse")
HOST = "impacts.example"


class SignIn(http.server.BaseHTTPRequestHandler):
    """What oauth2-proxy answers to `auth_request`, and its page."""

    def do_GET(self):
        user = re.search(r"user=([\w.@]+)", self.headers.get("Cookie", ""))
        if self.path != "/oauth2/auth":
            return self.answer(200, b"sign in")
        if not user:
            return self.answer(401, b"")
        return self.answer(202, b"", {"X-Auth-Request-Email": user[1]})

    def answer(self, status, body, headers=()):
        self.send_response(status)
        for name, value in {**dict(headers), "Content-Length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def token(name, *flags):
    """A new token, and its line for the file."""
    printed = subprocess.run([CONTUSE, "token", name, *flags], capture_output=True, text=True, check=True).stdout
    secret, line = (words.split(": ", 1)[1].strip() for words in printed.splitlines()[:2])
    return secret, line


def configuration(port, sign_in, service, tokens, folder):
    """The example, for these ports and tokens."""
    section = (ROOT / "docs/operations.md").read_text().split("### Single sign-on", 1)[1]
    text = re.search(r"```nginx\n(.*?)```", section, re.S)[1]
    replaced = {
        "listen 443 ssl;": f"listen 127.0.0.1:{port};",
        "http://127.0.0.1:4180": f"http://127.0.0.1:{sign_in}",
        "http://127.0.0.1:8080": f"http://{service}",
        '"the token that `contuse token anna` printed"': f'"{tokens[0]}"',
        '"the token that `contuse token bert --scope read` printed"': f'"{tokens[1]}"',
    }
    for old, new in replaced.items():
        assert old in text, f"{old} is not in the example"
        text = text.replace(old, new)
    paths = "".join(f"{kind}_temp_path {folder}/{kind};" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    return f"pid {folder}/pid; error_log stderr; events {{}} http {{ access_log off; {paths}\n{text}}}"


def check(port):
    scene = (ROOT / "tests/recording/small_ball_on_block.json").read_bytes()

    def ask(method, path, user=None, body=None, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        cookie = {"Cookie": f"user={user}@hospital.example"} if user else {}
        connection.request(method, path, body, {"Host": HOST, "Content-Type": "application/json", **cookie, **headers})
        answer = connection.getresponse()
        return answer.status, answer.read()

    def jobs(user, **headers):
        status, body = ask("GET", "/v1/jobs", user, **headers)
        assert status == 200, (user, status, body)
        return len(json.loads(body)["jobs"])

    assert ask("GET", "/v1/jobs") == (200, b"sign in"), "whoever is not signed in is asked to"
    status, body = ask("POST", "/v1/jobs", "anna", scene, Origin=f"https://{HOST}")
    assert status == 202, body
    assert (jobs("anna"), jobs("bert")) == (1, 0), "each sees what is their own"
    assert ask("POST", "/v1/jobs", "bert", scene)[0] == 403, "the token of bert reads only"
    assert ask("GET", "/v1/jobs", "carl")[0] == 401, "carl has no token"
    assert jobs("anna", Authorization="Bearer of-someone-else-entirely") == 1, "the header of a client is replaced"
    assert ask("POST", "/v1/jobs", "anna", scene, Origin="https://evil.example")[0] == 403, "pages of other origins change nothing"


def main():
    # Before a service is started, which would outlive this.
    assert shutil.which("nginx"), "nginx is not on the path"
    anna, bert = token("anna"), token("bert", "--scope", "read")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tokens").write_text(f"{anna[1]}\n{bert[1]}\n")
        flags = ["--listen", "127.0.0.1:0", "--data", f"{folder}/data", "--tokens-file", f"{folder}/tokens"]
        service = subprocess.Popen([CONTUSE, "serve", *flags], stdout=subprocess.PIPE, text=True)
        sign_in = http.server.ThreadingHTTPServer(("127.0.0.1", 0), SignIn)
        threading.Thread(target=sign_in.serve_forever, daemon=True).start()
        address, port = service.stdout.readline().split("http://")[1].strip(), free_port()
        written = Path(folder) / "nginx.conf"
        written.write_text(configuration(port, sign_in.server_port, address, (anna[0], bert[0]), folder))
        nginx = subprocess.Popen(["nginx", "-p", folder, "-c", written, "-e", "stderr", "-g", "daemon off;"])
        try:
            for _ in range(100):
                with socket.socket() as s:
                    if s.connect_ex(("127.0.0.1", port)) == 0:
                        break
                assert nginx.poll() is None, "nginx ended"
                time.sleep(0.05)
            check(port)
        finally:
            for process in (nginx, service):
                process.terminate()
                process.wait(timeout=30)
    print("the example for single sign-on works")


if __name__ == "__main__":
    sys.exit(main())
