"""All patients in one command: how long it takes."""
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import common
from networks import SHARED


def whole(work):
    """The whole tracings as files of nothing but points, radii and links."""
    sys.path.append(str(Path(__file__).resolve().parent.parent / "labels"))
    import cases

    if cases.missing():
        return []
    cases.make(work / "whole", upright=True, levels=("whole",))
    return [shutil.copy(folder / "fragments.swc", work / f"{folder.name.split('-')[0]}.swc") for folder in sorted((work / "whole").iterdir())]


def run(work, _options):
    folder = SHARED / "insist-cow"
    if not folder.exists():
        print(f"skipped: there is no {folder}")
        return None
    tracings = sorted(str(path) for path in folder.glob("*/tracing*.swc"))
    bare = whole(work)
    lines = []
    for command, options, files in (("classify", ["--labels", "names"], tracings), ("infer", ["--labels", "names"], tracings), ("classify", [], bare), ("infer", [], bare)):
        if not files:
            continue
        out = work / f"{command}{'-named' if options else ''}"
        begun = time.monotonic()
        done = subprocess.run([common.WILLIS, command, *files, *options, "-o", out, "--force", "--quiet"], capture_output=True, text=True)
        seconds = time.monotonic() - begun
        if done.returncode not in (0, 1):
            raise SystemExit(done.stderr)
        rows = common.rows(out / "cohort.csv")
        failed = sum(row["status"] != "ok" for row in rows)
        lines.append([f"`willis {' '.join([command, *options])}`{'' if options else ', nothing but the files'}", len(rows), failed, f"{seconds:.1f}"])
    return common.table(["command", "patients", "failed", f"seconds on {os.cpu_count()} cores"], lines)
