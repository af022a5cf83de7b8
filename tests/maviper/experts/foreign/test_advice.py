"""What torch says of a file that holds more than weights: its advice to load it all the same is not passed on."""

import sys
from types import SimpleNamespace

import pytest

from codegen.errors import InputError
from maviper.experts.foreign import weights

SAID = {
    "Weights only load failed. This file can still be loaded, to do so you have two options, do those only if you "
    "trust the source of the checkpoint.\n(1) Re-running `torch.load` with `weights_only` set to `False` will likely "
    "succeed.\n(2) WeightsUnpickler error: Unsupported global: GLOBAL os.system was not an allowed global by default. "
    "Please use `torch.serialization.add_safe_globals([system])`.": "it holds os.system",
    "Weights only load failed. Re-running `torch.load` with `weights_only` set to `False` will likely succeed. "
    "WeightsUnpickler error: Unsupported operand 149": "it holds more than tensors, or is damaged",
    "Cannot use ``weights_only=True`` with TorchScript archives.": "it is a TorchScript archive",
    "PytorchStreamReader failed reading zip archive": "PytorchStreamReader failed reading zip archive",
    "": "RuntimeError",
}


@pytest.mark.parametrize("said", SAID, ids=SAID.values())
def test_the_reason_is_told_and_the_advice_is_not(said, monkeypatch):
    def load(*_given, **_settings):
        raise RuntimeError(said)

    monkeypatch.setitem(sys.modules, "torch", SimpleNamespace(load=load))
    with pytest.raises(InputError) as caught:
        weights.read(b"anything", "expert.pt")
    assert str(caught.value).splitlines()[1] == f"expert.pt: {SAID[said]}"
    assert "weights_only" not in str(caught.value) and "trust" not in str(caught.value)
