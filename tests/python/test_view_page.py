"""The page of `rrf view` as a thing to look at: pictures at rest, the truth, warnings, keys, screens of all sizes.

With RRF_SCREENSHOTS a folder gets a picture of the page at every size.
"""

import os
import pathlib
import re

import pytest
from viewer import Viewer

SIZES = [(1920, 1080), (1280, 720), (800, 600), (390, 844)]
# contrast that WCAG 2.2 asks for at level AA: 1.4.3 (text), 1.4.11 (borders of fields), and target size 2.5.8
TEXT, EDGE, TARGET = 4.5, 3.0, 24

# colours of everything that has words, and of the fields' borders, over what lies behind them
COLOURS = """() => {
    const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
    const behind = (element) => {
        let layers = [];
        for (let at = element; at; at = at.parentElement) {
            const colour = numbers(getComputedStyle(at).backgroundColor);
            const alpha = colour.length > 3 ? colour[3] : 1;
            if (alpha > 0) layers.push([colour.slice(0, 3), alpha]);
            if (alpha === 1) break;
        }
        // words over the picture: the brightest picture is the worst
        const over = element.closest('#picture, #warnings') ? [255, 255, 255] : [0, 0, 0];
        return layers.reverse().reduce((under, [c, a]) => under.map((x, i) => a * c[i] + (1 - a) * x), over);
    };
    const seen = [...document.querySelectorAll("body *")].filter((e) => e.checkVisibility() && !e.closest(":disabled"));
    const words = seen.filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()) || e.matches("input[type=number], select"));
    const told = (e) => `${e.tagName}#${e.id}.${e.className.baseVal ?? e.className}: ${e.textContent.trim().slice(0, 30)}`;
    const text = words.filter((e) => !e.closest("option, script, style")).map((e) => {
        const style = getComputedStyle(e);
        return [told(e), numbers(e.closest("svg") ? style.fill : style.color).slice(0, 3), behind(e)];
    });
    const fields = seen.filter((e) => e.matches("input[type=number], input[type=date], select, aside button:not(#lights button)"));
    const edges = fields.map((e) => [told(e), numbers(getComputedStyle(e).borderTopColor).slice(0, 3), behind(e.parentElement)]);
    return { text, edges };
}"""


# words that leave a box which hides them, or come within two pixels of a border beside them
CUT = """() => {
    const found = [];
    for (const e of document.querySelectorAll("header *, aside *, dialog *")) {
        if (!e.checkVisibility() || ![...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim())) continue;
        // dots say that there is more
        const style = (at) => getComputedStyle(at);
        if (style(e).textOverflow === "ellipsis" || style(e.parentElement).textOverflow === "ellipsis") continue;
        const range = document.createRange();
        range.selectNodeContents(e);
        const words = e.closest("svg") ? e.getBoundingClientRect() : range.getBoundingClientRect();
        if (words.left < 0 || words.right > document.documentElement.clientWidth) {
            found.push(`outside: ${e.textContent.trim().slice(0, 30)}`);
            continue;
        }
        for (let at = e; at.parentElement; at = at.parentElement) {
            const { borderLeftWidth, borderRightWidth, overflowX } = style(at), box = at.getBoundingClientRect();
            const border = parseFloat(borderLeftWidth) > 0 && parseFloat(borderRightWidth) > 0;
            const near = at === e && border ? 2 + parseFloat(borderLeftWidth) : 0;
            const hides = overflowX !== "visible" || border;
            if (hides && (words.left < box.left + near - 0.5 || words.right > box.right - near + 0.5)) {
                found.push(`${at.tagName}#${at.id}: ${e.textContent.trim().slice(0, 30)}`);
                break;
            }
        }
    }
    return found;
}"""


def luminance(rgb):
    """Relative luminance as WCAG defines it."""
    linear = [c / 255 / 12.92 if c / 255 <= 0.04045 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in rgb]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_contrast_by_its_definition():
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21)
    assert contrast((119, 119, 119), (255, 255, 255)) == pytest.approx(4.48, abs=0.01)


@pytest.fixture
def restful(browser, server):
    """A page that refines its picture at rest."""
    viewer = Viewer(browser, server, refine=True)
    yield viewer
    viewer.clean(server)
    viewer.page.close()


def warn(viewer):
    """Puts the light where the bake did not expect it."""
    viewer.page.evaluate("lights[0].position = [0, 0.4, 0.2]; lightsChanged()")
    viewer.until("document.querySelector('#warnings li')")


def traced(viewer, paths):
    """Until the picture has been traced with `paths` a pixel, at the smallest size."""
    if viewer.page.input_value("#size") != "256":
        viewer.change(lambda: viewer.page.select_option("#size", "256"))
    viewer.page.click("#trace")
    viewer.wait_paths(paths)


