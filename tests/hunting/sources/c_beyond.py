"""Steps out of the subset of C."""
from tests.hunting.sources.drafts import Step
STEPS = (Step("static", "statement", "static int n_ = 0; if (n_++ > 40) return {label};"),)
