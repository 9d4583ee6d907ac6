"""All patients in one command: how long it takes."""
import os
import subprocess
import time

import common
from networks import SHARED


def run(work, _options):
    folder = SHARED / "insist-cow"
    if not folder.exists():
        print(f"skipped: there is no {folder}")
        return None
    tracings = sorted(str(path) for path in folder.glob("*/tracing*.swc"))
    lines = []
    for command, options in (("classify", ["--labels", "names"]), ("infer", ["--labels", "names"])):
        begun = time.monotonic()
        done = subprocess.run([common.WILLIS, command, *tracings, *options, "-o", work / command, "--force", "--quiet"], capture_output=True, text=True)
        seconds = time.monotonic() - begun
        rows = common.rows(work / command / "cohort.csv")
        failed = sum(row["status"] != "ok" for row in rows)
        lines.append([f"`willis {command} {' '.join(options)}`", len(rows), failed, f"{seconds:.0f}"])
        if done.returncode not in (0, 1):
            raise SystemExit(done.stderr)
    return common.table(["command", "patients", "failed", f"seconds on {os.cpu_count()} cores"], lines)
