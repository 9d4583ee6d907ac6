"""Draws the pictures of the book in docs/src/pictures, which is not committed: pages of runs on data that ships and on phantoms, in headless Chromium.

`docs/pictures.py` draws all, `docs/pictures.py --missing` those that are not there, as `mdbook build docs` does; names after it draw these alone. Needs
selenium and Chromium with its chromedriver (WILLIS_CHROMIUM names another). WILLIS names a built willis; without it, cargo builds one.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs/src/pictures"
SCAN, MASK, CIRCLE = "data/broken-circle-of-willis.swc", "data/scan.nii.gz", "data/circle-of-willis/complete.graphml"
FLAGS = """--headless --no-sandbox --disable-gpu --hide-scrollbars --disable-quic --no-first-run --disable-background-networking --disable-component-update
--disable-sync --disable-dev-shm-usage --use-angle=swiftshader --enable-unsafe-swiftshader --force-color-profile=srgb""".split()
# Selects what is asked first.
FIRST = 'document.querySelector("#review-list .go").click();'
# Leaves a part of the page alone.
ALONE = """for (let part = document.querySelector("{}"); part !== document.body; part = part.parentElement)
  for (const other of part.parentElement.children) if (other !== part && !["SCRIPT", "STYLE"].includes(other.tagName)) other.style.display = "none";
scrollTo(0, 0);"""
BROKEN = ["phantom", "cerebral", "--break", "--seed"]
# By picture: the commands, the page, the size of the window, and what is done on the page before the picture is taken.
WANTED = {
    "infer.png": ([["infer", SCAN, "-o", "out"]], "out/report.html", (1280, 960), ""),
    "decide.png": ([["infer", SCAN, "-o", "out"]], "out/report.html", (1280, 1100), FIRST),
    "slices.png": ([["infer", MASK, "-n", "64", "-o", "mask"]], "mask/report.html", (580, 740), FIRST + ALONE.format(".slices")),
    "image.png": (
        [["phantom", "tree", "--break", "--spacing", "0.7mm", "-o", "scan.nii.gz", "--image", "image.nii.gz"],
         ["infer", "scan.nii.gz", "--image", "image.nii.gz", "-n", "64", "-o", "image"]],
        "image/report.html", (580, 740), FIRST + ALONE.format(".slices")),
    "surface.png": ([["infer", MASK, "-n", "64", "-o", "mask"]], "mask/report.html", (1280, 960), ""),
    "classify.png": ([[*BROKEN, "1", "-o", "one.swc"], ["infer", "one.swc", "--landmarks", "one.landmarks.csv", "-o", "one"],
                      ["classify", "one", "-o", "circle"]], "circle/report.html", (1100, 1000), ""),
    "cohort.png": ([*([*BROKEN, str(seed), "-o", f"scan-{seed}.swc"] for seed in (1, 2, 3, 4)),
                    ["infer", "scan-*.swc", "--landmarks", "{}.landmarks.csv", "-n", "64", "-o", "cohort"]], "cohort/cohort.html", (1280, 900), ""),
    "simulate.png": ([["simulate", CIRCLE, "--occlude", "L-A1", "-o", "occluded"]], "occluded/report.html", (1280, 960), ""),
    "modulate.png": ([["modulate", CIRCLE, "-n", "64", "-o", "modulated"]], "modulated/report.html", (1280, 960), ""),
    "comparison.png": ([*([*BROKEN, str(seed), "-o", f"of-{seed}.swc"] for seed in range(8)),
                        ["measure", "groups.csv", "--compare", "group", "-o", "compared"]], "compared/report.html", (1280, 1100), ""),
    "waveforms.svg": ([["simulate", CIRCLE, "--pulse", "--occlude", "L-A1", "-o", "pulse"]], "pulse/waveforms.svg", None, ""),
    "territories.svg": ([["simulate", CIRCLE, "--transport", "--occlude", "L-A1", "-o", "transport"]], "transport/territories.svg", None, ""),
    "modulation.svg": ([["modulate", CIRCLE, "-n", "64", "-o", "modulated"]], "modulated/modulation.svg", None, ""),
    "summary.svg": ([["infer", SCAN, "-o", "out"]], "out/summary.svg", None, ""),
    "likelihood.svg": ([["infer", SCAN, "-o", "out"]], "out/likelihood.svg", None, ""),
}


def shot(browser, page, size, action, picture):
    """A picture of a page once it is ready and something was done on it."""
    browser.set_window_size(*size)
    browser.get(page.as_uri())
    WebDriverWait(browser, 60).until(lambda driver: driver.execute_script("return document.documentElement.dataset.ready") == "yes")
    browser.execute_script(action)
    # The view flies for half a second.
    time.sleep(1.5)
    browser.save_screenshot(str(picture))


def main():
    asked = [name for name in sys.argv[1:] if name != "--missing"] or list(WANTED)
    wanted = [name for name in asked if "--missing" not in sys.argv or not (PICTURES / name).is_file()]
    if not wanted:
        return
    willis = [os.environ["WILLIS"]] if "WILLIS" in os.environ else ["cargo", "run", "--release", "--locked", "--manifest-path", ROOT / "Cargo.toml", "--"]
    options = webdriver.ChromeOptions()
    options.binary_location = os.environ.get("WILLIS_CHROMIUM") or shutil.which("chromium") or ""
    for flag in FLAGS:
        options.add_argument(flag)
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, browser:
        shutil.copytree(ROOT / "data", Path(folder) / "data")
        groups = "".join(f"of-{seed}.swc,{seed},{'ab'[seed % 2]}\n" for seed in range(8))
        (Path(folder) / "groups.csv").write_text(f"input,subject,group\n{groups}")
        done = set()
        for name in wanted:
            commands, page, size, action = WANTED[name]
            for command in commands:
                if str(command) not in done:
                    subprocess.run([*willis, *command, "--quiet"], check=True, cwd=folder)
                    done.add(str(command))
            if size is None:
                shutil.copy(Path(folder) / page, PICTURES / name)
            else:
                shot(browser, Path(folder) / page, size, action, PICTURES / name)
            print(PICTURES / name)


if __name__ == "__main__":
    main()
