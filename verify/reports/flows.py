"""What reports say of continuous time, and errors in words.

Does: the sentence of what verdicts about a flow are about; numbers rounded so that a bound stays one.
Assumes: checked systems.
Does not: collect facts (systems.py).
"""

from decimal import ROUND_CEILING, Context, Decimal
from fractions import Fraction

from codegen.wording import format_count
from verify.decimals import plain
from verify.systems.system import Flow

DIGITS = 6  # of an error in words
SEMANTICS = (
    "A state is an exact number for each variable. At the start and after each period an agent observes the exact "
    "value of each feature, rounded once to what it compares, float32 or float64. A split goes left iff x <= "
    "threshold. The engines use the exact end of the half line on which this is true after rounding. The action "
    "is held until the next of these samples. At every moment the derivative of a variable is what the world file "
    "gives for the state and the actions, and an error anywhere within its bounds is added, which may change at "
    "any time."
)
VIOLATED = "fails in the episode shown, which was followed in enclosures that leave no doubt"
ONE_READING = (
    "The search tries its plans by the checker's own steps, so a proof has one reading of the flow. Episodes that "
    "other code played beside it broke no claim that is proved."
)
PERIODS = "A claim about episodes covers only the periods that it names. Its steps are periods."


def sentence(flow: Flow) -> str:
    """Describes what verdicts about continuous time are about."""
    errors = {name: max(map(abs, bounds)) for name, bounds in flow.errors.items()}
    told = ", ".join(f"{name} {upwards(error)} a second" for name, error in errors.items())
    jumping = list(dict.fromkeys(name for each in flow.each for name in each.jumps if name not in flow.kept))
    jumps = f", jumps of {', '.join(jumping)} at samples" if jumping else ""
    cases = f" in {format_count(len(flow.cases), 'case')}" if flow.cases else ""
    often = f"of the stated flow{cases}, with actions held for {_periods(flow)}{_delays(flow)}{jumps}"
    return often + (f" and derivatives off by at most {told}" if told else ", exactly")


def _periods(flow: Flow) -> str:
    if not any(flow.jitter):
        return f"{plain(flow.period)} s"
    low, high = (flow.period + end for end in flow.jitter)
    return f"{plain(low)} to {plain(high)} s"


def _delays(flow: Flow) -> str:
    """Describes how late observations are."""
    if not flow.kept:
        return ""
    most = len(flow.kept) // len(set(flow.kept.values()))
    least = most + 1 - len(flow.seen)
    return f", observations late by {f'{least} to {most} periods' if least < most else format_count(most, 'period')}"


def upwards(number: Fraction | float, digits: int = DIGITS) -> str:
    """A number with so many digits at most, never below it."""
    return short(Fraction(number), digits, ROUND_CEILING)


def short(number: Fraction, digits: int, rounding: str) -> str:
    """A number with so many digits at most, rounded as decimal's modes say."""
    exact = Context(prec=digits, rounding=rounding).divide(Decimal(number.numerator), Decimal(number.denominator))
    near = float(exact)
    return f"{near:.{digits}g}" if near or not number else str(exact)
