"""The lights of `rrf view` in a headless browser: the page's own and the scene's."""

import shutil
import subprocess

import pytest
from viewer import ROOT, RRF, Viewer, bake, served


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
    return bake(scene, folder / "run")


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
