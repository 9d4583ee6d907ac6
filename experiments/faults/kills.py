#!/usr/bin/env python3
"""Kills willis, or lets the system refuse, at the system calls of every command that writes, and checks that nothing is lost.

A call is tried where it touches the working folder: each that moves, removes, makes or locks, and some of the writes, reads and looks. In
turn the output is new, replaces an earlier one (--force), or must be refused, as it is there. After a kill or an error each part of
the output is absent, the earlier or the new one, and never another; a command that ends well has written all; one that is refused has
touched nothing; one line says what is wrong; and the same command again gives the bytes of a run that nobody disturbed, and leaves nothing hidden.
Makes the rows of the table of this folder's README: of all commands, or of those named.

    kills.py WILLIS [COMMAND...]
"""

import collections
import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import common

CHANGES = "rename,renameat,renameat2,unlink,unlinkat,rmdir,mkdir,mkdirat,fsync,fdatasync,flock,openat,write,pwrite64,ftruncate,copy_file_range,sendfile"
LOOKS = "openat,read,pread64,stat,lstat,statx,newfstatat,lseek,getdents64,mmap"
# Of these at most so many a command are tried; all others always.
OFTEN, MOST = ("openat", "write", "read", "pread64", "stat", "lstat", "statx", "newfstatat", "lseek", "getdents64", "mmap", "fsync"), int(os.environ.get("WILLIS_PLACES", "24"))
# A command that takes longer, s, is tried at so many places in all.
SLOW = 1.0
DATA = HERE.parents[1] / "data"
# Their commands, times and versions differ from run to run.
VOLATILE = re.compile(r"(run|cohort|dataset_description)\.json$|\.html$")
SHORT = ["-n", "64", "--dpi", "36"]


def swc(path, scale):
    """The broken circle, its radii times `scale`."""
    out = []
    for row in (DATA / "broken-circle-of-willis.swc").read_text().splitlines():
        cells = row.split()
        if cells and not row.startswith("#"):
            cells[5] = f"{float(cells[5]) * scale:.4f}"
        out.append(" ".join(cells))
    path.write_text("\n".join(out) + "\n")


def tube(path, width):
    """A mask of a broken tube, as NIfTI."""
    import struct

    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, 36, 14, 7, 1, 1, 1, 1)
    struct.pack_into("<2h", head, 70, 2, 8)
    struct.pack_into("<4f", head, 76, 1, 0.5, 0.5, 0.5)
    struct.pack_into("<2f", head, 108, 352, 1)
    head[123] = 2
    struct.pack_into("<h", head, 254, 1)
    for row in range(3):
        struct.pack_into("<f", head, 280 + 20 * row, 0.5)
    head[344:348] = b"n+1\0"
    inside = lambda x, y, z: 4 <= x <= 31 and not 16 <= x < 20 and (y - 6) ** 2 + (z - 3) ** 2 <= width**2
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(head) + bytes(inside(x, y, z) for z in range(7) for y in range(14) for x in range(36)))


def one(here, turn):
    swc(here / "a.swc", 1 + 0.1 * turn)


def two(here, turn):
    one(here, turn)
    swc(here / "b.swc", 1.05 + 0.1 * turn)


def a_run(here, turn):
    one(here, turn)
    willis(here, "infer", "a.swc", "-o", "run", "-q", *SHORT)


def two_runs(here, turn):
    two(here, turn)
    for name in "ab":
        willis(here, "infer", f"{name}.swc", "-o", f"runs/{name}", "-q", *SHORT)


def mask(here, turn):
    tube(here / "m.nii", 2 + 0.3 * turn)


def trees(here, turn):
    for seed in range(4):
        case = here / f"trees/{'easy' if seed < 2 else 'hard'}/t{seed % 2}"
        case.mkdir(parents=True)
        willis(case, "phantom", "tree", "--break", "--seed", str(seed + 10 * turn), "-o", "fragments.swc", "-q")
        (case / "fragments.truth.json").rename(case / "truth.json")
        (case / "inlets.csv").write_text("x_mm,y_mm,z_mm\n0,0,0\n")


