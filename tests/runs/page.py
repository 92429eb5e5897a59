#!/usr/bin/env python3
"""The page under load: few file descriptors, many connections, slow ones among them.

    python3 tests/runs/page.py
"""

import base64
import contextlib
import json
import os
import resource
import signal
import socket
import struct
import subprocess
import tempfile
import time
from pathlib import Path

import runs

# a viewer waits no longer than this for the page
PATIENCE = 2.0


def main():
    passed = 0
    with tempfile.TemporaryDirectory(prefix="rrf-page-") as folder:
        run = Path(folder) / "run"
        runs.call(*runs.bake(run))
        for name, check in CHECKS:
            print(f"{name}: {check(run)}")
            passed += 1
    print(f"{passed} passed, 0 failed")


@contextlib.contextmanager
def served(run, files=None):
    """A page of a run: its process, address and token; at most `files` descriptors."""
    limit = (lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))) if files else None
    process = subprocess.Popen(
        [str(runs.program()), "view", str(run)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=limit,
    )
    try:
        url = process.stdout.readline().strip()
        address, token = url.removeprefix("http://").split("/?token=")
        host, port = address.split(":")
        yield process, (host, int(port)), token
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()


class WebSocket:
    """The little of RFC 6455 that a question and its answer need."""

    def __init__(self, address, token, path):
        self.stream = socket.create_connection(address, timeout=60)
        host = f"{address[0]}:{address[1]}"
        key = base64.b64encode(os.urandom(16)).decode()
        self.stream.sendall(
            f"GET {path}?token={token} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n"
            f"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self.exactly(1)
        if b" 101 " not in head:
            raise SystemExit(f"no WebSocket: {head}")

    def exactly(self, count):
        data = b""
        while len(data) < count:
            more = self.stream.recv(count - len(data))
            if not more:
                raise ConnectionError("the server closed the connection")
            data += more
        return data

    def send(self, value):
        data, mask = json.dumps(value).encode(), os.urandom(4)
        length = struct.pack("!BH", 0x80 | 126, len(data))
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))
        self.stream.sendall(b"\x81" + length + mask + masked)

    def message(self):
        _, length = self.exactly(2)
        if length == 126:
            (length,) = struct.unpack("!H", self.exactly(2))
        elif length == 127:
            (length,) = struct.unpack("!Q", self.exactly(8))
        return self.exactly(length)

    def text(self):
        return json.loads(self.message())


def question(hello, size):
    """The page's first question, in another size."""
    return {"fov": hello["fov"], "id": 1, "size": size, "lights": hello["lights"]}


def frame(address, token):
    """Seconds until a viewer has seen its page and a frame."""
    start = time.monotonic()
    get(address, token)
    frames = WebSocket(address, token, "/frames")
    frames.send(question(frames.text()["hello"], size=[64, 64]))
    facts = frames.text()
    if "error" in facts or len(frames.message()) < 64 * 64 * 3:
        raise SystemExit(f"no frame: {facts}")
    return time.monotonic() - start


def get(address, token):
    with socket.create_connection(address, timeout=10) as stream:
        stream.sendall(f"GET /?token={token} HTTP/1.1\r\nHost: {address[0]}:{address[1]}\r\n\r\n".encode())
        answer = b""
        while more := stream.recv(1 << 16):
            answer += more
    if not answer.startswith(b"HTTP/1.1 200"):
        raise SystemExit(f"no page: {answer[:200]}")


def few_files(run):
    """60 connections of nobody under `ulimit -n 40`, and viewers in all other places."""
    with served(run, files=40) as (process, address, token):
        idle = [socket.create_connection(address, timeout=10) for _ in range(60)]
        time.sleep(0.5)
        waited = frame(address, token)
        viewers = []
        with contextlib.suppress(OSError, ConnectionError, SystemExit):
            while len(viewers) < 40:
                viewer = WebSocket.__new__(WebSocket)
                viewer.stream = socket.create_connection(address, timeout=1)
                viewers.append(viewer)
                viewer.__init__(address, token, "/frames")
        time.sleep(0.5)
        if process.poll() is not None:
            raise SystemExit(f"the server ended: {process.stderr.read()}")
        for viewer in viewers:
            viewer.stream.close()
        for stream in idle:
            stream.close()
        time.sleep(0.5)
        again = frame(address, token)
        end(process)
    if max(waited, again) > PATIENCE:
        raise SystemExit(f"a viewer waits {max(waited, again):.1f} s")
    return f"a frame after {waited:.2f} s, after the load {again:.2f} s"


def slow_connections(run):
    """100 connections that send a byte now and then, opened anew when they are closed."""
    with served(run) as (process, address, token):
        slow = [socket.create_connection(address, timeout=10) for _ in range(100)]
        waited = []
        for round_ in range(5):
            for k, stream in enumerate(slow):
                try:
                    stream.sendall(b"GET / HTTP/1.1\r\n"[round_ : round_ + 1])
                except OSError:
                    stream.close()
                    slow[k] = socket.create_connection(address, timeout=10)
            waited.append(frame(address, token))
            time.sleep(0.3)
        end(process)
    if max(waited) > PATIENCE:
        raise SystemExit(f"a viewer waits {max(waited):.1f} s")
    return f"frames after at most {max(waited):.2f} s"


def end(process):
    """The first SIGTERM ends the server, cleanly."""
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=5)
    if process.returncode != 0:
        raise SystemExit(f"exit code {process.returncode}: {errors}")


CHECKS = [("40 file descriptors, 60 connections", few_files), ("100 slow connections", slow_connections)]


if __name__ == "__main__":
    main()
