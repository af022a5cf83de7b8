"""The errors that a caller can mend, and exit codes, under the name that users import them by: `maviper.errors`.

Does: hands on what `codegen.errors` defines; its text draws their tree.
Assumes: whoever uses maviper need not know which of its packages raises an error.
Does not: define any.
"""

from codegen.errors import DisagreementError as DisagreementError
from codegen.errors import ExitCode as ExitCode
from codegen.errors import HangingToolError as HangingToolError
from codegen.errors import InputError as InputError
from codegen.errors import MaviperError as MaviperError
from codegen.errors import MissingToolError as MissingToolError
from codegen.errors import PartlyReadError as PartlyReadError
from codegen.errors import ProfileError as ProfileError
from codegen.errors import RefusedError as RefusedError
from codegen.errors import UnknownNameError as UnknownNameError
