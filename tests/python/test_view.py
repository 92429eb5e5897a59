"""`rrf view` in a headless browser: what a person sees and does, and who is kept out.

The browser is Debian's chromium (tests/setup.sh). Without RRF_CHROMIUM the tests look for
`chromium` on the path.
"""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time
import urllib.error
import urllib.request

import pytest
from playwright.sync_api import sync_playwright

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


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    """The Cornell box with the smallest bake, or the run that RRF_RUN names."""
    if run := os.environ.get("RRF_RUN"):
        return run
    run = tmp_path_factory.mktemp("view") / "run"
    scene = ROOT / "scenes/cornell-box/scene.pbrt"
    size = ["--rows", "2000", "--cells", "2", "--paths", "4", "--rounds", "2"]
    subprocess.run(
        [RRF, "bake", "-q", scene, "-o", run, f"--light-box={LIGHT_BOX}", *size],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return str(run)


@pytest.fixture
def server(baked):
    """A running `rrf view`; gives its URL, and checks that SIGINT ends it well."""
    process = subprocess.Popen([RRF, "view", baked], stdout=subprocess.PIPE, text=True)
    yield process.stdout.readline().strip()
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 0


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    """The Cornell box with a point and a spot of its own beside its lamp, with the smallest bake."""
    folder = tmp_path_factory.mktemp("lit")
    shutil.copytree(ROOT / "scenes/cornell-box", folder / "scene")
    scene = folder / "scene/scene.pbrt"
    lights = '''WorldBegin
    LightSource "point" "rgb I" [ 0.5 0.4 0.3 ] "point from" [ 0.3 1.2 0.4 ]
    LightSource "spot" "rgb I" [ 2 2 2 ] "point from" [ -0.4 1.5 0.3 ] "point to" [ -0.2 0 0 ]
        "float coneangle" [ 25 ] "float conedeltaangle" [ 8 ]
'''
    scene.write_text(scene.read_text().replace("WorldBegin", lights, 1))
    size = ["--rows", "2000", "--cells", "2", "--paths", "4", "--rounds", "2"]
    subprocess.run(
        [RRF, "bake", "-q", scene, "-o", folder / "run", f"--light-box={LIGHT_BOX}", *size],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return str(folder / "run")


@pytest.fixture
def lit_server(lit):
    """A page on that run, its own lights on, and a sun that comes in at the open front."""
    arguments = [RRF, "view", lit, "--scene-lights", "--sun=180,30,0.5,0.5,0.4"]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
    yield process.stdout.readline().strip()
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 0


@pytest.fixture
def lit_viewer(browser, lit_server):
    viewer = Viewer(browser, lit_server, height=1000)
    viewer.change(lambda: viewer.page.evaluate("setExposure(0)"))
    yield viewer
    viewer.clean(lit_server)
    viewer.page.close()


@pytest.fixture(scope="module")
def browser():
    chromium = os.environ.get("RRF_CHROMIUM") or shutil.which("chromium")
    assert chromium, "no chromium: run tests/setup.sh"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            # CI runs as root, where Chromium's sandbox does not start
            args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
        )
        yield browser
        browser.close()


class Viewer:
    """A page, everything that it logged and asked for."""

    def __init__(self, browser, url, width=1100, height=700):
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.logged, self.requests, self.failed = [], [], []
        self.page.on("console", self.log)
        self.page.on("pageerror", lambda e: self.failed.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.on("websocket", lambda w: self.requests.append(w.url))
        self.page.goto(url)
        self.shown(1)

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
        """Until `count` frames have been shown in all, and no question waits."""
        self.until(f"Number(document.body.dataset.frames || 0) >= {count} && !asked && !again")

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

    def light(self):
        """Where the first light's handle is on the page."""
        return self.page.evaluate(
            """() => {
                const box = document.getElementById("frame").getBoundingClientRect();
                const [x, y] = project(lights[0].position, [box.width, box.height]);
                return [box.left + x, box.top + y];
            }"""
        )

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


@pytest.fixture
def viewer(browser, server):
    viewer = Viewer(browser, server)
    yield viewer
    viewer.clean(server)
    viewer.page.close()


def test_shows_a_frame(viewer):
    picture = viewer.digest()
    width, height = picture["size"]
    assert min(width, height) == 512
    # neither black nor white: between 5 and 95 % of full brightness on average
    assert 0.05 < picture["sum"] / (3 * 255 * width * height) < 0.95
    assert re.match(r"\d+ fps, [\d.]+ ms, \d+×512|512×\d+", viewer.page.text_content("#speed"))


def test_light_drags_and_the_picture_follows(viewer):
    position = viewer.page.evaluate("lights[0].position")
    before, after = viewer.change(lambda: viewer.drag(viewer.light(), (80, 40)))
    moved = viewer.page.evaluate("lights[0].position")
    assert before["hash"] != after["hash"]
    assert position != moved
    # in the picture's plane: not along the view
    along = viewer.page.evaluate("([a, b]) => dot(sub(b, a), camera.forward)", [position, moved])
    assert abs(along) < 1e-6
    # with Shift only up and down
    viewer.page.keyboard.down("Shift")
    viewer.change(lambda: viewer.drag(viewer.light(), (30, -30)))
    viewer.page.keyboard.up("Shift")
    raised = viewer.page.evaluate("lights[0].position")
    assert raised[1] > moved[1]
    assert raised[0] == pytest.approx(moved[0]) and raised[2] == pytest.approx(moved[2])


def test_handle_stays_under_the_mouse(viewer):
    x, y = viewer.light()
    viewer.change(lambda: viewer.drag((x, y), (-70, 30)))
    assert viewer.light() == pytest.approx([x - 70, y + 30], abs=1.5)


def test_camera_moves(viewer):
    box = viewer.page.locator("#frame").bounding_box()
    spot = (box["x"] + 0.3 * box["width"], box["y"] + 0.7 * box["height"])
    for act in (
        lambda: viewer.drag(spot, (60, 10)),
        lambda: viewer.drag(spot, (40, 10), "right"),
        lambda: viewer.drag(spot, (20, 10), "middle"),
        lambda: viewer.page.mouse.wheel(0, 120),
        lambda: viewer.page.keyboard.press("w", delay=150),
        lambda: viewer.page.mouse.dblclick(spot[0] + 40, spot[1]),
    ):
        before, after = viewer.change(act)
        assert before["hash"] != after["hash"]
    first = viewer.page.evaluate("start.eye")
    assert viewer.page.evaluate("camera.eye") != first
    viewer.change(lambda: viewer.page.keyboard.press("Home"))
    assert viewer.page.evaluate("camera.eye") == first


def test_modes_differ_and_parts_add_up(viewer):
    viewer.change(lambda: viewer.page.evaluate("setExposure(0)"))
    seen = {}
    for key, mode in enumerate(["full", "direct", "indirect", "cells", "trust"], start=1):
        if mode != "full":
            viewer.change(lambda key=key: viewer.page.keyboard.press(str(key)))
        seen[mode] = viewer.digest()
    assert len({picture["hash"] for picture in seen.values()}) == 5
    assert seen["full"]["sum"] > max(seen["direct"]["sum"], seen["indirect"]["sum"])


def test_lights_come_go_and_change(viewer):
    page = viewer.page
    viewer.change(lambda: page.click("#add"))
    assert page.evaluate("lights.length") == 2
    viewer.change(lambda: page.fill("#colour", "#ff4020"))
    viewer.change(lambda: page.evaluate("setExposure(shownExposure)"))
    before, after = viewer.change(
        lambda: (page.fill("#watts", "0.25"), page.dispatch_event("#watts", "change"))
    )
    assert before["hash"] != after["hash"]
    viewer.change(lambda: page.click("#remove"))
    assert page.evaluate("lights.length") == 1


def test_own_lights_have_rows(lit_viewer):
    """Each is off and on, alone, in another colour and strength; the picture follows, and adds up."""
    viewer, page = lit_viewer, lit_viewer.page
    rows = page.locator("#own li")
    names = [row.get_attribute("data-name") for row in rows.all()]
    assert names == ["light0", "light1", "light2", "sun"] and page.evaluate("own.length") == 3
    lamp = page.evaluate("own.findIndex((l) => l.kind === 'lamp')")
    shows = rows.nth(lamp).locator("p").text_content()
    assert "points that stand for it" in shows
    spot = page.evaluate("own.findIndex((l) => l.kind === 'spot')")
    assert "direct light only" in rows.nth(spot).locator("p").text_content()
    for k in range(3):
        box = page.locator(f"#own li:nth-child({k + 1}) input[type=checkbox]")
        before, after = viewer.change(box.click)
        assert before["sum"] > after["sum"], names[k]
        viewer.change(lambda: page.locator(f"#own li:nth-child({k + 1}) input[type=checkbox]").click())
        solo = page.locator(f"#own li:nth-child({k + 1}) button").first
        before, after = viewer.change(solo.click)
        assert before["sum"] > after["sum"] > 0, names[k]
        viewer.change(lambda: page.locator(f"#own li:nth-child({k + 1}) button").first.click())
    number = page.locator(f"#own li:nth-child({lamp + 1}) input[type=number]")
    before, after = viewer.change(lambda: (number.fill("1"), number.dispatch_event("change")))
    assert before["sum"] > after["sum"]
    colour = page.locator(f"#own li:nth-child({spot + 1}) input[type=color]")
    before, after = viewer.change(lambda: colour.fill("#2040ff"))
    assert before["hash"] != after["hash"]


def test_own_lights_are_dragged(lit_viewer):
    page = lit_viewer.page
    for kind in ("point", "spot"):
        index = page.evaluate(f"own.findIndex((l) => l.kind === '{kind}')")
        where = page.evaluate(
            """(k) => {
                const box = document.getElementById("frame").getBoundingClientRect();
                const [x, y] = project(own[k].position, [box.width, box.height]);
                return [box.left + x, box.top + y];
            }""",
            index,
        )
        position = page.evaluate(f"own[{index}].position")
        before, after = lit_viewer.change(lambda: lit_viewer.drag(where, (45, 25)))
        assert before["hash"] != after["hash"]
        moved = page.evaluate(f"own[{index}].position")
        assert moved[0] > position[0] and moved[1] < position[1]
        name = page.evaluate(f"own[{index}].name")
        assert f"--move {name}:" in page.text_content("#command")


def test_the_suns_dial(lit_viewer, tmp_path):
    viewer, page = lit_viewer, lit_viewer.page
    assert page.evaluate("sun.toward") == pytest.approx([180, 30], abs=1e-3)
    box = page.locator("#dial").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    unit = box["width"] / 140
    # from below: -z is up, +x to the right; half way to the rim is 45 degrees high
    def press(dx, dy):
        page.mouse.move(middle[0] + dx * unit, middle[1] + dy * unit)
        page.mouse.down()
        page.mouse.up()

    before, after = viewer.change(lambda: press(10, 40))
    assert before["hash"] != after["hash"]
    azimuth, elevation = page.evaluate("sun.toward")
    assert azimuth == pytest.approx(165.96, abs=1.5)
    assert elevation == pytest.approx(90 - 1.5 * 41.23, abs=1.5)
    viewer.change(lambda: (page.fill("#azimuth", "200"), page.dispatch_event("#azimuth", "change")))
    assert page.evaluate("sun.toward[0]") == 200
    # a summer solstice's noon at 50 degrees north: 63.45 degrees high in the south
    viewer.change(lambda: (page.fill("#latitude", "50"), page.fill("#date", "2026-06-21")))
    assert page.evaluate("sun.toward") == pytest.approx([180, 63.45], abs=0.1)
    morning = page.evaluate("sunAt(80, 6, 0)")
    assert morning == pytest.approx([90, 0], abs=1)
    command = page.text_content("#command").replace("\\\n", " ").split()
    assert any(word.startswith("--sun=180,63.4") for word in command)
    assert "--scene-lights" in command
    subprocess.run([RRF, *command[1:]], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    viewer.change(lambda: page.click("#add-sun"))
    assert page.evaluate("suns.length") == 2
    viewer.change(lambda: page.locator("#own li:last-child button").last.click())
    assert page.evaluate("suns.length") == 1


def test_resizing(viewer):
    page = viewer.page
    viewer.change(lambda: page.set_viewport_size({"width": 900, "height": 760}))
    narrow = viewer.digest()["size"]
    viewer.change(lambda: page.set_viewport_size({"width": 1300, "height": 600}))
    wide = viewer.digest()["size"]
    assert min(narrow) == min(wide) == 512
    assert wide[0] / wide[1] > narrow[0] / narrow[1]
    viewer.change(lambda: page.select_option("#size", "256"))
    assert min(viewer.digest()["size"]) == 256


def test_tracing_beside_it(viewer):
    page = viewer.page
    viewer.change(lambda: page.select_option("#size", "256"))
    page.click("#trace")
    viewer.wait_paths(8)
    rows = page.locator("#measures tr").all_text_contents()
    assert [re.match(r"\D+", row.replace("2000", ""))[0] for row in rows] == [
        "relative error",
        "relMSE",
        "ΔE",
        "FLIP",
    ]
    page.check("#difference")
    assert "too bright" in page.text_content("#truth-caption")
    # the view changes: the tracing begins again by itself
    paths = int(page.evaluate("document.body.dataset.paths"))
    box = page.locator("#frame").bounding_box()
    page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2)
    viewer.change(lambda: page.mouse.wheel(0, 120))
    viewer.until(f"Number(document.body.dataset.paths) < {paths}")
    page.click("#trace")
    assert page.evaluate("tracing") is None


def test_second_viewer_has_its_own_camera(browser, server, viewer):
    first = viewer.digest()
    other = Viewer(browser, server)
    other.page.mouse.wheel(0, 0)
    box = other.page.locator("#frame").bounding_box()
    other.page.mouse.move(box["x"] + 5, box["y"] + box["height"] / 2)
    before, after = other.change(lambda: other.page.mouse.wheel(0, 300))
    assert before["hash"] != after["hash"]
    assert viewer.digest() == first
    other.clean(server)
    other.page.close()
    # and its going away leaves the first one working
    before, after = viewer.change(lambda: viewer.drag(viewer.light(), (40, 20)))
    assert before["hash"] != after["hash"]


def test_the_command_makes_the_same_picture(viewer, tmp_path):
    """The shell command that the page tells: its PNG is the page's picture, but for the
    live one's coarser sRGB table."""
    box = viewer.page.locator("#frame").bounding_box()
    spot = (box["x"] + 0.3 * box["width"], box["y"] + 0.7 * box["height"])
    viewer.change(lambda: viewer.drag(spot, (35, 12)))
    viewer.change(lambda: viewer.page.evaluate("setExposure(shownExposure)"))
    command = viewer.page.text_content("#command").replace("\\\n", " ").split()
    assert command[0] == "rrf"
    subprocess.run([RRF, *command[1:]], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    data = (tmp_path / "view.png").read_bytes()
    difference = viewer.page.evaluate(
        """async (bytes) => {
            const blob = new Blob([new Uint8Array(bytes)], { type: "image/png" });
            const image = await createImageBitmap(blob);
            const canvas = new OffscreenCanvas(image.width, image.height);
            canvas.getContext("2d").drawImage(image, 0, 0);
            const read = (c) => c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
            const [a, b] = [read(canvas), read(document.getElementById("frame"))];
            if (a.length !== b.length) return [255, 1];
            let [most, many] = [0, 0];
            for (let i = 0; i < a.length; i++) {
                const d = Math.abs(a[i] - b[i]);
                most = Math.max(most, d);
                many += d > 1;
            }
            return [most, many / a.length];
        }""",
        list(data),
    )
    # one level by the table; edge pixels by seven digits of the printed camera
    assert difference[1] < 1e-3, difference


def get(url, **headers):
    """Status and headers of a plain GET."""
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers)) as answer:
            return answer.status, dict(answer.headers), answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), ""


