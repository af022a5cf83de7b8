"""Files given to the wrong command: the error says what the file is, what was wanted, and who takes it."""

import re
from pathlib import Path

import pytest

from maviper.cli import main
from maviper.files import kinds

ROOT = Path(__file__).parents[3]
GENERATED = ROOT / "generated"
PROFILE = GENERATED / "proved_defenders" / "profile.json"
VERDICTS = GENERATED / "verdicts" / "physical_deception"
TABLE = ROOT / "maviper" / "manual" / "files.md"


def one(pattern, folder=GENERATED):
    return sorted(folder.rglob(pattern))[0]


FILES = {
    kinds.PROFILE: PROFILE,
    kinds.CERTIFICATE: one("certificate-1-distinct_targets.json"),
    kinds.COUNTEREXAMPLE: one("counterexample-*.json", VERDICTS),
    kinds.REPORT: one("report.json"),
    kinds.CLAIMS: VERDICTS / "properties.toml",
    kinds.EXPERT: one("*.safetensors", ROOT / "maviper" / "experts" / "shipped"),
}
HEADERS = {"expert": kinds.EXPERT, "training": kinds.TRAINING}
TAKERS = [
    (["show", "{}"], {kinds.PROFILE}, "a policy profile"),
    (["evaluate", "{}"], {kinds.PROFILE, kinds.EXPERT, kinds.CLAIMS}, "a policy profile"),
    (["check", "{}", "--profile", str(PROFILE)], {kinds.CERTIFICATE}, "a certificate"),
    (["replay", "{}", "--profile", str(PROFILE)], {kinds.COUNTEREXAMPLE}, "a counterexample"),
    (["verify", str(PROFILE), "--region", "{}"], set(), "a region file"),
    (["verify", str(PROFILE), "--claims", "{}"], {kinds.CLAIMS}, "a file of claims"),
    (
        ["extract", "physical-deception", "--counterexamples", "{}", "-o", "x.json"],
        {kinds.COUNTEREXAMPLE},
        "a counterexample to a claim about single decisions",
    ),
]


@pytest.mark.parametrize("kind", FILES, ids=lambda kind: kind.called)
def test_files_are_known_whole_and_damaged(kind):
    data = FILES[kind].read_bytes()
    assert kinds.kind_of(data) is kind
    assert kinds.kind_of(data[: max(2_000, len(data) // 2)]) is kind


@pytest.mark.parametrize("command,takes,wanted", TAKERS, ids=lambda value: value if isinstance(value, str) else None)
def test_the_wrong_kind_is_answered_in_three_lines(tmp_path, monkeypatch, capsys, command, takes, wanted):
    monkeypatch.chdir(tmp_path)
    for kind, file in FILES.items():
        if kind not in takes:
            assert main.run([word.format(file) for word in command]) == 2, kind
            *_, first, where, advice = capsys.readouterr().err.splitlines()
            assert first == f"error: {kind.called}, not {wanted}" and file.name in where and advice[2:] == kind.taken


def test_what_the_manual_lists_is_known():
    forms = re.findall(r"`(maviper-[a-z-]+-\d)`", TABLE.read_text())
    members = {"states": "states", "zones": "zones", "verification": "report", "cell": "format"}
    members |= {"system-verification": "report", "difference-outputs": "difference", "extraction": "format"}
    for form in forms:
        stem = form[len("maviper-") : -2]
        if stem in ("claims", "record", "expert", "training"):  # for no command, or told by the header of tensors
            continue
        member = members.get(stem, stem.rpartition("-")[2])
        assert kinds.kind_of(f'{{"{member}": "{form}"}}'.encode()) is kinds.NAMED[stem]
    assert len(forms) >= 7


def test_the_manual_says_what_reads_each_form():
    told = dict[str, str]()  # by form, the paragraphs that name it
    for paragraph in re.split(r"\n(?=- )|\n\n", TABLE.read_text()):
        for form in re.findall(r"`maviper-([a-z-]+)-\d+`", paragraph):
            told[form] = told.get(form, "") + paragraph
    assert len(told) > 15
    for form, paragraphs in told.items():
        kind = (kinds.NAMED | HEADERS).get(form)
        readers = [] if kind is None else re.findall(r"`maviper (\w+)", kind.taken)[:1]
        assert all(re.search(rf"`(maviper )?{name}\b", paragraphs) for name in readers), form
        assert kind is None or readers or "People" in paragraphs, form


def test_other_files_are_of_no_kind():
    for data in (
        b"",
        b"{}",
        b"[1]",
        b"hello",
        b'{"states": 5}',
        b'{"said": "\\"certificate\\": \\"maviper-certificate-1\\""}',
    ):
        assert kinds.kind_of(data) is None
