"""Pages of odd profiles: names that look like markup, features without a meaning, many agents, large trees."""

import dataclasses
import json
import re

import numpy as np
import pytest

from codegen import ir
from codegen.dynamics import motionless
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.profiles import ensure
from maviper.files.profiles import load
from maviper.page.document import Contents, Recorded, Shown, Stored, about, bound_sliders, document, usual_claims
from maviper.page.page import MAX_RULES, contents_of, page
from tests.maviper.page.browsers import in_chromium, in_node, overhang, violations
from tests.support.odd_pages import with_trees
from tests.support.pages import GENERATED, committed

SHOWN = """
  const count = (what) => document.querySelectorAll(what).length;
  return {
    main: !document.getElementById("live").hidden,
    arena: getComputedStyle(document.getElementById("arena")).display,
    trees: count(".tree svg"),
    open: count("#trees details[open]"),
    wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    sliders: count("#sliders input"),
  };
"""


def without_meaning(profile):
    policies = tuple(
        dataclasses.replace(one, features=tuple(dataclasses.replace(each, meaning=None) for each in one.features))
        for one in profile.agents
    )
    return dataclasses.replace(profile, agents=policies)


def test_texts_do_not_become_markup(tmp_path):
    profile = committed("physical_deception")
    text = "</script><script>alert(1)</script><!--"
    hostile = dataclasses.replace(
        profile,
        world=dataclasses.replace(profile.world, reference=text),
        provenance=dataclasses.replace(profile.provenance, tool=text),
    )
    claim = dataclasses.replace(usual_claims(profile)[0].claim, label=text)
    html = page(hostile, Contents((Shown(claim, text),)))
    assert "<script>alert" not in html and html.count("<script") == page(profile, Contents()).count("<script")
    told = """
      const scripts = document.querySelectorAll("script").length;
      return [document.getElementById("claim").textContent, game.data.tool, scripts];
    """
    found = in_chromium(html, told, [], tmp_path)
    assert found == [f"{text} of the defenders", text, 6]  # two of them the test's


def test_a_profile_without_meanings_shows_trees_and_sliders(tmp_path):
    profile = without_meaning(committed("physical_deception"))
    html = page(profile, contents_of(profile, usual_claims(profile)))
    found = in_chromium(html, SHOWN, [], tmp_path)
    assert found["main"] and found["arena"] == "none" and found["trees"] == 3
    assert found["sliders"] == 2 * sum(len(one.features) for one in profile.agents)  # each with a field


def test_long_names_of_actions_and_features_stay_within_their_nodes(tmp_path):
    profile = without_meaning(with_trees(committed("physical_deception"), 3))
    names = ["MAINTAIN_HEADING", "WWWWWWWWWWWW", "Emergency_Shutdown_Of_Everything", "mmmmmmmm-mm", "x" * 40]
    policies = tuple(
        dataclasses.replace(
            one,
            actions=tuple(dataclasses.replace(each, name=name) for each, name in zip(one.actions, names, strict=True)),
            features=(dataclasses.replace(one.features[0], name="MMMMMMMMMMMMMMMMMMMM"), *one.features[1:]),
        )
        for one in profile.agents
    )
    html = page(dataclasses.replace(profile, agents=policies), Contents())
    script = """
      return [...document.querySelectorAll(".tree g")].flatMap((node) => {
        const box = node.querySelector("rect").getBBox();
        return [...node.querySelectorAll("text")].filter((text) => {
          const { x, width } = text.getBBox();
          return x < box.x || x + width > box.x + box.width;
        }).map((text) => [text.textContent, text.getBBox().width, box.width]);
      });
    """
    assert in_chromium(html, script, [], tmp_path) == []


def test_a_large_tree_folds_and_its_code_is_left_out(tmp_path):
    profile = with_trees(committed("physical_deception"), 12)
    html = page(ensure(profile), Contents(usual_claims(profile)))
    assert "const Policy = null;" in html and "4,096" not in html
    assert re.search(rf"{4096 - MAX_RULES} more leaves", html)
    drawn = "return document.querySelectorAll('#tree-1 g.leaf, #tree-1 g.folded').length;"
    wide, small = (in_chromium(html, drawn, [], tmp_path, width) for width in (1900, 400))
    assert 20 <= wide <= 30 + 12 and 4 <= small <= 8 + 12  # with the path that is taken
    script = "const at = Engine.coordinates(game, given); return Engine.actions(game, at).length;"
    state = {"position": [[0.1, 0.2]] * 5, "velocity": [[0, 0]] * 3, "goal": 0}
    assert in_node(html, script, state, tmp_path) == 3


