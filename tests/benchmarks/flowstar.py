"""A flow step with the action held, over 1,000 boxes: ours in one batch beside Flow*, in width and in time.

    python tests/benchmarks/flowstar.py --flowstar FOLDER [--boxes 1000] [--rounds 3] [--json] [NAME ...]

FOLDER is a checkout of github.com/chenxin415/flowstar (GPL; GMP, MPFR, GSL, GLPK, flex, bison). Its library is built
there by its own makefile, if it was not yet; without it nothing is measured, and the script says so. The boxes are
parts of sets that the checker follows in proofs of generated/arch, at samples, with the action that is held. Both take
one period in as many steps as the certificate says: we with its order and a frame that begins at the sample, Flow* with
Taylor models of the same order, a flowpipe and a call of `reach` for each box (flowstar_driver.cpp). An input is a
variable that does not move, as its users write it. Flow* gets the smallest estimate of remainders, of powers of ten,
with which most boxes are done; plants with boxes that it leaves undone are shown, and are in no mean. Widths are
compared box by box and variable by variable where they are no points, as geometric means; times are of the processor,
ours and Flow*'s in turn, without reading and printing.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for maviper, also when run by this path

import numpy as np

from codegen.numbers import nearest_double
from maviper.files.profiles import load
from maviper.worlds.stated.certified import read_certificate
from verify.checker.envelope import numbers
from verify.checker.flows.programs import Stepping
from verify.checker.flows.series import FlowReading
from verify.checker.flows.spans import Spans
from verify.checker.flows.steps import FlowStep, build_frames
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.systems.expressions import Call, Name, Number, Power, Product, Quotient, Sum

PLACE = Path(__file__).parents[2] / "generated" / "arch"
NAMES = ("pendulum", "tora_remain", "nav", "unicycle", "attitude", "double_pendulum_less", "airplane", "quad")
TARGETS = {"width over Flow*": (1.1, 1.0, "lower"), "time over Flow*": (2.0, 0.5, "lower")}
SEED = 0
FEW = 20  # boxes by which an estimate is chosen first
ESTIMATES = [10.0**power for power in range(-8, 1)]


class Step:
    """One period of a plant: our step of the checker, and boxes with what is held in them."""

    def __init__(self, name, count):
        (path, *_) = sorted((PLACE / name).glob("certificate-*.json"))
        certificate, statement = read_certificate(path)
        self.flow, system = statement.system.flow, statement.system
        self.names = [one.name for one in system.variables]
        sweep = FlowSweep(load(PLACE / name / "profile.json"), system, certificate.claim)
        lists = []
        sweep.watch = lambda told: lists.append(told.sets) if told.step == 0 else None
        widths = {sweep.columns[x]: nearest_double(width) for x, width in certificate.proof.cells.items()}
        sweep.run(Plan(list(numbers(certificate.proof.cuts)), certificate.proof.order, certificate.proof.steps, widths))
        random = np.random.default_rng(SEED)
        low, high, joint = (
            np.concatenate([part(each) for each in lists])
            for part in (lambda sets: sets.box.low, lambda sets: sets.box.high, lambda sets: sets.joint)
        )
        place = random.integers(len(low), size=count)
        share = np.sort(random.random((2, count, len(self.names))), axis=0)
        width = high[place] - low[place]
        self.box = Spans(low[place] + share[0] * width, low[place] + share[1] * width)
        self.held = sweep.inputs(joint[place])
        self.order, self.steps = certificate.proof.order, certificate.proof.steps
        reading, how = FlowReading(self.flow, self.names), Stepping(self.order, self.flow.period / self.steps)
        zero = self.flow.period * 0
        self._step = FlowStep(reading, [(zero, zero)] * len(self.names), how)

    def ours(self):
        """Boxes after a period, and seconds."""
        begun = time.process_time()
        box, frames = self.box, (build_frames(self.box),)
        for _ in range(self.steps):
            moved = self._step.move_sets(box, frames, self.held)
            assert moved.shown.all()
            box, frames = moved.box, moved.frames
        return box, time.process_time() - begun

    def theirs(self, program):
        """The same of Flow*, whose errors of derivatives are left out as ours are."""
        known = {name: f"x{place}" for place, name in enumerate([*self.names, *self.held])}
        rates = [written(self.flow.rates[name], known) for name in self.names] + ["0"] * len(self.held)
        head = [str(len(known)), *(f"{name} {rate}" for name, rate in zip(known.values(), rates, strict=True))]
        columns = [(self.box.low[:, place], self.box.high[:, place]) for place in range(len(self.names))]
        rows = np.stack([end for pair in (*columns, *self.held.values()) for end in pair], axis=1)
        period = nearest_double(self.flow.period)
        undone = {}
        for estimate in ESTIMATES:
            settings = [*head, f"{self.order} {period / self.steps!r} {period!r} {estimate!r}"]
            undone[estimate] = answered(program, settings, rows[:FEW]).count("failed")
            if not undone[estimate]:
                break
        estimate = min(undone, key=lambda each: (undone[each], each))
        settings = [*head, f"{self.order} {period / self.steps!r} {period!r} {estimate!r}"]
        *told, seconds = answered(program, settings, rows)
        size = 2 * len(self.names)
        nothing = [float("nan")] * size
        ends = np.array([nothing if line == "failed" else list(map(float, line.split()))[:size] for line in told])
        return Spans(ends[:, 0::2], ends[:, 1::2]), float(seconds), estimate


def answered(program, settings, rows):
    """The lines that the driver says of some boxes."""
    body = [str(len(rows)), *(" ".join(map(repr, row)) for row in rows.tolist())]
    text = "\n".join([*settings, *body]) + "\n"
    return subprocess.run([program], input=text, capture_output=True, text=True, check=True).stdout.splitlines()


def written(expression, known):
    """A derivative in the language of Flow*, whose numbers may begin with a minus."""
    match expression:
        case Number(value):
            return f"({value.numerator} / {value.denominator})" if value.denominator != 1 else f"({value.numerator})"
        case Name(name):
            return known[name]
        case Sum(left, right):
            return f"({written(left, known)} + {written(right, known)})"
        case Product(left, right):
            return f"({written(left, known)} * {written(right, known)})"
        case Quotient(left, right):
            return f"({written(left, known)} / {written(right, known)})"
        case Power(base, exponent):
            return f"({written(base, known)}^{exponent})"
        case Call("tan", argument, None):
            inner = written(argument, known)
            return f"(sin({inner}) / cos({inner}))"
        case Call(("sin" | "cos" | "exp" | "sqrt") as function, argument, None):
            return f"{function}({written(argument, known)})"
    raise AssertionError(expression)


def built(folder, place):
    """The driver, linked with the library of a checkout."""
    toolbox = folder / "flowstar-toolbox"
    if not (toolbox / "libflowstar.a").exists():
        subprocess.run(["make", "CXX=g++ -w", "lib"], cwd=toolbox, check=True)
    program, source = place / "driver", Path(__file__).with_name("flowstar_driver.cpp")
    libraries = ["-lflowstar", "-lmpfr", "-lgmp", "-lgsl", "-lgslcblas", "-lm", "-lglpk"]
    command = ["g++", "-w", "-O3", "-std=c++11", f"-I{toolbox}", "-o", program, source, f"-L{toolbox}", *libraries]
    subprocess.run(command, check=True)
    return program


def compared(name, count, rounds, program):
    """Ratios of width and of time of one plant; None where Flow* does not do all of its boxes."""
    step = Step(name, count)
    step.ours()  # writes its programs
    taken = []
    for _ in range(rounds):
        ours, mine = step.ours()
        theirs, peers, estimate = step.theirs(program)
        taken.append((mine, peers))
    widths, least = [span.high - span.low for span in (ours, theirs)], 1e-12 * (1.0 + ours.largest)
    wide, done = (widths[0] > least) & (widths[1] > least), int(np.isfinite(theirs.low).all(axis=1).sum())
    width = np.exp(np.log(widths[0][wide] / widths[1][wide]).mean()) if done else float("nan")
    mine, peers = np.median(np.array(taken), axis=0)
    ratio = np.median([a / b for a, b in taken])
    print(
        f"{name:<22} order {step.order}, {step.steps} steps: width {width:.3f}, time {ratio:.3f} ({mine:.3f} s beside "
        f"{peers:.3f} s), {done:,} of {count:,} boxes done by Flow*, estimate {estimate:g}",
        file=sys.stderr,
    )
    return (width, ratio) if done == count else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", default=list(NAMES))
    parser.add_argument("--flowstar", type=Path, help="a checkout of Flow*")
    parser.add_argument("--boxes", type=int, default=1_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.flowstar is None or not (options.flowstar / "flowstar-toolbox" / "Makefile").exists():
        print("nothing measured: --flowstar names no checkout of Flow*", file=sys.stderr)
        raise SystemExit(0)
    with tempfile.TemporaryDirectory() as folder:
        program = built(options.flowstar, Path(folder))
        rows = [compared(name, options.boxes, options.rounds, program) for name in options.names]
    whole = [row for row in rows if row is not None]
    means = np.exp(np.log(np.array(whole)).mean(axis=0)).tolist() if whole else []
    figures = [
        {"name": name, "value": value, "reach": reach, "stretch": stretch, "better": better}
        for (name, (reach, stretch, better)), value in zip(TARGETS.items(), means, strict=False)
    ]
    if options.json:
        print(json.dumps({"figures": figures}))
    else:
        for each in figures:
            bars = f"reach {each['reach']}, stretch {each['stretch']}"
            print(f"{each['name']}, geometric mean: {each['value']:.3f} ({bars})")


if __name__ == "__main__":
    main()
