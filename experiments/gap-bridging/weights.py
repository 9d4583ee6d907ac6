"""The weights that ship: fitted on the training draws, into crates/models/src/candidates/model/weights.toml. weights.py [--work FOLDER]."""
import argparse
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

import bench

if bench.missing():
    print("skipped: there is no " + ", ".join(bench.missing()), file=sys.stderr)
    sys.exit()

import command
import common

SHIPPED = bench.ROOT / "crates/models/src/candidates/model/weights.toml"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, help="a folder to keep draws and weights in, and to go on from [a temporary one]")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gap-bridging-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(command.train(work, command.WHOLE), SHIPPED)
    lines = [[f["of"], f["cases"], *(f"{f[k]:.3f}" for k in ("average_precision", "calibration_error", "log_likelihood"))] for f in tomllib.loads(SHIPPED.read_text())["figures"]]
    print(common.table(["held out", "cases", "AP", "calibration error", "log-likelihood"], lines))


if __name__ == "__main__":
    main()
