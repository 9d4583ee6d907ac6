"""Opens pages of willis in headless Chromium and works them as a reader does.

Usage: drive.py CHROMIUM FOLDER...   Counts are worked out again from edges.csv with NetworkX.
"""

import csv
import json
import math
import re
import shutil
import sys
import tempfile
import time
from pathlib import Path

import networkx as nx
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from drive_review import check_access, review
from drive_surface import check_cube, check_slices, check_surface
from drive_words import check_classified, check_coarse, check_figures, check_names, check_print, check_simulated, check_walk

FLAGS = """--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
--force-prefers-reduced-motion --disable-component-update --disable-sync --disable-dev-shm-usage --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=1280,600""".split()


def browser(chromium, profile, *flags):
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in [*FLAGS, f"--user-data-dir={profile}", *flags]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    beside = Path(chromium).with_name("chromedriver")
    driver = str(beside) if beside.exists() else shutil.which("chromedriver")
    assert driver, "chromedriver is neither beside Chromium nor on the path"
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))


class Page:
    def __init__(self, driver, folder, name="report.html"):
        self.driver, self.folder, self.name = driver, Path(folder).resolve(), name
        self.open()
        rows = lambda name: list(csv.DictReader(open(self.folder / name))) if (self.folder / name).exists() else []
        self.edges, self.nodes = rows("edges.csv"), rows("nodes.csv")
        if not self.edges:
            return
        self.record = json.load(open(self.folder / "run.json"))
        everything = self.record["parameters"].get("uncertain") == "all"
        self.is_uncertain = lambda e: everything or e.get("origin") in ("candidate", "contact")

    def open(self):
        self.driver.get((self.folder / self.name).as_uri())
        WebDriverWait(self.driver, 60).until(lambda d: d.execute_script("return document.documentElement.dataset.ready") == "yes")

    def one(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.driver.execute_script("return document.querySelector(arguments[0]).textContent", selector)

    def number(self, selector):
        return int(self.text(selector).replace("\u202f", ""))

    def kind(self, row):
        """What the page calls a vessel; every one is a vessel, and an uncertain one says what it is."""
        edge = self.edges[row]
        names = {"contact": "Contact", "candidate": "Connection"} if self.is_uncertain(edge) and not edge["label"] else {}
        return f"{names.get(edge['origin'], 'Vessel')} {row}"

    def is_picked(self, row):
        """Whether the vessel is the selected one, by what the page calls it."""
        return self.kind(row).lower() in self.text("#picked h3").lower() and self.picked() == row

    def picked(self):
        return int(re.search(r"(?:vessel|connection|contact) (\d+)", self.text("#picked h3"), re.I)[1])

    def settle(self):
        """Waits until what was asked for is painted."""
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()));")

    def listed(self):
        """The rows of the list of what needs a person."""
        return self.driver.execute_script("return [...document.querySelectorAll('#review-list li')].map(line => Number(line.dataset.row))")

    def rest(self):
        """Waits until a flight has ended: two pictures in a row are the same."""
        still = """const done = arguments[0], frame = requestAnimationFrame; let last, left = 60;
          const look = () => frame(() => frame(() => { const now = document.getElementById('canvas').toDataURL();
            if (now === last || !left) return done(left); last = now; left -= 1; setTimeout(look, 50) })); look()"""
        assert self.driver.execute_async_script(still), "the view does not come to rest"

    def picture(self):
        self.settle()
        return self.driver.execute_script("return document.getElementById('canvas').toDataURL()")

    def counts(self):
        return {name: self.number(f"#count-{name}") for name in ("kept", "pruned", "undecided", "components", "cycles")}

    def slide(self, stop):
        self.driver.execute_script("const s = document.getElementById('slider'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));", stop)

    def threshold(self):
        value = self.one("#number").get_property("value")
        return float(value) if value else None

    def click(self, selector):
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", self.one(selector))
        self.one(selector).click()

    def no_error(self):
        said = [entry for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        assert not said, said
        assert not self.one("#failure").is_displayed()


# Folders whose page differs from another by the rule alone: what the rule decides is checked, and the review.
BY_RULE = ("otsu", "frequency", "all", "probability")

# Where a rule without a threshold turns.
TURNS = {"probable": 0.5, "reconnect": 0.4}


def is_open(page, edge, passes, near):
    """Whether an uncertain vessel is undecided: as run.json says where the rule has no threshold and the decision is that of the run."""
    if page.record["threshold"]["rule"].split("=")[0] in TURNS and passes == (edge["kept"] == "1"):
        return int(edge["edge"]) in page.record["convergence"]["undecided_edges"]
    return near


def recount(page, threshold):
    """Kept, pruned, undecided, components and cycles at a threshold, by the words of the README and run.json."""
    rule = page.record["threshold"]["rule"]
    by_frequency, by_evidence, value = rule.startswith("frequency"), rule.startswith(("prob", "best", "reconnect")), rule.startswith("value")
    uncertain = [e for e in page.edges if page.is_uncertain(e)]
    figure = "frequency" if by_frequency else "probability" if by_evidence else "likelihood"
    passes = lambda e: float(e[figure]) >= threshold if by_frequency or by_evidence else float(e[figure]) > threshold
    kept = [e for e in uncertain if passes(e)]
    graph = nx.MultiGraph()
    graph.add_nodes_from(range(len(page.nodes)))
    graph.add_edges_from((int(e["node_a"]), int(e["node_b"])) for e in kept + [e for e in page.edges if not page.is_uncertain(e)])
    components = nx.number_connected_components(graph)
    positive = [float(e["likelihood"]) for e in uncertain if float(e["likelihood"]) > 0]
    if by_frequency or by_evidence or value:
        flip = threshold
    else:
        below, above = [x for x in positive if x <= threshold], [x for x in positive if x > threshold]
        flip = (max(below) + min(above)) / 2 if below and above else None
    turn = TURNS.get(rule.split("=")[0])
    flip = turn if turn else flip
    n = page.record["parameters"]["samples"]
    error = lambda e: math.sqrt(float(e[figure]) * (1 - float(e[figure])) / n) if by_frequency else float(e["std_error"])
    near = lambda e: page.record["convergence"]["within_probability"] if by_evidence else 2 * error(e)
    undecided = [e for e in uncertain if flip is not None and is_open(page, e, passes(e), not abs(float(e[figure]) - flip) >= near(e))]
    return {
        "kept": len(kept),
        "pruned": len(uncertain) - len(kept),
        "undecided": len(undecided),
        "components": components,
        "cycles": graph.number_of_edges() - len(page.nodes) + components,
    }


def check_threshold(page):
    """At the start the run's own decisions; then five stops of the slider, a typed number, the buttons, the keys."""
    topology = page.record["counts"]["topology"]
    page.click("#threshold summary")
    start = page.counts()
    assert start == {
        **{name: topology[name] for name in ("kept", "pruned", "components", "cycles")},
        "undecided": page.record["convergence"]["undecided"],
    }, (start, topology)
    cut = page.record["threshold"]["value"]
    turn = TURNS.get(page.record["threshold"]["rule"].split("=")[0])
    assert (page.threshold() is None) == (cut is None or turn is not None)
    if page.threshold() is not None:
        # The box shows a threshold of few digits that decides alike.
        assert recount(page, page.threshold()) == start and len(page.one("#number").get_property("value")) <= 12
    assert start["kept"] == sum(page.is_uncertain(e) and e["kept"] == "1" for e in page.edges)
    if turn:
        # The most probable forest has no threshold; what is reconnected is not decided by one figure.
        # What lies near the turn, but for candidates with a far more probable one in their place; and what was left open, or kept below it.
        chance = lambda e: float(e["probability"])
        replaced = lambda e: chance(e) < turn and e.get("instead", "") and chance(page.edges[int(e["instead"])]) - chance(e) >= 0.2
        near = [e for e in page.edges if page.is_uncertain(e) and abs(chance(e) - turn) < 0.2 and not replaced(e)]
        assert len(near) <= start["undecided"] <= len(near) + page.record["counts"]["left_open"] + start["kept"], start
    else:
        assert start == recount(page, cut)
    last, seen = int(page.one("#slider").get_property("max")), set()
    for share in (0, 0.2, 0.45, 0.8, 1):
        page.slide(round(share * last))
        found = page.counts()
        assert found == recount(page, page.threshold()), (share, page.threshold(), found)
        seen.add(found["kept"])
    assert len(seen) == 5, seen
    box = page.one("#number")
    typed = (cut or 0.5) * 0.7
    box.send_keys(Keys.CONTROL + "a")
    box.send_keys(repr(typed), Keys.TAB)
    assert page.threshold() == typed and page.counts() == recount(page, typed)
    slider = page.one("#slider")
    before = page.counts()["kept"]
    slider.send_keys(Keys.ARROW_RIGHT)
    assert page.counts()["kept"] < before and page.counts() == recount(page, page.threshold())
    if page.one("#to-median").is_displayed():
        page.click("#to-median")
        assert page.counts()["kept"] == page.record["counts"]["topology_median"]["kept"]
        assert len(page.one("#number").get_property("value")) <= 12
    page.click("#to-run")
    assert page.counts() == start


def check_toggles(page):
    """Each switch changes the picture; with all off nothing is left but white, and back on all is as before."""
    names = ["kept", "pruned", "undecided", "observed"]
    for dots in ("#markers", "#cuts", "#suggested", "#hull"):
        box = page.one(dots)
        if box.is_displayed() and box.is_selected():
            shown = page.picture()
            page.click(dots)
            assert page.picture() != shown, dots
    last = whole = page.picture()
    for name in names:
        page.click(f"#show-{name}")
        now = page.picture()
        none = page.counts()["undecided"] == 0 if name == "undecided" else name == "observed" and all(map(page.is_uncertain, page.edges))
        assert now != last or none, name
        last = now
    ink = """const c = document.getElementById('canvas'), t = document.createElement('canvas'); [t.width, t.height] = [c.width, c.height];
      const k = t.getContext('2d'); k.drawImage(c, 0, 0); return k.getImageData(0, 0, t.width, t.height).data.some(v => v !== 255)"""
    assert not page.driver.execute_script(ink)
    for name in names:
        page.click(f"#show-{name}")
    assert page.picture() == whole
    # What is pruned and hardly probable is drawn only where it is asked for.
    if page.one("#show-unlikely").is_displayed() and any(0 < float(e["probability"] or 1) < 0.05 and e["kept"] == "0" for e in page.edges):
        page.click("#show-unlikely")
        assert page.picture() != whole
        page.click("#show-unlikely")
        assert page.picture() == whole


def rows(page):
    return page.driver.execute_script(
        "return [...document.querySelectorAll('#sheet tbody tr')].map(line => Number(line.dataset.row))")


def check_table(page):
    """Sorting by likelihood both ways, by mouse and by key; the filter; a page of rows at a time."""
    names = page.driver.execute_script("return [...document.querySelectorAll('#sheet th button')].map(b => b.textContent)")
    at = names.index("likelihood") + 1
    value = lambda row: float(page.edges[row]["likelihood"])
    rising = sorted(range(len(page.edges)), key=lambda row: (value(row), row))
    falling = sorted(range(len(page.edges)), key=lambda row: (-value(row), row))
    page.click(f"#sheet th:nth-child({at}) button")
    assert rows(page) == rising[:100] and page.one(f"#sheet th:nth-child({at})").get_attribute("aria-sort") == "ascending"
    page.one(f"#sheet th:nth-child({at}) button").send_keys(Keys.ENTER)
    assert rows(page) == falling[:100] and page.one(f"#sheet th:nth-child({at})").get_attribute("aria-sort") == "descending"
    if len(page.edges) > 100:
        page.click("button[aria-label='Next page']")
        assert rows(page) == falling[100:200]
    page.one("#filter").send_keys("candidate")
    found = rows(page)
    assert found and all(page.edges[row]["origin"] == "candidate" for row in found)
    page.one("#filter").clear()
    page.one("#filter").send_keys(" ", Keys.BACKSPACE)


def check_picking(page):
    """A row, the keys n, p and Escape, and a click into the view pick a vessel; it stands out and its row is shown."""
    page.click("#sheet th:first-child button")
    plain = page.picture()
    page.click("#sheet tbody tr:nth-child(3) td:nth-child(2)")
    assert page.is_picked(2) and page.picture() != plain, page.text("#picked h3")
    length = page.driver.execute_script("return [...document.querySelectorAll('#picked dt')].find(t => t.textContent === 'length_mm').nextSibling.textContent")
    assert math.isclose(float(length), float(page.edges[2]["length_mm"]), rel_tol=1e-5)
    assert page.one("#sheet tbody tr:nth-child(3)").get_attribute("aria-selected") == "true"
    canvas = page.one("#canvas")
    while page.one("#review-more").is_displayed():
        page.click("#review-more")
    # The list goes on from the vessel that is selected, if it is one of the list; without a list the keys go through all vessels.
    listed = page.listed()
    at = listed.index(2) if 2 in listed else -1
    step = lambda by: listed[(at + by) % len(listed)] if listed else 2 + by
    canvas.send_keys("n")
    assert page.picked() == step(1)
    canvas.send_keys("n")
    assert page.picked() == step(2)
    canvas.send_keys("p")
    assert page.picked() == step(1)
    page.rest()
    turned = page.picture()
    canvas.send_keys(Keys.ARROW_LEFT)
    assert page.picture() != turned
    canvas.send_keys("+")
    canvas.send_keys("0")
    canvas.send_keys(Keys.ESCAPE)
    assert "No vessel" in page.text("#picked")
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", canvas)
    size, picked = canvas.size, None
    for step in range(400):
        x, y = (step * 0.618) % 1 - 0.5, (step * 0.755) % 1 - 0.5
        ActionChains(page.driver, duration=0).move_to_element_with_offset(canvas, int(0.8 * x * size["width"]), int(0.8 * y * size["height"])).click().perform()
        if page.driver.execute_script("return Boolean(document.querySelector('#picked h3'))"):
            picked = page.picked()
            break
    assert picked is not None and 0 <= picked < len(page.edges)
    # A long table shows some of its rows only; the picked one is marked where it is among them.
    script = "const row = document.querySelector(`#sheet tbody tr[data-row='${arguments[0]}']`); return row ? row.ariaSelected : null"
    deadline = time.monotonic() + 20
    while (marked := page.driver.execute_script(script, picked)) not in ("true", None) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert marked in ("true", None), marked
    if len(page.edges) < 1000:
        assert marked == "true"


def check_lead(page):
    """Every page begins with a sentence whose figures are those of run.json; the equal tiles stand with the settings, folded."""
    said, record = page.text("#answer-words"), page.record
    assert said.endswith(".") and not page.one("#facts").is_displayed(), said
    named = page.driver.execute_script("return [...document.querySelectorAll('#facts dt')].map(name => name.textContent)")
    assert named and len({*named}) == len(named), named
    if record.get("counts", {}).get("uncertain") == 0:
        assert said.startswith("There is no possible connection.") and not page.one("#threshold").is_displayed(), said
    inflows = [record.get("total_inflow_mL_per_min"), record.get("total_inflow_mL_per_min_perturbed")]
    if "classes" in record:
        inflows = [part["total_inflow_mL_per_min"] for part in (record["unperturbed"], record["classes"][-1])]
    for inflow in filter(None, inflows):
        assert f"{inflow:.0f}" in said or f"{inflow:.3g}" in said, (inflow, said)


def check_colours(page):
    """Every figure to colour by gives its own picture and a scale."""
    options = page.driver.execute_script("return [...document.querySelectorAll('#colour-by option')].map(o => o.textContent)")
    seen = set()
    for at in range(len(options)):
        page.driver.execute_script("const s = document.getElementById('colour-by'); s.value = arguments[0]; s.dispatchEvent(new Event('change'))", at)
        seen.add(page.picture())
        assert page.text("#colour-ticks"), options[at]
    assert len(seen) > len(options) // 2


def check_labels(page):
    """Labels are text: no script but the two of the page, no message box, the label in a cell as it is."""
    assert page.driver.execute_script("return document.scripts.length") == 2
    cells = page.driver.execute_script("return [...document.querySelectorAll('#sheet td')].map(c => c.textContent)")
    for label in {e["label"] for e in page.edges[:100] if e["label"]}:
        assert label in cells, label


def check_circle(page):
    """Seven segments, each with the state and the probability of phenotype.json; then with a segment unseen and one thin."""
    told = json.loads((page.folder / "phenotype.json").read_text())
    segments = lambda: page.driver.execute_script(
        "return [...document.querySelectorAll('#circle .segment')].map(s => [s.dataset.segment, s.dataset.state, s.querySelector('title').textContent])")
    drawn = segments()
    assert sorted(name for name, _, _ in drawn) == ["AComm", "L-A1", "L-P1", "L-PComm", "R-A1", "R-P1", "R-PComm"]
    for name, state, title in drawn:
        assert (state == "present") == told["segments"][name], (name, state)
        if "probabilities" in told:
            p = told["probabilities"]["segments"][name]
            said = title.split("P = ")[1].split(",")[0]
            assert (said == "> .999" and p > 0.999) or (said == "< .001" and p < 0.001) or abs(float(said) - p) <= 0.005, (title, p)
    assert told["words"].lower() in page.text("#circle-words").lower()
    for variant in told.get("probabilities", {}).get("variants", [])[1:3]:
        assert variant["words"] in page.text("#circle-words")
    path = page.folder / "states.html"
    start, rest = (page.folder / "report.html").read_text().split('id="data">', 1)
    held, end = rest.split("</script", 1)
    held = json.loads(held)
    lists = held["phenotype"].get("probabilities", held["phenotype"])
    lists |= {"not_seen": ["L-A1"], "hypoplastic": ["R-P1"], "impossible": ["L-PComm"]}
    held["phenotype"]["segments"].update({"L-A1": True, "R-P1": True, "L-PComm": False})
    path.write_text(start + 'id="data">' + json.dumps(held).replace("<", "\\u003c") + "</script" + end)
    page.driver.get(path.as_uri())
    states = {name: state for name, state, _ in segments()}
    assert states["L-A1"] == "not seen" and states["R-P1"] == "hypoplastic" and states["L-PComm"] == "no candidate", states
    page.no_error()


def check_cohort(page):
    """A name opens the page of a subject, a variant its circle; the choice of a variant filters the table."""
    subjects = list(csv.DictReader(open(page.folder / "cohort.csv")))
    links = page.driver.execute_script("return [...document.querySelectorAll('#sheet a')].map(a => a.getAttribute('href'))")
    for subject in subjects:
        at = f"{subject['subject']}/report.html"
        way = f"{at}?from=..%2Fcohort.html"
        assert (page.folder / at).is_file() and way in links and f"{way}#circle" in links, links
    variants = [subject["variant"] for subject in subjects]
    for variant in {*variants}:
        page.driver.execute_script("const s = document.getElementById('variant'); s.value = arguments[0]; s.dispatchEvent(new Event('change'))", variant)
        assert len(page.driver.find_elements(By.CSS_SELECTOR, "#sheet tbody tr")) == variants.count(variant)
    page.no_error()


def check_comparison(page):
    """A panel for each measure, the most different first, with a point for each subject that has it; p and n as in comparison.csv."""
    rows = list(csv.DictReader(open(page.folder / "comparison.csv")))
    while page.one("#more-cards").is_displayed():
        page.click("#more-cards")
    cards = page.driver.execute_script(
        "return [...document.querySelectorAll('.card')].map(c => [c.querySelector('h3').textContent, c.querySelectorAll('.point.a').length,"
        " c.querySelectorAll('.point.b').length, c.textContent, c.querySelectorAll('.median').length])"
    )
    assert len(cards) == len(rows) > 10
    of = {row["measure"]: row for row in rows}
    assert [float(of[card[0]]["p_holm"]) for card in cards] == sorted(float(row["p_holm"]) for row in rows)
    for name, a, b, text, medians in cards:
        assert (a, b, medians) == (int(of[name]["n_a"]), int(of[name]["n_b"]), 2), (name, a, b)
        assert f"{of[name]['group_b']}: n {b}, median" in text, text
    page.no_error()


def main():
    chromium, folders = sys.argv[1], sys.argv[2:]
    with tempfile.TemporaryDirectory() as profile:
        driver = browser(chromium, profile)
        try:
            for folder in folders:
                if (Path(folder) / "cohort.csv").exists():
                    page = Page(driver, folder, "cohort.html")
                    check_access(page)
                    check_cohort(page)
                    check_walk(page)
                    print(folder, "holds")
                    continue
                page = Page(driver, folder)
                if folder not in BY_RULE:
                    check_access(page)
                    check_figures(page)
                    page = Page(driver, folder)
                if (Path(folder) / "comparison.csv").exists():
                    check_comparison(page)
                    print(folder, "holds")
                    continue
                if not page.edges:
                    check_circle(page)
                    check_classified(page)
                    print(folder, "holds")
                    continue
                check_labels(page)
                check_lead(page)
                if page.one("#threshold").is_displayed():
                    check_threshold(page)
                if folder not in BY_RULE:
                    if page.one("#threshold").is_displayed():
                        check_toggles(page)
                        check_table(page)
                        check_picking(page)
                    check_colours(page)
                    check_simulated(page)
                    check_names(page)
                    check_coarse(page)
                    check_print(page)
                if page.record["parameters"].get("image"):
                    check_cube(page)
                if page.one("#hull").is_displayed():
                    check_surface(page)
                    check_slices(page)
                if page.one("#threshold").is_displayed() and page.one("#review").is_displayed() and len(page.edges) < 1000:
                    page = Page(driver, folder)
                    page.click("#threshold summary")
                    # Flights are flown on one page; on the others the view goes there at once, as for readers who asked for less motion.
                    motion = [{"name": "prefers-reduced-motion", "value": "no-preference"}] if folder == "probable" else []
                    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": motion})
                    review(page, only_decisions=folder in BY_RULE)
                    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
                if (page.folder / "phenotype.json").exists():
                    check_circle(page)
                page.no_error()
                print(folder, "holds")
        finally:
            driver.quit()


if __name__ == "__main__":
    main()
