"""The table of parameters: every claim's are in it, and files and Python take all of it."""

import re

from maviper.options import VerifyOptions as Options
from maviper.options import table_of
from maviper.verification.ask import VerifyOptions
from verify.claims import files
from verify.claims.built_in import CLAIMS as CLASSES
from verify.claims.built_in import PARAMETER_NAMES as NAMES
from verify.claims.built_in import PARAMETERS
from verify.claims.catalogue import NAMES as CLAIMS
from verify.claims.catalogue import ZONES, readable
from verify.claims.decisions import STEADY
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.relations import RELATIONS
from verify.claims.wording import BUILT_IN


def test_the_table_has_what_claims_read():
    read = {parameter for claim in CLAIMS for parameter in readable(claim)} - {ZONES}
    assert read == set(NAMES) and len(set(NAMES)) == len(NAMES) == len(PARAMETERS)


def test_what_a_claim_means_reads_what_it_is_declared_with():
    """Certificates rest on the one, users know the other."""
    kinds = BUILT_IN | RELATIONS
    assert {name: kinds[name].reads for name in kinds} == {name: CLASSES[name].parameters() for name in kinds}
    episodes = {name: ("steps", "radius", *filter(None, [kind.whom])) for name, kind in EPISODE_CLAIMS.items()}
    assert episodes == {name: CLASSES[name].parameters() for name in EPISODE_CLAIMS}
    assert set(CLASSES) == {*kinds, *EPISODE_CLAIMS, STEADY}
    assert all(re.search(rf"claims\.{kind.__name__}\(", kind.__doc__) for kind in CLASSES.values())


def test_files_python_and_questions_take_what_the_table_has():
    assert set(NAMES) < set(files.KEYS) and set(NAMES) < set(table_of(Options))
    given = VerifyOptions.of({"names": ("covers",), "steps": 3, "radius": None, "max_zones": 7, "team": "a"})
    assert given.parameters == {"steps": 3} and given.max_zones == 7 and given.team == "a"