CUT = """
  const boxes = [...document.querySelectorAll("body *")].filter((one) => one instanceof HTMLElement && one.clientWidth);
  const wide = boxes.filter((one) => one.scrollWidth > one.clientWidth && getComputedStyle(one).display !== "inline");
  return [document.querySelectorAll("main").length, wide.map((one) => one.tagName + one.className)];
"""


@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("name", ["physical_deception", "physical_deception/extracted", "proved_navigation"])
def test_nothing_of_a_page_is_cut_off_or_scrolled_sideways(name, width, tmp_path):
    for file in ("play.html", "report.html"):
        html = (GENERATED / name / file).read_text()
        if file == "report.html":  # which has no scripts
            html = html.replace("</main>", f"</main>{EMPTY}")
        assert in_chromium(html, CUT, [], tmp_path, width) == [1, []], file


EMPTY = '<script type="application/json" id="data">null</script><script>window.maviper = {};</script>'


def test_names_of_entities_do_not_cover_each_other(tmp_path):
    """All in one place but for a little: each name has a place of its own."""
    profile = committed("physical_deception")
    script = """
      const state = window.maviper.state();
      window.maviper.restart({ ...state, position: state.position.map((_, i) => [0.05 * i, 0.04 * i]) });
      const boxes = [...document.querySelectorAll("#scene text")].map((one) => one.getBoundingClientRect());
      const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 4 || b.bottom <= a.top + 4;
      return boxes.flatMap((a, i) => boxes.slice(0, i).filter((b) => !apart(a, b))).length;
    """
    assert in_chromium(page(profile, Contents()), script, [], tmp_path) == 0


def test_a_folded_part_opens_by_the_keyboard(tmp_path):
    profile = with_trees(committed("physical_deception"), 12)
    script = """
      const count = () => document.querySelectorAll("#tree-1 g").length;
      const [before, folded] = [count(), document.querySelector("#tree-1 g.folded")];
      folded.focus();
      folded.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true, cancelable: true }));
      return [count() > before, document.activeElement.tagName.toLowerCase()];
    """
    assert in_chromium(page(ensure(profile), Contents()), script, [], tmp_path) == [True, "g"]


def test_a_page_without_a_counterexample_opens_at_the_same_start_for_everybody(tmp_path):
    html = page(committed("physical_deception"), Contents())
    script = 'return [window.maviper.state(), document.getElementById("try").textContent];'
    (first, said), second = (in_chromium(html, script, [], tmp_path) for _ in range(2))
    assert [first, said] == second and said.startswith("Drag adversary_0, or move it with the arrow keys")


def test_no_committed_page_is_wider_than_a_small_screen(tmp_path):
    pages = sorted(GENERATED.rglob("*.html"))
    assert len(pages) > 10
    assert dict(zip(pages, overhang(pages, tmp_path, 400), strict=True)) == dict.fromkeys(pages, 0)
    wide = tmp_path / "wide.html"
    wide.write_text("<!DOCTYPE html><body style='margin:0'><div style='width:409px'>a</div></body>")
    assert overhang([wide], tmp_path, 400) == [9]


def test_many_agents_show_the_tree_of_one(tmp_path):
    from maviper.worlds import find_built_in
    from tests.hunting.teams import bare

    world = find_built_in("cooperative-navigation,agents=20")
    profile = bare(world.name)
    found = in_chromium(page(profile, Contents(usual_claims(profile))), SHOWN, [], tmp_path)
    assert found["open"] == 1 and found["trees"] == 1


def test_space_presses_a_focused_button_while_somebody_steers(tmp_path):
    """The space key steers nobody into staying when it is pressed on a button: the button is what it is for."""
    profile = committed("physical_deception")
    script = """
      const press = (on) => {
        const event = new KeyboardEvent("keydown", { key: " ", bubbles: true, cancelable: true });
        on.dispatchEvent(event);
        return [event.defaultPrevented, document.getElementById("scrub").value];
      };
      document.getElementById("steer").click();
      return [press(document.getElementById("random")), press(document.body)];
    """
    html = page(profile, contents_of(profile, usual_claims(profile)))
    assert in_chromium(html, script, [], tmp_path) == [[False, "0"], [True, "1"]]


