"""The README's blocks between marks, calibration, and tables of counts."""
from pathlib import Path

README = Path(__file__).resolve().parent / "README.md"


def put(name, text):
    """Replaces what stands between the marks of a block."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    before, rest = README.read_text().split(begin)
    README.write_text(before + begin + "\n" + text + "\n\n" + end + rest.split(end)[1])


def calibration(pairs, bins=10):
    """Expected calibration error of (probability, came true), and per occupied bin (count, mean probability, share that came true)."""
    rows, error = [], 0.0
    for k in range(bins):
        inside = [(p, y) for p, y in pairs if min(int(p * bins), bins - 1) == k]
        if inside:
            p, y = (sum(x) / len(inside) for x in zip(*inside))
            error += len(inside) / len(pairs) * abs(p - y)
            rows.append((len(inside), p, y))
    return error, rows


def reliability(pairs):
    """A table of the bins."""
    error, rows = calibration(pairs)
    lines = ["| cases | mean probability | came true |", "|---|---|---|"]
    lines += [f"| {n} | {p:.2f} | {y:.2f} |" for n, p, y in rows]
    return error, "\n".join(lines)
