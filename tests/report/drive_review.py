"""What a person does with the page of a run: the list, flying, deciding, the download and its replay, tooltips; and axe-core's faults."""

import csv
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import networkx as nx
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys


def kept_graph(page, but=None):
    """What is kept, with lengths; with NetworkX, from edges.csv alone."""
    kept = nx.MultiGraph()
    kept.add_nodes_from(range(len(page.nodes)))
    for at, e in enumerate(page.edges):
        if at != but and (not page.is_uncertain(e) or e["kept"] == "1"):
            kept.add_edge(int(e["node_a"]), int(e["node_b"]), length=float(e["length_mm"]))
    return kept


def part_length(kept, node):
    return sum(d["length"] for *_, d in kept.subgraph(nx.node_connected_component(kept, node)).edges(data=True))


def consequence(page, row):
    """The chance that a decision is wrong times the length of what hangs on it."""
    kept, edge = kept_graph(page, but=row), page.edges[row]
    a, b = int(edge["node_a"]), int(edge["node_b"])
    hangs = 0 if nx.has_path(kept, a, b) else min(part_length(kept, a), part_length(kept, b))
    p = float(edge["probability"])
    return (1 - p if edge["kept"] == "1" else p) * (hangs + float(edge["length_mm"]))


def check_list(page):
    """The list asks what review.csv does, what a right answer puts right most first: the undecided at least, and a part that nothing connects by its length."""
    listed = page.listed()
    undecided = page.record["convergence"]["undecided_edges"]
    loops = {row: nx.has_path(kept_graph(page, but=row), *(int(page.edges[row][end]) for end in ("node_a", "node_b"))) for row in listed[:8]}
    for row in listed[:8]:
        said = page.text(f"#review-list li[data-row='{row}'] small")
        # Whatever is uncertain is decided in the list; where a vessel goes on is asked of certain ones alone. A loop is one by NetworkX.
        decides = page.driver.execute_script("return Boolean(document.querySelector(arguments[0]))", f"#review-list li[data-row='{row}'] .choose")
        assert decides == page.is_uncertain(page.edges[row]) and (not decides or "where does it go on?" not in said), (row, said)
        assert "closes a loop" not in said or loops[row], (row, said)
    if page.edges[0]["probability"] == "" and not any(e["probability"] for e in page.edges):
        # At most fifty are listed.
        assert set(listed) <= set(undecided) and len(listed) == min(len(undecided), 50), (listed, undecided)
        return
    asked = list(csv.DictReader(open(page.folder / "review.csv")))
    assert [int(q["edge"]) for q in asked[:50]] == listed and [int(q["rank"]) for q in asked] == list(range(1, len(asked) + 1)), (asked, listed)
    assert set(undecided) <= {int(q["edge"]) for q in asked}
    # The list and the rings of the picture have these numbers.
    ranks = page.driver.execute_script("return [...document.querySelectorAll('#review-list .rank')].map(rank => Number(rank.textContent))")
    assert ranks == [int(q["rank"]) for q in asked[:50]], ranks
    if (page.folder / "summary.svg").exists():
        said = [text.text for text in ElementTree.parse(page.folder / "summary.svg").iter("{http://www.w3.org/2000/svg}text")]
        assert all(said.count(str(rank)) >= 2 for rank in ranks[:30]) and str(len(ranks[:30]) + 1) not in said, said
    assert f"{len(asked)} question{'' if len(asked) == 1 else 's'} for a person" in page.text("#answer-words"), page.text("#answer-words")
    kept = kept_graph(page)
    for q in asked[:50]:
        edge, gain = page.edges[int(q["edge"])], float(q["gain_mm"])
        if q["kind"] == "part":
            assert any(abs(part_length(kept, int(edge[end])) - gain) <= 1e-6 * gain for end in ("node_a", "node_b")), q
        elif q["kind"] == "touch":
            assert abs((1 - float(q["probability"])) * float(q["hangs_mm"]) - gain) < 1e-6 * gain, q
        elif q["kind"] == "loop":
            # The shortest way round through it.
            ends, length = (int(edge["node_a"]), int(edge["node_b"])), float(edge["length_mm"])
            way = nx.shortest_path_length(kept_graph(page, but=int(q["edge"])), *ends, weight="length")
            assert abs(way - float(q["hangs_mm"])) < 1e-6 * way and abs((1 - float(edge["probability"])) * (way + length) - gain) < 1e-6 * gain, (q, way)
        else:
            assert abs(consequence(page, int(q["edge"])) - gain) <= 1e-6 * (1 + gain), q
    gains = [float(q["gain_mm"]) for q in asked]
    assert gains == sorted(gains, reverse=True)


