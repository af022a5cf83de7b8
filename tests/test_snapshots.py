"""What users read, under test: every help text, every error message. `--update-golden` renews."""

import re
import shutil
import sys
from pathlib import Path

from codegen import policy_json
from maviper.cli import main
from tests.support.altered import of_goals
from tests.support.verifying import every_command
from verify.certificates.games import to_json
from verify.claims.formula import TRUE
from verify.claims.region import Region

FOLDER = "tests/golden"


def test_help_texts(golden, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    text = ""
    for path, _ in every_command():
        assert main.run([*path, "--help"]) == 0
        text += f"$ {' '.join(('maviper', *path))} --help\n{capsys.readouterr().out}\n"
    golden(FOLDER, {"help.txt": text})


ERRORS = [
    ["verfy"],
    ["compile"],
    ["extract", "physical-decption", "-o", "p.json"],
    ["extract", "physical-deception", "--max-depth", "0", "-o", "p.json"],
    ["extract", "physical-deception", "--preset", "papper", "-o", "p.json"],
    ["extract", "physical-deception", "--seed", "-1", "-o", "p.json"],
    ["worlds", "show", "physical-decption"],
    ["show", "profile.json", "--agent", "agnt_1"],
    ["show", "missing.json"],
    ["show", "truncated.json"],
    ["show", "edited.json"],
    ["show", "misspelt.json"],
    ["show", "rules-broken.json"],
    ["compile", "profile.json", "--target", "pyton", "-o", "out"],
    ["compile", "profile.json", "--prefix", "2fast", "-o", "out"],
    ["compile", "profile.json", "-o", "profile.json/out"],
    ["compile", "profile.json", "--target", "json", "--prove", "-o", "out"],
    ["verify", "profile.json", "--claim", "distinct_target"],
    ["verify", "profile.json", "--claim", "distinct_targets(team=defender)"],
    ["verify", "profile.json", "--claim", "distinct_targets(margin=much)"],
    ["verify", "profile.json", "--region", "bad.toml"],
    ["verify", "profile.json", "--region", "misspelt.toml"],
    ["verify", "profile.json", "--set", "solver_units=0"],
    ["verify", "profile.json", "--claim", "no_double(kappa=1)"],
    ["verify", "profile.json", "--claim", "steady(of=alined)"],
    ["verify", "profile.json", "--set", "semantics=exact"],
    ["verify", "profile.json", "--claims", "claims.toml"],
    ["verify", "profile.json", "--claims", "claim.toml"],
    ["verify", "profile.json", "--claims", "powers.toml"],
    ["verify", "profile.json", "--claims", "acting.toml"],
    ["verify", "physical-decption", "--new"],
    ["compile", "profile.json", "--pass", "reoder", "-o", "out"],
    ["compile", "profile.json", "--pass", "drop", "-o", "out"],
    ["replay", "missing.json"],
    ["replay", "profile.json"],
    ["replay", "truncated.json"],
    ["replay", "far/certificate.json"],
    ["check", "far/certificate.json"],
    ["repair", "profile.json", "--claim", "reaches", "-o", "out"],
    ["diff", "profile.json", "far/other.json"],
    ["check", "missing.json"],
    ["check", "profile.json"],
    ["check", "truncated.json"],
    ["check", "certificate.json", "--profile", "missing.json"],
    ["check", "certificate.json"],
    ["train", "physical-deception", "-o", "run"],
    ["train", "physical-decption", "-o", "run"],
    ["train", "predator-prey,preys=1", "-o", "run"],
    ["train", "predator-prey,prey=99", "-o", "run"],
    ["train", "physical-deception", "--algorithm", "mapo", "-o", "run"],
    ["train", "physical-deception", "--recipe", "papr", "-o", "run"],
    ["train", "physical-deception", "--set", "games", "-o", "run"],
    ["train", "physical-deception", "--seeds", "0", "-o", "run"],
    ["extract", "cooperative-navigation,agents=25", "-o", "p.json"],
    ["extract", "physical-deception", "--critic", "guessed", "-o", "p.json"],
    ["extract", "no_such_module:expert", "-o", "p.json"],
    ["worlds", "check", "no_such_module:make"],
    ["extract", "physical-deception", "--algorithm", "mavipr", "-o", "p.json"],
    ["extract", "physical-deception", "--algorithm", "viper", "-o", "p.json"],
    ["extract", "physical-deception", "--splits", "histograms", "-o", "p.json"],
    ["extract", "profile.json", "-o", "p.json"],
    ["extract", "physical-deception", "--counterexamples", "missing.json", "-o", "p.json"],
    ["extract", "physical-deception", "--counterexamples", "profile.json", "-o", "p.json"],
    ["extract", "physical-deception", "--counterexamples", ".", "-o", "p.json"],
    ["evaluate", "physical-decption"],
    ["evaluate", "physical-deception", "--against", "randm"],
    ["evaluate", "physical-deception", "--with", "agnt_0=random"],
    ["evaluate", "physical-deception", "--episodes", "0"],
]


def test_error_messages(golden, capsys, monkeypatch, tmp_path):
    from tests.support.small import small_profile

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setitem(sys.modules, "torch", None)
    text = policy_json.dumps(small_profile())
    hashless = re.sub(r',\n  "content_hash": "\w+"', "", text)
    files = {
        "profile.json": text,
        "truncated.json": text[:1000],
        "edited.json": text.replace('"damping": 0.25', '"damping": 0.5'),
        "misspelt.json": text.replace('{"feature": "goal_dx"', '{"feature": "gaol_dx"'),
        "rules-broken.json": hashless.replace('"left": 1,', '"left": 0,').replace('"dt": 0.1', '"dt": -1e999'),
        "bad.toml": "goals = [",
        "claims.toml": '[[property]]\nname = "distinct_target"\n',
        "claim.toml": '[[property]]\nlabel = "mine"\nformula = "acts(agent_0) == lft or agent_1.x > 0"\n',
        "powers.toml": '[[property]]\nformula = """\nacts(agent_0) == left\nimplies agent_0.x * agent_0.x > 1"""\n',
        "acting.toml": '[[property]]\nformula = "true"\nassume = "closes(agent_0, goal)"\n',
        "far/other.json": hashless.replace("agent_", "cart_"),
        "certificate.json": to_json(of_goals("0" * 64, None, TRUE, Region({}, ()), "machine", {}, {"": b""})),
        "misspelt.toml": '[box]\n"agent_0.z" = [0, 1]\n',
    }
    for name, content in files.items():
        assert name == "profile.json" or content != text or not name.endswith(".json")
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(content)
    shutil.copy("certificate.json", "far")
    said = ""
    for arguments in ERRORS:
        code = main.run(arguments)
        out, err = capsys.readouterr()
        said += f"$ maviper {' '.join(arguments)}\n{err}[exit {code}]\n\n"
        assert code in (2, 5) and (out == "" or "check" in arguments) and not Path("out").exists()
    golden(FOLDER, {"errors.txt": said})