def test_scrubbing_and_stepping_make_the_same_episode(tmp_path):
    profile = committed("physical_deception")
    script = """
      const { restart, advance, scrub, state } = window.maviper;
      const start = state();
      scrub(9);
      const far = JSON.stringify(state());
      scrub(4);
      for (let i = 0; i < 5; i++) advance();
      const along = JSON.stringify(state());
      restart(start);
      for (let i = 0; i < 9; i++) advance();
      return [far === along, far === JSON.stringify(state()), document.getElementById("time").textContent];
    """
    assert in_chromium(page(profile, Contents()), script, [], tmp_path) == [True, True, "step 9, 0.9 s"]


def test_the_address_of_a_claim_opens_its_counterexample(tmp_path):
    profile = committed("physical_deception")
    claims = usual_claims(profile)[:2]
    names = [f"{one.name}.{axis}" for one in profile.world.agents + profile.world.landmarks for axis in "xy"]
    place = {name: 0.01 * number for number, name in enumerate(names)}
    html = page(profile, Contents(claims, (Stored("one", 1, place, "landmark_1"),)))
    named = '<script>history.replaceState(null, "", "#claim-2");</script><script type="application/json" id="data">'
    html = html.replace('<script type="application/json" id="data">', named)
    script = 'return [document.getElementById("claim").value, window.maviper.state()];'
    claim, state = in_chromium(html, script, [], tmp_path)
    assert claim == "1" and state["goal"] == 1 and state["position"][1] == [0.02, 0.03]


def pushed(low, high, names=("push_left", "push_right")):
    """One agent of one feature with that range, without places: left up to 0.03, then right."""
    features = (ir.FeatureSpec("pole_angle", "rad", low, high, None),)
    actions = tuple(ir.ActionSpec(name, None) for name in names)
    tree = ir.Tree([0, -1, -1], [0.03, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])
    policy = ir.AgentPolicy("agent", "agent", features, actions, tree)
    provenance = ir.Provenance("hand-made", "none", 0, "", "tests")
    return ensure(ir.PolicyProfile(motionless("cart", "none", ["agent"], 9), (policy,), provenance))


def test_a_recorded_episode_is_gone_through_and_a_field_changes_it(tmp_path):
    """Without rules of the game: what was observed is shown step by step, and what somebody types in is decided."""
    seen = np.array([[-0.5], [0.25], [0.75]], np.float32)
    html = page(pushed(-1.0, 1.0), Contents(recorded=Recorded((seen,), "The recorded episode took 3 steps.")))
    script = """
      const text = (id) => document.getElementById(id).textContent;
      const said = () => [text("time"), text("says-0").slice(0, 12)];
      const [slider, field] = document.querySelectorAll("#sliders input");
      const found = [[...said(), Number(field.value)]];
      window.maviper.scrub(1);
      found.push([...said(), Number(field.value)]);
      document.getElementById("step").click();
      document.getElementById("step").click();
      found.push([...said(), Number(slider.value)]);
      field.value = "-0.125";
      field.dispatchEvent(new Event("input"));
      found.push([...said(), Number(slider.value)]);
      field.value = "";
      field.dispatchEvent(new Event("input"));
      found.push(said());
      return [found, document.getElementById("about").textContent];
    """
    found, about = in_chromium(html, script, [], tmp_path)
    left, right = "\u2190 push_left,", "\u2192 push_right"
    assert found == [
        ["step 0", left, -0.5],
        ["step 1", right, 0.25],
        ["step 2", right, 0.75],
        ["step 2, changed", left, -0.125],
        ["step 2, changed", left],
    ]
    assert about == (
        "cart is a game of one agent. It observes 1 number (pole_angle) and chooses one of 2 actions (push_left, "
        "push_right) at each step, for at most 9 steps. The recorded episode took 3 steps."
    )


TANK = """
def tank(level, temp):
    if level < 0.1:
        return "fill"
    if level > 23.25:
        return "drain"
    return "cool" if temp >= 36.6 else "wait"
"""


def test_a_field_says_the_number_that_decides(tmp_path):
    """Of float64: the last number below 36.6 is another one, and the slider's hand means few digits."""
    profile = profile_of(from_python(TANK.encode(), "tank.py"), Names())
    script = """
      const said = () => document.getElementById("says-0").textContent.split(",")[0];
      const [, level, slider, temp] = document.querySelectorAll("#sliders input");
      const set = (one, text) => {
        one.value = text;
        one.dispatchEvent(new Event("input"));
        return [Number(level.value), Number(temp.value), said()];
      };
      const first = [Number(temp.value), said()];
      const tests = [...document.querySelectorAll("#tree-0 text")].map((one) => one.textContent).join(" ");
      const below = set(temp, "36.599999999999994");
      return [first, set(slider, "36.60000004"), below, set(level, "0.09999999999999999"), tests];
    """
    first, slid, below, empty, tests = in_chromium(page(profile, Contents()), script, [], tmp_path)
    assert first == [36.6, "cool"] and slid[1:] == [36.6, "cool"]
    assert below[1:] == [36.599999999999994, "wait"] and empty == [0.09999999999999999, 36.6, "fill"]
    assert "23.25" in tests and "36.6" in tests


