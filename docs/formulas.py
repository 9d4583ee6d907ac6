"""Sets the formulas and pictures of the book: a preprocessor of mdBook, which needs no network and no library.

Blocks of ```math and $`...$` hold TeX, as the forges show it, and become MathML, which browsers draw themselves. `<!-- picture NAME: words -->` becomes
the picture of that name with the words below it; `docs/pictures.py` makes the pictures, and without them the places stay empty.
`docs/formulas.py --check` fails where a page has a formula that cannot be set.
"""
import json
import re
import subprocess
import sys
from html import escape
from pathlib import Path

HERE = Path(__file__).resolve().parent
NAMES = dict(zip("alpha beta gamma phi pi rho tau theta mu omega epsilon Delta Lambda".split(), "αβγφπρτθµωεΔΛ"))
MARKS = {"cdot": "·", "ge": "≥", "le": "≤", "sim": "∼", "times": "×", "in": "∈", "bar": "|", "infty": "∞"}
LARGE = {"sum": "∑", "prod": "∏", "int": "∫"}
WORDS = "exp ln min max sinh tanh".split()
SPACES = {",": "0.17em", ";": "0.28em", "quad": "1em", "qquad": "2em"}
TOKEN = re.compile(r"\\(?:text|mathrm)\{[^{}]*\}|\\[A-Za-z]+|\\.|[0-9.]*[0-9]|\S")


class Formula:
    """One formula, read from the left: each part is an element of MathML."""

    def __init__(self, tex, block):
        self.tokens = TOKEN.findall(tex)
        self.tex, self.block, self.at = tex, block, 0

    def fail(self, why):
        raise ValueError(f"{why} in the formula {self.tex!r}")

    def take(self):
        if self.at == len(self.tokens):
            self.fail("something is missing at the end")
        self.at += 1
        return self.tokens[self.at - 1]

    def next_is(self, *tokens):
        return self.at < len(self.tokens) and self.tokens[self.at] in tokens

    def row(self, end=None):
        parts = []
        while self.at < len(self.tokens) and self.tokens[self.at] != end:
            parts.append(self.scripted())
        if end is not None:
            self.take()
        return f"<mrow>{''.join(parts)}</mrow>"

    def part(self):
        token = self.take()
        name = token[1:] if token.startswith("\\") else None
        if token == "{":
            return self.row("}")
        if name == "frac":
            return f"<mfrac>{self.part()}{self.part()}</mfrac>"
        if name == "sqrt":
            return f"<msqrt>{self.part()}</msqrt>"
        if token.endswith("}") and name:
            kind, words = name[:-1].split("{")
            # MathML drops the spaces at the ends of text.
            words = re.sub(r"^ | $", "\N{NO-BREAK SPACE}", words)
            return f"<mtext>{escape(words)}</mtext>" if kind == "text" else f'<mi mathvariant="normal">{escape(words)}</mi>'
        if name in SPACES:
            return f'<mspace width="{SPACES[name]}"/>'
        if name in LARGE:
            return f'<mo largeop="{"true" if self.block else "false"}" movablelimits="false">{LARGE[name]}</mo>'
        if name in NAMES:
            return f"<mi>{NAMES[name]}</mi>"
        if name in WORDS:
            return f'<mi>{name}</mi><mspace width="0.1em"/>'
        if name in MARKS:
            return f"<mo>{MARKS[name]}</mo>"
        if name:
            self.fail(f"\\{name} is not known")
        if token[0].isdigit():
            return f"<mn>{token}</mn>"
        if token.isalpha():
            return f"<mi>{token}</mi>"
        if token in "()[]|":
            return f'<mo stretchy="false">{token}</mo>'
        if token == "/":
            return '<mo lspace="0" rspace="0">/</mo>'
        if token in "+-=,;<>!":
            return f"<mo>{escape(token.replace('-', '−'))}</mo>"
        return self.fail(f"{token} is not known")

    def scripted(self):
        large = self.next_is("\\sum", "\\prod")
        base, scripts = self.part(), {}
        while self.next_is("_", "^", "'"):
            mark = self.take()
            if mark == "'":
                mark, script = "^", "<mo>′</mo>"
            else:
                script = self.part()
            scripts[mark] = f"<mrow>{scripts[mark]}{script}</mrow>" if mark in scripts else script
        under, over = ("munder", "mover") if large and self.block else ("msub", "msup")
        if len(scripts) == 2:
            both = under + over[1:]
            return f"<{both}>{base}{scripts['_']}{scripts['^']}</{both}>"
        for tag, mark in ((under, "_"), (over, "^")):
            if mark in scripts:
                return f"<{tag}>{base}{scripts[mark]}</{tag}>"
        return base

    def mathml(self):
        display = ' display="block"' if self.block else ""
        return f"<math{display}>{self.row()}</math>"


def picture(match):
    name, words = match.group(1), " ".join(match.group(2).split())
    if not (HERE / "src/pictures" / name).is_file():
        return ""
    return f'<figure>\n<img src="pictures/{name}" alt="{escape(words)}">\n<figcaption>{escape(words)}</figcaption>\n</figure>'


def set_page(text):
    """The text of a page with its formulas and pictures; what stands in other blocks and between backticks stays."""
    out = []
    for at, part in enumerate(re.split(r"(^```.*?^```[^\n]*$)", text, flags=re.M | re.S)):
        if part.startswith("```math"):
            lines = [line for line in part.split("\n")[1:-1] if line.strip()]
            out.append("\n".join(f'<div class="formula">{Formula(line, True).mathml()}</div>' for line in lines))
        elif at % 2:
            out.append(part)
        else:
            part = re.sub(r"\$`([^`]+)`\$", lambda match: Formula(match.group(1), False).mathml(), part)
            out.append(re.sub(r"<!-- picture (\S+): (.*?) -->", picture, part, flags=re.S))
    return "".join(out)


def check():
    """Every page is set; returns how many formulas there are."""
    formulas = 0
    for page in sorted((HERE / "src").glob("*.md")):
        try:
            made = set_page(page.read_text())
        except ValueError as error:
            sys.exit(f"{page.name}: {error}")
        formulas += made.count("<math")
        outside = re.sub(r"^```.*?^```[^\n]*$|`[^`\n]*`", "", made, flags=re.M | re.S)
        left = re.search(r"\\(frac|sum|sqrt|cdot|text|rho)\b|\$[^$\n]+\$", outside)
        if left:
            sys.exit(f"{page.name}: {left.group(0)} is no formula that is set")
    return formulas


def main():
    if sys.argv[1:2] == ["supports"]:
        return
    if sys.argv[1:] == ["--check"]:
        print(f"{check()} formulas")
        return
    _, book = json.load(sys.stdin)
    made = subprocess.run([sys.executable, HERE / "pictures.py", "--missing"], stdout=sys.stderr)
    if made.returncode:
        print("the book is without pictures: docs/pictures.py says what they need", file=sys.stderr)

    def walk(items):
        for item in items:
            chapter = item.get("Chapter") if isinstance(item, dict) else None
            if chapter:
                chapter["content"] = set_page(chapter["content"])
                walk(chapter["sub_items"])

    walk(book.get("items") or book["sections"])
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
