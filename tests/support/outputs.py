"""Monitors of agents that give numbers: what each language makes of outputs, after a step that is OK."""

import ctypes
import json
import shutil
import subprocess

import numpy as np

from codegen.agreement.compiled import STRICT, find_compiler

PROGRAM = """#include "{p}_monitor.h"
void run(const double *given, long n, double *found);
void run(const double *given, long n, double *found)
{{
    static const double x[{size}] = {{0.0}};
    long i;
    int k;
    for (i = 0; i < n; i++) {{
        {p}_monitor m;
        {kind} y[{K}];
        int word;
        {p}_monitor_start(&m);
        for (k = 0; k < 2; k++) {{
            {p}_monitor_renew_all(&m);
            (void){p}_monitor_step(&m, x, {p_upper}_M_DT);
        }}
        for (k = 0; k < {K}; k++) {{
            y[k] = ({kind})given[i * {K} + k];
        }}
        word = {p}_monitor_{agent}(&m, y);
        {p}_monitor_renew_all(&m);
        found[i * ({K} + 1)] = ({p}_monitor_step(&m, x, {p_upper}_M_DT) == word) ? word : -1; /* it stays */
        for (k = 0; k < {K}; k++) {{
            found[i * ({K} + 1) + k + 1] = y[k];
        }}
    }}
}}
"""
SCRIPT = """import { Monitor, DT } from "./MODULE";
const number = (each) => ({ nan: NaN, inf: Infinity, "-inf": -Infinity })[each] ?? each;
console.log(JSON.stringify(GIVEN.map((given) => {
  const m = new Monitor();
  m.renew_all();
  m.step(new Array(SIZE).fill(0), DT);
  const outputs = m.give("AGENT", given.map(number));
  return [m.word, ...outputs];
})));
"""


def given_by(texts, watched, folder, given):
    """By language the rows of word and outputs, for the outputs `given` [n, outputs] of the first agent."""
    found = {"python": _python(texts, watched, given)}
    if find_compiler() is not None:
        found["c"] = _c(texts, watched, folder, given)
    if shutil.which("node"):
        found["javascript"] = _javascript(texts, watched, folder, given)
    return found


def _python(texts, watched, given):
    space, name = {}, watched.fallbacks[0].agent.name
    exec(compile(texts[f"{watched.model.prefix}_monitor.py"], "monitor", "exec"), space)
    rows = []
    for each in given:
        found = space["Monitor"]()
        found.renew_all()
        assert found.step([0.0] * len(watched.places), space["DT"]) == 0
        outputs = found.give(name, each)
        rows.append([int(found.word), *outputs])
    return rows


def _c(texts, watched, folder, given):
    p, agent = watched.model.prefix, watched.fallbacks[0].agent
    names = {"p": p, "p_upper": p.upper(), "size": watched.size, "K": len(given[0])}
    names |= {"kind": agent.summed.kind, "agent": agent.lower}
    (folder / "run.c").write_text(PROGRAM.format(**names))
    for name, text in texts.items():
        if name.endswith(".h"):
            (folder / name).write_text(text)
    command = [*find_compiler(), *STRICT, "-O1", "-ffp-contract=off", "-shared", "-fPIC", "run.c", "-o", "run.so"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    asked, found = np.array(given), np.zeros((len(given), len(given[0]) + 1))
    pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (asked, found)]
    ctypes.CDLL(str(folder / "run.so")).run(pointers[0], ctypes.c_long(len(given)), pointers[1])
    return [[int(row[0]), *row[1:].tolist()] for row in found]


def _javascript(texts, watched, folder, given):
    name = f"{watched.model.prefix}_monitor.mjs"
    (folder / name).write_text(texts[name])
    told = json.dumps([[each if np.isfinite(each) else str(each) for each in row] for row in given])
    words = {"MODULE": name, "GIVEN": told, "SIZE": len(watched.places), "AGENT": watched.fallbacks[0].agent.name}
    script = SCRIPT
    for word, text in words.items():
        script = script.replace(word, str(text))
    (folder / "run.mjs").write_text(script)
    done = subprocess.run(["node", "run.mjs"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