def dataset(here, turn):
    (here / "study").mkdir()
    (here / "study/dataset_description.json").write_text('{"Name": "Study", "BIDSVersion": "1.10.0"}')
    for subject in ("01", "02"):
        tube(here / f"study/derivatives/net/sub-{subject}/anat/sub-{subject}_desc-vessels_mask.nii", 2 + 0.3 * turn)


def participants(here, turn):
    dataset(here, turn)
    willis(here, "bids", "study", "out", "participant", "-q", *SHORT)


# Name, what it needs, its words, and how its output appears: whole as one folder or file, as one with a row for each subject that failed, in
# parts, or as a set of files.
COMMANDS = [
    ("infer", one, ["infer", "a.swc", "-o", "out", "--checkpoint", "0", *SHORT], "whole"),
    ("infer, cohort", two, ["infer", "a.swc", "b.swc", "-o", "out", "--checkpoint", "0", *SHORT], "parts"),
    ("candidates", one, ["candidates", "a.swc", "-o", "out.graphml"], "whole"),
    ("merge", two_runs, ["merge", "runs/a", "runs/b", "-o", "out"], "whole"),
    ("simulate", one, ["simulate", "a.swc", "-o", "out", "--dpi", "36"], "whole"),
    ("modulate", one, ["modulate", "a.swc", "-o", "out", "-n", "16", "--dpi", "36"], "whole"),
    ("convert", one, ["convert", "a.swc", "out.csv"], "set"),
    ("skeleton", mask, ["skeleton", "m.nii", "-o", "out.swc"], "whole"),
    ("phantom", lambda here, turn: None, ["phantom", "arterial", "--edges", "100", "--break", "-o", "out.csv"], "set"),
    ("classify", a_run, ["classify", "run", "-o", "out"], "whole"),
    ("classify, cohort", two_runs, ["classify", "runs/a", "runs/b", "-o", "out"], "parts"),
    ("measure", a_run, ["measure", "run", "-o", "out"], "whole"),
    ("measure, cohort", two_runs, ["measure", "runs/a", "runs/b", "-o", "out"], "rows"),
    ("label", one, ["label", "a.swc", "-o", "out.vtp"], "set"),
    ("label, cohort", two, ["label", "a.swc", "b.swc", "-o", "out"], "parts"),
    ("bids participant", dataset, ["bids", "study", "out", "participant", *SHORT], "goes on"),
    ("bids group", participants, ["bids", "study", "out", "group"], "goes on"),
    ("train", trees, ["train", "trees", "-o", "out.toml", "--folds", "2", "--save-folds", "--passes", "1"], "set"),
    ("man", lambda here, turn: None, ["man", "-o", "out"], "set"),
]


def willis(here, *words, wrapper=()):
    done = subprocess.run([*wrapper, WILLIS, *words, "--threads", "1"], cwd=here, capture_output=True, text=True, check=False, timeout=600)
    if not wrapper and done.returncode:
        raise SystemExit(f"{words}: {done.stderr}")
    return done


def contents(here, inputs):
    """What stands in a folder besides the inputs and what is hidden, by path; of what differs from run to run only that it is whole."""
    found = {}
    for path in sorted(here.rglob("*")):
        name = str(path.relative_to(here))
        if path.is_dir() or name in inputs or any(part.startswith(".") for part in pathlib.Path(name).parts):
            continue
        text = path.read_bytes()
        if VOLATILE.search(name):
            text = "whole" if (json.loads(text) if name.endswith(".json") else text.rstrip().endswith(b"</html>")) else "cut"
        elif name.endswith(("cohort.csv", "group_willis.tsv")):
            rows = list(csv.reader(text.decode().splitlines(), delimiter="\t" if name.endswith("v") and "\t" in text.decode() else ","))
            timed = [at for at, column in enumerate(rows[0]) if column == "wall_s"] if rows else []
            text = [[cell for at, cell in enumerate(row) if at not in timed] for row in rows]
        found[name] = text
    return found


def hidden(here):
    return [str(path.relative_to(here)) for path in here.rglob(".willis*")]


def parts(found, how):
    """The contents by what appears at once: all of it, or each folder and file of the output."""
    if how in ("whole", "rows"):
        return {"": found} if found else {}
    out = collections.defaultdict(dict)
    for name, text in found.items():
        out["/".join(pathlib.Path(name).parts[:2]) if how == "parts" else name][name] = text
    return out