@pytest.mark.parametrize(
    ("names", "signs"),
    [
        (("push_left", "push_right"), ["\u2190", "\u2192"]),
        (("no_pull", "pull"), ["np", "p"]),
        (("on", "off"), ["on", "off"]),
        (("brake_1", "brake_2"), ["b1", "b2"]),
        (("run-a", "rest-a"), ["ru", "re"]),
    ],
)
def test_actions_have_signs_of_their_own(names, signs, tmp_path):
    script = "return [...document.querySelectorAll('.swatch')].map((one) => [one.textContent, one.style.background]);"
    found = in_chromium(page(pushed(-1e9, 1e9, names), Contents()), script, [], tmp_path)
    assert [sign for sign, _ in found] == signs
    assert len({colour for _, colour in found}) == 2 and "rgb(201, 206, 214)" not in str(found)  # gray: does nothing


def test_ranges_of_sliders_hold_every_test_and_what_was_seen():
    """A stated range where it is bounded; else thresholds and what was seen, with a margin within the stated range."""
    policy = pushed(-1e9, 1e9).agents[0]
    (low, high), threshold = bound_sliders(policy)[0], float(policy.tree.threshold[0])
    assert -10 < low < threshold < high < 10
    ((low, high),) = bound_sliders(policy, np.array([[-40.0], [np.nan], [60.0]], np.float32))
    assert (low, high) == (-90.0, 110.0)
    assert bound_sliders(pushed(-0.5, 0.5).agents[0]) == [(-0.5, 0.5)]
    looked = dataclasses.replace(pushed(-0.5, 0.5).agents[0], seen=((-0.1, -0.05, 0.05, 0.1),))
    assert bound_sliders(looked) == [(pytest.approx(-0.2), pytest.approx(0.2))]  # half of what was seen beyond it
    ((low, high),) = bound_sliders(pushed(0.0, 1e9).agents[0])
    assert low == 0 and threshold < high < 10


def test_an_imported_tree_is_no_game_and_has_no_reference():
    source = b"def thermostat(temperature):\n    return 'on' if temperature < 19.5 else 'off'\n"
    profile = profile_of(from_python(source, "t.py"), Names(), "float32")
    assert about(profile).startswith("An imported tree for one agent, thermostat. It observes 1 number (temperature)")
    assert "Reference:" not in page(profile, Contents())


def test_the_slice_is_of_an_agent_that_tests_something(tmp_path):
    """One of the corridor's robots always goes; the sliders that are open are those of the slice's agent."""
    html = page(load(GENERATED / "worlds" / "corridor.json"), Contents())
    told = """
      const open = () => [...document.querySelectorAll("#sliders > details")].map(({ open }) => open);
      const box = document.getElementById("sliced"), first = [box.selectedOptions[0].textContent, open()];
      box.value = 0;
      box.dispatchEvent(new Event("change"));
      return [first, open()];
    """
    assert in_chromium(html, told, [], tmp_path) == [["right", [False, True]], [True, False]]


def test_claims_of_six_agents_share_their_parts_and_are_judged():
    """Six agents have 720 matchings with six landmarks, but only 36 pairs."""
    from maviper.worlds import find_built_in
    from tests.hunting.teams import bare

    profile = bare(find_built_in("cooperative-navigation,agents=6").name)
    claims = document(profile, Contents(usual_claims(profile)))["claims"]
    judged = {claim["name"]: claim for claim in claims if claim["formula"]}
    assert {"distinct_targets", "own_target", "no_double", "aligned", "steady"} == set(judged)
    assert all(len(json.dumps(claim)) < 100_000 for claim in claims)


PAGES = ("physical_deception/report", "physical_deception/play", "physical_deception/extracted/report")
PAGES += ("physical_deception/extracted/play", "worlds/quadrotor/report", "reproduction/paper/mappo/report")


@pytest.mark.nightly
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_no_violation(name, tmp_path):
    assert violations(GENERATED / f"{name}.html", tmp_path) == []
