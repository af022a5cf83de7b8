"""What the verbs are asked, each option written once.

Does: holds the table of options of a verb (its TypedDict), and what reads such a table.
Assumes: a table is imported with the package and with --help, so that nothing heavy may come with it.
Does not: run a verb, or know click.
"""

from maviper.options.extraction import ExtractOptions
from maviper.options.measuring import EvaluateOptions, ExploitOptions
from maviper.options.profiles import CompileOptions, DiffOptions, ImportOptions, RepairOptions
from maviper.options.reproduction import ReproduceOptions
from maviper.options.table import complete_options, make_request, spell_out, table_of
from maviper.options.training import TrainOptions
from maviper.options.verification import FileOptions, SystemOptions, VerifyOptions

__all__ = [
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
    "spell_out",
    "table_of",
]