def state(found, old, new, how, failed):
    """What stands: absent, old, new, between, aside, or wrong."""
    if found == new:
        return "new"
    if found == old:
        return "old" if old else "absent"
    if how == "rows" and failed and set(found) == set(new):
        return "told"
    if how == "goes on":
        # What is there is whole, or says that it is not; the rest is made when the command goes on.
        return "between" if all(new.get(name) == text or old.get(name) == text or VOLATILE.search(name) or name.endswith((".tsv", ".json", ".unfinished")) for name, text in found.items()) else "wrong"
    stood, earlier, later = parts(found, how), parts(old, how), parts(new, how)
    # The tables of a cohort tell which subjects failed.
    told = lambda name: failed and how == "parts" and "." in name
    right = all(text in (earlier.get(name), later.get(name)) or told(name) for name, text in stood.items())
    main = next((name for name in stood if name in ("out.csv", "out.vtp", "out.toml", "out/willis.1")), None)
    if not old and how == "set" and main:
        right = False
    return "between" if right else "wrong"


def places(here, words, calls):
    """Which uses of the calls touch the folder, by what they are: a thread's k-th."""
    log = here.parent / "calls.log"
    began = time.monotonic()
    willis(here, *words, wrapper=["strace", "-f", "-y", "-qq", "-e", f"trace={calls}", "-o", str(log)])
    counts, touching = collections.Counter(), {}
    for row in log.read_text(errors="replace").splitlines():
        match = re.match(r"(\d+) +(\w+)\((.*)", row)
        if match:
            counts[match[1]] += 1
            if str(here) in match[3] or re.search(r'"[^/"]', match[3].split(" = ")[0]) and match[2] != "write":
                touching.setdefault(counts[match[1]], match[2])
    log.unlink()
    if time.monotonic() - began > SLOW:
        every = sorted(touching)
        return [every[int((i + 0.5) * len(every) / MOST)] for i in range(MOST)], len(touching)
    chosen = sorted(at for at, call in touching.items() if call not in OFTEN)
    often = sorted(at for at, call in touching.items() if call in OFTEN)
    step = max(1, len(often) / MOST)
    return sorted({*chosen, *(often[int(i * step)] for i in range(min(MOST, len(often))))}), len(touching)


def trial(root, made, words, how, fault, setting, at, calls):
    """What stood after a fault at a call, and what was wrong."""
    here = root / "try"
    start, old, new, inputs = made[setting]
    shutil.copytree(start, here)
    forced = [*words, "--force"] if setting == "forced" else words
    log = root / "log"
    inject = ["strace", "-f", "-qq", "-o", str(log), "-e", f"trace={calls}", "-e", f"inject={calls}:{fault}:when={at}"]
    done = willis(here, *forced, wrapper=inject)
    found = contents(here, inputs)
    what = state(found, old, new, how, done.returncode != 0)
    aside = next(here.glob(".willis-out*/old"), None)
    if not found and old and aside:
        what = "aside" if contents(aside, ()) == {name.split("/", 1)[1]: text for name, text in old.items()} else "wrong"
    why = [] if what != "wrong" else ["a mixture: " + ", ".join(name for name in {**found, **new} if found.get(name) not in (new.get(name), old.get(name)) or found.get(name) is None)]
    if what == "absent" and old:
        why.append("the earlier one is lost")
    if fault != "signal=KILL":
        # An error may hit what is printed, too.
        is_mute = any("write(2," in row and "INJECTED" in row for row in log.read_text(errors="replace").splitlines())
        said = is_mute or "willis: " in done.stderr
        if done.returncode == 0 and setting != "refused" and what != "new":
            why.append("ended well without its output")
        if done.returncode not in (0, 1, 2, 127) or "panicked" in done.stderr:
            why.append(f"status {done.returncode}: {done.stderr}")
        if done.returncode in (1, 2) and not said:
            why.append(f"no error: {done.stderr}")
        if setting == "refused" and found != old:
            why.append(f"what was to be refused is {what}")
    if setting == "refused":
        again = willis(here, *words, wrapper=["env"])
        right = again.returncode == 2 and "exists already" in again.stderr if how in ("whole", "rows", "set") else again.returncode == 0
        wanted = old
    else:
        # A subject that could not be read is a row of a table that is there.
        again = willis(here, *(forced if what != "told" else [*words, "--force"]), wrapper=["env"])
        right = again.returncode == 0 or what == "new" and setting == "fresh" and "exists already" in again.stderr
        wanted = new
    after = contents(here, inputs)
    if not right or after != wanted or hidden(here):
        differ = [name for name in {**after, **wanted} if after.get(name) != wanted.get(name)]
        why.append(f"again: {again.returncode} {again.stderr} differ {differ} hidden {hidden(here)}")
    shutil.rmtree(here)
    return what, bool(done.returncode), why


