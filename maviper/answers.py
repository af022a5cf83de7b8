"""The classes of what functions return, under the name that users import them by: `maviper.answers.Verdict`.

Does: hands on the classes of verdicts, their evidence, and of what else `maviper` returns; and the writer of regions.
Assumes: whoever imports them has asked for an answer, so the solver may come with them.
Does not: define any.
"""

from maviper.compilation.compile import Compiled as Compiled
from maviper.evaluation.exploitability import Exploitability as Exploitability
from maviper.evaluation.run import Evaluation as Evaluation
from maviper.evaluation.run import Reached as Reached
from maviper.reproduction.compared import AlgorithmsCompared as AlgorithmsCompared
from maviper.reproduction.run import Reproduced as Reproduced
from maviper.team import Team as Team
from maviper.verification.compared import OutputsCompared as OutputsCompared
from maviper.verification.diff import Compared as Compared
from maviper.verification.files.certificates import Checked as Checked
from maviper.verification.files.counterexamples import Replayed as Replayed
from maviper.verification.guarding import Guarded as Guarded
from maviper.verification.repair import Repaired as Repaired
from maviper.verification.robust import Changes as Changes
from maviper.verification.robust import Radii as Radii
from maviper.verification.run import Verified as Verified
from verify.claims.region import Region as Region
from verify.claims.region_files import region_toml as region_toml
from verify.counterexamples.search import AgentView as AgentView
from verify.counterexamples.search import Counterexample as Counterexample
from verify.question import Question as Question
from verify.reach.results import SystemCounterexample as SystemCounterexample
from verify.result import Cost as Cost
from verify.result import Evidence as Evidence
from verify.result import Result as Result
from verify.result import Verdict as Verdict
from verify.verdicts.decisions import DecisionEvidence as DecisionEvidence
from verify.verdicts.episodes import EpisodeEvidence as EpisodeEvidence
from verify.verdicts.systems import SystemEvidence as SystemEvidence
