"""The standing hunt: a slice finds nothing wrong, false words put back are found, the judge stands alone."""

import ast
import itertools
import json
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.policy_json import dumps
from codegen.profiles import ensure
from maviper.verification.run import question_files
from tests import hunt
from tests.hunting import (
    asking,
    driven,
    episodes,
    game_sums,
    giving,
    judge,
    outputs,
    places,
    planted,
    playing,
    questions,
    sampling,
    stated,
)
from tests.hunting.planted import put
from tests.support import summed
from tests.support.giving import tamed
from tests.support.tiers import sweep
from verify.claims.formula import TRUE
from verify.kinds import Kind
from verify.result import Verdict
from verify.solver.solve import decide
from verify.systems import curves
from verify.systems.system import Affine, Piece

pytestmark = pytest.mark.solver

JUDGING = ("reading", "meaning", "places", "judge", "playing", "stated", "sampling", "giving", "summing", "driving")
SLICE = {  # by kind how many questions, a minute and a half in all, and the least share of each verdict
    "decisions": (300, 0.3),
    "episodes": (60, 0.2),
    "doubles": (200, 0.25),
    "double-episodes": (30, 0.15),
}
SLOW = pytest.mark.slow
ASKED = [  # kind, how many questions, and the least share of PROVED, of VIOLATED and of bounds close to the extreme
    ("episodes", 12, 0.25, 0.25, 0),
    ("systems", 8, 0.25, 0.25, 0.4),
    pytest.param("systems", 24, 0.25, 0.25, 0.4, marks=SLOW),
    ("files", 8, 0.01, 0.01, 0),
    ("following", 12, 0.25, 0.25, 0),
    ("outputs", 8, 0.25, 0.25, 1),
    pytest.param("outputs", 160, 0.3, 0.3, 0, marks=SLOW),
    ("driven", 6, 0.25, 0.25, 1),
    pytest.param("driven", 120, 0.25, 0.25, 1, marks=SLOW),
    ("game-sums", 4, 0.25, 0.2, 0),
    pytest.param("game-sums", 24, 0.25, 0.2, 0, marks=SLOW),
]
FOUND_WITHIN = 2_000  # questions
PLANTED = {"outputs": planted.OUTPUTS, "driven": planted.DRIVEN, "game-sums": planted.GAMES}
NOTICED_WITHIN = {"outputs": 120, "driven": 80, "game-sums": 80}
FOLDER = Path(__file__).parent.parent / "generated" / "hunt"
OUTSIDE = 200  # questions for another solver


@pytest.mark.slow
@pytest.mark.parametrize("kind", SLICE)
def test_a_slice_finds_nothing_wrong(kind, capsys):
    count, least = SLICE[kind]
    record = hunt.hunt(kind, None, count, None)
    with capsys.disabled():
        print()
        record.show()
    assert record.counts["asked"] == count and record.wrong == []
    assert record.share("proved, not vacuous") >= least and record.share("verdict VIOLATED") >= least
    assert record.median_depth >= 4