def prepare(root, needs, words, how):
    """The folders from which the trials start, with what stands before and after."""
    made = {}
    for turn in (0, 1):
        (root / f"inputs{turn}").mkdir()
        needs(root / f"inputs{turn}", turn)
    inputs = {str(path.relative_to(root / "inputs1")) for path in (root / "inputs1").rglob("*")}
    for turn in (0, 1):
        done = shutil.copytree(root / f"inputs{turn}", root / f"done{turn}")
        before = contents(done, inputs)
        willis(done, *(words if turn else [word.replace("100", "110") for word in words] if words[0] == "phantom" else words))
    new = contents(root / "done1", inputs)
    assert new, words
    made["fresh"] = (root / "inputs1", before, new, inputs)
    if how != "goes on":
        old = contents(root / "done0", inputs)
        earlier = shutil.copytree(root / "inputs1", root / "earlier")
        for name in old:
            (earlier / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(root / "done0" / name, earlier / name)
        made["forced"] = (earlier, old, new, inputs)
        if how in ("whole", "rows", "set"):
            made["refused"] = (earlier, old, new, inputs)
    return made


def main():
    global WILLIS
    if shutil.which("strace") is None:
        print("skipped: strace is not installed")
        return
    WILLIS = str(pathlib.Path(sys.argv[1]).resolve())
    chosen = sys.argv[2:]
    rows, faults = [], 0
    for name, needs, words, how in COMMANDS:
        if chosen and name not in chosen:
            continue
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            made = prepare(root, needs, words, how)
            counts = collections.Counter()
            for setting, fault, calls in [("fresh", "signal=KILL", CHANGES), ("forced", "signal=KILL", CHANGES), ("fresh", "error=EIO", CHANGES), ("forced", "error=ENOSPC", CHANGES), ("fresh", "error=EIO", LOOKS), ("forced", "error=EIO", LOOKS), ("refused", "error=EIO", LOOKS)]:
                if setting not in made:
                    continue
                probe = shutil.copytree(made[setting][0], root / "try")
                at, uses = places(probe, [*words, "--force"] if setting == "forced" else words, calls)
                shutil.rmtree(probe)
                counts["uses"] += uses
                for place in at:
                    what, ended, why = trial(root, made, words, how, fault, setting, place, calls)
                    counts["kills" if fault == "signal=KILL" else "errors"] += ended
                    counts["tried"] += 1
                    counts["wrong" if why else "between" if what == "told" else what] += 1
                    if why:
                        print(f"{name}, {setting}, {fault} at {place} of {calls[:12]}: {'; '.join(why)}", file=sys.stderr, flush=True)
            faults += counts["wrong"]
            figures = [counts[key] for key in ("uses", "tried", "kills", "errors", "absent", "old", "new", "between", "aside", "wrong")]
            rows.append([f"`{name}`", *map(str, figures)])
            print(" | ".join(rows[-1]), flush=True)
    readme = HERE / "README.md"
    stood = {row[0]: row for row in ([cell.strip() for cell in line.strip("|").split("|")] for line in readme.read_text().splitlines() if line.startswith("| `"))}
    stood |= {row[0]: row for row in rows}
    names = [f"`{name}`" for name, *_ in COMMANDS]
    header = ["command", "calls", "tried", "kills", "errors told", "absent", "earlier", "new", "parts", "put aside", "wrong"]
    common.splice(readme, "kills", common.table(header, [stood[name] for name in names if name in stood]))
    if faults:
        sys.exit(f"{faults} faults")


if __name__ == "__main__":
    main()