def check_flight(page):
    """A click flies there, puts a ring around it, and shows the alternatives with their probabilities."""
    rows = [row for row in page.listed() if page.is_uncertain(page.edges[row])]
    before = page.picture()
    page.click(f"#review-list li[data-row='{rows[0]}'] .go")
    page.rest()
    assert page.picture() != before and page.is_picked(rows[0]), page.text("#picked h3")
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


def state(page, row):
    """What the list says of a connection: its figure, or what was decided."""
    return page.text(f"#review-list li[data-row='{row}'] .chance")


def says(page, row, p):
    """Whether the list says this probability of a connection."""
    said = state(page, row).removeprefix("P").removeprefix(" = ").strip()
    return said[0] in "<>" or abs(float(said) - p) <= 0.005


def expects(page, record):
    """Whether the page expects the errors that run.json does."""
    about = lambda x: "none" if x < 0.05 else f"about {float(f'{x:.{1 if x < 1 else 2}g}'):g}"
    wrong, missed = (record["expected_errors"][name] for name in ("wrong", "missed"))
    return f"{about(wrong)} expected to be wrong, {about(missed)} missed" in page.text("#answer-words")


def check_replayed(page, folder, listed, start):
    """The page of a run with decisions says what that run does; where they are taken back, what the run without them does."""
    new = type(page)(page.driver, folder)
    decided = {row: d["decision"] for row, d in listed.items() if d["decision"] != "unsure"}
    others = lambda: [row for row in new.listed() if row not in listed and page.is_uncertain(page.edges[row])]
    assert all(says(new, row, float(new.edges[row]["probability"])) for row in others()) and expects(new, new.record)
    found = new.record["counts"]["topology"]
    assert new.counts()["undecided"] == new.record["convergence"]["undecided"] and new.counts()["components"] == found["components"]
    for row, decision in decided.items():
        new.click(f"#review-list li[data-row='{row}'] .{decision}")
    assert all(says(new, row, float(page.edges[row]["probability"])) for row in others()) and expects(new, page.record)
    assert new.counts() == start, (new.counts(), start)
    while new.one("#undo").is_enabled():
        new.click("#undo")
    new.no_error()
    page.open()
    page.click("#threshold summary")


def go(page, row):
    page.click(f"#review-list li[data-row='{row}'] .go")
    page.rest()


