"""Pages of agents that remember: a step changes memory as the reference does, in the page's script and under its
button; an episode of a proof is played from the memory that it begins with.
"""

import numpy as np
import pytest

import maviper
from codegen.importers.c.source import from_c
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Said
from codegen.memory import step_memory
from maviper.page.document import Contents
from maviper.page.page import page, with_proof
from tests.maviper.page.browsers import in_chromium, in_node
from tests.support.remembering import SOURCES, make_world


def imported(name):
    return profile_of(from_c(SOURCES[name].encode(), "act.c", Said(run=False)), Names())


@pytest.mark.parametrize("name", SOURCES)
def test_the_page_changes_memory_as_the_reference_does(name, tmp_path):
    profile, rng = imported(name), np.random.default_rng(0)
    (policy,) = profile.agents
    known = np.stack([rng.integers(each.low, each.high + 1, 500) for each in policy.memory], axis=1)
    known[:100] = [[rng.choice([each.low, each.high]) for each in policy.memory] for _ in range(100)]
    seen = rng.choice(np.float32([-1, 0, 0.25, 0.5, 1, 11, 18, 19, 20, 21, 22]), (500, 1))
    rows = np.concatenate([seen, known], axis=1).tolist()
    told = in_node(
        page(profile, Contents()), "return given.map((row) => Engine.after(game.agents[0], row));", rows, tmp_path
    )
    _, after = step_memory(policy, known, seen)
    assert told == np.concatenate([seen, after], axis=1).tolist()


def test_a_button_steps_to_what_is_remembered_then_and_another_forgets_it(tmp_path):
    script = """
      const set = (name, value) => {
        const field = document.querySelector(`input[type=number][aria-label=${name}]`);
        field.value = value;
        field.dispatchEvent(new Event("input"));
      };
      const read = () => [
        document.querySelector("input[type=range][aria-label='heating, slider']").value,
        document.getElementById("says-0").textContent.split(",")[0],
      ];
      const told = [read()];
      set("t", 18);
      told.push(read());
      document.getElementById("step").click();
      set("t", 20);
      told.push(read());
      document.getElementById("back").click();
      told.push(read());
      set("heating", 7.3);
      told.push(read());
      return [told, document.querySelector("#trees p").textContent];
    """
    told, machine = in_chromium(page(imported("heater"), Contents()), script, [], tmp_path)
    assert told == [[str(at), f"action_{act}"] for at, act in ((0, 0), (0, 1), (1, 1), (0, 0), (1, 1))]
    assert machine == "remembers heating, 0 to 1, 0 after a reset; := 1 in leaf 1; := 0 in leaf 6"


def test_an_episode_of_a_proof_remembers_from_its_start_on(tmp_path):
    profile = imported("heater")
    world = tmp_path / "world.toml"
    claim = '[[claim]]\nname = "always"\nregion = { box = { t = [18, 22.5] } }\n'
    world.write_text(make_world(profile.agents[0], claim))
    for name, text in maviper.verify_system(profile, world).files.items():
        (tmp_path / name).write_text(text)
    contents = with_proof(Contents(), profile, tmp_path / "certificate-1-always.json")
    ((told,), (rows,)) = contents.told, contents.recorded.seen
    assert set(told.words) == {"OK"} and len(rows) == 40 and rows[0, 1] == 0
    _, after = step_memory(profile.agents[0], rows[:, 1:], rows[:, :1])
    assert (rows[1:, 1:] == after[:-1]).all() and len({*rows[:, 1].tolist()}) == 2
