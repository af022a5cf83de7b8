"""Monitors of trees with sums and without a certificate: inputs and outputs alone are watched."""

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.lowering.lower import lower
from codegen.lowering.watching import watch_inputs
from codegen.sums import DOUBLE_SUMS, FLOAT64_SUMS
from codegen.targets import emit, monitor
from maviper.compilation.run import compile_and_prove, split_targets
from tests.support import monitors
from tests.support.generated import FOLDER
from tests.support.monitors import INVALID, OK
from tests.support.outputs import given_by
from tests.support.summed import policy, profile

PROVED = FOLDER.parent / "verdicts" / "physical_deception" / "certificate-1-distinct_targets.json"
TWO = ("c", "python")


def files(made):
    """The texts of code and monitors, and the lowered monitor."""
    model = lower(made)
    watched = watch_inputs(made, model)
    return {**emit(made, monitors.LANGUAGES), **monitor.emit(watched, monitors.LANGUAGES)}, watched


@pytest.mark.compile
@pytest.mark.parametrize("languages", [TWO, pytest.param(monitors.LANGUAGES, marks=pytest.mark.slow)])
def test_inputs_are_watched_in_all_languages(languages, tmp_path):
    """Ranges, finiteness and ages of what both agents observe; the word stays."""
    made = profile(policy(3, DOUBLE_SUMS), policy(4, DOUBLE_SUMS, agent="agent_1"))
    texts, watched = files(made)
    rng, count, size = np.random.default_rng(5), 800, len(watched.places)
    assert size == 10 and watched.open == 10
    w = rng.uniform(-3.0, 3.0, (count, size))
    odd = rng.random(w.shape) < 0.01
    w[odd] = rng.choice([np.nan, np.inf, -np.inf, 3.0, -3.0, np.nextafter(3.0, 4.0), -3.1], odd.sum())
    fresh = (rng.random(w.shape) > 0.004).astype(np.int32)
    dt = rng.choice([1.0, 0.0, 1.5, 1.6, np.nan, -0.1], count, p=[0.9, *[0.02] * 5])
    start = (rng.random(count) < 0.4).astype(np.int32)
    wanted, age, word = [], np.full(size, np.inf), INVALID
    stays = False
    for each, new, after, begun in zip(w, fresh, dt, start, strict=True):
        age, stays, word = (np.full(size, np.inf), False, INVALID) if begun else (age, stays, word)
        age = np.where(new == 1, 0.0, age + after)
        if not stays:
            well = 0.0 <= after <= 1.5 and (age <= 1.5).all() and (each >= -3.0).all() and (each <= 3.0).all()
            word = OK if well else INVALID
        stays = word == INVALID
        wanted.append(word)
    assert wanted.count(OK) > 100 < wanted.count(INVALID)
    n, rest = 3, watched.fallbacks[0].action
    acted = [i % n if word == OK else rest for i, word in enumerate(wanted)]
    monitors.ensure_said_by_all(texts, watched, tmp_path, (w, fresh, dt, start), (wanted, acted), languages)


@pytest.mark.compile
@pytest.mark.parametrize(
    ("arithmetic", "gives"), [(FLOAT64_SUMS, None), pytest.param(DOUBLE_SUMS, "float32", marks=pytest.mark.slow)]
)
def test_outputs_are_watched_in_all_languages(arithmetic, gives, tmp_path):
    """An output beyond its bounds, or no number, is INVALID; then the fallback is given, which is next to 0."""
    texts, watched = files(profile(policy(7, arithmetic, outputs=2, gives=gives)))
    given = [[0.5, -1.0], [1.5, 0.0], [1.75, 0.0], [0.0, -1.0625], [np.nan, 0.0], [0.0, np.inf], [-np.inf, 0.0]]
    wanted = [[OK, *row] if all(-1.0 <= y <= 1.5 for y in row) else [INVALID, 0.0, 0.0] for row in given]
    assert [row[0] for row in wanted] == [OK] * 2 + [INVALID] * 5
    for language, rows in given_by(texts, watched, tmp_path, given).items():
        assert rows == wanted, language


def test_outputs_of_another_number_are_invalid_and_what_has_no_bound_is_finite():
    texts, watched = files(profile(policy(7, FLOAT64_SUMS, outputs=2, bounded=False)))
    space = {}
    exec(compile(texts[f"{watched.model.prefix}_monitor.py"], "monitor", "exec"), space)

    def told(outputs):
        found = space["Monitor"]()
        found.renew_all()
        assert found.step([0.0] * 5, 1.0) == OK
        return found.give("agent_0", outputs), found.word

    assert told([1e308, -7.0]) == ([1e308, -7.0], OK)
    for outputs in ([1.0], [1.0, 2.0, 3.0], [1.0, np.inf], [1.0, None]):
        assert told(outputs) == ([0.0, 0.0], INVALID)


def test_a_monitor_of_sums_needs_no_certificate_and_takes_none_of_single_features():
    made = profile(policy(3, DOUBLE_SUMS))
    with pytest.raises(InputError, match="about tests of single features"):
        compile_and_prove(made, ["python", "monitor"], certificate=PROVED)
    assert split_targets(["monitor", "python"], None, sums=True) == (True, ("python",))
    code = compile_and_prove(made, ["python", "monitor"])
    text = next(text for name, text in code.files.items() if name.endswith("_monitor.py"))
    assert "it proves    nothing" in text
