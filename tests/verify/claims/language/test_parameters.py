"""The table of parameters: every claim's are in it, and files and options take all of it."""

import click

from maviper.cli.verify import verify
from maviper.verification.ask import PARAMETERS as ASKED
from maviper.verification.ask import VerifyOptions
from verify.claims import files
from verify.claims.catalogue import NAMES as CLAIMS
from verify.claims.catalogue import ZONES, readable
from verify.claims.language.parameters import NAMES, PARAMETERS, Form


def test_the_table_has_what_claims_read():
    read = {parameter for claim in CLAIMS for parameter in readable(claim)} - {ZONES}
    assert read == set(NAMES) and len(set(NAMES)) == len(NAMES) == len(PARAMETERS)


def test_files_options_and_questions_take_what_the_table_has():
    options = {each.name: each for each in verify.params if each.name in NAMES}
    assert set(options) == set(NAMES) and set(NAMES) < set(files.KEYS) and (*NAMES, ZONES) == ASKED
    for name, form, told in PARAMETERS:
        assert options[name].help == told
        assert (options[name].type is click.INT) is (form is Form.COUNT)
    given = VerifyOptions.of({"names": ("covers",), "steps": 3, "radius": None, "max_zones": 7, "team": "a"})
    assert given.given == {"steps": 3, ZONES: 7} and given.team == "a"
