"""make_pickles.py FOLDER: pickles of every protocol, that the tests read back."""
import collections
import copyreg
import datetime
import pathlib
import pickle
import sys

import numpy as np

folder = pathlib.Path(sys.argv[1])

shared = ["shared"]
recursive = [1]
recursive.append(recursive)
values = {
    "none": None, "true": True, "false": False,
    "integers": [0, 1, 255, 256, 65535, 65536, -1, -129, 2**31 - 1, -2**31, 2**62, -2**63],
    "floats": [0.0, -1.5, 1e300, float("inf")],
    "text": "Vélo \u4e16 \U0001f600\n\\", "bytes": b"\x00\xff'\n\\", "bytearray": bytearray(b"ab\xff"),
    "empty": [[], (), {}, "", b""],
    "tuples": [(1,), (1, 2), (1, 2, 3), (1, 2, 3, 4)],
    "set": {7}, "frozenset": frozenset([8]),
    "nested": [[1.0, 2], (3, [4.5])],
    "shared": [shared, shared], "recursive": recursive,
    "ordered": collections.OrderedDict([("b", 1), ("a", 2)]),
    "date": datetime.date(2022, 10, 23),
    "global": collections.OrderedDict, 3: "number", "long": list(range(3000)),
}

fortran = np.asfortranarray(np.arange(6, dtype=np.float32).reshape(2, 3))
arrays = {
    "f4": np.array([[1.5, -2], [3, 4]], np.float32), "f8": np.array([1e-300]),
    "f2": np.array([0.5, -2], np.float16), "big": np.array([1, -2], ">i4"), "i8": np.array([-5]),
    "u1": np.array([[255]], np.uint8), "bool": np.array([True, False]),
    "fortran": fortran, "fortran_texts": np.asfortranarray([["a", "bcd"], ["e", "f"]]),
    "empty": np.zeros((0, 7)), "zero_d": np.array(2.5), "scalar": np.float32(1.25),
    "integer": np.int64(-9), "flag": np.bool_(True), "step": np.arange(10)[::3],
    "texts": np.array(["chair", "Vélo", ""]), "byte_texts": np.array([b"ab", b"c"]),
    "objects": np.array([{"a": 1}, None, "x"], dtype=object).reshape(3, 1),
    "object_texts": np.array(["p", "qq"], dtype=object),
    "structured": np.zeros(2, [("x", "f4")]), "complex": np.zeros(1, complex),
    "large": np.arange(100000, dtype=np.int32),
}

for protocol in range(6):
    (folder / f"values{protocol}.pkl").write_bytes(pickle.dumps(values, protocol))
    (folder / f"arrays{protocol}.pkl").write_bytes(pickle.dumps(arrays, protocol))
np.save(folder / "scene.npy", {"boxes": fortran, "names": ["a"]}, allow_pickle=True)
np.save(folder / "objects.npy", arrays["objects"], allow_pickle=True)
np.save(folder / "texts.npy", arrays["fortran_texts"])
np.save(folder / "byte_texts.npy", arrays["byte_texts"])
np.save(folder / "numbers.npy", fortran)
