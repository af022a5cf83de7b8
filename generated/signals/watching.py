"""A monitor in C beside a signal in SUMO: is its phase, with its clocks, one of which the claim is proved for ever?

Does: exports the monitor that `maviper compile --target monitor` wrote of one signal; has it look at each step of 5 s.
Assumes: a world file of `worlds/`, whose numbers it counts in steps as `plant.py` does.
Does not: act: `imported_monitor_AGENT` gives a fallback where an application wants one.
"""

import ctypes

from junctions import STEP, Signal

SOURCE = """#include "{0}_monitor.h"
static {0}_monitor m;
void start(void) {{ {0}_monitor_start(&m); }}
int word(const double *w) {{ {0}_monitor_renew_all(&m); return {0}_monitor_step(&m, w, 1.0); }}
"""


class Watch:
    """Looks at a signal after each step. `counts`: of steps, and of those that were no longer of a proved state."""

    def __init__(self, signal: Signal, code: ctypes.CDLL, green: int) -> None:
        self.signal, self.code, self.ended, self.show = signal, code, green, signal.show
        self.counts = {"watched": 0, "doubted": 0}
        signal.show = self.look
        code.start()

    def look(self, phase: int) -> None:
        """Shows a phase, and asks the monitor."""
        signal, count = self.signal, len(self.signal.states)
        self.ended = self.ended if phase == signal.phase else signal.green
        self.show(phase)
        seen = signal.observe().astype(float)[count:]
        state = [signal.phase, seen[0] / STEP, self.ended / STEP, *seen[1 : count + 1] / STEP, *seen[count + 1 :]]
        self.counts["watched"] += 1
        self.counts["doubted"] += self.code.word((ctypes.c_double * len(state))(*state)) != 0
