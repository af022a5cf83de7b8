"""Monitors of regions that compare sums: never too generous, by exact fractions, and no narrower than they say."""

import math
from fractions import Fraction

import numpy as np
import pytest

from codegen.agreement.compiled import STRICT, find_compiler
from codegen.errors import InputError
from codegen.ir import outputs
from codegen.lowering.lower import lower
from codegen.lowering.model import RaisedSum
from maviper import load
from maviper.compilation import covers
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.files import profiles
from maviper.worlds.stated.certified import read_certificate
from tests.support import monitors
from tests.support.explicit_mpc import prove_lasting
from tests.support.monitors import INVALID, OK, OUTSIDE, CoverTwin, asked_of_cover
from verify.checker.covers.boxes import end_of
from verify.systems.system import Affine, HalfSpace

CLAIMS = {
    "always": 'name = "always"\nregion = { where = ["angle + 0.1[s]*spin <= 0.06"] }',
    "decides": """formula = "not acts(cart) == left"
region = { where = ["angle + 0.3[s]*spin > 0.2", "spin >= 0", "v*1[s]/3 + x/7 - 0.1[m]*angle <= 0.1[m]"] }""",
    "assuming": """name = "always"
region = { box = { angle = [-0.15, 0.15] } }
assuming = { where = ["x + 1[m]*angle < 0.3", "v*1[s] - x >= -0.5[m]"] }""",
    "either": """formula = "not acts(cart) == left"
region = [{ where = ["spin >= 0", "angle + 0.3[s]*spin > 0.2"] },
          { where = ["spin >= 0", "angle - 0.1[s]*spin >= 0.1"] }]""",
    "no terms": """formula = "not acts(cart) == left"
region = [{ where = ["angle + 0.3[s]*spin > 0.2", "spin >= 0", "x - x <= 1[m]"] }, { where = ["x - x < 0[m]"] }]""",
}
MARGIN = Fraction(1, 1 << 48)  # of the sizes of all terms, as the manual says of up to six


class Proof:
    """A certificate that `maviper verify` writes of a committed world, and what a monitor makes of it."""

    def __init__(self, folder, text):
        self.certificate = monitors.certify(folder, "pendulum", text)
        self.profile = load(folder / "profile.json")
        self.claim = read_certificate(self.certificate)[0].claim
        self.read()

    def read(self):
        """Reads the certificate as it is compiled now."""
        self.cover = load_proof(self.certificate, self.profile).region
        return self

    @property
    def halves(self):
        """Of the claim's regions those that compare sums."""
        regions = (*self.claim.regions, *self.claim.assuming)
        return [half for region in regions for half in region if len(half.form.terms) > 1]

    def state(self, w):
        """Exact numbers by name."""
        return {one.name: Fraction(float(x)) for one, x in zip(self.cover.variables, w, strict=True)}

    def holds(self, w, room=Fraction(0)):
        """Whether a state is in a region of the claim, and of what it assumes, exactly; of sums with room to spare."""
        at = self.state(w)

        def meets(half):
            size = sum(abs(factor * at[name]) for name, factor in half.form.terms)
            spare = room * size if len(half.form.terms) > 1 else 0
            return HalfSpace(half.form.plus(Affine(constant=spare)), half.strict).holds(at)

        given = [regions for regions in (self.claim.regions, self.claim.assuming) if regions]
        return all(any(all(map(meets, region)) for region in regions) for regions in given)

    def near(self, count, seed):
        """States whose sums are as near the bounds of the claim as one variable makes them, and a few floats beside."""
        rng, found = np.random.default_rng(seed), []
        names = [one.name for one in self.cover.variables]
        for half in self.halves:
            (low, high), wanted = self._crossed(half, names), len(found) + 4 * count
            while len(found) < wanted:
                row = rng.integers(len(low))
                w = low[row] + rng.random(len(names)) * (high[row] - low[row])
                if rng.random() < 0.2:  # numbers with few digits, whose sums may be the bound itself
                    w = np.clip(np.round(w, 2), low[row], high[row])
                name, factor = half.form.terms[rng.integers(len(half.form.terms))]
                at = self.state(w)
                w[names.index(name)] = float(at[name] - half.form.at(at) / factor)
                if not ((w >= low[row]) & (w <= high[row])).all():
                    continue
                for away in rng.choice([-64, *range(-24, 25), 64], 4, replace=False):
                    beside = w.copy()
                    for _ in range(abs(away)):
                        beside[names.index(name)] = math.nextafter(beside[names.index(name)], math.inf * away)
                    found.append(beside)
        return np.array(found)

    def _crossed(self, half, names):
        """Boxes of the first part, within 5, that hold states in a half space and others beyond it."""
        n, part = len(names), self.cover.steps[0][0]
        low, high = np.maximum(part.low[:, :n], -5.0), np.minimum(part.high[:, :n], 5.0)
        ends = np.full(len(low), float(half.form.constant)), np.full(len(low), float(half.form.constant))
        for name, factor in half.form.terms:
            for end, side in zip(ends, (low, high) if factor > 0 else (high, low), strict=True):
                end += float(factor) * side[:, names.index(name)]
        crossed = (ends[0] < 0.0) & (ends[1] > 0.0)
        return low[crossed], high[crossed]


