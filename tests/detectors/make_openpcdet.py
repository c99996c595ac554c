"""make_openpcdet.py FOLDER [CHECKPOINT...]: OpenPCDet checkpoints for the network whose entries FOLDER/entries.txt
lists as "NAME SIZE SIZE ...", in every layout; the numbers, once each, in FOLDER/expected.npz; and
the convolution of a block of voxels by the first sparse layer, in FOLDER/convolution.npz. Only the
checkpoints of these names, if names are given."""
import collections
import os
import pathlib
import sys

import numpy as np
import torch

folder = pathlib.Path(sys.argv[1])
wanted = sys.argv[2:]
torch.manual_seed(1)
state = collections.OrderedDict(global_step=torch.tensor([42]))
for line in (folder / "entries.txt").read_text().splitlines():
    name, *sizes = line.split()
    shape = [int(size) for size in sizes]
    if name.endswith("num_batches_tracked"):
        state[name] = torch.tensor(7)
    elif name.endswith("running_var"):
        state[name] = torch.rand(shape) + 0.5
    else:
        state[name] = torch.randn(shape) * 0.05
np.savez(folder / "expected.npz",
         **{name: value.numpy() for name, value in state.items() if name != "global_step"})


class Evil:
    def __reduce__(self):
        return os.system, (f"touch {folder}/evil",)


def laid_out(order):
    return collections.OrderedDict((name, value.permute(order).contiguous()
                                    if value.dim() == 5 else value)
                                   for name, value in state.items())


def save(name, model_state, zipped=True, **more):
    if wanted and name not in wanted:
        return
    torch.save({"model_state": model_state, "epoch": 80, "it": 18560, "version": "pcdet+0.5.2+0",
                "optimizer_state": {"param_groups": [{"lr": 1e-3}]}, **more},
               folder / name, _use_new_zipfile_serialization=zipped)


save("spconv2.pth", state)
save("spconv1.pth", laid_out((1, 2, 3, 4, 0)), zipped=False)
save("native.pth", laid_out((1, 2, 3, 0, 4)))
save("evil.pth", state, evil=Evil())
if not wanted:
    torch.save(collections.OrderedDict((f"module.{name}", value) for name, value in state.items()
                                       if not name.endswith("num_batches_tracked")),
               folder / "plain.pth")
    torch.save({"epoch": 3}, folder / "nothing.pth")
more = collections.OrderedDict(state)
more["teacher.a.weight"] = more["teacher.a.bias"] = more["dense_head.extra"] = torch.zeros(2)
save("more.pth", more)
less = collections.OrderedDict(more)
for name in list(less):
    if name.startswith("point_head.") or name == "dense_head.conv_box.bias":
        del less[name]
less["dense_head.conv_cls.bias"] = torch.zeros(3)
save("less.pth", less)
bad = collections.OrderedDict(state)
bad["dense_head.conv_box.bias"] = torch.full_like(bad["dense_head.conv_box.bias"], float("nan"))
save("bad.pth", bad)

# Layouts as spconv documents them, convolved by PyTorch.
weight = state["backbone_3d.conv_input.0.weight"]  # (out, z, y, x, in)
size = (6, 5, 7)
occupied = torch.rand(size) < 0.4
features = torch.randn(*size, weight.shape[4]) * occupied[..., None]
dense = torch.nn.functional.conv3d(features.permute(3, 0, 1, 2)[None],
                                   weight.permute(0, 4, 1, 2, 3), padding=1)[0]
z, y, x = torch.nonzero(occupied, as_tuple=True)
np.savez(folder / "convolution.npz", x=x.numpy(), y=y.numpy(), z=z.numpy(),
         features=features[z, y, x].numpy(), expected=dense.permute(1, 2, 3, 0)[z, y, x].numpy())
