"""What the verbs are asked, each option written once.

Does: holds the table of options of a verb (its TypedDict), and what reads such a table.
Assumes: a table is imported with the package and with --help, so that nothing heavy may come with it.
Does not: run a verb, or know click.
"""

from maviper.options.extraction import ExtractOptions
from maviper.options.table import complete_options, make_request, speak_python, spell_out, table_of
from maviper.options.verbs import (
    VERIFY_SETTINGS,
    CompareOptions,
    CompileOptions,
    DiffOptions,
    EvaluateOptions,
    ExploitOptions,
    FileOptions,
    ImportOptions,
    RepairOptions,
    ReproduceOptions,
    SystemOptions,
    TrainOptions,
    VerifyOptions,
)

__all__ = [
    "VERIFY_SETTINGS",
    "CompareOptions",
    "CompileOptions",
    "DiffOptions",
    "EvaluateOptions",
    "ExploitOptions",
    "ExtractOptions",
    "FileOptions",
    "ImportOptions",
    "RepairOptions",
    "ReproduceOptions",
    "SystemOptions",
    "TrainOptions",
    "VerifyOptions",
    "complete_options",
    "make_request",
    "speak_python",
    "spell_out",
    "table_of",
]
