"""Pages of odd profiles: names that look like markup, features without a meaning, many agents, large trees."""

import dataclasses
import re

import pytest

from codegen.check import ensure
from maviper.page.document import Contents, Shown, Stored, usual_claims
from maviper.page.page import MAX_RULES, contents_of, page
from tests.maviper.page.browsers import in_chromium, in_node, overhang
from tests.support.odd_pages import with_trees
from tests.support.pages import GENERATED, committed

SHOWN = """
  const count = (what) => document.querySelectorAll(what).length;
  return {
    main: !document.querySelector("main").hidden,
    arena: document.getElementById("arena").style.display,
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
    assert found["sliders"] == sum(len(one.features) for one in profile.agents)


def test_a_large_tree_folds_and_its_code_is_left_out(tmp_path):
    profile = with_trees(committed("physical_deception"), 12)
    html = page(ensure(profile), Contents(usual_claims(profile)))
    assert "const Policy = null;" in html and "4,096" not in html
    assert re.search(rf"{4096 - MAX_RULES} more leaves", html)
    drawn = "return document.querySelectorAll('#tree-1 g.leaf, #tree-1 g.folded').length;"
    assert 64 <= in_chromium(html, drawn, [], tmp_path) <= 64 + 12
    script = "const at = Engine.coordinates(game, given); return Engine.actions(game, at).length;"
    state = {"position": [[0.1, 0.2]] * 5, "velocity": [[0, 0]] * 3, "goal": 0}
    assert in_node(html, script, state, tmp_path) == 3


@pytest.mark.parametrize("name", ["physical_deception", "proved_navigation", "verdicts/predator_prey"])
def test_nothing_is_wider_than_a_small_page(name, tmp_path):
    profile = committed(name)
    found = in_chromium(page(profile, contents_of(profile, usual_claims(profile))), SHOWN, [], tmp_path, width=400)
    assert found["wide"] == 0 and found["trees"] == len(profile.agents)


def test_no_committed_page_is_wider_than_a_small_screen(tmp_path):
    pages = sorted(GENERATED.rglob("*.html"))
    assert len(pages) > 10
    assert dict(zip(pages, overhang(pages, tmp_path, 400), strict=True)) == dict.fromkeys(pages, 0)
    wide = tmp_path / "wide.html"
    wide.write_text("<!DOCTYPE html><body style='margin:0'><div style='width:409px'>a</div></body>")
    assert overhang([wide], tmp_path, 400) == [9]


def test_many_agents_show_the_tree_of_one(tmp_path):
    from maviper.worlds import built_in
    from tests.hunting.teams import bare

    world = built_in("cooperative-navigation,agents=20")
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
    assert in_chromium(page(profile, Contents()), script, [], tmp_path) == [True, True, "step 9"]


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