def test_a_measure_is_told_once_it_is_known(viewer):
    page, seen = viewer.page, {}
    # not every pass is measured, and passes do not wait for one who looks on
    page.evaluate("window.all = []; const tell = tellMeasures; tellMeasures = (facts) => { if (facts.measures) all.push(facts.measures); tell(facts); }; 0")
    traced(viewer, 64)
    for measures in page.evaluate("all"):
        for measure in measures:
            known = measure["uncertainty"] < measure["value"] / 3
            assert measure["is_known"] == known
            seen.setdefault(measure["name"], []).append((measure["value"], measure["uncertainty"], known))
    assert set(seen) >= {"relative_error", "rel_mse", "delta_e_2000", "flip"}
    # half of the noise is gone with four times the paths
    spread = [uncertainty for _, uncertainty, _ in seen["delta_e_2000"]]
    assert spread[-1] < spread[0]
    assert seen["relative_error"][-1][2], seen["relative_error"]
    row = page.locator("#measures tr").first
    assert re.fullmatch(r"relative error[\d.]+ ± [\d.]+ %", row.text_content())
    page.click("#trace")
    for row in page.locator("#measures tr").all():
        assert (row.get_attribute("data-known") == "false") == row.text_content().endswith("—")
    unknown = page.locator("#measures tr[data-known=false]").count()
    assert page.is_visible("#withheld") == (unknown > 0)


def test_two_pictures_of_one_size_with_a_wipe(viewer):
    page = viewer.page
    traced(viewer, 2)
    page.click("#trace")
    rectangles = [page.locator(f"#{name}").bounding_box() for name in ("frame", "traced")]
    assert rectangles[0] == rectangles[1]
    sizes = page.evaluate("['frame', 'traced'].map((id) => [$(id).width, $(id).height])")
    assert sizes[0] == sizes[1]
    box, line = rectangles[0], page.locator("#wipe").bounding_box()
    middle = (line["x"] + line["width"] / 2, line["y"] + 30)
    assert middle[0] == pytest.approx(box["x"] + box["width"] / 2, abs=1)
    viewer.drag(middle, (0.25 * box["width"], 0))
    assert page.evaluate("border") == pytest.approx(0.75, abs=0.01)
    assert "75" in page.evaluate("$('traced').style.clipPath")
    page.focus("#wipe")
    page.keyboard.press("ArrowLeft")
    assert page.get_attribute("#wipe", "aria-valuenow") == "73"
    eye = page.evaluate("camera.eye")
    page.keyboard.press("Home")
    assert page.evaluate("border") == 0 and page.evaluate("camera.eye") == eye
    # another view: the traced picture is not its own
    viewer.change(lambda: page.evaluate("orbit(0.1, 0)"))
    assert page.is_hidden("#traced") and page.is_hidden("#wipe")


def test_at_rest_the_picture_fills_the_window_and_its_edges_are_smooth(restful):
    page = restful.page
    # however slow the machine is
    page.evaluate("longest = 1e9; home()")
    restful.until("Number(document.body.dataset.rays) === 16", 300)
    assert page.evaluate("[$('frame').width, $('frame').height]") == page.evaluate(
        "(() => { const box = $('picture').getBoundingClientRect(); return [box.width, box.height].map(Math.round); })()"
    )
    assert re.fullmatch(r"at rest, \d+×\d+, 16 camera rays a pixel", page.text_content("#speed"))
    assert "--aa 4" in page.text_content("#command")
    smooth = restful.digest()
    # it moves again at once, by the smaller picture without antialiasing
    page.evaluate("orbit(0.05, 0)")
    restful.until("facts.aa === 1 && Math.min(...facts.size) === 512 && !asked", 60)
    assert restful.digest()["hash"] != smooth["hash"]
    # and a picture at rest that is being made is dropped for a movement
    restful.until("asked && detail.aa > 1", 120)
    page.evaluate("home()")
    restful.until("detail === MOVING && !asked", 60)
    restful.until("Number(document.body.dataset.rays) === 16", 300)
    assert restful.digest()["hash"] == smooth["hash"]


