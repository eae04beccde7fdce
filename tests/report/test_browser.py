"""Reports in a real browser: quiet, alone, readable on phones, desks and paper, by day and by night, clicked through.

Needs Chromium, its driver and selenium (`apt-get install chromium chromium-driver`, `pip install selenium`).
"""

import base64
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from estexp_jax.report.explain import page as explain_page
from estexp_jax.report.propose import page as propose_page
from estexp_jax.report.recover import page as recover_page
from tests.report.examples import LOST, WEAK, diagnosis, proposal, recovered

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync")
FLAGS += ("--disable-background-networking", "--disable-component-update", "--hide-scrollbars", "--lang=en")
SMALLEST_TEXT_PX = 12.0

PAGES = {
    "explain": lambda: explained(),
    "recover": lambda: recover_page.recover_page(
        "<b>run</b>", [LOST, WEAK], recovered(), "x", {"seed": 0, "model": "a.xml"}
    ),
    "propose": lambda: propose_page.propose_page(proposal()),
}


def explained() -> str:
    """With commands, as in a folder that holds results."""
    return explain_page.explain_page(diagnosis(), diagnosis().findings, folder=Path("some where"))


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    binary, driver = next(filter(None, map(shutil.which, BROWSERS)), None), shutil.which("chromedriver")
    if binary is None or driver is None:
        pytest.skip("no Chromium with chromedriver; on Debian: apt-get install chromium chromium-driver")
    webdriver = pytest.importorskip("selenium.webdriver", reason="drives the browser; pip install selenium")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    yield running
    running.quit()


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    for name, made in PAGES.items():
        (folder / f"{name}.html").write_text(made(), encoding="utf-8")
    return {name: folder / f"{name}.html" for name in PAGES}


def open_at(browser: Any, path: Path, width: int) -> None:
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get(path.as_uri())


