"""The compiled zone search: equal bytes, counts and points to the Python search, for both widths of integers."""

import importlib.util
import shlex
import subprocess
import sysconfig
import threading
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from codegen.agreement.compiled import find_compiler
from tests.support.teams import team, towards
from tests.support.zone_cases import deception, navigation, near_roles, noisy, random_region, stated, switching
from verify.claims.catalogue import find_property
from verify.claims.decisions import formula
from verify.claims.region_files import start_region
from verify.extent import violations
from verify.kinds import MACHINE, REAL
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.subjects import Game
from verify.zones import engine
from verify.zones import search as zone_compiled
from verify.zones.search import BudgetError, CompiledSearch, ZoneSearch
from verify.zones.tables import Flat, Problem

pytestmark = pytest.mark.compile
SOURCE = Path(zone_compiled.__file__).parent / "_zones.c"


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The extension, built here under strict warnings."""
    place = tmp_path_factory.mktemp("extension") / "_zones.so"
    compiler = [*find_compiler(), "-O2", "-std=gnu99", "-Wall", "-Wextra", "-Wshadow", "-Werror"]
    include = f"-I{sysconfig.get_paths()['include']}"
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        pytest.skip("no headers of Python")
    command = [*compiler, "-fPIC", "-shared", "-fno-strict-aliasing", include, str(SOURCE), "-o", str(place)]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, shlex.join(command) + built.stderr
    spec = importlib.util.spec_from_file_location("_zones", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def both(compiled, monkeypatch):
    """Asks a question with both searches; what they say must be equal. Counts how often the compiled one was used."""
    monkeypatch.setattr(zone_compiled, "_zones", compiled)
    used = []

    def asked(*question, bits=None, **options):
        def build(problem, region, budget):
            least = zone_compiled.width(problem)
            used.append(least if bits is None or least is None else max(bits, least))
            if least is None:
                return ZoneSearch(problem, region, budget)
            with monkeypatch.context() as patch:
                patch.setattr(zone_compiled, "width", lambda _: used[-1])
                return CompiledSearch(problem, region, budget)

        with monkeypatch.context() as patch:
            patch.setattr(engine, "search", ZoneSearch)
            plain = engine.decide(stated(*question, **options))
            patch.setattr(engine, "search", build)
            assert engine.decide(stated(*question, **options)) == plain
        return plain

    asked.used = used
    return asked


@pytest.mark.parametrize("semantics", [MACHINE, REAL])
@pytest.mark.parametrize("bits", [128, 256])
def test_random_questions(both, bits, semantics):
    rng = np.random.default_rng(11)
    found = []
    for _ in range(80):
        profile, claim = deception(rng, 4)
        asked = formula(profile, claim)
        found.append(both(profile, asked, random_region(rng, profile), semantics, bits=bits).verdict)
    assert {Verdict.PROVED, Verdict.VIOLATED, Verdict.VACUOUS} <= set(found)
    assert both.used.count(bits) > 40


@pytest.mark.parametrize(
    ("draw", "count", "at_starts", "least"),
    [
        (near_roles, 40, 0.5, 6),
        (noisy, 40, 0.5, 6),  # errors of features
        (lambda rng, _: navigation(rng, 3), 10, 0, 0),
    ],
)
def test_random_questions_of_other_teams(both, profile, draw, count, at_starts, least):
    rng = np.random.default_rng(14)
    found = []
    for _ in range(count):
        asked, claim = draw(rng, profile)
        region = start_region(asked.world) if rng.random() < at_starts else random_region(rng, asked)
        found.append(both(asked, formula(asked, claim), region, eps=claim.eps).verdict)
    assert found.count(Verdict.PROVED) >= least and found.count(Verdict.VIOLATED) >= least


@pytest.mark.parametrize("bits", [128, 256])
def test_all_violating_zones(compiled, monkeypatch, bits):
    """The same zones in the same order, with the same limits."""
    monkeypatch.setattr(zone_compiled, "_zones", compiled)
    rng, seen = np.random.default_rng(14), 0

    def build(problem, region, budget):
        least = max(bits, zone_compiled.width(problem))
        with monkeypatch.context() as patch:
            patch.setattr(zone_compiled, "width", lambda _: least)
            return CompiledSearch(problem, region, budget)

    for _ in range(15):
        profile, claim = deception(rng, 3)
        region = random_region(rng, profile)
        for most, nodes in ((1000, 10**6), (3, 10**6), (1000, 60)):
            question = Question(Game(profile), claim, region, MACHINE, Budgets(max_nodes=nodes, max_cells=most))
            monkeypatch.setattr(engine, "search", ZoneSearch)
            plain = violations.violations(question)
            monkeypatch.setattr(engine, "search", build)
            assert violations.violations(question) == plain
            seen += sum(len(one.zones) for one in plain)
    assert seen > 100


def test_the_budget_ends_at_the_same_node(both, profile):
    pair = team(profile, *switching(0.1))
    claim = formula(pair, find_property("distinct_targets", pair))
    for budget in (1, 3, 10, 50, 100):
        assert both(pair, claim, start_region(pair.world), budget=budget).verdict is Verdict.UNKNOWN


def test_bounds_beyond_256_bits_are_searched_in_python(both, profile):
    pair = team(profile, towards(0, 0), towards(1, 1))
    claim = formula(pair, find_property("distinct_targets", pair, radius=Fraction(10**90 // 11, 10**90)))
    assert both(pair, claim, start_region(pair.world)).verdict is Verdict.PROVED
    assert set(both.used) == {None}


def test_combinations_beyond_the_table_are_asked_for(compiled, monkeypatch, profile):
    """Many classes: the search asks for each combination, and gets the same answers."""
    pair = team(profile, *switching(0.1))
    claim = formula(pair, find_property("distinct_targets", pair))
    few = engine.decide(stated(pair, claim, start_region(pair.world)))

    class Spread(CompiledSearch):
        def refutation(self, trees, classes, resolve):
            spread = [[number * 3000 for number in own] for own in classes]
            return super().refutation(trees, spread, lambda numbers: resolve(tuple(n // 3000 for n in numbers)))

    monkeypatch.setattr(zone_compiled, "_zones", compiled)
    monkeypatch.setattr(engine, "search", Spread)
    assert engine.decide(stated(pair, claim, start_region(pair.world))) == few


def test_an_error_while_searching_is_raised(compiled, monkeypatch, profile):
    class Broken(CompiledSearch):
        def refutation(self, trees, classes, resolve):
            def broken(numbers):
                raise KeyboardInterrupt

            return super().refutation(trees, classes, broken)

    monkeypatch.setattr(zone_compiled, "_zones", compiled)
    monkeypatch.setattr(engine, "search", Broken)
    pair = team(profile, *switching(0.1))
    with pytest.raises(KeyboardInterrupt):
        engine.decide(stated(pair, formula(pair, find_property("distinct_targets", pair)), start_region(pair.world)))


def test_without_the_extension_the_python_search_answers(monkeypatch, profile):
    monkeypatch.setattr(zone_compiled, "AVAILABLE", False)
    pair = team(profile, towards(0, 0), towards(1, 1))
    claim = formula(pair, find_property("distinct_targets", pair))
    assert engine.decide(stated(pair, claim, start_region(pair.world))).verdict is Verdict.PROVED


@pytest.mark.parametrize(("choices", "ends"), [(3_000, False), (100_000, True)])
def test_thousands_of_choices_need_no_more_stack_than_there_is(choices, ends, compiled, monkeypatch):
    """Each choice, of two bounds that can hold, is a level of the recursion; the thread has a small stack."""
    monkeypatch.setattr(zone_compiled, "_zones", compiled)
    edges, weights = [(0, 1, 0), (0, 0, 1)] * choices, [*range(2 * choices)]
    problem = Problem([2], edges, weights, 16 * choices, 1, {"x": (0, 1)})
    ors = tuple((Flat((2 * k,), ()), Flat((2 * k + 1,), ())) for k in range(choices))
    region = Flat((), ors)
    search = CompiledSearch(problem, region, 10 * choices)
    found = []

    def ask():
        try:
            found.append(search.is_inhabited())
        except BudgetError:
            found.append(None)

    before = threading.stack_size(4 * 2**20)
    try:
        thread = threading.Thread(target=ask)
        thread.start()
        thread.join()
    finally:
        threading.stack_size(before)
    assert found == [None if ends else True]
    if not ends:
        other = ZoneSearch(problem, region, 10 * choices)
        assert other.is_inhabited() and other.open == search.open and other.nodes == search.nodes
