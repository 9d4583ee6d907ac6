"""What a person does with the page of a run: the list, flying, deciding, the download and its replay, tooltips; and axe-core's faults."""

import csv
import os
import subprocess
import tempfile
import time
from pathlib import Path

import networkx as nx
from selenium.webdriver.common.action_chains import ActionChains


def consequence(page, row):
    """How doubtful a decision is times the length of what hangs on it, from edges.csv alone; with NetworkX."""
    edges = page.edges
    kept = nx.MultiGraph()
    kept.add_nodes_from(range(len(page.nodes)))
    for at, e in enumerate(edges):
        if at != row and (not page.is_uncertain(e) or e["kept"] == "1"):
            kept.add_edge(int(e["node_a"]), int(e["node_b"]), length=float(e["length_mm"]))
    a, b = int(edges[row]["node_a"]), int(edges[row]["node_b"])
    if nx.has_path(kept, a, b):
        hangs = 0
    else:
        length = lambda node: sum(d["length"] for *_, d in kept.subgraph(nx.node_connected_component(kept, node)).edges(data=True))
        hangs = min(length(a), length(b))
    p = float(edges[row]["probability"])
    return 4 * p * (1 - p) * (hangs + float(edges[row]["length_mm"]))


def check_list(page):
    """The list has the undecided ones, those of the largest consequence first."""
    listed = page.listed()
    undecided = page.record["convergence"]["undecided_edges"]
    # At most fifty are listed.
    assert set(listed) <= set(undecided) and len(listed) == min(len(undecided), 50), (listed, undecided)
    if page.edges[0]["probability"] == "" and not any(e["probability"] for e in page.edges):
        return
    weights = [consequence(page, row) for row in listed]
    assert all(a >= b * (1 - 1e-5) for a, b in zip(weights, weights[1:])), weights


def check_flight(page):
    """A click flies there, puts a ring around it, and shows the alternatives with their probabilities."""
    rows = page.listed()
    before = page.picture()
    page.click(f"#review-list li[data-row='{rows[0]}'] .go")
    page.rest()
    assert page.picture() != before and page.text("#picked h3").startswith(page.kind(rows[0])), page.text("#picked h3")
    ring = """const c = document.getElementById('overlay'), k = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
      for (let i = 0; i < k.length; i += 4) if (k[i] > 190 && k[i + 1] < 40 && k[i + 2] < 70 && k[i + 3] > 200) return true; return false"""
    assert page.driver.execute_script(ring), "no ring"
    degree = {}
    for e in page.edges:
        if e["origin"] == "observed":
            for end in (e["node_a"], e["node_b"]):
                degree[end] = degree.get(end, 0) + 1
    free = {end for end in (page.edges[rows[0]]["node_a"], page.edges[rows[0]]["node_b"]) if degree.get(end, 0) <= 1}
    rivals = [at for at, e in enumerate(page.edges) if e["origin"] != "observed" and at != rows[0] and free & {e["node_a"], e["node_b"]}]
    shown = page.driver.execute_script("return [...document.querySelectorAll('.alternatives tbody tr')].length")
    assert shown == min(len(rivals) + 1, 12), (shown, rivals)


