"""Text from templates: the one Jinja2 environment of the project.

Does: finds the templates in a wheel or in a checkout, renders them strictly, offers the filters that templates use;
  escapes what steers a terminal in every value, and in those of one line (`visible`) also the ends of lines.
Assumes: templates only place values; whatever needs thought was done before.
Does not: hold any text of a target language.
"""

import re
import zlib
from collections.abc import Mapping, MutableMapping
from fractions import Fraction
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import TYPE_CHECKING, Any

from codegen.errors import escape_text
from codegen.intervals import format_share, percent
from codegen.numbers import smt_literal
from codegen.wording import format_count, visible

if TYPE_CHECKING:
    from jinja2 import Environment, Template

MAX_SHOWN = 12  # characters of a number that is shown as it is
PACKAGE = Path(__file__).parent.parent


class _Compiled(SourceFileLoader):
    """A template that is compiled as Python's modules are: once, into __pycache__ where that can be written, until its
    file changes, or Jinja, or what templates are read with.
    """

    def __init__(self, environment: "Environment", name: str, path: Path) -> None:
        super().__init__(name, str(path))
        self._environment = environment

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """The size of the file and, for its time, a number that all of it changes."""
        told = f"{Path(path).stat().st_mtime_ns} {_reader()}"
        return {**super().path_stats(path), "mtime": zlib.crc32(told.encode())}

    def source_to_code(self, data: Any, path: Any, **_: Any) -> CodeType:
        """The template as a program."""
        return self._environment.compile(data.decode(), self.name, str(path))


@cache
def _reader() -> str:
    """What templates are read with: Jinja's version, and the times of the files that are beside it here."""
    from jinja2 import __version__

    times = [each.stat().st_mtime_ns for each in (Path(__file__), *sorted(PACKAGE.glob("*.py")))]
    return f"{__version__} {times}"


@cache
def _environment() -> "Environment":
    from jinja2 import BaseLoader, Environment, StrictUndefined

    folder = PACKAGE / "templates"  # in a wheel; a checkout has them beside the packages
    folder = folder if folder.is_dir() else PACKAGE.parent / "templates"

    class Loader(BaseLoader):
        def load(
            self, environment: Environment, name: str, globals: MutableMapping[str, Any] | None = None
        ) -> "Template":
            code = _Compiled(environment, name, folder / name).get_code(name)
            assert code is not None, "each template is a file"
            return environment.template_class.from_code(environment, code, globals or {})

    environment = Environment(
        loader=Loader(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_escape_value,
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
    )
    filters = {
        "comment": comment,
        "counted": format_count,
        "float32": smt_literal,
        "percent": percent,
        "sampled": format_share,
        "shown": escape_text,
    }
    filters |= {"brief": brief, "exact": exact, "rounded": shorten_number, "visible": visible}
    environment.filters.update(filters)  # pyright: ignore[reportUnknownMemberType]
    return environment


def _escape_value(value: object) -> object:
    """Escapes a value that a template places: lines stay lines, all else that steers a terminal is escaped."""
    if not isinstance(value, str) or value.isprintable():
        return value
    return type(value)("\n".join(map(visible, value.split("\n"))))


def render(template: str, **values: Any) -> str:
    """The text of a template of the folder templates/."""
    return _environment().get_template(template).render(**values)


def brief(number: float | str) -> str:
    """A number as lines show it: with six digits; a fraction that is no float64 number comes as a text, and stays."""
    return number if isinstance(number, str) else f"{number:g}"


def exact(number: float | str) -> str:
    """A number with as many digits as it has: six, or those of its shortest decimal."""
    text = brief(number)
    return text if isinstance(number, str) or float(text) == number else repr(float(number))


def shorten_number(exact: float | str) -> str:
    """A number from its exact text, as a reader takes it in: itself where it is short, else with six digits and a sign
    that says so.
    """
    text = str(exact)
    return text if len(text) <= MAX_SHOWN else f"≈{float(Fraction(text.strip(chr(34)))):.6g}"


def comment(value: object) -> str:
    """A text that cannot end the comment or string it is put into: `a*/ b` becomes `a_/ b`."""
    return re.sub(r'[^\x20-\x7e]|[\\"]|\*(?=/)|/(?=\*)|\?(?=\?)', "_", str(value))