def test_strangers_stay_out(server):
    host = re.match(r"http://([^/]+)/", server)[1]
    port = int(host.rsplit(":", 1)[1])
    status, headers, page = get(server)
    assert status == 200
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "unsafe" not in policy and "*" not in policy
    assert "http" not in re.sub(r"http://www.w3.org/2000/svg", "", page)
    assert get(f"http://{host}/")[0] == 403
    assert get(f"http://{host}/?token=0")[0] == 403
    assert get(server[:-1])[0] == 403
    assert get(server, Host=f"rebound.example:{port}")[0] == 403
    assert get(server, Origin="http://rebound.example")[0] == 403
    assert get(server.replace("/?", "/nothing?"))[0] == 404
    # only on the loopback address
    for address in {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None)}:
        if not address.startswith(("127.", "::1")):
            with pytest.raises(OSError):
                socket.create_connection((address, port), timeout=2)


def test_wrong_token_in_the_browser(browser, server):
    page = browser.new_page()
    assert page.goto(server[:-2] + "zz").status == 403
    page.close()


def test_closing_the_page_frees_the_work(browser, server):
    """While a page traces, the server is busy; once it is closed, it is not."""
    viewer = Viewer(browser, server)
    viewer.page.click("#trace")
    viewer.wait_paths(2)
    port = int(re.search(r":(\d+)/", server)[1])
    process = owner(port)
    viewer.page.close()
    idle = [busy_seconds(process, 1.0) for _ in range(8)]
    assert min(idle) < 0.05, idle


