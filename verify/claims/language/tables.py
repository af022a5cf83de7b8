"""The `[[property]]` tables of a file, whatever their claims are about.

Does: finds them; reads each, and tells what is wrong in all of them at once.
Assumes: a parsed TOML text.
Does not: know claims.
"""

from collections.abc import Callable, Mapping
from typing import TypeVar

from codegen.errors import InputError, PartlyReadError
from verify.claims.region_files import is_list, is_table
from verify.toml_places import Place

Table = Mapping[str, object]
Read = TypeVar("Read")
MAX_PROPERTIES = 200


def properties(document: Table, file: Place) -> list[tuple[Table, Place]]:
    """The tables with their places. InputError for none, for too many, and for what is no table."""
    stated = document.get("property", [])
    place = file / "property"
    listed = stated if is_list(stated) else []
    tables: list[tuple[Table, Place]] = [(each, place / i) for i, each in enumerate(listed) if is_table(each)]
    if not tables or len(tables) < len(listed):
        raise InputError("no property in the file", file, "begin each with a line [[property]]")
    if len(tables) > MAX_PROPERTIES:
        raise InputError(f"a file may hold at most {MAX_PROPERTIES} properties", file, "split the file")
    return tables


def read_each(tables: list[tuple[Table, Place]], read: Callable[[Table, Place], Read]) -> list[Read]:
    """Reads each table. InputError that tells every table that cannot be read; PartlyReadError where others can be."""
    claims: list[Read] = []
    faults: list[InputError] = []
    for table, place in tables:
        try:
            claims.append(read(table, place))
        except InputError as error:
            faults.append(error)
    if not faults:
        return claims
    first, several = faults[0], len(faults) > 1
    told = "\n".join(f"- {fault}".replace("\n", "\n  ") for fault in faults)
    what = f"{len(faults)} of {len(tables)} properties cannot be read" if several else first.what
    where, advice = (told, "") if several else (first.where, first.next_step)
    if claims:
        raise PartlyReadError(what, where, advice, claims)
    raise InputError(what, where, advice) if several else first