def test_the_rate_is_told_of_movements_only(viewer):
    page, told = viewer.page, []
    page.evaluate("new MutationObserver(() => (window.said ||= []).push($('speed').textContent)).observe($('speed'), { childList: true })")
    for _ in range(2):
        page.keyboard.down("w")
        viewer.until(f"Number(document.body.dataset.frames) >= {viewer.frames() + 8}")
        page.keyboard.up("w")
        viewer.until("$('speed').textContent.startsWith('at rest')")
        told.append(page.text_content("#speed"))
    said = page.evaluate("window.said")
    rates = [float(found[1]) for text in said if (found := re.search(r"([\d.]+) fps", text))]
    assert rates and min(rates) > 0
    assert all("fps" not in text for text in told)


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_every_screen_shows_picture_warnings_and_controls(browser, server, size, request):
    width, height = size
    viewer = Viewer(browser, server, width, height, refine=True)
    page = viewer.page
    warn(viewer)
    inner = page.evaluate("[innerWidth, innerHeight, document.documentElement.scrollWidth]")
    assert inner[2] <= inner[0], "scrolls sideways"
    picture = page.locator("#frame").bounding_box()
    assert picture["width"] * picture["height"] > 0.4 * width * height
    warning = page.locator("#warnings li").first
    assert warning.is_visible() and "outside" in warning.text_content()
    box = warning.bounding_box()
    assert 0 <= box["x"] and box["x"] + box["width"] <= width and 0 <= box["y"] < 0.4 * height
    controls = page.locator("button:visible, select:visible, input:visible")
    for control in controls.all():
        place = control.bounding_box()
        told = control.evaluate("(e) => e.outerHTML.slice(0, 80)")
        assert place["x"] >= 0 and place["x"] + place["width"] <= width, told
        # small boxes stand in a line of the full height, whose label is a target too
        around = control.evaluate("(e) => (e.closest('label, .line') || e).getBoundingClientRect().height")
        assert max(place["height"], around) >= TARGET, told
    if folder := os.environ.get("RRF_SCREENSHOTS"):
        viewer.until("facts.aa > 1", 60)
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=f"{folder}/rest-{width}.png")
        page.screenshot(path=f"{folder}/whole-{width}.png", full_page=True)
        traced(viewer, 16)
        page.click("#trace")
        page.screenshot(path=f"{folder}/truth-{width}.png")
    viewer.clean(server)
    page.close()


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_no_word_is_cut_off(browser, server, size):
    viewer = Viewer(browser, server, *size)
    page = viewer.page
    viewer.change(lambda: page.click("#add-sun"))
    assert page.is_visible("#dial")
    page.evaluate("$('help').show()")
    assert page.evaluate(CUT) == []
    # the measure finds what is cut off
    page.evaluate("$('help').close(); $('dial').style.overflow = 'hidden'")
    assert page.evaluate(CUT) == ["svg#dial: +x"]
    page.evaluate("$('dial').style.overflow = ''; document.querySelector('#modes span').textContent = 'm'.repeat(60)")
    assert any("mmm" in told for told in page.evaluate(CUT))
    viewer.clean(server)
    page.close()


def test_fields_of_a_light_are_there_with_a_light(viewer):
    page = viewer.page
    viewer.change(lambda: page.click("#add"))
    assert page.is_visible("#colour") and page.is_visible("#watts") and page.is_visible("#x")
    while page.evaluate("lights.length"):
        viewer.change(lambda: page.click("#remove"))
    assert page.is_hidden("#colour") and page.is_hidden("#watts") and page.is_hidden("#x")
    assert page.is_disabled("#remove")
    viewer.change(lambda: page.click("#add"))
    assert page.is_visible("#colour") and page.is_enabled("#remove")


def test_contrast_is_enough_everywhere(viewer):
    page = viewer.page
    warn(viewer)
    traced(viewer, 8)
    page.click("#trace")
    viewer.change(lambda: page.click("#add-sun"))
    traced(viewer, 8)
    page.click("#trace")
    page.evaluate("$('help').show(); $('gone').hidden = false")
    found = page.evaluate(COLOURS)
    assert len(found["text"]) > 50 and len(found["edges"]) > 10
    poor = [(what, contrast(*pair)) for what, *pair in found["text"] if contrast(*pair) < TEXT]
    poor += [(what, contrast(*pair)) for what, *pair in found["edges"] if contrast(*pair) < EDGE]
    assert poor == []
    page.evaluate("$('help').close(); $('gone').hidden = true")


def test_the_keyboard_reaches_all_and_its_place_is_seen(viewer):
    page = viewer.page
    wanted = page.evaluate(
        """[...document.querySelectorAll("button, input, select, [tabindex]")]
            .filter((e) => e.checkVisibility() && !e.disabled && e.name !== "mode").length + 1"""
    )
    seen = set()
    for _ in range(wanted + 5):
        page.keyboard.press("Tab")
        told = page.evaluate(
            """() => {
                const e = document.activeElement;
                if (e === document.body) return null;
                const style = getComputedStyle(e.name === "mode" ? e.nextElementSibling : e);
                e.dataset.number ||= String(Math.random());
                return [e.dataset.number, e.outerHTML.slice(0, 90), style.outlineStyle, parseFloat(style.outlineWidth)];
            }"""
        )
        if told is None:
            continue
        number, html, style, width = told
        seen.add(number)
        assert style == "solid" and width >= 2, html
    # a date is three stops of one element
    assert len(seen) >= wanted - 1


def test_two_fingers_go_nearer(browser, server):
    viewer = Viewer(browser, server, 390, 844, has_touch=True, is_mobile=True)
    page = viewer.page
    touch = page.context.new_cdp_session(page)
    box = page.locator("#frame").bounding_box()
    middle = (box["x"] + 0.5 * box["width"], box["y"] + 0.75 * box["height"])

    def send(kind, *apart):
        points = [{"x": middle[0] + side * apart[0], "y": middle[1], "id": k} for k, side in enumerate((-1, 1))] if apart else []
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    before = page.evaluate("length(sub(camera.pivot, camera.eye))")

    def pinch():
        send("touchStart", 40)
        send("touchMove", 60)
        send("touchMove", 80)
        send("touchEnd")

    viewer.change(pinch)
    assert page.evaluate("length(sub(camera.pivot, camera.eye))") == pytest.approx(before / 2, rel=0.05)
    viewer.clean(server)
    page.close()