def owner(port):
    """The process that listens on a port, by /proc."""
    line = next(
        line
        for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[1].endswith(f":{port:04X}") and line.split()[3] == "0A"
    )
    wanted = f"socket:[{line.split()[9]}]"
    for folder in pathlib.Path("/proc").glob("[0-9]*/fd"):
        try:
            if any(os.readlink(fd) == wanted for fd in folder.iterdir()):
                return folder.parent
        except OSError:
            continue
    raise LookupError(port)


def busy_seconds(process, seconds):
    """Processor time that it uses in the next `seconds`."""
    def used():
        fields = (process / "stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    before = used()
    time.sleep(seconds)
    return used() - before


def test_screenshot(viewer):
    """The README's picture, written where RRF_SCREENSHOT says."""
    target = os.environ.get("RRF_SCREENSHOT")
    page = viewer.page
    viewer.change(lambda: page.click("#add"))
    viewer.change(lambda: page.fill("#colour", "#ff9050"))
    page.click("#trace")
    goal = 16 if target else 2
    viewer.wait_paths(goal)
    page.click("#trace")
    for _ in range(40 if target else 1):
        # the speed that the picture shows is that without tracing
        viewer.change(lambda: page.evaluate("ask()"))
    shot = page.screenshot(path=target) if target else page.screenshot()
    assert len(shot) > 20_000
