"""Pages of agents that test sums or give numbers: the page computes the reference's bits and draws tests as lines."""

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from maviper.page.document import Contents, about, bound_sliders, outputs_data, plane, usual_claims
from maviper.page.page import contents_of, page
from tests.maviper.page.browsers import in_chromium, in_node
from tests.support import summed

STEERING = """
def act(x):
    if x[0] - x[1] <= 0.25:
        if x[0] + x[1] <= 0:
            return [-0.5 * x[0] - x[2], -0.5 * x[1] - x[3]]
        return [0.5, -x[3]]
    return [-x[2], 0.75]
"""
TOLD = """
  return given.map(([number, seen]) => {
    const agent = game.agents[number];
    const leaf = Engine.path(agent.tree, seen).pop();
    const found = agent.outputs ? Engine.given(agent, agent.tree, leaf, seen) : agent.tree.action[leaf];
    const coded = Policy.ACT[agent.name](seen);
    if (JSON.stringify(coded) !== JSON.stringify(found)) throw new Error(`${agent.name}: ${coded} and ${found}`);
    return [leaf, agent.outputs ? found.map((x) => (Object.is(x, -0) ? "-0" : x)) : found];
  });
"""


def steering():
    said = Said(arrays="float32", outputs=("force_x", "force_y"))
    return profile_of(from_python(STEERING.encode(), "steer.py", said), Names(outputs=said.outputs))


def finite_rows(policy, count):
    rng = np.random.default_rng(1)
    rows = np.concatenate(list(probes.telling(policy, rng)))
    rows = rows[np.isfinite(rows).all(axis=1)]
    if policy.outputs:  # JSON has no infinities
        rows = rows[np.isfinite(ir.outputs(policy, rows)).all(axis=1)]
    return rows[rng.permutation(len(rows))[:count]]


def test_the_page_gives_the_references_bits(tmp_path):
    profile = summed.together(3, inner=0.3, over=0.3)
    given, expected = [], []
    for number, policy in enumerate(profile.agents):
        rows = finite_rows(policy, 200)
        given += [[number, row] for row in rows.astype(float).tolist()]
        does = ir.outputs(policy, rows).astype(float) if policy.outputs else ir.act(policy, rows)
        leaves = ir.apply(policy.tree, rows).tolist()
        expected += [[leaf, signed(one)] for leaf, one in zip(leaves, does.tolist(), strict=True)]
    assert len(expected) > 1_500
    found = in_node(page(profile, Contents()), TOLD, given, tmp_path)
    assert [[leaf, read(one)] for leaf, one in found] == expected


def signed(given):
    """Numbers as the script gives them back: JSON would lose the sign of -0."""
    if isinstance(given, int):
        return given
    return ["-0" if value == 0 and np.signbit(value) else value for value in given]


def read(given):
    """And back: JavaScript writes large numbers as whole ones."""
    return given if isinstance(given, int) else [one if one == "-0" else float(one) for one in given]


def test_a_page_that_adds_in_doubles_is_found_out(tmp_path):
    profile = summed.together(3)
    place, policy = next((at, one) for at, one in enumerate(profile.agents) if one.tree.arithmetic == "float32 steps")
    given = [[place, row] for row in finite_rows(policy, 400).astype(float).tolist()]
    html = page(profile, Contents())
    right = 'arithmetic === "float32 steps" ? Math.fround : same'
    assert right in html
    with pytest.raises(AssertionError, match="agent_"):
        in_node(html.replace(right, "same"), TOLD, given, tmp_path)


def test_lines_part_what_the_tree_parts(tmp_path):
    """The middle of each leaf's polygon reaches the leaf, and each line's ends are where its test turns."""
    profile = steering()
    (policy,) = profile.agents
    script = """
      const [agent] = game.agents;
      return given.map(([seen, axes]) => Engine.pieces(agent, agent.tree, seen, axes, [[-1, 1], [-2, 2]]));
    """
    seen = [0.5, 0.125, 0.25, -0.75]
    asked = [[seen, axes] for axes in ([0, 1], [1, 0], [1, 2])]
    lines = 0
    told = in_node(page(profile, Contents()), script, asked, tmp_path)
    for (_, axes), found in zip(asked, told, strict=True):
        leaves = [area for area in found["areas"] if policy.tree.feature[area["node"]] < 0]
        assert leaves
        for area in leaves:
            row = list(seen)
            for axis, value in zip(axes, np.mean(area["polygon"], axis=0).tolist(), strict=True):
                row[axis] = value
            assert ir.apply(policy.tree, [row]).tolist() == [area["node"]]
        for cut in found["cuts"]:
            (each,) = (policy.tree.sums[int(policy.tree.feature[cut["node"]]) - 4],)
            for end in cut["line"]:
                row = np.array([seen])
                row[0, axes] = end
                assert each.value(row, "float64")[0] == pytest.approx(float(policy.tree.threshold[cut["node"]]))
                lines += 1
    assert lines >= 8