def check_decisions(page, downloads):
    """Accept, undo, reject, by mouse and by key; counts follow and survive a reload; the downloaded list is replayed to the same counts,
    loaded again, and refused on another graph."""
    driver = page.driver
    open_rows = page.record["convergence"]["undecided_edges"]
    listed, start = page.listed(), page.counts()
    rows = [row for row in listed if row in open_rows]
    sentence = page.text("#answer-words")
    canvas = page.one("#canvas")
    go(page, rows[0])
    beside = driver.execute_script("return document.querySelectorAll('.alternatives tbody tr').length") - 1
    canvas.send_keys("a")
    now, was = page.counts(), page.edges[rows[0]]["kept"] == "1"
    # Others follow: of those beside it each may have come into doubt.
    assert now["undecided"] < start["undecided"] + beside, (start, now, beside)
    assert page.text("#answer-words") != sentence and "1 decided by a person" in page.text("#answer-words")
    assert state(page, rows[0]) == "accepted"
    assert page.one(f"#review-list li[data-row='{rows[0]}'] .accept").get_attribute("aria-pressed") == "true"
    assert page.one(f"#review-list li[data-row='{rows[0]}'] .reject").get_attribute("aria-pressed") == "false"
    # The page goes on to the next that is open, and never stops at one that is decided.
    page.rest()
    left = page.listed()[:-1]
    assert rows[0] not in left and (not left or page.picked() == left[0]), (left, page.picked())
    for _ in range(min(len(left), 4)):
        canvas.send_keys("n")
        assert page.picked() != rows[0]
    # Beside what was accepted nothing is kept that says P < .001.
    go(page, rows[0])
    for line in driver.execute_script("return [...document.querySelectorAll('.alternatives tbody tr')].map(line => [...line.children].map(cell => cell.textContent))"):
        assert not (line[1] == "< .001" and line[-1].startswith("kept")), line
    # Letters decide nothing while a table has the focus, a field, or while they are turned off.
    held = page.counts()
    driver.execute_script("document.querySelector('#sheet th button').focus()")
    ActionChains(driver).send_keys("r").perform()
    assert page.counts() == held
    page.one("#comment").send_keys("raw", Keys.TAB)
    assert page.counts() == held and driver.execute_script("return document.getElementById('comment').value") == "raw"
    driver.execute_script("document.getElementById('letters').click()")
    canvas.send_keys("u")
    assert page.counts() == held
    driver.execute_script("document.getElementById('letters').click()")
    canvas.send_keys("u")
    canvas.send_keys("u")
    assert page.counts() == start and page.text("#answer-words") == sentence and page.listed() == listed
    page.click(f"#review-list li[data-row='{rows[0]}'] .accept")
    page.click(f"#review-list li[data-row='{rows[-1]}'] .reject")
    unsure = next((row for row in page.listed() if row not in (rows[0], rows[-1]) and page.is_uncertain(page.edges[row])), None)
    if unsure is not None:
        go(page, unsure)
        page.click("#decide .unsure")
        assert state(page, unsure) == "unsure"
        # What the reader is unsure of is open no more.
        left = driver.execute_script("return document.querySelectorAll('#review-list li:not(.accept, .reject, .unsure)').length")
        assert not left or page.text("#review-note").startswith(f"{left} open"), (left, page.text("#review-note"))
    after, errors = page.counts(), page.text("#answer-words")
    # A reload keeps decisions and what can be taken back.
    page.open()
    page.click("#threshold summary")
    assert page.counts() == after and page.text("#answer-words") == errors and state(page, rows[0]) == "accepted"
    page.click("#undo")
    assert unsure is None or state(page, unsure) != "unsure"
    if unsure is not None:
        go(page, unsure)
        page.click("#decide .unsure")
        assert page.counts() == after
    else:
        page.click(f"#review-list li[data-row='{rows[-1]}'] .reject")
    page.one("#who").clear()
    page.one("#who").send_keys('A. "Reader", MD')
    page.click(f"#review-list li[data-row='{rows[0]}'] .accept")
    page.click(f"#review-list li[data-row='{rows[0]}'] .accept")
    target = save(page, downloads)
    listed = {int(d["edge"]): d for d in csv.DictReader(open(target))}
    assert {row: d["decision"] for row, d in listed.items()} == {rows[0]: "accept", rows[-1]: "reject"} | ({} if unsure is None else {unsure: "unsure"}), listed
    assert listed[rows[0]]["who"] == 'A. "Reader", MD'
    assert all(d["when"].endswith("Z") and d["input_sha256"] == page.record["input"]["sha256"] for d in listed.values())
    command, replayed = page.record["command"].split(), f"{page.folder.name}-replayed"
    replay = lambda *more: subprocess.run(
        [os.environ["WILLIS_BINARY"], *command[1 : command.index("-o")], *more, "-o", replayed, "-q", "--force"],
        cwd=page.folder.parent, capture_output=True, text=True)
    done = replay("--decisions", str(target))
    assert done.returncode == 0, done.stderr
    again = list(csv.DictReader(open(page.folder.parent / replayed / "edges.csv")))
    assert again[rows[0]]["kept"] == "1" and float(again[rows[0]]["probability"]) == 1
    assert again[rows[-1]]["kept"] == "0" and float(again[rows[-1]]["probability"]) == 0 and float(again[rows[-1]]["likelihood"]) == 0
    # What the page says is what the run says: of each that is listed, and in all.
    for row in (row for row in set(page.listed()) - set(listed) if page.is_uncertain(page.edges[row])):
        assert says(page, row, float(again[row]["probability"])), (row, state(page, row), again[row])
    record = json.load(open(page.folder.parent / replayed / "run.json"))
    found, after = record["counts"]["topology"], page.counts()
    assert (after["components"], after["cycles"]) == (found["components"], found["cycles"]), (after, found)
    kept = sum(page.is_uncertain(e) and e["kept"] == "1" for e in again)
    assert (after["kept"], after["undecided"]) == (kept, record["convergence"]["undecided"]), (after, kept)
    assert expects(page, record), (record["expected_errors"], page.text("#answer-words"))
    check_replayed(page, page.folder.parent / replayed, listed, start)
    # Without places it is a list for rows of this graph alone.
    bare = Path(downloads) / "bare.csv"
    with open(bare, "w", newline="") as file:
        out = csv.DictWriter(file, [name for name in listed[rows[0]] if name != "places"], extrasaction="ignore")
        out.writeheader()
        out.writerows(listed.values())
    refused = replay("--decisions", str(bare), "-k", "2")
    assert refused.returncode == 2 and "bare.csv:2: edge" in refused.stderr, refused.stderr
    # The list is loaded again where nothing was decided; with a fault nothing is.
    while page.one("#undo").is_enabled() and page.one("#undo").is_displayed():
        page.click("#undo")
    assert page.counts() == start
    spoiled = Path(downloads) / "spoiled.csv"
    of_all = target.read_text()
    for text, word in [(of_all.replace(",reject,", ",perhaps,"), "perhaps"), (of_all + of_all.splitlines()[1] + "\n", "comes again")]:
        spoiled.write_text(text)
        page.one("#load").send_keys(str(spoiled))
        page.settle()
        assert word in page.text("#load-note") and page.counts() == start, page.text("#load-note")
    page.one("#load").send_keys(str(target))
    page.settle()
    assert page.counts() == after and state(page, rows[0]) == "accepted", page.text("#load-note")
    assert list(csv.DictReader(open(save(page, downloads)))) == list(listed.values())
    check_small(page)
    driver.execute_script("localStorage.clear()")


