#!/usr/bin/env python3
"""Frames a second of the page of `rrf view`, in headless Chromium, and where their time goes.

    .venv/bin/python tests/page_rate.py RUN [--light x,y,z,r,g,b] [--size 512] [--frames 60]

The camera turns after each frame, as under a hand that drags without a pause. A frame's time ends when its pixels
are in the canvas. Medians over the frames, in milliseconds:

    frame     from one frame shown to the next
    render    the picture in linear radiance
    encode    sRGB bytes of it
    transfer  the question, the answer's way through the socket and the browser's queues
    show      bytes into the canvas, the line of figures, the handles of the lights

`processor` is time of all threads a frame, of the program and of the browser: it holds on a busy machine too.

The browser is driven through its debugging pipe with nothing but evaluation. Test frameworks also have it report every
message of a socket, which costs more than all of the page.
"""

import argparse
import contextlib
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "python"))
from viewer import served  # noqa: E402

# turns the camera after each frame; a row for each frame: when it was shown, how long showing took, its facts
TURN = """([frames, warm]) => new Promise((resolve) => {
    const rows = [], before = show, after = answered;
    let began = 0, direction = 0.01;
    show = (...all) => { began = performance.now(); before(...all); };
    answered = () => {
        const now = performance.now();
        rows.push([now, now - began, facts.render_ms, facts.frame_ms]);
        if (rows.length === frames + warm) {
            [show, answered] = [before, after];
            resolve(rows.slice(warm));
        } else {
            // there and back, so that the view stays what the run was baked for
            if (rows.length % 20 === 0) direction = -direction;
            orbit(direction, 0);
        }
        after();
    };
    orbit(direction, 0);
})"""
WARM = 5


def seconds_of(pids):
    """Processor seconds of processes so far."""
    ticks = 0
    for pid in pids:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def family(of):
    """A process and its descendants."""
    parents = {}
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parents[int(folder.name)] = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue  # ended meanwhile
    found = {of}
    while more := {pid for pid, parent in parents.items() if parent in found} - found:
        found |= more
    return found


def named(pids, name):
    return [pid for pid in pids if pathlib.Path(f"/proc/{pid}/comm").read_text().strip().startswith(name)]


class Browser:
    """A headless browser with one page, driven by the DevTools protocol over a pair of pipes."""

    def __init__(self, folder):
        (theirs_in, self.to), (self.back, theirs_out) = os.pipe(), os.pipe()
        # the protocol's descriptors are 3 and 4; they are set past those that the pipes may have
        words = [os.environ.get("RRF_CHROMIUM") or shutil.which("chromium"), "--headless", "--no-sandbox", "--disable-gpu"]
        words += ["--disable-dev-shm-usage", "--no-first-run", f"--user-data-dir={folder}", "--remote-debugging-pipe"]
        moved = ["sh", "-c", f'exec 8<&{theirs_in} 9>&{theirs_out} 3<&8 4>&9 8<&- 9>&-; exec "$@"', "sh"]
        self.process = subprocess.Popen([*moved, *words], pass_fds=[theirs_in, theirs_out], stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.rest, self.number, self.session = b"", 0, {}

    def call(self, method, **parameters):
        answer = self.answer(method, **parameters)
        if "error" in answer:
            raise SystemExit(f"{method}: {answer['error']}")
        return answer["result"]

    def answer(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters} | self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.rest:
                more = os.read(self.back, 1 << 16)
                if not more:
                    raise SystemExit(f"the browser ended in {method}")
                self.rest += more
            line, _, self.rest = self.rest.partition(b"\0")
            answer = json.loads(line)
            if answer.get("id") == self.number:
                return answer

    def open(self, url):
        target = self.call("Target.createTarget", url=url)["targetId"]
        self.session = {"sessionId": self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}

    def window(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def evaluate(self, expression):
        found = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in found:
            raise SystemExit(f"{expression}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def until(self, condition, seconds=120):
        end = time.monotonic() + seconds
        # at first the page is a blank one, which goes while it is asked: no answer then
        while not self.answer("Runtime.evaluate", expression=condition).get("result", {}).get("result", {}).get("value"):
            if time.monotonic() > end:
                raise SystemExit(f"not within {seconds} s: {condition}")
            time.sleep(0.05)


@contextlib.contextmanager
def browsing(url):
    """A page in a browser of its own, which is ended."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(folder)
        try:
            browser.open(url)
            yield browser
        finally:
            browser.process.terminate()
            browser.process.wait()


def measure(options):
    """A row for each frame, processor seconds of program and browser, and the picture's size."""
    light = ["--light", options.light] if options.light else []
    with served(options.run, *light) as url, browsing(url) as page:
        page.until("document.readyState === 'complete' && document.body?.dataset.frames")
        # a square picture beside the controls
        page.window(1100, 700)
        wide, high = page.evaluate("[$('picture').clientWidth, $('picture').clientHeight]")
        page.window(1100 - wide + high, 700)
        page.evaluate("$('refine').checked && $('refine').click(); 0")
        page.evaluate(f"$('size').value = '{options.size}'; $('size').dispatchEvent(new Event('change')); 0")
        page.until(f"!asked && !again && Math.min(...facts.size) === {options.size}")
        mine = family(os.getpid())
        groups = {"program": named(mine, "rrf"), "browser": named(mine, "chrom")}
        before = {name: seconds_of(pids) for name, pids in groups.items()}
        rows = page.evaluate(f"({TURN})([{options.frames}, {WARM}])")
        spent = {name: seconds_of(pids) - before[name] for name, pids in groups.items()}
        return rows, spent, page.evaluate("facts.size")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--light", help="a point light in place of the scene's own lights")
    parser.add_argument("--size", default="512", help="as in the page's list of sizes")
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    rows, spent, size = measure(options)
    median = statistics.median
    gaps = [after[0] - row[0] for row, after in zip(rows, rows[1:])]
    frame, render = median(gaps), median(row[2] for row in rows)
    encode, show = median(row[3] - row[2] for row in rows), median(row[1] for row in rows)
    transfer = median(gap - after[1] - after[3] for gap, after in zip(gaps, rows[1:]))
    print(f"{size[0]} x {size[1]}: {1e3 / frame:.1f} frames a second")
    print(f"frame {frame:.1f}, render {render:.1f}, encode {encode:.2f}, transfer {transfer:.1f}, show {show:.2f} ms")
    each = {name: 1e3 * seconds / (options.frames + WARM) for name, seconds in spent.items()}
    print(f"processor {each['program']:.1f} ms a frame in the program, {each['browser']:.1f} in the browser")


if __name__ == "__main__":
    main()