def test_bars_arrows_and_lines_are_drawn_and_the_point_is_moved(tmp_path):
    profile = steering()
    script = """
      const count = (what) => document.querySelectorAll(what).length;
      const bars = () => [...document.querySelectorAll("#bars-0 > svg[aria-label^=force_]")];
      const said = () => bars().map((one) => one.getAttribute("aria-label"));
      const [x, y] = document.querySelectorAll('#sliders input[type="number"]');
      const type = (field, value) => { field.value = value; field.dispatchEvent(new Event("input")); };
      const before = { cuts: count("#plot .cut"), arrows: count("#plot .arrow"), leaves: count("#plot .leaf"), wide:
        document.documentElement.scrollWidth - document.documentElement.clientWidth };
      type(x, -0.25);
      type(y, 0.125);
      const moved = said();
      const up = document.getElementById("up");
      up.value = "2";
      up.dispatchEvent(new Event("change"));
      const says = document.getElementById("says-0").textContent;
      return [before, moved, says, count("#plot .cut"), count("#bars-0 .arrow")];
    """
    for width in (400, 1400):
        before, bars, says, cuts, arrows = in_chromium(page(profile, Contents()), script, [], tmp_path, width)
        assert before == {"cuts": 2, "arrows": 36, "leaves": 3, "wide": 0}
        assert [bar.partition(",")[0] for bar in bars] == ["force_x 0.125", "force_y -0.0625"]
        assert says.startswith("force_x = -0.5 x0 - x2, force_y = -0.5 x1 - x3, leaf 2; nearest test: x0 + x1, 0.125")
        assert (cuts, arrows) == (1, 1)  # the other test turns at the edge


def test_the_point_of_a_slice_is_dragged(tmp_path):
    script = """
      const plot = document.getElementById("plot");
      plot.setPointerCapture = () => {};
      const box = plot.getBoundingClientRect();
      const [wide, tall] = [box.width / 120, box.height / 104];
      const at = (x, y) => ({ clientX: box.left + x * wide, clientY: box.top + y * tall, pointerId: 1 });
      plot.dispatchEvent(new PointerEvent("pointerdown", at(66, 47)));
      plot.dispatchEvent(new PointerEvent("pointermove", at(14, 2)));
      plot.dispatchEvent(new PointerEvent("pointerup", at(14, 2)));
      plot.dispatchEvent(new PointerEvent("pointermove", at(100, 90)));
      const fields = [...document.querySelectorAll('#sliders input[type="number"]')];
      return fields.slice(0, 2).map((one) => Number(one.value));
    """
    profile = steering()
    (low, _), (_, high), *_ = bound_sliders(profile.agents[0])
    found = in_chromium(page(profile, Contents()), script, [], tmp_path)
    assert found == pytest.approx([low, high], abs=1e-2)


def test_words_and_ranges_of_outputs():
    profile = steering()
    (policy,) = profile.agents
    assert about(profile).endswith(
        "It observes 4 numbers (x0, x1, x2, x3) and gives 2 numbers (force_x, force_y) at each step."
    )
    assert plane(policy) == (0, 1) and usual_claims(profile) == ()
    ranges = bound_sliders(policy)
    assert ranges[0][0] <= 0 <= 0.25 <= ranges[0][1] and ranges[1][0] <= -0.25  # each test can be turned by each
    data = outputs_data(policy, [(-1.0, 1.0)] * 4)
    assert [one["span"] for one in data] == [(-1.5, 1.5), (-1.5, 1.5)]
    bounded = summed.policy(0, "float64", outputs=3)
    assert plane(bounded) is None
    assert {one["span"] for one in outputs_data(bounded, [(-1.0, 1.0)] * 5)} == {(-1.0, 1.5)}


def test_a_page_of_sums_with_actions_colours_its_slice(tmp_path):
    profile = summed.profile(summed.policy(5, "double sums"))
    html = page(profile, contents_of(profile, usual_claims(profile)))
    script = """
      const fills = [...document.querySelectorAll("#plot .leaf")].map((one) => one.getAttribute("fill"));
      return [fills.length, document.querySelectorAll("#plot .inside").length, document.getElementById("toned").hidden];
    """
    leaves, texts, hidden = in_chromium(html, script, [], tmp_path)
    assert leaves >= 1 and texts == 36 and hidden
