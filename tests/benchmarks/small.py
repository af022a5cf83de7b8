"""A decision on a Cortex-M0, of one tree of 40 leaves over whole numbers: its instructions and bytes, beside others.

    python -m tests.benchmarks.small [--tinymind FOLDER] [--json]

gcc at -Os. Instructions: what an emulated core executes to decide for rows at each threshold and next to it, from the
first of the function to its return; the mean of a row. Bytes: the text of the object that decides, with its tables.
Each decision is compared with scikit-learn's. emlearn asks x < t, with t cut to a whole number: it is given the number
after each threshold. Its function counts votes; the tree alone is what it calls for them. FOLDER is the folder cpp of
tinymind, whose template walks a table of nodes.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen.importers.scikit import from_sklearn
from codegen.targets import emit
from tests.benchmarks.common import figure, reader, tell
from tests.support.machines import EMULATOR, VECTORS

FEATURES, LEAVES = 6, 40
COMPILER = "arm-none-eabi-gcc -mcpu=cortex-m0 -mthumb -Os -fno-exceptions -specs=rdimon.specs".split()  # noqa: SIM905
TRACED = "-semihosting-config enable=on,target=native -singlestep -d exec,nochain -D log".split()  # noqa: SIM905
WHOLE = "#include <stdint.h>\ntypedef int16_t number;\n"
DECIDE = "int decide(const number *x) {{ return {}; }}\n"
MAIN = """
int decide(const number *x);
static const number rows[][{features}] = {{{rows}}};
static const unsigned char wanted[] = {{{wanted}}};
int main(void)
{{
    int wrong = 0;
    for (unsigned row = 0; row < sizeof wanted; row++) wrong |= decide(rows[row]) ^ wanted[row];
    return wrong;
}}
"""
TINYMIND = """
#include "{folder}/qtree.hpp"
static const tinymind::QTreeNode<int16_t> nodes[] = {{{nodes}}};
static constexpr tinymind::QDecisionTree<int16_t, int16_t, {count}, {features}> tree{{nodes}};
extern "C" """


def fitted():
    """The tree, over numbers of 12 bits."""
    x = np.random.default_rng(0).integers(0, 4096, (4_000, FEATURES))
    y = (x[:, 0] > x[:, 1]).astype(int) + 2 * (x[:, 2] + x[:, 3] / 2 > 3000)
    return DecisionTreeClassifier(max_depth=6, max_leaf_nodes=LEAVES, random_state=0).fit(x, y)


def ways(folder):
    """The source of each way to decide."""
    for name, numbers, style in (("whole numbers", "int16", "nested"), ("ordered", "", "ordered")):
        (header,) = emit(from_sklearn(fitted(), numbers=numbers), ["c"], prefix="ours", style=style).values()
        head = WHOLE if numbers else "typedef float number;\n"
        yield f"maviper, {name}", head + header + DECIDE.format("ours_agent_0_act(x)")
    try:
        import emlearn
    except ImportError:
        print("emlearn is not installed: pip install emlearn", file=sys.stderr)
    else:
        model = fitted()
        model.tree_.threshold[:] = np.floor(model.tree_.threshold) + 1
        text = emlearn.convert(model, dtype="int16_t").save(name="their", include_proba=False)
        yield "emlearn, int16", WHOLE + text.replace("their_predict", "decide")
        alone = text.replace("int32_t their_predict", "static int32_t their_predict")
        yield "emlearn, the tree alone", WHOLE + alone + DECIDE.format(f"their_tree_0(x, {FEATURES})")
    if folder:
        tree = fitted().tree_
        columns = tree.feature, np.floor(tree.threshold), tree.children_left, tree.children_right
        nodes = np.stack([*columns, tree.value[:, 0].argmax(axis=1)], axis=1).astype(int).tolist()
        listed = str(nodes)[1:-1].replace("[", "{").replace("]", "}")
        head = TINYMIND.format(folder=Path(folder).resolve(), nodes=listed, count=len(nodes), features=FEATURES)
        yield "tinymind, int16", WHOLE + head + DECIDE.format("tree.predict(x)")


def measure(source, place, decides=True):
    """Instructions of a whole program that decides for all rows, a row, and bytes of what decides."""
    model, rng = fitted(), np.random.default_rng(1)
    split = model.tree_.feature >= 0
    at = np.floor(model.tree_.threshold[split])
    rows = rng.integers(0, 4096, (3 * len(at), FEATURES))
    rows[np.arange(len(rows)), np.tile(model.tree_.feature[split], 3)] = np.concatenate([at - 1, at, at + 1])
    wanted = model.predict(rows) if decides else np.zeros(len(rows), dtype=int)
    numbers = {"rows": ", ".join(map(str, rows.ravel())), "wanted": ", ".join(map(str, wanted))}
    head = "".join(line for line in source.splitlines(keepends=True)[:2] if line.startswith(("typedef", "#include")))
    name = "decide.cpp" if "tinymind" in source else "decide.c"
    Path(place, name).write_text(source)
    Path(place, "main.c").write_text(head + MAIN.format(features=FEATURES, **numbers))
    Path(place, "vectors.c").write_text(VECTORS)
    for command in (
        [*COMPILER, "-c", name, "-o", "decide.o"],
        [*COMPILER, "vectors.c", "main.c", "decide.o", "-Wl,--section-start=.vectors=0", "-o", "program"],
        [*EMULATOR, *TRACED],  # which fails where a decision is another
        ["arm-none-eabi-size", "decide.o"],
    ):
        told = subprocess.run(command, cwd=place, check=True, capture_output=True, text=True).stdout
    return Path(place, "log").read_text().count("Trace ") / len(rows), int(told.splitlines()[1].split()[0])


def main():
    parser = reader(__doc__)
    parser.add_argument("--tinymind", metavar="FOLDER")
    options = parser.parse_args()
    found = []
    with tempfile.TemporaryDirectory(prefix="maviper-") as place:
        nothing = measure(WHOLE + DECIDE.format(0), place, decides=False)[0] - 2  # it executes two itself
        for name, source in ways(options.tinymind):
            executed, size = measure(source, place)
            found.append(figure(f"{name}: instructions a decision", executed - nothing))
            found.append(figure(f"{name}: bytes", size))
    tell(found, options.json)


if __name__ == "__main__":
    main()
