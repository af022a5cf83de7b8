"""`maviper.reproduce`, the verb: the paper's experiments, with the options of the command as parameters.

Does: hands its parameters to `maviper.reproduction.run`.
Assumes: it is imported with the package, so that nothing heavy may come with it.
Does not: print.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from codegen.process import flags
from maviper.options import ReproduceOptions, spelled_out

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Unpack

    from maviper.reproduction.run import Reproduced


@flags.defaults
@spelled_out(ReproduceOptions)
def reproduce(output: str | Path, **options: Unpack[ReproduceOptions]) -> Reproduced:
    """The experiments of the MAVIPER paper, as cells in the folder `output`, with their table and report.

    None: as quick, default or full says. With `plan`, `lines` of what is returned are the plan. `failed` of it: cells
    that failed, with their messages. Finished cells are not made again. InputError for what cannot be used,
    MissingToolError without room on the disk, without Dask, or when its scheduler goes away.
    """
    from maviper.reproduction.run import reproduced, request

    return reproduced(output, request(options))
