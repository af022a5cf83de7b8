"""How many lines must be right for a certificate of each kind, and for a counterexample in real arithmetic.

    python -m tests.benchmarks.trusted [--json]

Lines are counted as in the tables of `verify/checker/README.md`: all lines of the modules of ours that the accept path
imports, directly or not.
"""

import subprocess
import sys
from pathlib import Path

from tests.benchmarks.common import figure, reader, tell

ROOT = Path(__file__).parents[2]
ACCEPT = "verify.checker.accept"  # gives each proof about a system to what checks it
PATHS = {
    "decisions": "verify.checker.decisions",
    "episodes": "verify.checker.episodes.certificates",
    "systems, symbolic states": "verify.checker.systems.branch_proofs",
    "systems, boxes and forms": "verify.checker.covers.invariants",
    "continuous time": "verify.checker.flows.sweep",
    "systems, all": ACCEPT,
    "counterexamples in real arithmetic": "verify.states.state",
}


def imported(module: str) -> set[str]:
    """The modules of ours that one imports, directly or not; packages, which are docstrings, aside."""
    code = (
        f"import sys, {module}; ours = {{n: m for n, m in sys.modules.items() if n.split('.')[0] in"
        " ('codegen', 'maviper', 'verify')}; print(*(n for n, m in ours.items() if not hasattr(m, '__path__')))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def count_lines(modules: set[str]) -> int:
    """The lines of modules together."""
    return sum(len((ROOT / f"{name.replace('.', '/')}.py").read_text().splitlines()) for name in modules)


def main() -> None:
    """Prints a line for each kind."""
    options = reader(__doc__).parse_args()
    bases = {kind: imported(module) for kind, module in PATHS.items()}
    figures = (figure(f"{kind}, lines in {len(base)} modules", count_lines(base)) for kind, base in bases.items())
    tell(figures, options.json)


if __name__ == "__main__":
    main()
