"""A session with the page of a real mask: thirty connections are decided by keys alone, with reloads in between; a run with the saved list
has the counts that the page showed.

Usage: drive_session.py CHROMIUM FOLDER   The run is made in the folder that holds FOLDER; WILLIS_BINARY names willis.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from drive import Page, browser
from drive_review import save

DECISIONS = 30


def main():
    chromium, folder = sys.argv[1:]
    with tempfile.TemporaryDirectory() as profile, tempfile.TemporaryDirectory() as downloads:
        driver = browser(chromium, profile)
        try:
            page = Page(driver, folder)
            made, taken_back = {}, False
            page.one("#canvas").send_keys("n")
            while len(made) < DECISIONS:
                pass_observed(page)
                row = page.picked()
                assert row not in made, "the page goes on to what is open"
                # A reader would look; this one follows the probability, and is now and then not sure.
                key = "x" if len(made) % 10 == 7 else "a" if float(page.edges[row]["probability"]) >= 0.5 else "r"
                made[row] = {"a": "accept", "r": "reject", "x": "unsure"}[key]
                page.one("#canvas").send_keys(key)
                if len(made) % 10 == 0:
                    before = counts(page)
                    page.open()
                    assert counts(page) == before, (counts(page), before)
                    page.one("#canvas").send_keys("n")
                if len(made) == 15 and not taken_back:
                    taken_back = True
                    page.one("#canvas").send_keys("u")
                    assert made.popitem()[0] == page.picked(), page.text("#picked h3")
            after, words = counts(page), page.text("#answer-words")
            target = save(page, downloads)
            rows = {int(row["edge"]): row["decision"] for row in csv.DictReader(open(target))}
            assert rows == made, (rows, made)
            command = page.record["command"].split()
            done = subprocess.run([os.environ["WILLIS_BINARY"], *command[1 : command.index("-o")], "--decisions", str(target), "-o", "replayed-session", "-q"],
                cwd=page.folder.parent, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            record = json.load(open(page.folder.parent / "replayed-session/run.json"))
            again = list(csv.DictReader(open(page.folder.parent / "replayed-session/edges.csv")))
            found = record["counts"]["topology"]
            sure = {row for row, decision in made.items() if decision != "unsure"}
            assert not sure & set(record["convergence"]["undecided_edges"]), "what is decided is open"
            kept = sum(page.is_uncertain(edge) and edge["kept"] == "1" for edge in again)
            replayed = {"kept": kept, "undecided": record["convergence"]["undecided"], "components": found["components"], "cycles": found["cycles"]}
            assert {name: after[name] for name in replayed} == replayed, (after, replayed, words)
            page.no_error()
            print(f"{len(made)} decisions: {replayed}")
        finally:
            driver.quit()


def pass_observed(page):
    """Goes on to a connection, by the key: where a part goes on that nothing connects is for the view to show. In one go, without a frame for each press."""
    observed = [row for row, edge in enumerate(page.edges) if edge["origin"] == "observed"]
    page.driver.execute_script("""
      const observed = new Set(arguments[0]), picked = () => Number(/(?:vessel|connection|contact) (\\d+)/i.exec(document.querySelector("#picked h3").textContent)[1]);
      while (observed.has(picked())) document.getElementById("canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "n", bubbles: true }));""", observed)


def counts(page):
    return page.driver.execute_script("return Object.fromEntries(['kept', 'pruned', 'undecided', 'components', 'cycles'].map(name => [name, Number(document.getElementById(`count-${name}`).textContent.replace('\\u202f', ''))]))")


if __name__ == "__main__":
    main()
