"""Programs that try to do something else than compute, and a generator of them.

Does: writes Python whose function `act` looks like a controller; each reaches for files, processes, modules or names
  through an expression, a statement, a default, a class, or what it returns.
Assumes: nothing. Canaries stand in `tests/codegen/importers/running/test_hostile.py`.
Does not: run any.
"""

from collections.abc import Iterator
from pathlib import Path

CANARY = "CANARY"  # replaced by a path that must not come to be

# what a program would do if it could reach it: each is an expression
REACHES = (
    "open('CANARY', 'w')",
    "__import__('os').system('touch CANARY')",
    "eval(\"open('CANARY', 'w')\")",
    "exec(\"open('CANARY', 'w')\")",
    "compile('1', 'a', 'eval')",
    "globals()['__builtins__']",
    "vars()",
    "getattr(x, '__class__')",
    "().__class__.__base__.__subclasses__()",
    "(1).__class__.__mro__[1].__subclasses__()",
    "''.__class__",
    "[].append.__self__",
    "print.__self__.open('CANARY', 'w')",
    "max.__self__",
    "(lambda: 0).__globals__",
    "(lambda: 0).__code__",
    "(lambda: 0).__builtins__",
    "(i for i in x).gi_frame.f_back.f_builtins",
    "(i for i in x).gi_code",
    "'{0.__class__}'.format(x)",
    "'{0.gi_frame}'.format((i for i in x))",
    "'{a}'.format_map({'a': x})",
    "f'{x.__class__}'",
    "f'{x!r:{x}}'",
    "f'{().__class__.__base__}'",
    "str.format('{0.__class__}', x)",
    "type(x)",
    "type('A', (), {})",
    "super().__getattribute__('x')",
    "object.__subclasses__()",
    "breakpoint()",
    "input()",
    "help()",
    "memoryview(b'a')",
    "b'bytes'",
    "1j",
    "dir()",
    "setattr(x, 'a', 1)",
    "delattr(x, 'a')",
    "hash(x)",
    "id(x)",
    "iter(x).__reduce__()",
    "x.__reduce_ex__(2)",
    "x.tofile('CANARY')",
    "x.dump('CANARY')",
    "x.ctypes.data",
    "x.__array_interface__",
    "np.load('CANARY')",
    "np.save('CANARY', [1])",
    "np.savetxt('CANARY', [1])",
    "np.fromfile('CANARY')",
    "np.memmap('CANARY', mode='w+', shape=1)",
    "np.genfromtxt('CANARY')",
    "np.loadtxt('CANARY')",
    "np.DataSource().open('CANARY')",
    "np.ctypeslib.load_library('c', '/')",
    "np.f2py.compile('x')",
    "np.core.multiarray",
    "np.os.system('touch CANARY')",
    "np.__builtins__",
    "np.asarray(x).tofile('CANARY')",
    "np.array([1]).dump('CANARY')",
    "np.frompyfunc(open, 2, 1)('CANARY', 'w')",
    "np.vectorize(open)('CANARY', 'w')",
    "np.abs.__self__",
    "np.clip.__globals__",
    "np.clip.__wrapped__",
    "math.__loader__",
    "math.__spec__.loader",
    "math.sin.__self__",
    "os.system('touch CANARY')",
    "sys.modules['os']",
    "subprocess.run(['touch', 'CANARY'])",
    "socket.socket()",
    "ctypes.CDLL(None)",
    "importlib.import_module('os')",
    "\uff3f\uff3fimport\uff3f\uff3f('os')",
    "x.\uff3f\uff3fclass\uff3f\uff3f",
    "().__\uff43lass__",
    "(y := __builtins__)",
    "[y := open('CANARY', 'w') for _ in x]",
    "{open: 1 for _ in x}",
    "sorted(x, key=open)",
    "list(map(open, ['CANARY']))",
    "list(map(__import__, ['os']))",
    "reduce(getattr, ['__class__', '__base__'], x)",
    "partial(open, 'CANARY', 'w')()",
    "partial(max).func.__self__",
    "ValueError('a').__traceback__",
    "ValueError('a').with_traceback(None)",
    "logging.FileHandler('CANARY')",
    "logging.basicConfig(filename='CANARY')",
    "logging.getLogger().__class__",
    "Enum('A', 'b').__class__",
    "Enum.__members__",
    "Colour.RED.__class__.__mro__",
    "Colour.__class__",
    "namedtuple('A', '__class__')",
    "namedtuple('A', 'a').__new__.__globals__",
    "namedtuple('A', \"a'); open('CANARY', 'w'); ('\")",
    "dataclass(type)",
)
# where an expression stands; {e} is it
PLACES = (
    "{h}\ndef act(x):\n    {e}\n    return 1 if x[0] > 0 else 2\n",
    "{h}\nVALUE = {e}\ndef act(x):\n    return 1 if x[0] > 0 and VALUE is not None else 2\n",
    "{h}\ndef act(x, y={e}):\n    return 1 if x[0] > 0 else 2\n",
    "{h}\nclass A:\n    held = {e}\n    def act(self, x):\n        return self.held if x[0] > 0 else 2\n",
    "{h}\nact = lambda x: {e} if x[0] > 0 else 2\n",
    "{h}\ndef act(x):\n    return 1 if x[0] > 0 else {e}\n",
)
HEAD = """import math, os, sys, socket, subprocess, ctypes, importlib, logging
import numpy as np
from collections import namedtuple
from dataclasses import dataclass
from enum import Enum
from functools import partial, reduce
class Colour(Enum):
    RED = 1
"""
WHOLE = Path(__file__).with_name("hostile.txt").read_text().split("#----\n")  # programs that stand as they are


def list_programs() -> Iterator[str]:
    """Each whole program, and each reach at one place or two."""
    yield from WHOLE
    for place, reach in enumerate(REACHES):
        for frame in (PLACES[place % len(PLACES)], PLACES[(place * 5 + 3) % len(PLACES)]):
            yield frame.format(h=HEAD, e=reach)