@pytest.mark.parametrize(("kind", "count", "proved", "violated", "close"), ASKED)
def test_questions_are_asked_and_judged(kind, count, proved, violated, close):
    """Of systems half of the claims lie within 2 % of what the judge has sampled."""
    record = hunt.hunt(kind, None, count, None)
    assert record.wrong == []
    assert record.share("verdict PROVED") >= proved and record.share("verdict VIOLATED") >= violated
    assert record.share("bound within 2 % of the extreme") >= close
    assert record.share("verdict UNKNOWN") <= (0.1 if (kind, count) == ("outputs", 160) else 1)
    assert record.counts["certificates forged, refused"] >= {"outputs": count // 32, "driven": count // 20}.get(kind, 0)


@pytest.mark.parametrize(("count", "thorough"), [(40, False), pytest.param(24, True, marks=pytest.mark.slow)])
def test_real_arithmetic_is_asked_and_judged(count, thorough):
    """Of the first questions in it; thorough: with both engines, the front door and forged certificates each time."""
    drawn = (questions.drawn(seed) for seed in itertools.count())
    real = itertools.islice((each for each in drawn if each.case.semantics == "real"), count)
    told = [asking.ask(each, thorough) for each in real]
    assert [text for each in told for text in each.wrong] == []
    verdicts = [each.verdict for each in told]
    assert verdicts.count("PROVED") >= count // 6 and verdicts.count("VIOLATED") >= count // 3


@pytest.mark.parametrize("fault", sweep(pytest.param(fault, id=fault.name) for fault in planted.PLANTED))
def test_what_was_mended_is_found_when_it_is_put_back(fault):
    with pytest.MonkeyPatch.context() as patch:
        fault.plant(patch)
        answers = (hunt.KINDS[fault.kind](seed, False) for seed in range(FOUND_WITHIN))
        told = next((one for one in answers if any(fault.shows in text for text in one.wrong)), None)
    assert told is not None, f"not found within {FOUND_WITHIN} questions"
    assert hunt.KINDS[fault.kind](told.seed, True).wrong == []


SOON = [  # kind, within how many questions, fault and what is said first
    *(pytest.param("files", 40, fault, "", id=name) for name, fault in planted.FILES.items()),
    ("systems", 12, put(sampling.Episodes, "broken", lambda _: lambda self, claim: True), "PROVED, and"),
    ("systems", 12, put(stated, "moved", lambda _: lambda system, agents, at, *_: dict(at)), "VIOLATED by"),
    # as if no action moved anything, and as if no state lay in a piece
    ("following", 30, put(Piece, "total", lambda _: lambda one, name, acts: one.move.get(name, Affine())), ""),
    ("following", 30, put(curves, "_beyond", lambda _: lambda piece: TRUE), ""),
]


@pytest.mark.parametrize(("kind", "within", "fault", "says"), SOON)
def test_a_fault_in_files_systems_or_their_judge_is_noticed_soon(kind, within, fault, says, monkeypatch):
    fault(monkeypatch)
    told = (text for seed in range(within) for text in hunt.KINDS[kind](seed, False).wrong)
    assert any(text.startswith(says) for text in told)


@pytest.mark.parametrize(
    ("kind", "name"), sweep(pytest.param(kind, name) for kind, faults in PLANTED.items() for name in faults)
)
def test_a_fault_in_what_proves_or_checks_numbers_is_noticed(kind, name):
    for module in (outputs, driven):
        module.one_case.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        PLANTED[kind][name](patch)
        noticed = any(is_noticed(seed, kind) for seed in range(NOTICED_WITHIN[kind]))
    for module in (outputs, driven):
        module.one_case.cache_clear()
    assert noticed


def test_states_that_are_drawn_for_a_team_lie_in_its_box():
    """Exactly: ends of this box are no floats, and a state beside one broke a claim that was rightly proved."""
    case = game_sums.Case(198)
    states = case._drawn(np.random.default_rng(0), 200)
    for name, (low, high) in case.region.box.items():
        assert all(low <= Fraction(float(each)) <= high for each in states[name]), name


def is_noticed(seed, kind):
    """Whether the judge contradicts an answer; or the reference by which every counterexample is judged, or the second
    reading of what a file states, contradicts the first.
    """
    try:
        return bool(hunt.KINDS[kind](seed, False).wrong)
    except (AssertionError, InputError):
        return True


def test_random_agents_are_ones_that_commands_take():
    """Also where numbers that were too large are alike now, and where nothing is summed."""
    sumless = alike = 0
    for seed in range(240):
        arithmetic, made = summed.ARITHMETICS[seed % 3], {"outputs": seed // 3 % 3, "levels": seed // 9 % 4}
        drawn = summed.policy(seed, arithmetic, **made)
        agent = tamed(drawn)
        ensure(summed.profile(agent))
        sumless += not agent.tree.arithmetic
        alike += len(agent.tree.vectors) < len(drawn.tree.vectors) or len(agent.tree.sums) < len(drawn.tree.sums)
    assert sumless > 20 and alike > 1


def test_the_judge_of_outputs_computes_what_the_reference_does():
    """In all three arithmetics, by the bits; profiles are read from their files."""
    for name, profile in summed.every(5).items():
        rows = np.random.default_rng(5).normal(size=(120, 5))
        rows[::2] = np.round(rows[::2] * 4) / 4  # thresholds and ties
        for policy, document in zip(profile.agents, json.loads(dumps(profile))["agents"], strict=True):
            judged = giving.Agent(document)
            with np.errstate(all="ignore"):
                if policy.outputs:
                    assert judged.given(rows).tobytes() == ir.outputs(policy, rows).tobytes(), name
                else:
                    actions = [policy.actions[place].name for place in ir.act(policy, rows)]
                    assert judged.acts(rows).tolist() == actions, name


def test_a_hunt_goes_on_where_it_ended(tmp_path):
    whole = hunt.hunt("decisions", None, 6, None)
    for count in (2, 6):
        record = hunt.hunt("decisions", tmp_path, count, None)
        assert record.next == count
    assert record.counts == whole.counts and record.depths == whole.depths
    kept = (tmp_path / "decisions.json").read_text()
    hunt.hunt("decisions", tmp_path, 6, None)
    assert (tmp_path / "decisions.json").read_text() == kept


def test_no_word_on_record_is_wrong():
    kept = sorted(FOLDER.glob("*.json"))
    assert set(PLANTED) <= {path.stem for path in kept} <= {*PLANTED, *hunt.READING}
    assert all(hunt.Record(path.stem, FOLDER).wrong == [] for path in kept)


@pytest.mark.parametrize("name", JUDGING)
def test_the_judge_imports_nothing_of_ours(name):
    tree = ast.parse((Path(hunt.__file__).parent / "hunting" / f"{name}.py").read_text())
    imported = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add(node.module)
    own = {f"tests.hunting.{other}" for other in JUDGING}
    others = {module for module in imported if module.partition(".")[0] not in sys.stdlib_module_names}
    assert others <= own | {"numpy", "numpy.typing", "mpe2"}, others


def test_enumerating_and_sampling_do_not_contradict_each_other():
    """Where cells are listed one by one, no sampled state fails unless a listed one does."""
    seen = 0
    for seed in range(60):
        case = questions.drawn(seed).case
        if not places.enumerable(case) or case.semantics == "real":
            continue
        rng = np.random.default_rng(seed)
        for goal in case.goals:
            listed = places.cells(case, goal)
            if listed is not None and len(listed) and judge.violating(case, listed, goal, rng) is None:
                assert judge.violating(case, places.sampled(case, goal, rng), goal, rng) is None
                seen += 1
    assert seen > 5


def test_episodes_in_numpy_are_those_of_mpe2():
    for seed in range(8):
        case = episodes.drawn(seed).case
        states = places.sampled(case, case.goals[0], np.random.default_rng(seed))[:3]
        states[:, [name[-2] == "v" for name in case.names]] = 0.0
        steps = case.claim["steps"]
        course = playing.simulated(case.profile, case.at(states, case.goals[0]), case.goals[0], steps)
        for row, state in enumerate(states.tolist()):
            exact = playing.played(case.profile, places.described(state, case.names), case.goals[0], steps)
            for name in case.names:
                if case.profile.world["contact_force"]:
                    assert np.abs(course[name][:, row] - exact[name][:, 0]).max() < 1e-9
                else:
                    assert (course[name][:, row] == exact[name][:, 0]).all(), name


def answered(cvc5, text):
    """What cvc5 says to a question in SMT-LIB."""
    solver = cvc5.Solver()
    parser = cvc5.InputParser(solver)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "question")
    said = []
    while not (command := parser.nextCommand()).isNull():
        said.append(command.invoke(solver, parser.getSymbolManager()).strip())
    return said[-1]


@pytest.mark.slow
def test_another_solver_decides_alike():
    """cvc5 reads the exported questions and answers as Z3 does, all goals together."""
    cvc5 = pytest.importorskip("cvc5")
    count, verdicts = 0, set()
    for seed in range(10 * OUTSIDE):
        question = questions.drawn(seed).question
        if question.claim.kind is Kind.LEAVES or (verdict := decide(question).verdict) is Verdict.UNKNOWN:
            continue
        answers = [answered(cvc5, text) for text in question_files([question]).values()]
        assert set(answers) <= {"sat", "unsat"}
        assert ("sat" in answers) == (verdict is Verdict.VIOLATED), seed
        count += len(answers)
        verdicts.add(verdict)
        if count >= OUTSIDE:
            break
    assert count >= OUTSIDE and {Verdict.PROVED, Verdict.VIOLATED} <= verdicts


@pytest.mark.solver
@pytest.mark.parametrize("seed", [2804, 4583])
def test_teams_that_rest_where_a_sign_is_0_move_as_in_mpe2(seed):
    """Found by the hunt: mpe2's contacts push by 1e-29 from far away, which decides the sign of an offset of 0."""
    assert episodes.ask(episodes.drawn(seed)).wrong == []
