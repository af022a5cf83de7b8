"""The memory of a signal in bytes: what `size` says of the C of its tree, with its stack and its observation.

    python -m tests.benchmarks.memory [PROFILE ...] [--json]

Without profiles: the proved signals of Cologne. A signal is a program of its own: the function that decides, and what
of the compiler's library it calls, which compares floats where a core does not. Flash is code and constants. RAM is
data, the function's own stack and the observation, of float32. Clocks and counting are the environment's.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from codegen.targets import emit
from maviper import load
from tests.benchmarks.common import figure, reader, tell

PROOFS = Path(__file__).parents[2] / "generated" / "signals" / "proofs"
CORES = {
    "x86-64": "gcc",
    "Cortex-M0": "arm-none-eabi-gcc -mthumb -mcpu=cortex-m0",
    "Cortex-M4F": "arm-none-eabi-gcc -mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard",
}
OPTIONS = ("-std=c99", "-Os", "-fstack-usage", "-ffunction-sections", "-nostdlib", "-static")
LINKED = ("-Wl,--gc-sections", "-Wl,-e,decide", "-lgcc")


def measure(compiler: str, header: str, call: str, features: int) -> tuple[int, int]:
    """Bytes of flash and RAM of a program that decides by `call`."""
    first, *options = compiler.split()
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        Path(folder, "tree.h").write_text(header)
        Path(folder, "tree.c").write_text(f'#include "tree.h"\nint decide(const float *x) {{ return {call}(x); }}\n')
        command = [first, *options, *OPTIONS, "tree.c", "-o", "tree", *LINKED]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        told = subprocess.run(
            [first.replace("gcc", "size"), "tree"], cwd=folder, check=True, capture_output=True
        ).stdout
        text, data, bss = map(int, told.decode().splitlines()[1].split()[:3])
        (usage,) = Path(folder).glob("*.su")
        stack = max(int(line.split("\t")[1]) for line in usage.read_text().splitlines())
    return text + data, data + bss + stack + 4 * features


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("profiles", nargs="*", type=Path)
    options = parser.parse_args()
    figures = []
    for core, compiler in CORES.items():
        if shutil.which(compiler.split()[0]) is None:
            print(f"{core}: {compiler.split()[0]} is not installed")
            continue
        found = []
        for path in options.profiles or sorted(PROOFS.glob("cologne?.json")):
            profile = load(path)
            (header,) = emit(profile, ["c"], "signals").values()
            found += [
                measure(compiler, header, f"signals_{each.agent}_act", len(each.features)) for each in profile.agents
            ]
        flash, ram = (sorted(each) for each in zip(*found, strict=True))
        for kind, sizes in (("flash", flash), ("RAM", ram)):
            figures.append(figure(f"{core}: bytes of {kind}, median of {len(found)}", sizes[len(sizes) // 2]))
            figures.append(figure(f"{core}: bytes of {kind}, most", sizes[-1]))
    tell(figures, options.json)


if __name__ == "__main__":
    main()