def check_decisions(page, downloads):
    """Accept, undo, reject, by mouse and by key; counts follow; the downloaded list is replayed, and refused on another graph."""
    rows, start = page.listed(), page.counts()
    sentence = page.text("#answer-words")
    canvas = page.one("#canvas")
    page.click(f"#review-list li[data-row='{rows[0]}'] .go")
    page.rest()
    hook = "const of = CanvasRenderingContext2D.prototype, fill = of.fillText; window.written = []; of.fillText = function (text, ...where) { written.push(text); fill.call(this, text, ...where); }; return null"
    page.driver.execute_script(hook)
    canvas.send_keys("a")
    now, was = page.counts(), page.edges[rows[0]]["kept"] == "1"
    assert now["undecided"] == start["undecided"] - 1 and now["kept"] == start["kept"] + (not was), (start, now)
    assert page.text("#answer-words") != sentence and "1 decided by a person" in page.text("#answer-words")
    # The list and the figure in the view follow the decision.
    assert page.text(f"#review-list li[data-row='{rows[0]}'] .chance") == "accepted"
    page.rest()
    beside = page.driver.execute_script("return window.written")
    assert any(text.endswith("P > .999") for text in beside), beside
    canvas.send_keys("u")
    assert page.counts() == start and page.text("#answer-words") == sentence
    page.click(f"#review-list li[data-row='{rows[0]}'] .accept")
    page.click(f"#review-list li[data-row='{rows[-1]}'] .reject")
    after = page.counts()
    kept_last = page.edges[rows[-1]]["kept"] == "1"
    assert after["kept"] == start["kept"] + (not was) - kept_last and after["undecided"] <= start["undecided"] - 2
    page.one("#who").send_keys('A. "Reader", MD')
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})
    target = Path(downloads) / "decisions.csv"
    page.click("#download")
    for _ in range(100):
        if target.exists() and target.stat().st_size:
            break
        time.sleep(0.1)
    listed = list(csv.DictReader(open(target)))
    assert [(int(d["edge"]), d["decision"]) for d in listed] == sorted([(rows[0], "accept"), (rows[-1], "reject")]), listed
    assert all(d["who"] == 'A. "Reader", MD' and d["when"].endswith("Z") and d["input_sha256"] == page.record["input"]["sha256"] for d in listed)
    command = page.record["command"].split()
    replay = lambda *more: subprocess.run(
        [os.environ["WILLIS_BINARY"], *command[1 : command.index("-o")], *more, "-o", "replayed", "-q", "--force"],
        cwd=page.folder.parent, capture_output=True, text=True)
    done = replay("--decisions", str(target))
    assert done.returncode == 0, done.stderr
    again = list(csv.DictReader(open(page.folder.parent / "replayed/edges.csv")))
    assert again[rows[0]]["kept"] == "1" and float(again[rows[0]]["probability"]) == 1
    assert again[rows[-1]]["kept"] == "0" and float(again[rows[-1]]["probability"]) == 0 and float(again[rows[-1]]["likelihood"]) == 0
    # What the page says of the others is what the run says.
    for row in rows[1:-1]:
        said = page.text(f"#review-list li[data-row='{row}'] .chance").removeprefix("P").removeprefix(" = ").strip()
        p = float(again[row]["probability"])
        assert said[0] in "<>" or abs(float(said) - p) <= 0.005, (row, said, p)
    refused = replay("--decisions", str(target), "-k", "2")
    assert refused.returncode == 2 and "decisions.csv:2: edge" in refused.stderr, refused.stderr
    target.unlink()


def check_tooltip(page):
    """The pointer over a vessel says what it is."""
    page.driver.execute_script("document.querySelector('[data-view=fit]').click(); document.getElementById('view').scrollIntoView({block: 'center'})")
    page.rest()
    canvas = page.one("#canvas")
    size = canvas.size
    for step in range(300):
        x, y = (step * 0.618) % 1 - 0.5, (step * 0.755) % 1 - 0.5
        ActionChains(page.driver, duration=0).move_to_element_with_offset(canvas, int(0.9 * x * size["width"]), int(0.9 * y * size["height"])).perform()
        page.settle()
        if page.one("#tooltip").is_displayed():
            assert "essel" in page.text("#tooltip") or "(" in page.text("#tooltip")
            return
    raise AssertionError("no tooltip")


def check_picture(page, downloads):
    """The saved picture is twice as fine as the view, and has the name of the input."""
    name = Path(page.record["input"]["path"]).name.removesuffix(".gz")
    found = lambda: [path for path in Path(downloads).glob(f"{Path(name).stem}*.png") if path.stat().st_size]
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})
    page.click("#picture")
    for _ in range(100):
        if found():
            break
        time.sleep(0.1)
    [target] = found()
    wide = int.from_bytes(target.read_bytes()[16:20], "big")
    assert wide == 2 * page.driver.execute_script("return document.getElementById('canvas').clientWidth")
    target.unlink()


def check_access(page):
    """axe-core finds no serious fault, where WILLIS_AXE names its script."""
    script = os.environ.get("WILLIS_AXE")
    if not script:
        print("skipped: WILLIS_AXE names no axe.min.js")
        return
    page.driver.execute_script("for (const d of document.querySelectorAll('details')) d.open = true;")
    page.driver.execute_script(Path(script).read_text())
    found = page.driver.execute_async_script("const done = arguments[0]; axe.run().then(r => done(r.violations));")
    bad = [(v["id"], v["impact"], [n["target"] for n in v["nodes"]][:3]) for v in found if v["impact"] in ("serious", "critical")]
    assert not bad, bad


def review(page):
    """All of it, on the page of a run with evidence."""
    check_list(page)
    if not page.listed():
        return
    with tempfile.TemporaryDirectory() as downloads:
        check_flight(page)
        check_tooltip(page)
        check_picture(page, downloads)
        if any(e["probability"] for e in page.edges) and len(page.listed()) > 1:
            check_decisions(page, downloads)