def check_edits(page, downloads):
    """A missing vessel by typed places, and a place by a click; kept over a reload, saved, made by the replay, and taken back."""
    driver = page.driver
    page.open()
    page.click("#edits summary")
    candidate = next(e for e in page.edges if e["origin"] == "candidate")
    place = lambda node: " ".join(page.nodes[int(node)][axis] for axis in ("x_mm", "y_mm", "z_mm"))
    places = f"{place(candidate['node_a'])} + {place(candidate['node_b'])}"
    assert not page.one("#edit-add").is_enabled()
    page.one("#edit-places").send_keys("1 2 +")
    assert not page.one("#edit-add").is_enabled() and "three numbers" in page.text("#edit-guide")
    page.click("#edit-clear")
    page.one("#edit-places").send_keys(places)
    page.click("#edit-add")
    assert "join" in page.text("#edit-list").lower() and page.one("#edit-places").get_property("value") == ""
    # A click in the view is a place on a vessel.
    driver.execute_script("document.querySelector('[data-view=fit]').click(); document.getElementById('view').scrollIntoView({block: 'center'})")
    page.rest()
    canvas, taken = page.one("#canvas"), ""
    for step in range(300):
        x, y = (step * 0.618) % 1 - 0.5, (step * 0.755) % 1 - 0.5
        ActionChains(driver, duration=0).move_to_element_with_offset(canvas, int(0.9 * x * canvas.size["width"]), int(0.9 * y * canvas.size["height"])).click().perform()
        taken = page.one("#edit-places").get_property("value")
        if taken:
            break
    points = [list(map(float, point.split()[:3])) for *_, d in nx.read_graphml(page.folder / "candidates.graphml").edges(data=True) for point in d.get("points", "").split(";") if point.strip()]
    points += [[float(node[axis]) for axis in ("x_mm", "y_mm", "z_mm")] for node in page.nodes]
    at = list(map(float, taken.split()))
    assert len(at) == 3 and min(sum((a - b) ** 2 for a, b in zip(at, point)) for point in points) < 20**2, taken
    page.click("#edit-clear")
    page.open()
    page.click("#threshold summary")
    page.click("#edits summary")
    assert "join" in page.text("#edit-list").lower()
    target = save(page, downloads)
    *_, edit = csv.DictReader(open(target))
    assert (edit["decision"], edit["places"].strip(), edit["edge"]) == ("join", places, ""), edit
    command, edited = page.record["command"].split(), f"{page.folder.name}-edited"
    done = subprocess.run([os.environ["WILLIS_BINARY"], *command[1 : command.index("-o")], "--decisions", str(target), "-o", edited, "-q", "--force"],
        cwd=page.folder.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *before, made = csv.DictReader(open(page.folder.parent / edited / "edges.csv"))
    assert len(before) == len(page.edges) and (made["kept"], float(made["probability"])) == ("1", 1), made
    page.click("#undo")
    assert page.text("#edit-list") == ""
    driver.execute_script("localStorage.clear()")


def check_pairings(page, downloads):
    """Ways to pair vessels where a contact is: one click decides its contacts or makes an edit, another way takes its place, and the replay has it."""
    table = page.folder / "pairings.csv"
    ways = [way for way in csv.DictReader(open(table)) if way["contacts"]] if table.exists() else []
    contacts = next((way["contacts"] for way in ways if way["part"] and int(way["contacts"].split()[0]) in page.listed()), None)
    if contacts is None:
        return
    page.open()
    ways = [way for way in ways if way["contacts"] == contacts]
    rows = list(map(int, contacts.split()))
    go(page, rows[0])
    buttons = lambda: page.driver.find_elements("css selector", ".pairings button")
    assert [button.text for button in buttons()] == [way["vessels"] for way in ways], contacts
    edited = next(at for at, way in enumerate(ways) if way["part"])
    stated = next(at for at, way in enumerate(ways) if way["accept"] or way["reject"])
    for at in (edited, stated, edited):
        buttons()[at].click()
        go(page, rows[0])
        assert [button.get_attribute("aria-pressed") == "true" for button in buttons()] == [n == at for n in range(len(ways))]
        made = {int(d["edge"]) if d["edge"] else d["places"].strip(): d["decision"] for d in csv.DictReader(open(save(page, downloads)))}
        wanted = {row: "unsure" for row in rows} | {ways[at]["part"].strip(): "part"} if ways[at]["part"] else {int(row): name for name in ("accept", "reject") for row in ways[at][name].split()}
        assert made == wanted, (made, wanted)
    page.driver.execute_script("localStorage.clear()")
    page.open()
    check_loaded_pairing(page, downloads)


def check_loaded_pairing(page, downloads):
    """A way that is an edit whose places begin with a minus is known again in a list, where a space stands before it."""
    ways = list(csv.DictReader(open(page.folder / "pairings.csv")))
    way = next((way for way in ways if way["contacts"] and way["part"].startswith(" -")), None)
    if way is None:
        return
    rows = list(map(int, way["contacts"].split()))
    target = Path(downloads) / "paired.csv"
    with open(target, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(["edge", "id_a", "id_b", "decision", "places"])
        for row in rows:
            out.writerow([row, *(page.nodes[int(page.edges[row][end])]["id"] for end in ("node_a", "node_b")), "unsure", ""])
        out.writerow(["", "", "", "part", way["part"]])
    page.one("#load").send_keys(str(target))
    page.settle()
    assert page.text("#load-note").startswith(f"{len(rows) + 1} decisions loaded"), page.text("#load-note")
    go(page, rows[0])
    pressed = [button.text for button in page.driver.find_elements("css selector", ".pairings button") if button.get_attribute("aria-pressed") == "true"]
    assert pressed == [way["vessels"]], (pressed, way)
    page.driver.execute_script("localStorage.clear()")
    page.open()


def arrived(found, seconds):
    """Whether a file is there before so many seconds have passed."""
    deadline = time.monotonic() + seconds
    while not found():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def save(page, downloads):
    """Downloads the decisions, under the name of the input. A browser under load may lose one press."""
    name = Path(page.record["input"]["path"]).name.removesuffix(".gz")
    target = Path(downloads) / f"{Path(name).stem}-decisions.csv"
    target.unlink(missing_ok=True)
    page.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})
    page.driver.execute_script("window.presses = 0; document.getElementById('download').addEventListener('click', () => { window.presses += 1; });")
    for _ in range(2):
        page.click("#download")
        if arrived(lambda: target.exists() and target.stat().st_size, seconds=30):
            return target
    raise AssertionError(f"nothing was downloaded: the page took {page.driver.execute_script('return window.presses')} presses of two, the folder holds {os.listdir(downloads)}")


