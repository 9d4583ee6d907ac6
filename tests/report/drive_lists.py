"""Lists that a page saves are lists that it loads, whatever nodes are called; what review.csv asks is on the page where nothing can be decided, too; and groups
without a subject are not said to be alike.

Usage: drive_lists.py CHROMIUM FOLDER...
"""

import csv
import sys
import tempfile
from pathlib import Path

from selenium.webdriver.support.ui import WebDriverWait

from drive import Page, browser
from drive_review import save, state


def check_asked(page):
    """The sentence, the list and its numbers are those of review.csv."""
    asked = list(csv.DictReader(open(page.folder / "review.csv")))
    assert page.one("#review").is_displayed() and page.listed() == [int(one["edge"]) for one in asked], (page.listed(), asked)
    ranks = page.driver.execute_script("return [...document.querySelectorAll('#review-list .rank')].map(rank => rank.textContent)")
    assert ranks == [one["rank"] for one in asked], ranks
    count = "1 question" if len(asked) == 1 else f"{len(asked)} questions"
    assert f"{count} for a person" in page.text("#answer-words"), page.text("#answer-words")
    # Keys belong to the view.
    assert ("Keys:" in page.text("#review-note")) == page.one("#stage").is_displayed(), page.text("#review-note")


def check_saved(page, downloads):
    """What was saved is loaded where nothing was decided."""
    row = next((row for row in page.listed() if page.is_uncertain(page.edges[row])), None)
    if row is None:
        return
    page.click(f"#review-list li[data-row='{row}'] .accept")
    target = save(page, downloads)
    page.driver.execute_script("localStorage.clear()")
    page.open()
    page.driver.execute_script("localStorage.clear()")
    page.one("#load").send_keys(str(target))
    page.settle()
    assert state(page, row) == "accepted" and page.text("#load-note").startswith("1 decision loaded"), page.text("#load-note")
    page.driver.execute_script("localStorage.clear()")


def check_tabs(page):
    """What is decided in another tab holds in this one, so neither takes from the browser what the other kept."""
    rows = [row for row in page.listed() if page.is_uncertain(page.edges[row])][:2]
    if len(rows) < 2:
        return
    driver, first = page.driver, page.driver.current_window_handle
    page.click(f"#review-list li[data-row='{rows[0]}'] .accept")
    driver.switch_to.new_window("tab")
    page.open()
    page.click(f"#review-list li[data-row='{rows[1]}'] .reject")
    driver.close()
    driver.switch_to.window(first)
    WebDriverWait(driver, 60).until(lambda _: state(page, rows[1]) == "rejected")
    page.open()
    assert [state(page, row) for row in rows] == ["accepted", "rejected"]
    driver.execute_script("localStorage.clear()")
    page.open()


FRAME = """<iframe src="report.html" width="1200" height="900"></iframe>
<script>window.told = []; window.addEventListener("message", event => window.told.push(event.data));</script>"""
OPEN = "return [...document.querySelectorAll('#review-list li:not(.accept, .reject, .unsure)')].map(line => Number(line.dataset.row))"


def check_told(page):
    """The page of a cohort is told as many open questions as the list has, where a place is answered by an edit, too."""
    if not (page.folder / "pairings.csv").exists():
        return
    driver = page.driver
    (page.folder / "frame.html").write_text(FRAME)
    driver.get((page.folder / "frame.html").as_uri())
    driver.switch_to.frame(0)
    WebDriverWait(driver, 60).until(lambda d: d.execute_script("return document.documentElement.dataset.ready") == "yes")
    assert any(one["kind"] == "touch" for one in csv.DictReader(open(page.folder / "review.csv")))
    for _ in range(100):
        rows = driver.execute_script(OPEN)
        if not rows:
            break
        decides = driver.find_elements("css selector", f"#review-list li[data-row='{rows[0]}'] .reject")
        if not decides:
            driver.execute_script(f"document.querySelector(\"#review-list li[data-row='{rows[0]}'] .go\").click()")
            decides = [button for button in driver.find_elements("css selector", ".pairings button") if button.is_enabled()]
        driver.execute_script("arguments[0].click()", decides[0])
        left = len(driver.execute_script(OPEN))
        driver.switch_to.default_content()
        told = driver.execute_script("return told.filter(message => message.willis === 'decisions').at(-1).open")
        driver.switch_to.frame(0)
        assert told == left, (rows[0], told, left)
    assert driver.execute_script("return document.getElementById('review-note').textContent").startswith("All are decided")
    driver.execute_script("localStorage.clear()")
    driver.switch_to.default_content()
    page.open()


def main():
    chromium, folders = sys.argv[1], sys.argv[2:]
    with tempfile.TemporaryDirectory() as profile, tempfile.TemporaryDirectory() as downloads:
        driver = browser(chromium, profile)
        try:
            for folder in folders:
                page = Page(driver, folder)
                if not page.edges:
                    assert page.text("#answer-words").startswith("By group: nothing is compared"), page.text("#answer-words")
                    continue
                check_asked(page)
                check_told(page)
                check_saved(page, Path(downloads))
                check_tabs(page)
                page.no_error()
                print(folder, "holds")
        finally:
            driver.quit()


if __name__ == "__main__":
    main()
