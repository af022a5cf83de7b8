"""Rules that `maviper show` prints, copied into a claim over observations, are proved: of every shipped tree."""

import re
from pathlib import Path

import pytest

from maviper.evaluation.show import rules
from maviper.files.profiles import load
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import pose_questions
from verify.result import Verdict
from verify.verdicts.decisions import by_zones, conditions_of, verdict

GENERATED = Path(__file__).parents[3] / "generated"
SHIPPED = sorted(path.relative_to(GENERATED) for path in GENERATED.rglob("profile.json"))
RULE = re.compile(r"(?:if (?P<test>.*)|always) -> (?P<action>\S+)  \(leaf .*")
LARGE = 100  # leaves: their left sides are not asked about one by one

pytestmark = pytest.mark.solver


def copied(profile, policy):
    """The rules of an agent as a claim: each name of a feature is that of a variable."""
    found = []
    for line in rules(policy):
        rule = RULE.fullmatch(line)
        test = rule["test"] or "true"
        if len(profile.agents) > 1:
            for feature in {each.name for each in policy.features}:
                test = re.sub(rf"(?<![\w.]){re.escape(feature)}(?![\w.])", f"{policy.agent}.{feature}", test)
        found.append(f"({test} implies acts({policy.agent}) == {rule['action']})")
    return " and ".join(found)


@pytest.mark.parametrize("path", SHIPPED, ids=str)
def test_a_copied_rule_is_proved(path, tmp_path):
    profile = load(GENERATED / path, sums=True)
    plain = [policy for policy in profile.agents if not policy.tree.sums and not policy.outputs]
    claims = tmp_path / "claims.toml"
    claims.write_text("".join(f"[[property]]\nformula = '''{copied(profile, one)}'''\n" for one in plain))
    if not plain:
        pytest.skip("tests of sums round, and are claimed exactly")
    options = VerifyOptions(file=claims, observations=True)
    asked, _ = pose_questions(profile, "profile.json", options)
    assert len(asked) == len(plain)
    for one in asked:
        assert by_zones(one.question).opinion.verdict is Verdict.PROVED
        if len(conditions_of(one.claim)) < LARGE:
            assert verdict(one.question)[0] in (Verdict.PROVED, Verdict.VACUOUS)  # a leaf may be dead
