"""make_checkpoints.py FOLDER: what torch.save writes, in both formats, for the tests to read."""
import collections
import os
import pathlib
import sys
import zipfile

import numpy as np
import torch

folder = pathlib.Path(sys.argv[1])
base = torch.arange(24, dtype=torch.float32)
state = collections.OrderedDict(
    plain=base.reshape(2, 3, 4), transposed=base.reshape(4, 6).t(), part=base[5:17:3],
    expanded=torch.tensor([7.0]).expand(3), scalar=torch.tensor(2.5), empty=torch.zeros(0, 4),
    half=torch.tensor([0.5, -2], dtype=torch.float16),
    bfloat16=torch.tensor([1.5, -3e38, 0.0], dtype=torch.bfloat16),
    double=torch.tensor([1e-300], dtype=torch.float64), long=torch.tensor([-5, 2**40]),
    int=torch.tensor([-7], dtype=torch.int32), short=torch.tensor([-8], dtype=torch.int16),
    char=torch.tensor([-9], dtype=torch.int8), byte=torch.tensor([255], dtype=torch.uint8),
    bool=torch.tensor([True, False]), parameter=torch.nn.Parameter(torch.ones(2, 2)))
state._metadata = {"": {"version": 1}}
checkpoint = {"epoch": 80, "it": np.int64(3), "model_state": state, "version": "pcdet+0.5.2",
              "optimizer_state": {"state": {0: {"step": 3, "exp_avg": base}},
                                  "param_groups": [{"lr": 1e-3, "betas": (0.9, 0.99)}]},
              "complex": torch.zeros(1, dtype=torch.complex64)}
del checkpoint["complex"]


class Evil:
    """Runs a command when it is unpickled by Python."""

    def __reduce__(self):
        return os.system, (f"touch {folder}/evil",)


for name, zipped in (("zip.pth", True), ("legacy.pth", False)):
    torch.save(checkpoint, folder / name, _use_new_zipfile_serialization=zipped)
    torch.save({"model_state": state, "evil": Evil()}, folder / f"evil_{name}",
               _use_new_zipfile_serialization=zipped)
    torch.save({"c": torch.zeros(1, dtype=torch.complex64)}, folder / f"complex_{name}",
               _use_new_zipfile_serialization=zipped)
torch.jit.save(torch.jit.script(torch.nn.Linear(2, 2)), str(folder / "script.pth"))

with zipfile.ZipFile(folder / "zip.pth") as archive:
    members = {name: archive.read(name) for name in archive.namelist()}


def rewrite(name, change, compression=zipfile.ZIP_STORED):
    changed = dict(members)
    change(changed)
    with zipfile.ZipFile(folder / name, "w", compression) as out:
        for member, content in changed.items():
            out.writestr(member, content)


rewrite("missing_storage.pth", lambda m: m.pop("zip/data/0"))
rewrite("short_storage.pth", lambda m: m.update({"zip/data/0": m["zip/data/0"][:-4]}))
rewrite("big_endian.pth", lambda m: m.update({"zip/byteorder": b"big"}))
rewrite("no_value.pth", lambda m: m.pop("zip/data.pkl"))
rewrite("bomb.pth", lambda m: m.update({"zip/data/0": bytes(100 << 20)}), zipfile.ZIP_DEFLATED)
