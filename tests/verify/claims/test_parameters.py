"""The table of parameters: every claim's are in it, and files and options take all of it."""

import re
import subprocess
import sys
from pathlib import Path

import click

from maviper.cli.verify import verify
from maviper.verification.ask import VerifyOptions
from verify.claims import files
from verify.claims.built_in import CLAIMS as CLASSES
from verify.claims.catalogue import NAMES as CLAIMS
from verify.claims.catalogue import ZONES, readable
from verify.claims.decisions import STEADY
from verify.claims.episodes import EPISODE_CLAIMS
from verify.claims.parameters import NAMES, PARAMETERS
from verify.claims.relations import RELATIONS
from verify.claims.wording import BUILT_IN

ROOT = Path(__file__).parents[3]


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


def test_files_options_and_questions_take_what_the_table_has():
    options = {each.name: each for each in verify.params if each.name in NAMES}
    assert set(options) == set(NAMES) and set(NAMES) < set(files.KEYS)
    for name, form, told in PARAMETERS:
        assert options[name].help == told
        assert options[name].type is not click.INT and (options[name].metavar == form.value)
    given = VerifyOptions.of({"names": ("covers",), "steps": 3, "radius": None, "max_zones": 7, "team": "a"})
    assert given.parameters == {"steps": 3} and given.max_zones == 7 and given.team == "a"


ADDED = """
import importlib.util, inspect, sys, types
from pathlib import Path

name = "verify.claims.parameters"
file = importlib.util.find_spec(name).origin
line = "    order: "
table = Path(file).read_text()
assert table.count(line) == 1
module = sys.modules[name] = types.ModuleType(name)
exec(table.replace(line, '    slack: Annotated[Number | None, "New."]\\n' + line), module.__dict__)

import maviper
from codegen.errors import InputError
from maviper.cli import main

option = next(each for each in main.cli.commands["verify"].params if each.name == "slack")
assert (option.opts, option.help, option.metavar) == (["--slack"], "New.", "NUMBER")
assert inspect.signature(maviper.verify).parameters["slack"].annotation == module.Number | None
profile, folder = maviper.load(sys.argv[1]), Path(sys.argv[2])
for value in ("0.1", '"much"'):
    (folder / "claims.toml").write_text(f'[[property]]\\nname = "no_double"\\nslack = {value}\\n')
    try:
        maviper.verify_file(profile, folder / "claims.toml")
    except InputError as error:
        print(error.what)
try:
    maviper.verify(profile, "no_double", slack="1/40")
except InputError as error:
    print(error.what, "at", error.where)
"""


def test_a_new_parameter_is_one_line_of_the_table(tmp_path):
    """Option, Python and property files have it, as an exact number; what is left is a claim that reads it."""
    profile = ROOT / "generated" / "proved_defenders" / "profile.json"
    command = [sys.executable, "-c", ADDED, str(profile), str(tmp_path)]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert process.stdout.splitlines() == [
        "no_double has no parameter slack",
        "not a number: 'much'",
        "none of these claims has the parameter slack at slack",
    ], process.stderr
