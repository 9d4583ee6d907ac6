"""What pages say and mark: arteries by name, what a simulation changed, the page of a classification, a cohort that is walked through."""

import base64
import csv
import json
import re
import time
import zipfile
import tempfile
from pathlib import Path

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.support.ui import WebDriverWait

ARTERY = re.compile(r"^([LR]-(ICA|A1|A2|M1|P1|P2|PComm|VA)|AComm|BA|VA)\b")
# The pixels of what stands over the vessels that are as red as the marks.
RED = """const c = document.getElementById('overlay'), k = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let i = 0; i < k.length; i += 4) if (k[i] > 190 && k[i + 1] < 40 && k[i + 2] < 70 && k[i + 3] > 200) n += 1; return n"""


def check_names(page):
    """Where arteries are known by their geometry, a connection is called by those that it joins; the sentence tells what is cut and what is kept."""
    if (page.folder / "phenotype.json").exists():
        names = page.driver.execute_script("return [...document.querySelectorAll('#review-list b')].map(b => b.textContent)")
        assert names and sum(bool(ARTERY.match(name)) for name in names) >= len(names) / 2, names
    contacts = [edge for edge in page.edges if edge.get("origin") == "contact"]
    if contacts and page.one("#threshold").is_displayed():
        kept = sum(edge["kept"] == "1" for edge in contacts)
        page.open()
        assert f"{len(contacts) - kept} of {len(contacts)} observed contacts cut, {kept} kept" in page.text("#answer-words"), page.text("#answer-words")


def check_simulated(page):
    """The sentence names what was changed, and the view marks it, with the flows that turned round; figures can be enlarged."""
    changes = page.record.get("perturbations", [])
    if changes:
        said = page.text("#answer-words").lower()
        for change in changes:
            assert f"{change['kind']} of {(change['label'] or 'edge').lower()}" in said, said
        if page.record["reversed"]:
            assert all(vessel["label"].lower() in said for vessel in page.record["reversed"][:4]), said
        red = page.driver.execute_script(RED)
        page.click("#flow")
        page.settle()
        assert red > 40 and page.driver.execute_script(RED) < red, red
        page.click("#flow")
    if "classes" in page.record:
        assert "a number u is drawn" in page.text("#answer-words")
    if page.driver.execute_script("return Boolean(document.querySelector('.enlarge'))"):
        wide = "return document.querySelector('.enlarge img').clientWidth"
        before = page.driver.execute_script(wide)
        page.click(".enlarge")
        assert page.driver.execute_script(wide) >= before and page.one(".enlarge").get_attribute("aria-pressed") == "true"
        page.click(".enlarge")


