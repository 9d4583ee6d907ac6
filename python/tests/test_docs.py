"""What the pages say in Python, done: the blocks of a page that use the module, one after another, beside a copy of the data."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def blocks_of(page):
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(), re.M | re.S)
    return [block for block in blocks if "willis." in block or page.name == "python.md"]


PAGES = [page for page in [Path("README.md"), *sorted(Path("docs/src").glob("*.md"))] if blocks_of(page)]


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_a_page_does_what_it_says(page, tmp_path):
    for needed in ("pandas", "networkx", "dask.distributed"):
        pytest.importorskip(needed)
    shutil.copytree("data", tmp_path / "data")
    script = "import warnings; warnings.simplefilter('ignore')\n" + "\n".join(blocks_of(page)).replace('if __name__ == "__main__":', "if True:")
    # In no file, as in a notebook: workers that are started do not run the page again.
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("notebook", sorted(Path("docs/notebooks").glob("*.ipynb")), ids=str)
def test_notebooks_have_no_outputs(notebook):
    cells = json.loads(notebook.read_text())["cells"]
    assert cells and all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells)
