"""`rrf view` in a headless browser: what a person sees and does."""

import os
import re

import pytest
from viewer import Viewer


def test_shows_a_frame(viewer):
    picture = viewer.digest()
    width, height = picture["size"]
    assert min(width, height) == 512
    # neither black nor white: between 5 and 95 % of full brightness on average
    assert 0.05 < picture["sum"] / (3 * 255 * width * height) < 0.95
    assert re.search(r"\d+×512|512×\d+", viewer.page.text_content("#speed"))


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
    names = ["relative error", "relMSE", "ΔE2000", "FLIP"]
    assert all(row.startswith(name) for row, name in zip(rows, names, strict=True))
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
    box = viewer.page.locator("#frame").bounding_box()
    spot = (box["x"] + 0.3 * box["width"], box["y"] + 0.7 * box["height"])
    viewer.change(lambda: viewer.drag(spot, (35, 12)))
    viewer.change(lambda: viewer.drag(viewer.light(), (40, 20)))
    viewer.change(lambda: viewer.page.evaluate("setExposure(shownExposure)"))
    viewer.command_makes_it(tmp_path)


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