@pytest.fixture(scope="module")
def proofs(tmp_path_factory):
    made = {}

    def prove(name):
        if name not in made:
            made[name] = Proof(tmp_path_factory.mktemp("rows"), CLAIMS[name])
        return made[name]

    return prove


def judge(proof, states):
    """How many states are vouched for; AssertionError where one of them is outside, or one is refused that is further
    than the margin from all sums' bounds.
    """
    n, vouched = len(proof.cover.variables), proof.cover.holds(states, 0)
    boxed = np.logical_and.reduce([_drop_sums(part, n).holds(states) for part in proof.cover.steps[0]])
    outside = np.array([not proof.holds(w) for w in states])
    assert not (vouched & outside).any(), "too generous"
    inside = np.array([proof.holds(w, MARGIN) for w in states]) & boxed
    assert not (inside & ~vouched).any(), "too narrow"
    assert outside.any()
    return int(vouched.sum())


def _drop_sums(part, n):
    return part._replace(low=part.low[:, :n], high=part.high[:, :n])


@pytest.mark.parametrize("name", CLAIMS)
def test_it_is_never_too_generous_and_no_narrower_than_it_says(name, proofs):
    """Against exact fractions, at the bounds of sums and a few floats beside."""
    proof = proofs(name)
    assert proof.cover.sums
    assert judge(proof, proof.near(150, 1)) > 50


