"""LICENSE-THIRD-PARTY: the crates that are linked into the program, with licence and copyright, and the texts of the licences.

notices.py writes the file, notices.py --check fails when it is out of date. It reads `cargo metadata` and the sources of the crates that
cargo has fetched.
"""
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NOTICES = ROOT / "LICENSE-THIRD-PARTY"
# Of several licences the first that is offered here.
CHOICE = ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-3-Clause", "Zlib"]
# What the text of a licence holds.
MARKS = {
    "MIT": ["Permission is hereby granted", "WITHOUT WARRANTY"],
    "BSD-3-Clause": ["Redistribution and use", "THIS SOFTWARE IS PROVIDED"],
    "Zlib": ["as-is", "altered"],
}
HEAD = """Third-party software in willis

The program and its Python module link these crates in, some of them on some systems only, and the Rust standard library (MIT or
Apache-2.0, The Rust Project Contributors). Where a crate offers several licences, the one named is the one taken. The texts of the
licences follow the list.

The pictures are drawn with the font Ubuntu Light, unmodified, which alone of the fonts in the crate epaint_default_fonts is used:
Copyright 2010, 2011 Canonical Ltd., licensed under the Ubuntu Font Licence 1.0.
"""


def linked():
    """The packages on the target's normal dependencies, without those that only run while compiling."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    macro = lambda package: any("proc-macro" in target["kind"] for target in package["targets"])
    ours = set(metadata["workspace_members"])
    open_, seen = list(ours), set()
    while open_:
        here = open_.pop()
        if here in seen:
            continue
        seen.add(here)
        for dependency in nodes[here]["deps"]:
            normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if normal and not macro(packages[dependency["pkg"]]):
                open_.append(dependency["pkg"])
    return sorted((packages[one] for one in seen - ours), key=lambda package: (package["name"], package["version"]))


def of_text(package):
    """The licence of a crate that names none but has its text."""
    text = " ".join(path.read_text(encoding="utf-8", errors="replace")[:400] for path in texts(package))
    if re.search(r"Apache License\s+Version 2\.0", text):
        return "Apache-2.0"
    raise SystemExit(f"{package['name']} names no licence")


def taken(package):
    """The licence that is taken of an expression; all that is joined by AND."""
    parts = re.split(r"\s+AND\s+", package["license"] or of_text(package))
    chosen = []
    for part in parts:
        offered = re.split(r"\s+OR\s+|/", part.strip().strip("()"))
        chosen.append(next((licence for licence in CHOICE if licence in offered), offered[0]))
    return " AND ".join(chosen)


def texts(package):
    folder = Path(package["manifest_path"]).parent
    return sorted(path for path in folder.iterdir() if path.is_file() and re.match(r"(licen[sc]e|copying|copyright)", path.name, re.I))


def copyright_of(package):
    """Lines of copyright in the licence files of a crate, else its authors."""
    found = []
    for path in texts(package):
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            line = line.strip(" \t*#-")
            if re.match(r"copyright\s+(\(c\)|©|\d{4}|20|the )", line, re.I) and not re.search(r"\[yyyy\]|\{yyyy\}|owner or entity", line):
                found.append(re.sub(r"\s*<[^>]*@[^>]*>", "", re.sub(r"\s+", " ", line)))
    found = list(dict.fromkeys(found))
    authors = [re.sub(r"\s*<[^>]*>", "", author) for author in package["authors"]]
    return found or [f"by {', '.join(authors) or 'the authors of ' + package['name']}"]


def body(text):
    """A licence without lines of copyright and blank lines at its ends."""
    lines = [line.rstrip() for line in text.splitlines()]
    lines = [line for line in lines if not re.match(r"\s*copyright\s+(\(c\)|©|\d{4})", line, re.I)]
    return "\n".join(lines).strip("\n")


def first(packages, licence, marks):
    """The text of a licence from the first crate that has it whole."""
    for package in packages:
        if licence in taken(package).split(" AND "):
            for path in texts(package):
                text = path.read_text(encoding="utf-8", errors="replace")
                if all(mark in text for mark in marks) and len(text) < 20_000 and "\n" in text:
                    return body(text)
    raise SystemExit(f"no text of {licence}")


def made():
    packages = linked()
    out = [HEAD]
    for package in packages:
        out.append(f"{package['name']} {package['version']}: {taken(package)}")
        out += [f"    {line}" for line in copyright_of(package)]
    font = next(package for package in packages if package["name"] == "epaint_default_fonts")
    font = (Path(font["manifest_path"]).parent / "fonts/UFL.txt").read_text(encoding="utf-8").strip("\n")
    used = sorted({licence for package in packages for licence in taken(package).split(" AND ")})
    sections = []
    for licence in used:
        if licence == "Apache-2.0":
            sections.append((licence, body((ROOT / "LICENSE-APACHE").read_text(encoding="utf-8"))))
        elif licence in MARKS:
            sections.append((licence, first(packages, licence, MARKS[licence])))
    sections.append(("Ubuntu-font-1.0", font))
    for title, text in sections:
        out.append(f"\n\n{'=' * 20} {title} {'=' * 20}\n\n{text}")
    return "\n".join(out) + "\n"


def main():
    text = made()
    if "--check" in sys.argv:
        if NOTICES.read_text(encoding="utf-8") != text:
            sys.exit(f"{NOTICES.name} is not that of the dependency tree: run .ci/notices.py")
    else:
        NOTICES.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
