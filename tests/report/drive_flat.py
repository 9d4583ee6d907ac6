"""The page of a run where the browser has no WebGL.

Usage: drive_flat.py CHROMIUM FOLDER
"""

import sys
import tempfile

from drive import Page, browser, check_picking, check_toggles


def main():
    chromium, folder = sys.argv[1:]
    with tempfile.TemporaryDirectory() as profile:
        driver = browser(chromium, profile, "--disable-3d-apis")
        try:
            page = Page(driver, folder)
            assert "flat lines" in page.text("#canvas-note")
            check_toggles(page)
            check_picking(page)
            page.no_error()
            print(folder, "holds without WebGL")
        finally:
            driver.quit()


if __name__ == "__main__":
    main()