def check_figures(page):
    """Each figure is shown, and no word of it is cut off at the edge of its page, in a wider font either."""
    shown = "return [...document.querySelectorAll('#pictures img')].every(image => image.naturalWidth > 0)"
    WebDriverWait(page.driver, 20).until(lambda driver: driver.execute_script(shown))
    outside = """const page = document.documentElement.getBoundingClientRect();
      return [...document.querySelectorAll("text")].filter(text => {
        if (arguments[0]) text.setAttribute("font-family", arguments[0]);
        const box = text.getBoundingClientRect();
        return box.left < page.left || box.right > page.right || box.top < page.top || box.bottom > page.bottom;
      }).map(text => text.textContent)"""
    for figure in page.folder.glob("*.svg"):
        page.driver.get(figure.as_uri())
        assert page.driver.execute_script("return document.querySelectorAll('text').length") > 1, figure
        for font in ("", "DejaVu Sans"):
            assert not page.driver.execute_script(outside, font), (figure, font, page.driver.execute_script(outside, font))
        # A browser makes a PDF of the size of the figure, with its text as text.
        printed = base64.b64decode(page.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"])
        size = [float(x) for x in page.driver.execute_script("return document.documentElement.getAttribute('viewBox')").split()[2:]]
        boxes = [list(map(float, box.split())) for box in re.findall(rb"/MediaBox ?\[([^]]*)\]", printed)]
        assert len(boxes) == 1 and all(abs(a - b / 100) < 1 for a, b in zip(boxes[0][2:], size)) and b"/Font" in printed, (figure, boxes, size)


def check_classified(page):
    """A sentence leads, with the warnings; the subject is the title; a link goes to the run, and from there back."""
    told = json.loads((page.folder / "phenotype.json").read_text())
    subject = next(csv.DictReader(open(page.folder / "phenotype.csv")))["subject"]
    page.open()
    assert page.text("#title") == f"willis classify: {subject}", page.text("#title")
    assert page.text("#answer-words").lower().startswith(told["words"].lower()) and page.text("#answer-words").endswith(".")
    way = page.one("#of-run a").get_attribute("href")
    page.driver.get(way)
    WebDriverWait(page.driver, 60).until(lambda d: d.execute_script("return document.documentElement.dataset.ready") == "yes")
    assert page.text("#title").startswith("willis infer"), way
    page.click("#back")
    WebDriverWait(page.driver, 60).until(lambda d: d.current_url == (page.folder / "report.html").as_uri())
    # A way back that leads elsewhere is none.
    page.driver.get(f"{way.split('?')[0]}?from=javascript:alert(1).html")
    assert not page.driver.execute_script("return document.getElementById('back')")
    page.no_error()


def check_print(page):
    """A print has every row of a table, no wider than the paper, and no word of a header in two lines."""
    driver = page.driver
    if len(page.edges) > 1000:
        return
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", dict(width=1046, height=718, deviceScaleFactor=1, mobile=False))
    driver.execute_script("window.dispatchEvent(new Event('beforeprint'))")
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    rows, wide, high = driver.execute_script("""const t = document.querySelector('#sheet table'); return [t.tBodies[0].rows.length, t.getBoundingClientRect().width, Math.max(...[...t.tHead.rows[0].cells].map(cell => {
      const range = document.createRange();
      return Math.max(...[...cell.firstElementChild.childNodes].filter(node => node.nodeType === 3).map(node => { range.selectNode(node); return range.getClientRects().length; }));
    }))]""")
    held = int(re.search(r"\((\d+)\)", page.text("#tabs [aria-selected=true]"))[1])
    assert rows == held and wide <= 1046 and high == 1, (rows, wide, high)
    driver.execute_script("window.dispatchEvent(new Event('afterprint'))")
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert driver.execute_script("return document.querySelectorAll('#sheet tbody tr').length") <= 100


def check_coarse(page):
    """A large network that is drawn slowly moves as a coarser picture of the same view."""
    if len(page.edges) < 10_000:
        return
    page.rest()
    moving = """const c = document.getElementById('canvas'), done = arguments[0], box = c.getBoundingClientRect(); c.setPointerCapture = () => {};
      const at = (kind, x) => c.dispatchEvent(new PointerEvent(kind, {clientX: box.left + x, clientY: box.top + 90, pointerId: 1, buttons: 1, bubbles: true, pointerType: 'mouse'}));
      at('pointerdown', 90); at('pointermove', 96); requestAnimationFrame(() => requestAnimationFrame(() => { const seen = c.toDataURL(); at('pointerup', 96); done(seen); }));"""
    seen = page.driver.execute_async_script(moving)
    page.rest()
    ink = """const done = arguments[1], image = new Image(); image.onload = () => { const t = document.createElement('canvas'); [t.width, t.height] = [image.width, image.height];
      const k = t.getContext('2d'); k.drawImage(image, 0, 0); const p = k.getImageData(0, 0, t.width, t.height).data; let n = 0; for (let i = 0; i < p.length; i += 4) n += p[i] < 250 || p[i + 1] < 250; done(n / p.length * 4); }; image.src = arguments[0];"""
    coarse, fine = (page.driver.execute_async_script(ink, picture) for picture in (seen, page.picture()))
    assert seen != page.picture() and fine / 2 < coarse < 2 * fine, (coarse, fine)


def check_walk(page):
    """Cards show their pictures. The subjects come one after the other; what is decided on them is kept over a reload, and saved as one archive."""
    driver = page.driver
    driver.execute_script("document.querySelector('#cards').scrollIntoView()")
    WebDriverWait(driver, 30).until(lambda d: d.execute_script("return [...document.querySelectorAll('.card img')].every(i => i.naturalWidth > 0)"))
    subjects = [row["subject"] for row in csv.DictReader(open(page.folder / "cohort.csv"))]
    assert len(driver.execute_script("return [...document.querySelectorAll('.card img')]")) == len(subjects)
    page.click("#walk-begin")
    count = lambda: driver.execute_script("return document.getElementById('walk-note').textContent")
    WebDriverWait(driver, 60).until(lambda d: count().startswith("0 decisions"))
    driver.switch_to.frame("walk-page")
    for _ in range(20):
        # Of a part that nothing connects it is asked where it goes on, which is no choice between two.
        ActionChains(driver).send_keys("n").perform()
        if not driver.execute_script("return document.getElementById('decide').hidden"):
            break
    ActionChains(driver).send_keys("a").perform()
    driver.switch_to.default_content()
    assert count().startswith("1 decision,"), count()
    first = page.text("#walk-heading").split(",")[0]
    page.click("#walk-on")
    WebDriverWait(driver, 60).until(lambda d: count().startswith("0 decisions") and page.text("#walk-heading").split(",")[0] != first)
    page.open()
    assert "1 decision on 1 subject" in page.text("#walk-sum"), page.text("#walk-sum")
    with tempfile.TemporaryDirectory() as downloads:
        driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": downloads})
        page.click("#walk-save")
        target = Path(downloads) / "decisions.zip"
        for _ in range(100):
            if target.exists() and target.stat().st_size:
                break
            time.sleep(0.1)
        archive = zipfile.ZipFile(target)
        assert archive.testzip() is None and sorted(archive.namelist()) == sorted(f"{name}-decisions.csv" for name in subjects)
        rows = {name: list(csv.DictReader(archive.read(f"{name}-decisions.csv").decode().splitlines())) for name in subjects}
    assert {name: len(list_) for name, list_ in rows.items()} == {name: int(name == first) for name in subjects}
    assert rows[first][0]["decision"] == "accept"
    driver.execute_script("localStorage.clear()")
    page.no_error()