def requests(browser: Any) -> list[str]:
    """Addresses that the page asked for, other than data in it."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return [address for address in asked if not address.startswith("data:")]


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_quiet_alone_and_readable(browser, files, name, width):
    browser.get_log("performance")
    open_at(browser, files[name], width)
    assert browser.get_log("browser") == []
    assert requests(browser) == [files[name].as_uri()]
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    out = """return [...document.querySelectorAll("body :not(dialog)")].filter((part) => {
        const box = part.getBoundingClientRect();
        return box.width && !part.closest(".wide") && (box.left < -1 || box.right > innerWidth + 1);
    }).map((part) => part.outerHTML.slice(0, 90))"""
    assert browser.execute_script(out) == []
    sizes = """return [...document.querySelectorAll("body *")].filter((part) => part.checkVisibility() &&
        [...part.childNodes].some((node) => node.nodeType === 3 && node.data.trim()))
        .map((part) => parseFloat(getComputedStyle(part).fontSize))"""
    found = browser.execute_script(sizes)
    assert len(found) > 20 and min(found) >= SMALLEST_TEXT_PX
    seen = """return [...document.images].filter((image) => image.checkVisibility())
        .map((image) => [image.complete && image.naturalWidth, image.clientWidth])"""
    for natural, shown in browser.execute_script(seen):
        assert natural and shown >= 0.9 * min(width - 32, 700)
    head = browser.execute_script("return document.querySelector('h1').getBoundingClientRect().bottom")
    assert head < 300  # the verdict is what one sees first


@pytest.mark.parametrize("name", PAGES)
def test_figures_enlarge_and_escape_closes_them(browser, files, name):
    open_at(browser, files[name], 390)
    figures = browser.find_elements("css selector", "figure button.zoom")
    for figure in (figure for figure in figures if figure.is_displayed()):
        browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", figure)
        before = figure.size["width"]
        figure.click()
        [large] = browser.find_elements("css selector", "dialog[open] img")
        assert large.size["width"] > 2 * before
        browser.switch_to.active_element.send_keys("\ue00c")  # escape
        assert browser.find_elements("css selector", "dialog[open]") == []
    assert browser.get_log("browser") == []


LINES = "return [...document.querySelectorAll('.panels canvas')].map((canvas) => canvas.toDataURL())"
"""What each panel shows."""


@pytest.mark.parametrize("width", [390, 1280])
def test_recording_and_reading_are_chosen_and_a_part_enlarged(browser, files, width):
    open_at(browser, files["explain"], width)
    recordings, readings = browser.find_elements("css selector", "#traces select")
    assert [o.text for o in recordings.find_elements("tag name", "option")] == [
        "b <i>$\\x$.csv (test)",
        "a.csv (train)",
    ]
    shown, told = [browser.execute_script(LINES)], [browser.find_element("css selector", "#traces .errors").text]
    for choice in ("force.0", "a.csv (train)", "angle"):
        box = recordings if choice.startswith("a.csv") else readings
        next(o for o in box.find_elements("tag name", "option") if o.text == choice).click()
        kept = readings.find_elements("css selector", "option:checked")[0].text
        assert kept == ("angle" if choice == "angle" else "force.0")  # the reading stays when the recording changes
        wait(browser)
        shown.append(browser.execute_script(LINES))
        told.append(browser.find_element("css selector", "#traces .errors").text)
    assert len({tuple(one) for one in (shown[0], shown[1], shown[3])}) == 3  # the forces of both are the same
    assert "17 deg" in told[0] and "2 N" in told[1] and "5.7 deg" in told[3]

    whole = shown[-1]
    for move, same in (("in", False), ("later", False), ("whole", True)):
        button = browser.find_element("css selector", f"#traces [data-move={move}]")
        button.click()
        wait(browser)
        now = browser.execute_script(LINES)
        assert (now == whole) == same, move
    panel = browser.find_element("css selector", ".panels .u-over")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", panel)
    if width > 500:  # by drawing with a mouse
        actions = action_chains(browser)
        actions.move_to_element(panel).click_and_hold().move_by_offset(60, 0).release().perform()
        wait(browser)
        drawn = browser.execute_script(LINES)
        assert all(a != b for a, b in zip(drawn, whole, strict=True))  # both panels
        actions = action_chains(browser)
        actions.move_to_element(panel).perform()
        wait(browser)
        values = [one.text for one in browser.find_elements("css selector", ".panels .u-legend .u-value")]
        assert len(values) == 7 and all(re.fullmatch(r"-?[\d.e-]+", value) for value in values)
    assert browser.get_log("browser") == []


def action_chains(browser: Any) -> Any:
    from selenium.webdriver import ActionChains

    return ActionChains(browser)


def wait(browser: Any) -> None:
    """Until what was asked for is drawn."""
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_text_is_legible_by_day_and_by_night(browser, files, name, scheme):
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    try:
        open_at(browser, files[name], 1280)
        contrast = """const light = (colour) => {
            const [r, g, b] = colour.match(/[\\d.]+/g).map((part) => part / 255)
                .map((part) => (part <= .03928 ? part / 12.92 : ((part + .055) / 1.055) ** 2.4));
            return .2126 * r + .7152 * g + .0722 * b;
        };
        const paper = (part) => {
            const colour = getComputedStyle(part).backgroundColor;
            return colour === "rgba(0, 0, 0, 0)" && part.parentElement ? paper(part.parentElement) : colour;
        };
        return [...document.querySelectorAll("body *")].filter((part) => part.checkVisibility() &&
            [...part.childNodes].some((node) => node.nodeType === 3 && node.data.trim())).map((part) => {
                const [a, b] = [light(getComputedStyle(part).color), light(paper(part))].sort((x, y) => y - x);
                return [(a + .05) / (b + .05), part.outerHTML.slice(0, 90)];
            })"""
        found = browser.execute_script(contrast)
        assert len(found) > 20 and [one for one in found if one[0] < 4.5] == []
        dark = browser.execute_script("return getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)"
        assert dark == (scheme == "dark")
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_a_command_is_copied(browser, files):
    open_at(browser, files["explain"], 1280)
    for command in browser.find_elements("css selector", "pre.command"):
        command.find_element("css selector", "button.copy").click()
        wait(browser)
        assert command.find_element("css selector", "button.copy").text == "Copied"
        paste = "return document.body.appendChild(document.createElement('textarea'))"
        field = browser.execute_script(paste)
        field.send_keys("\ue009v")  # control and v
        assert field.get_property("value") == command.find_element("tag name", "code").text
    assert browser.find_elements("css selector", "pre.command")


@pytest.mark.parametrize("name", PAGES)
def test_the_contents_lead_to_every_section(browser, files, name):
    open_at(browser, files[name], 390)
    links = [a.get_attribute("href").partition("#")[2] for a in browser.find_elements("css selector", "nav a")]
    heads = [head.get_attribute("id") for head in browser.find_elements("tag name", "h2")]
    assert links == heads and len(links) >= 3


COLUMN = "return [...arguments[0].tBodies[0].rows].map((row) => row.cells[arguments[1]].textContent.trim())"


@pytest.mark.parametrize("name", PAGES)
def test_every_table_sorts_by_every_column(browser, files, name):
    open_at(browser, files[name], 1280)
    browser.execute_script("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    tables = browser.find_elements("css selector", "table.sortable")
    heads = [table.find_elements("css selector", "th button") for table in tables]
    assert any(heads)
    for table, buttons in zip(tables, heads, strict=True):
        assert (len(table.find_elements("css selector", "tbody tr")) > 1) == bool(buttons)
        for column, button in enumerate(buttons):
            whole = browser.execute_script(COLUMN, table, column)
            for state in ("ascending", "descending"):
                browser.execute_script("arguments[0].click()", button)
                shown = browser.execute_script(COLUMN, table, column)
                assert sorted(shown) == sorted(whole)
                assert table.find_elements("css selector", f"th[aria-sort={state}]")
                keys = [number(text) for text in shown]
                if "number" in button.find_element("xpath", "..").get_attribute("class"):
                    known = [key for key in keys if key is not None]
                    assert known == sorted(known, reverse=state == "descending")
                    assert None not in keys[: len(known)]  # what has no number stays last


def number(text: str) -> float | None:
    found = re.match(r"[<>]?\s*([-+]?[\d.]+(?:e[-+]?\d+)?)", text)
    return None if found is None else float(found[1]) + {"<": -1e-6, ">": 1e-6}.get(text[0], 0.0)


@pytest.mark.parametrize("name", PAGES)
def test_paper_has_all_of_it_and_no_buttons(browser, files, name):
    open_at(browser, files[name], 1280)
    made = browser.execute_cdp_cmd("Page.printToPDF", {"paperWidth": 8.27, "paperHeight": 11.69})
    printed = base64.b64decode(made["data"])
    assert printed.startswith(b"%PDF") and 1 <= len(re.findall(rb"/Type\s*/Page\b", printed)) <= 8
    assert browser.execute_script("return [...document.querySelectorAll('details')].every((part) => part.open)")
    size = {"width": 690, "height": 1000, "deviceScaleFactor": 1, "mobile": False}  # A4 less its margins
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        assert browser.execute_script("return document.documentElement.scrollWidth") <= 690
        unseen = (
            "return [...document.querySelectorAll('.copy, nav, .traces, video')].filter((p) => p.checkVisibility())"
        )
        assert browser.execute_script(unseen) == []
        drawings = "return [...document.querySelectorAll('figure img')].every((image) => image.checkVisibility())"
        assert browser.execute_script(drawings)
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


def test_what_names_bring_in_never_runs(browser, tmp_path):
    """Even markup that got past the escaping would be refused, as the page allows its own script only."""
    hostile = "<script>window.ran = 1</script><img src=x onerror='window.ran = 2'><iframe src='https://x.invalid'>"
    (tmp_path / "hostile.html").write_text(recover_page.recover_page(hostile, [], recovered(), "x", {hostile: hostile}))
    open_at(browser, tmp_path / "hostile.html", 1280)
    assert browser.get_log("browser") == []
    assert browser.execute_script("return [window.ran === undefined, document.querySelectorAll('iframe').length]") == [
        True,
        0,
    ]
    opened = (tmp_path / "hostile.html").read_text().replace("</h1>", f"</h1>{hostile}", 1)
    (tmp_path / "open.html").write_text(opened)
    open_at(browser, tmp_path / "open.html", 1280)
    refused = [entry["message"] for entry in browser.get_log("browser")]
    assert len(refused) >= 3 and all("Content Security Policy" in message for message in refused)
    assert browser.execute_script("return window.ran === undefined")


@pytest.mark.slow
def test_the_report_of_a_saved_explanation_offers_all_that_was_recorded(browser, explained):
    open_at(browser, explained / "report.html", 1280)
    recordings, readings = browser.find_elements("css selector", "#traces select")
    shown = [o.text.rpartition(" ")[0] for o in recordings.find_elements("tag name", "option")]
    assert sorted(shown) == sorted(f"{path.stem}.csv" for path in (explained / "predictions").glob("*.csv"))
    for k in range(len(shown)):
        recordings.find_elements("tag name", "option")[k].click()
        for o in readings.find_elements("tag name", "option"):
            o.click()
            wait(browser)
            assert "off by" in browser.find_element("css selector", "#traces .errors").text
    links = [a.get_attribute("href") for a in browser.find_elements("css selector", "td.file a")]
    assert len(links) >= 6 and all((explained / link.rstrip("/").rpartition("/")[2]).exists() for link in links)
    assert browser.get_log("browser") == []
