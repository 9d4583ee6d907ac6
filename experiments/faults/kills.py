#!/usr/bin/env python3
"""Kills willis at every rename, unlink, mkdir and fsync that it makes, and checks that nothing is lost.

For each system call and each of its uses (the first, the second, ...), a run that replaces an earlier output is killed right there, by
`strace -e inject`. Then the output must be the earlier one, the new one, or be put aside whole; and the same command again must give the
bytes of a run that nobody killed, and leave nothing hidden. Prints a table: call, kills, what stood after the kill.

    kills.py WILLIS INPUT.swc
"""

import filecmp
import pathlib
import shutil
import subprocess
import sys
import tempfile

CALLS = ["rename,renameat,renameat2", "unlink,unlinkat,rmdir", "mkdir,mkdirat", "fsync,fdatasync", "openat", "write"]
# Calls that are made hundreds of times are tried at so many places only.
MOST = 60
OLD, NEW = ["--seed", "1"], ["--seed", "2"]


def run(willis, source, folder, seed, wrapper=()):
    words = [*wrapper, willis, "infer", source, "-o", "out", "-n", "128", "--dpi", "36", "--force", "--checkpoint=0", "-q", *seed]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def same(one, two):
    """Whether two output folders have the same files and bytes, times and commands in run.json and the pages aside."""
    names = sorted(path.name for path in one.iterdir())
    if names != sorted(path.name for path in two.iterdir()):
        return False
    fixed = [name for name in names if name not in ("run.json", "report.html")]
    return filecmp.cmpfiles(one, two, fixed, shallow=False)[0] == fixed


def uses(willis, source, folder, calls):
    """How often a run makes the calls."""
    log = folder / "calls.log"
    done = run(willis, source, folder, NEW, ["strace", "-f", "-qq", "-e", f"trace={calls}", "-o", str(log)])
    assert done.returncode == 0, done.stderr
    count = sum(1 for line in log.read_text().splitlines() if "resumed" not in line)
    log.unlink()
    return count


def main():
    if shutil.which("strace") is None:
        print("skipped: strace is not installed")
        return
    willis, source = (str(pathlib.Path(word).resolve()) for word in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as made:
        root = pathlib.Path(made)
        truth = {}
        for name, seed in (("old", OLD), ("new", NEW)):
            folder = root / name
            folder.mkdir()
            done = run(willis, source, folder, seed)
            assert done.returncode == 0, done.stderr
            truth[name] = folder / "out"
        print("| call | uses | kills | the earlier one stood | the new one stood | put aside | wrong |")
        print("|---|---|---|---|---|---|---|")
        faults = 0
        for calls in CALLS:
            probe = root / "probe"
            shutil.copytree(root / "old", probe)
            count = uses(willis, source, probe, calls)
            shutil.rmtree(probe)
            places = range(1, count + 1) if count <= MOST else sorted({1 + i * count // MOST for i in range(MOST)})
            stood = {"old": 0, "new": 0, "aside": 0, "wrong": 0}
            kills = 0
            for at in places:
                folder = root / "try"
                shutil.copytree(root / "old", folder)
                inject = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={calls}", "-e", f"inject={calls}:signal=KILL:when={at}"]
                done = run(willis, source, folder, NEW, inject)
                kills += done.returncode != 0
                out, aside = folder / "out", folder / ".willis-out" / "old"
                if out.is_dir() and same(out, truth["old"]):
                    state = "old"
                elif out.is_dir() and same(out, truth["new"]):
                    state = "new"
                elif not out.exists() and aside.is_dir() and same(aside, truth["old"]):
                    state = "aside"
                else:
                    state = "wrong"
                again = run(willis, source, folder, NEW)
                hidden = [path.name for path in folder.iterdir() if path.name.startswith(".")]
                if again.returncode != 0 or not same(folder / "out", truth["new"]) or hidden:
                    state = "wrong"
                    print(f"{calls} {at}: {again.stderr} {hidden}", file=sys.stderr)
                stood[state] += 1
                shutil.rmtree(folder)
            faults += stood["wrong"]
            print(f"| `{calls}` | {count} | {kills} | {stood['old']} | {stood['new']} | {stood['aside']} | {stood['wrong']} |", flush=True)
        if faults:
            sys.exit(f"{faults} faults")


if __name__ == "__main__":
    main()
