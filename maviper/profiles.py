"""The parts of profiles, which also describe a user's own environment, under the name that users import them by.

Does: hands on classes of `codegen.ir`.
Assumes: nothing heavy comes with them.
Does not: define any.
"""

from codegen.ir import ActionSpec as ActionSpec
from codegen.ir import AgentPolicy as AgentPolicy
from codegen.ir import FeatureSpec as FeatureSpec
from codegen.ir import Meaning as Meaning
from codegen.ir import OutputSpec as OutputSpec
from codegen.ir import PolicyProfile as PolicyProfile
from codegen.ir import Tree as Tree
