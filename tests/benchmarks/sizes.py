"""What a checkout without history and a wheel take, beside the bars of a release: 20 MB and 4 MB.

    python -m tests.benchmarks.sizes [--wheel FILE] [--json]

A checkout is what `git archive` holds: the bytes of all committed files at HEAD. Its largest folders and files are
listed. Without --wheel a wheel is built from that archive, in a folder of its own, which takes a minute.
"""

import gzip
import io
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from pathlib import Path

from tests.benchmarks.common import figure, reader, tell

ROOT = Path(__file__).parents[2]
BARS = {"checkout without history, MB": 20.0, "wheel, MB": 4.0}
EXPERTS = "maviper/experts/shipped/"
MB = 1e6
SHOWN = 12


def committed() -> dict[str, int]:
    """The bytes of each file at HEAD, by path."""
    command = ["git", "ls-tree", "-r", "-l", "-z", "HEAD"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    rows = (row.split("\t") for row in listed.split("\0") if row)
    return {path: int(about.split()[3]) for about, path in rows}


def packed_archive() -> int:
    """The bytes of that checkout as a .tar.gz, as a forge hands it out."""
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True).stdout
    return len(gzip.compress(archive, 6, mtime=0))


def built(place: Path) -> Path:
    """A wheel of HEAD, built in a folder."""
    archive = subprocess.run(["git", "archive", "HEAD"], cwd=ROOT, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as packed:
        packed.extractall(place / "source", filter="data")
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(place / "dist"), "."]
    subprocess.run(command, cwd=place / "source", check=True)
    (wheel,) = (place / "dist").glob("*.whl")
    return wheel


def by_folder(files: dict[str, int]) -> Counter[str]:
    """The bytes of each folder of the second level, and of files above it."""
    sizes = Counter[str]()
    for path, size in files.items():
        sizes["/".join(path.split("/")[:-1][:2]) or "."] += size
    return sizes


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("--wheel", type=Path, help="measure this one instead of building one")
    options = parser.parse_args()
    files = committed()
    with tempfile.TemporaryDirectory() as name:
        wheel = (options.wheel or built(Path(name))).stat().st_size
    values = dict(zip(BARS, (sum(files.values()) / MB, wheel / MB), strict=True))
    tell((figure(name, value, BARS[name]) for name, value in values.items()), options.json)
    if options.json:
        return
    print(f"the checkout as a .tar.gz, MB: {packed_archive() / MB:.2f}")
    for title, sizes in (("folders", by_folder(files)), ("files", Counter(files))):
        print(f"\n{title}, MB")
        print("\n".join(f"{size / MB:>8.2f}  {path}" for path, size in sizes.most_common(SHOWN)))


if __name__ == "__main__":
    main()
