"""A page of `rrf view` in a headless browser, as the tests of `test_view*.py` drive it."""

import contextlib
import os
import pathlib
import re
import shlex
import signal
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
RRF = os.environ.get("RRF", str(ROOT / "target/release/rrf"))
LIGHT_BOX = "-0.6,1.3,-0.6,0.6,1.8,0.6"
# sums of a 16x16 grid of the picture's pixels: enough to tell two frames apart
DIGEST = """() => {
    const canvas = document.getElementById("frame");
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let [sum, hash] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
        sum += data[i] + data[i + 1] + data[i + 2];
        hash = (Math.imul(hash, 31) + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) | 0;
    }
    return { sum, hash, size: [canvas.width, canvas.height] };
}"""

# the largest difference of a PNG's channels from the shown picture's, and the share of those that differ
DIFFERENCE = """async (bytes) => {
    const blob = new Blob([new Uint8Array(bytes)], { type: "image/png" });
    const image = await createImageBitmap(blob, { colorSpaceConversion: "none" });
    const canvas = new OffscreenCanvas(image.width, image.height);
    canvas.getContext("2d").drawImage(image, 0, 0);
    const read = (c) => c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
    const [a, b] = [read(canvas), read(document.getElementById("frame"))];
    if (a.length !== b.length) return [255, 1];
    let [most, many] = [0, 0];
    for (let i = 0; i < a.length; i++) {
        const d = Math.abs(a[i] - b[i]);
        most = Math.max(most, d);
        many += d > 0;
    }
    return [most, many / a.length];
}"""


def bake(scene, run, *more):
    """The smallest bake of nets, or a bake of other settings."""
    size = ["--method", "nets", "--rows", "2000", "--cells", "2", "--paths", "4", "--rounds", "2", f"--light-box={LIGHT_BOX}"]
    command = [RRF, "bake", "-q", scene, "-o", run, *(more or size)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return str(run)


@contextlib.contextmanager
def served(run, *more):
    """The URL of a running `rrf view`; SIGINT ends it well."""
    process = subprocess.Popen([RRF, "view", run, *more], stdout=subprocess.PIPE, text=True)
    yield process.stdout.readline().strip()
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 0


class Viewer:
    """A page, everything that it logged and asked for."""

    def __init__(self, browser, url, width=1100, height=700, refine=False, **more):
        self.page = browser.new_page(viewport={"width": width, "height": height}, **more)
        self.logged, self.requests, self.failed = [], [], []
        self.page.on("console", self.log)
        self.page.on("pageerror", lambda e: self.failed.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.on("websocket", lambda w: self.requests.append(w.url))
        self.page.goto(url)
        self.until("document.body.dataset.frames")
        if not refine:
            # pictures are those of the moving size, whenever they are read
            self.page.evaluate("$('refine').click()")
            self.until("!asked && !again && facts.aa === 1 && Math.min(...facts.size) === 512")

    def log(self, message):
        # said of this test's own reading of pictures
        if "willReadFrequently" not in message.text:
            self.logged.append(f"{message.type}: {message.text}")

    def frames(self):
        return int(self.page.evaluate("document.body.dataset.frames || 0"))

    def until(self, condition, seconds=60):
        """Waits for a JavaScript expression. (Playwright's own wait would have the page
        evaluate a string, which its policy forbids.)"""
        end = time.monotonic() + seconds
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"not within {seconds} s: {condition}; {self.logged}"
            time.sleep(0.02)

    def shown(self, count):
        """Until `count` frames have been shown in all, and no question of a movement waits."""
        self.until(f"Number(document.body.dataset.frames || 0) >= {count} && !(asked && detail === MOVING) && !again")

    def wait_paths(self, paths):
        """Until the traced picture has so many paths a pixel."""
        self.until(f"Number(document.body.dataset.paths || 0) >= {paths}", 60 + 20 * paths)

    def digest(self):
        return self.page.evaluate(DIGEST)

    def change(self, act):
        """The picture before and after."""
        before, frames = self.digest(), self.frames()
        act()
        # counted from before the act: its frame may be there already
        self.shown(frames + 1)
        return before, self.digest()

    def command_makes_it(self, folder):
        """Runs the command that the page tells in a folder: its PNG has the bytes of the page's picture."""
        command = self.page.text_content("#command").replace("\\\n", " ")
        words = shlex.split(command)
        assert words[0] == "rrf"
        subprocess.run([RRF, *words[1:]], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        difference = self.page.evaluate(DIFFERENCE, list((folder / "view.png").read_bytes()))
        assert difference == [0, 0], (difference, command)
        return words

    def place(self, position):
        """Where a position, as a JavaScript expression, is on the page."""
        return self.page.evaluate(
            f"""() => {{
                const box = document.getElementById("frame").getBoundingClientRect();
                const [x, y] = project({position}, [box.width, box.height]);
                return [box.left + x, box.top + y];
            }}"""
        )

    def light(self):
        """Where the first light's handle is on the page."""
        return self.place("lights[0].position")

    def drag(self, start, by, button="left"):
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down(button=button)
        mouse.move(start[0] + by[0], start[1] + by[1], steps=4)
        mouse.up(button=button)

    def clean(self, url):
        """Nothing was logged, nothing asked of anyone else."""
        assert self.failed == []
        assert self.logged == []
        host = re.match(r"http://([^/]+)/", url)[1]
        assert self.requests
        for request in self.requests:
            own = (f"http://{host}/", f"ws://{host}/", "data:")
            assert request.startswith(own), request
