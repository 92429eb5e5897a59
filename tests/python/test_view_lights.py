"""The lights of `rrf view` in a headless browser: the page's own and the scene's."""

import os
import pathlib
import shutil

import pytest
from viewer import ROOT, Viewer, bake, served

# the smallest transfer
SMALL = ["--method", "transfer", "--preset", "preview", "--rows", "3000", "--paths", "64"]


def lit_scene(folder):
    """The Cornell box with a point and a spot of its own beside its lamp."""
    shutil.copytree(ROOT / "scenes/cornell-box", folder / "scene")
    scene = folder / "scene/scene.pbrt"
    lights = '''WorldBegin
    LightSource "point" "rgb I" [ 0.5 0.4 0.3 ] "point from" [ 0.3 1.2 0.4 ]
    LightSource "spot" "rgb I" [ 2 2 2 ] "point from" [ -0.4 1.5 0.3 ] "point to" [ -0.2 0 0 ]
        "float coneangle" [ 25 ] "float conedeltaangle" [ 8 ]
'''
    scene.write_text(scene.read_text().replace("WorldBegin", lights, 1))
    return scene


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    """Nets of the box with the smallest bake."""
    folder = tmp_path_factory.mktemp("lit")
    return bake(lit_scene(folder), folder / "run")


@pytest.fixture(scope="module")
def lit_transfer(tmp_path_factory):
    """A transfer of the box."""
    folder = tmp_path_factory.mktemp("lit_transfer")
    return bake(lit_scene(folder), folder / "run", *SMALL)


@pytest.fixture
def lit_server(lit):
    """A page on that run, its own lights on, and a sun that comes in at the open front."""
    with served(lit, "--scene-lights", "--sun=180,30,0.5,0.5,0.4") as url:
        yield url


@pytest.fixture
def lit_viewer(browser, lit_server):
    viewer = Viewer(browser, lit_server, height=1000)
    viewer.change(lambda: viewer.page.evaluate("setExposure(0)"))
    yield viewer
    viewer.clean(lit_server)
    viewer.page.close()


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


def index_of(page, kind):
    return page.evaluate(f"own.findIndex((l) => l.kind === '{kind}')")


def drag_own(viewer, kind, by):
    """Drags an own light by its handle; gives its name, and its place before and after."""
    page, index = viewer.page, index_of(viewer.page, kind)
    position = page.evaluate(f"own[{index}].position")
    before, after = viewer.change(lambda: viewer.drag(viewer.place(f"own[{index}].position"), by))
    assert before["hash"] != after["hash"]
    name, moved = page.evaluate(f"[own[{index}].name, own[{index}].position]")
    assert f"--move {name}:" in page.text_content("#command")
    return name, position, moved


def test_own_lights_are_dragged(lit_viewer, tmp_path):
    for kind in ("point", "spot"):
        _, position, moved = drag_own(lit_viewer, kind, (45, 25))
        assert moved[0] > position[0] and moved[1] < position[1]
    # points stand for the lamp where it is
    page, lamp = lit_viewer.page, index_of(lit_viewer.page, "lamp")
    assert page.evaluate(f"own[{lamp}].position") is None
    lit_viewer.command_makes_it(tmp_path)


def test_a_lamp_is_dragged(browser, lit_transfer, tmp_path):
    """The lamp is seen elsewhere, lights from there, and the command says so."""
    with served(lit_transfer) as url:
        viewer = Viewer(browser, url)
        page = viewer.page
        viewer.change(lambda: page.evaluate("setExposure(shownExposure)"))
        lamp = index_of(page, "lamp")
        home = viewer.place(f"own[{lamp}].position")
        white = f"""() => {{
            const [x, y] = project(own[{lamp}].position, size());
            const data = $("frame").getContext("2d").getImageData(x, y, 1, 1).data;
            return Math.min(data[0], data[1], data[2]);
        }}"""
        assert page.evaluate(white) > 200
        _, position, moved = drag_own(viewer, "lamp", (-70, 90))
        assert moved[0] < position[0] and moved[1] < position[1] - 0.1
        # its own brightness is where it is now, and no longer where it was
        if picture := os.environ.get("RRF_SCREENSHOTS"):
            pathlib.Path(picture).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=f"{picture}/lamp.png")
        assert page.evaluate(white) > 200
        viewer.command_makes_it(tmp_path)
        # a second move is one from where the file has it, not from the first
        drag_own(viewer, "lamp", (40, -30))
        viewer.command_makes_it(tmp_path)
        # the same bytes as before any move
        page.evaluate(f"own[{lamp}].position = own[{lamp}].home.position")
        viewer.change(lambda: page.evaluate("ask()"))
        assert viewer.place(f"own[{lamp}].position") == pytest.approx(home)
        words = viewer.command_makes_it(tmp_path)
        assert not any(word.startswith("--move") for word in words)
        # traced pictures have it too
        drag_own(viewer, "lamp", (-70, 90))
        viewer.change(lambda: page.select_option("#size", "256"))
        page.click("#trace")
        viewer.wait_paths(32)
        page.click("#trace")
        relative = page.evaluate("tracedFacts.measures.find((m) => m.name === 'relative_error')")
        assert relative["value"] < 0.5, relative
        viewer.clean(url)
        page.close()


def test_at_rest_the_command_makes_the_same_picture(browser, lit_transfer, tmp_path):
    with served(lit_transfer) as url:
        viewer = Viewer(browser, url, width=640, height=480, refine=True)
        page = viewer.page
        page.evaluate("longest = 1e9; orbit(0.1, 0)")
        viewer.until("Number(document.body.dataset.rays) === 16 && !asked", 300)
        words = viewer.command_makes_it(tmp_path)
        assert "--noise" not in words
        viewer.clean(url)
        page.close()


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
    words = viewer.command_makes_it(tmp_path)
    assert any(word.startswith("--sun=180,63.4") for word in words)
    assert "--scene-lights" in words
    viewer.change(lambda: page.click("#add-sun"))
    assert page.evaluate("suns.length") == 2
    viewer.change(lambda: page.locator("#own li:last-child button").last.click())
    assert page.evaluate("suns.length") == 1
