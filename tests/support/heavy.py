"""What several tests use of `test_imports`."""

HEAVY = {"highspy", "joblib", "matplotlib", "mpe2", "pettingzoo", "scipy", "sklearn", "torch", "z3"}
# What a claim about decisions, which most commands ask, does not need. With all of them, 230 modules of ours take
# 150 ms to import. tests/test_house.py holds that none of these is loaded.
ASIDE = {
    "codegen.agreement.compiled", "codegen.importers.reading", "maviper.compilation.covers",
    "maviper.compilation.monitors", "maviper.verification.files.systems",
    "maviper.worlds.outside.vmas", "maviper.worlds.outside.pettingzoo", "verify.extent.largest", "verify.reach.replay",
    "verify.reports.code", "verify.reports.episodes", "verify.reports.systems", "verify.reports.where",
    "verify.verdicts.episodes",
}  # fmt: skip
