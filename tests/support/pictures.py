"""The README's picture: a photograph of the committed page of a team that violates its claim.

Run as `python -m tests.support.pictures`, with Chromium on the path, after `generated/` was made again.
"""

import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from tests.support.chromium import COMMAND, QUIETLY

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "generated" / "physical_deception" / "extracted" / "play.html"
PICTURE = ROOT / "maviper" / "manual" / "play.png"
WIDTH, HEIGHT, SCALE = 1400, 1530, 0.6
MAX_BYTES, COLOURS = 60_000, 256


def main() -> None:
    assert COMMAND is not None, "chromium is not installed"
    with tempfile.TemporaryDirectory() as folder:
        shot = Path(folder) / "play.png"
        sizes = [f"--window-size={WIDTH},{HEIGHT}", f"--force-device-scale-factor={SCALE}", "--hide-scrollbars"]
        # time that passes at once, so that the arena is coloured to its end
        command = [COMMAND, *QUIETLY, *sizes, "--virtual-time-budget=5000", f"--user-data-dir={folder}/user"]
        subprocess.run([*command, f"--screenshot={shot}", PAGE.as_uri()], check=True, capture_output=True, timeout=300)
        photograph = Image.open(shot).convert("RGB")
    # a third of the bytes; no part of any colour moves by more than a twentieth
    colours = photograph.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    colours.save(PICTURE, "PNG", optimize=True)
    assert PICTURE.stat().st_size <= MAX_BYTES, PICTURE.stat().st_size


if __name__ == "__main__":
    main()
