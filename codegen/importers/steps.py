"""Steps of scikit-learn before a tree that folding.py can fold: scalers, selectors and binarizers.

Does: says which column of the observation each column after the steps is made of.
Assumes: a fitted Pipeline of scikit-learn.
Does not: take a step that it does not know, or whose columns depend on one another.

Each known step maps one column by subtractions, additions, products with and quotients by positive numbers, clipping or
a comparison, and so never falls where its input rises.
"""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from codegen.errors import InputError, escape_text

POSITIVE = {  # steps of scikit-learn, and what their columns are multiplied with or divided by
    "sklearn.preprocessing._data.StandardScaler": "scale_",
    "sklearn.preprocessing._data.RobustScaler": "scale_",
    "sklearn.preprocessing._data.MinMaxScaler": "scale_",
    "sklearn.preprocessing._data.MaxAbsScaler": "scale_",
    "sklearn.preprocessing._data.Binarizer": "",
}
SELECTORS = "sklearn.feature_selection."
USED = ("mean_", "scale_", "center_", "min_", "data_min_", "data_max_", "max_abs_")  # by transform


def columns(steps: Sequence[tuple[str, Any]], width: int) -> list[int]:
    """Which column of the observation each column after the steps is made of. InputError with its name for a step that
    is not known to keep columns apart and in order.
    """
    places: list[int] = list(range(width))
    for name, step in steps:
        kind = f"{type(step).__module__}.{type(step).__qualname__}"
        _ensure_finite(name, step)
        if kind.startswith(SELECTORS) and "transform" not in vars(step) and hasattr(step, "get_support"):
            kept: list[int] = step.get_support(indices=True).tolist()
            places = [places[place] for place in kept]
        elif kind not in POSITIVE or "transform" in vars(step) or not _rising(step, POSITIVE[kind]):
            what = f"the step {escape_text(name)!r} before the tree is not understood: {type(step).__name__}"
            raise InputError(what, "", "use scalers, selectors and binarizers, or give the tree alone")
    return places


def _ensure_finite(name: str, step: Any) -> None:
    """InputError for a step that was fitted on missing or infinite numbers, and makes such of every observation."""
    for attribute, value in cast("dict[str, Any]", vars(step)).items():
        array = np.asarray(value) if attribute.endswith("_") and isinstance(value, np.ndarray | float) else None
        if attribute in USED and array is not None and array.dtype.kind == "f" and not np.isfinite(array).all():
            step_name = f"the step {escape_text(name)!r} before the tree"
            what = f"{step_name} has learned numbers that are not finite: {attribute}"
            raise InputError(what, type(step).__name__, "fit it on data without missing or infinite values")


def _rising(step: Any, attribute: str) -> bool:
    factor = getattr(step, attribute, None) if attribute else None
    return factor is None or bool((np.isfinite(factor) & (np.asarray(factor) > 0)).all())