FAULTS = {
    "no margin": lambda patched: patched.setattr(RaisedSum, "_share", 0.0),
    "lowered in place of raised": lambda patched: patched.setattr(RaisedSum, "_share", -12 * 2.0**-53),
    "far too much": lambda patched: patched.setattr(RaisedSum, "_share", 2.0**-40),
    "a sign": lambda patched: patched.setattr(covers, "float", lambda factor: -float(factor), raising=False),
    "one term": lambda patched: patched.setattr(covers, "RaisedSum", lambda terms: RaisedSum(terms[:1])),
    "a bound": lambda patched: patched.setattr(
        covers, "end_of", lambda bound, strict: end_of(bound + Fraction(1, 1 << 40), strict)
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_noticed(fault, proofs, monkeypatch):
    proof = proofs("decides")
    states = proof.near(150, 1)
    with monkeypatch.context() as patched:
        FAULTS[fault](patched)
        with pytest.raises(AssertionError, match="too"):
            judge(proof.read(), states)
    judge(proof.read(), states)


@pytest.mark.compile
@pytest.mark.parametrize(
    ("name", "languages"),
    [
        ("always", monitors.LANGUAGES),
        *(pytest.param(name, monitors.LANGUAGES, marks=pytest.mark.slow) for name in ("decides", "assuming", "either")),
    ],
)
def test_all_languages_say_the_same_word(name, languages, proofs, tmp_path):
    """Of states at the bounds of sums, of those that sensors get wrong, and of those that come late; in C also where
    products could be fused with sums.
    """
    proof = proofs(name)
    cover, profile = proof.cover, proof.profile
    watched = lower_monitor(profile, lower(profile), load_proof(proof.certificate, profile))
    drawn, near = asked_of_cover(cover, 600, 5), proof.near(100, 2)
    ones = np.ones(len(near), dtype=np.int32)
    beside = near, np.ones(near.shape, np.int32), np.full(len(near), cover.dt), ones
    asked = [np.concatenate(both) for both in zip(drawn, beside, strict=True)]
    wanted = CoverTwin(cover).said(asked)
    assert {OK, OUTSIDE, INVALID} <= set(wanted) and wanted.count(OK) > 200
    texts, said = monitors.ensure_alike(profile, watched, asked, wanted, tmp_path, languages)
    if find_compiler() is not None:
        fused = (*STRICT, "-O3", "-march=native", "-ffp-contract=fast")
        (tmp_path / "fused").mkdir()
        assert monitors.run_c(texts, watched, tmp_path / "fused", asked, fused) == said


def test_a_region_that_was_proposed_is_watched(tmp_path):
    """Of a controller that computes its output. Who is vouched for is in the region, exactly, and so one step on."""
    certificate = prove_lasting(tmp_path)
    profile, (proof, _) = profiles.load(tmp_path / "cart.json", sums=True), read_certificate(certificate)
    cover = load_proof(certificate, profile).region
    (region,) = [each.region for part in proof.proof.parts for each in part.regions]
    (policy,), names = profile.agents, [one.name for one in cover.variables]
    assert names == ["x", "v"] and len(cover.sums) == 2
    lower_monitor(profile, lower(profile), load_proof(certificate, profile))
    half = next(half for half in region if len(half.form.terms) > 1)
    w = np.random.default_rng(1).uniform(-1.1, 1.1, (600, 2))
    terms = dict(half.form.terms)
    w[::2, 0] = (float(-half.form.constant) - float(terms["v"]) * w[::2, 1]) / float(terms["x"])  # at a border
    w[::2, 0] += np.random.default_rng(2).integers(-60, 60, 300) * 2.0**-53
    held = cover.holds(w, 0)

    def is_inside(states):
        own = [half for half in region if {name for name, _ in half.form.terms} <= set(names)]
        at = [dict(zip(names, map(Fraction, row), strict=True)) for row in states.tolist()]
        return np.array([all(half.holds(state) for half in own) for state in at])

    inside, push = is_inside(w), outputs(policy, w)[:, 0]
    assert not (held & ~inside).any() and held[::2].sum() > 20 and (inside & ~held).sum() <= inside[::2].sum()
    assert (held == inside)[1::2].all() and 50 < held[1::2].sum() < 250
    after = np.column_stack([w[:, 0] + 0.5 * w[:, 1] + 0.125 * push, w[:, 1] + 0.5 * push])
    assert is_inside(after[held]).all()


def test_raised_sums_are_never_below_exact_ones():
    """Whole factors, also such as are no floats; numbers of all sizes, subnormal ones and those that overflow."""
    rng = np.random.default_rng(8)
    for _ in range(300):
        n = int(rng.integers(2, 7))
        factors = [int(rng.integers(1, 1 << 62)) ** int(rng.integers(1, 3)) for _ in range(n)]
        factors = [int(rng.choice([-1, 1])) * int(rng.choice([1, 3, 1_000, factor])) for factor in factors]
        raised = RaisedSum(tuple(enumerate(map(float, factors))))
        sizes = rng.choice([5e-324, 1e-310, 1e-290, 1.0, 1e9, 1e300], (40, n))
        w = np.round(rng.normal(size=(40, n)), int(rng.integers(0, 17))) * sizes
        last, others = factors[-1], sum(Fraction(f) * Fraction(x) for f, x in zip(factors[:-1], w[0, :-1], strict=True))
        if abs(others) < last * Fraction(1e300):
            w[0, -1] = float(-others / last)  # so that nearly nothing is left
        for state, found in zip(w, raised.of(w).tolist(), strict=True):
            terms = [Fraction(f) * Fraction(float(x)) for f, x in zip(factors, state, strict=True)]
            if math.isfinite(found):
                over, size = Fraction(found) - sum(terms), sum(map(abs, terms))
                assert 0 <= over <= Fraction(3 * (n + 4), 1 << 53) * size + Fraction(5e-324)
            else:
                assert not found <= 1e308 and max(map(abs, terms)) > Fraction(1e307)


@pytest.mark.parametrize(
    ("halves", "said"),
    [
        ([({"angle": 1, "spin": -1}, 0), ({"angle": -1, "spin": 1}, 0)], "with one number"),
        ([({"angle": 3, "spin": -1}, -6), ({"angle": Fraction(-1, 2), "spin": Fraction(1, 6)}, 1)], "with one number"),
        ([({"angle": 1, "spin": Fraction(1, 10**200)}, 0)], "too unlike"),
    ],
)
def test_what_floats_cannot_tell_is_refused_with_the_reason(halves, said, proofs):
    region = tuple(
        HalfSpace(Affine.of({name: Fraction(factor) for name, factor in terms.items()}, Fraction(constant)))
        for terms, constant in halves
    )
    with pytest.raises(InputError, match=f"compares angle and spin.*{said}"):
        covers.ensure_wide([region], "here")
    covers.ensure_wide([region[:1] if "one number" in said else ()], "here")