def check_small(page):
    """On a telephone what decides stands under the view, in sight, and is large enough for a finger."""
    driver, size = page.driver, dict(width=390, height=844, deviceScaleFactor=1, mobile=True)
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    go(page, page.listed()[-1])
    page.settle()
    for box in driver.execute_script("return [...document.querySelectorAll('#decide button')].map(b => { const r = b.getBoundingClientRect(); return [r.width, r.height, r.top, r.bottom]; })"):
        assert box[0] >= 44 and box[1] >= 44 and 0 <= box[2] and box[3] <= size["height"], box
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


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
    assert arrived(found, seconds=30), "no picture was saved"
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


def review(page, only_decisions=False):
    """All of it, on the page of a run with evidence; or what a rule decides of it: the list, and what follows a decision."""
    check_list(page)
    if not page.listed():
        return
    with tempfile.TemporaryDirectory() as downloads:
        if not only_decisions:
            check_flight(page)
            check_tooltip(page)
            check_picture(page, downloads)
            check_pairings(page, downloads)
        if any(e["probability"] for e in page.edges) and len(page.record["convergence"]["undecided_edges"]) > 1:
            check_decisions(page, downloads)
            if not only_decisions and any(e["origin"] == "candidate" for e in page.edges):
                check_edits(page, downloads)
