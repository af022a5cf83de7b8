"""Which worker takes which tests: a file stays on one, and so do all that open pages, and all that read our sources.

Does: hands out whole files in the order of the collection; those that share a browser or syntax trees go to one.
Assumes: pytest-xdist's scheduler by files, which counts the tests of all files again whenever one test ends.
Does not: order the files (tests/seconds.py).
"""

from xdist.scheduler import LoadFileScheduling

PAGES = ("tests/maviper/page/", "tests/maviper/cli/test_diff.py", "tests/test_worlds.py")
PAGES += ("tests/maviper/verification/test_stated_report.py",)
SOURCES = ("tests/test_house.py", "tests/test_imports.py", "tests/test_no_code_is_read.py")


class Scheduling(LoadFileScheduling):
    """By files; those of PAGES count as one, and those of SOURCES."""

    def _split_scope(self, nodeid):
        together = [files[0] for files in (PAGES, SOURCES) if nodeid.startswith(files)]
        return together[0] if together else super()._split_scope(nodeid)

    def _pending_of(self, workload):
        """How many tests of a worker's files are left; files that are through are not looked at again."""
        for scope in [scope for scope, tests in workload.items() if False not in tests.values()]:
            del workload[scope]
        return super()._pending_of(workload)
