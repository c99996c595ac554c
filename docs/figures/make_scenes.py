#!/usr/bin/env python3
"""make_scenes.py FOLDER: a made bin (COB-3D's layout) and a made room (Arbox' own), for figures.

    arbox view --dataset FOLDER/bins --output bin.png
    arbox view --dataset FOLDER/room --output room.png

Everything is boxes, seen by a ray-casting depth camera; nothing comes from a dataset.
"""
import json
import pathlib
import struct
import sys
import zlib

import numpy as np


def quaternion_matrix(q):
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def axis_quaternion(axis, angle):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])


def product(a, b):
    w, x, y, z = a
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]) @ b


def cast(rays, origin, center, size, rotation):
    """Distance along each ray to a box (inf for none), normals, and how near an edge the hit is."""
    local = rays @ rotation
    start = rotation.T @ (origin - center)
    with np.errstate(divide="ignore", invalid="ignore"):
        low = (-size / 2 - start) / local
        high = (size / 2 - start) / local
    near, far = np.minimum(low, high), np.maximum(low, high)
    enter, leave = near.max(-1), far.min(-1)
    hit = (enter < leave) & (enter > 0)
    axis = near.argmax(-1)
    rows = np.arange(len(rays))
    normals = np.zeros_like(rays)
    normals[rows, axis] = -np.sign(local[rows, axis])
    point = start + local * np.where(hit, enter, 0)[:, None]
    gaps = size / 2 - np.abs(point)
    gaps[rows, axis] = np.inf
    return np.where(hit, enter, np.inf), normals @ rotation.T, gaps.min(-1)


def render(boxes, intrinsic, shape, camera, origin):
    """Depth, colours, normals of the nearest box, its index, and the mask of each box alone."""
    height, width = shape
    v, u = np.mgrid[:height, :width]
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], -1)
    rays = pixels @ np.linalg.inv(intrinsic).T @ camera
    depth = np.full(u.size, np.inf)
    color, normal = np.zeros((u.size, 3)), np.zeros((u.size, 3))
    index, masks = np.full(u.size, -1), []
    light = np.array([0.35, -0.5, 0.8]) @ camera if origin is None else np.array([0.3, -0.5, 0.8])
    for i, box in enumerate(boxes):
        start = np.zeros(3) if origin is None else origin
        t, n, edge = cast(rays, start, box["center"], box["size"], box["matrix"])
        shade = 0.62 + 0.38 * np.abs(n @ (light / np.linalg.norm(light)))
        tone = np.array(box["color"])[None] * shade[:, None]
        tone = tone * np.where(edge < 0.012, 0.72, 1.0)[:, None]
        nearer = t < depth
        depth[nearer], color[nearer], normal[nearer], index[nearer] = t[nearer], tone[nearer], n[nearer], i
        masks.append(np.isfinite(t).reshape(shape))
    return depth, color, normal, index, masks, rays


def make_bin(folder, rng):
    shape, intrinsic = (480, 640), np.array([[560.0, 0, 319.5], [0, 560, 239.5], [0, 0, 1]])
    floor = 1.25
    boxes = []
    for center, size in [((0, 0, floor + 0.02), (0.96, 0.72, 0.04)),
                         ((-0.48, 0, floor - 0.13), (0.03, 0.75, 0.3)), ((0.48, 0, floor - 0.13), (0.03, 0.75, 0.3)),
                         ((0, -0.36, floor - 0.13), (0.99, 0.03, 0.3)), ((0, 0.36, floor - 0.13), (0.99, 0.03, 0.3))]:
        boxes.append(dict(center=np.array(center), size=np.array(size), matrix=np.eye(3), color=(0.42, 0.47, 0.55)))
    first, quaternions = len(boxes), []
    palette = [(0.80, 0.62, 0.40), (0.86, 0.84, 0.80), (0.70, 0.30, 0.26), (0.36, 0.55, 0.42), (0.88, 0.74, 0.36)]
    for layer in range(2):
        for gx in range(4 - layer):
            for gy in range(3 - layer):
                size = rng.uniform([0.13, 0.09, 0.05], [0.22, 0.15, 0.10])
                x = (gx - (3 - layer) / 2) * 0.22 + rng.normal(0, 0.012)
                y = (gy - (2 - layer) / 2) * 0.21 + rng.normal(0, 0.012)
                q = product(axis_quaternion([0, 0, 1], rng.uniform(-3, 3)),
                            axis_quaternion(rng.normal(size=3), rng.uniform(0.03, 0.3 + 0.25 * layer)))
                boxes.append(dict(center=np.array([x, y, floor - size[2] / 2 - 0.02 - 0.11 * layer]), size=size,
                                  matrix=quaternion_matrix(q), color=palette[int(rng.integers(len(palette)))]))
                quaternions.append(q)
    depth, color, normal, index, masks, _ = render(boxes, intrinsic, shape, np.eye(3), None)
    objects = range(first, len(boxes))
    depth = np.where(np.isfinite(depth), depth, 0) + rng.normal(0, 0.0008, depth.shape) * np.isfinite(depth)
    scene = folder / "bins" / "train" / "00000"
    (scene / "annotation").mkdir(parents=True, exist_ok=True)
    planes = lambda pixels: np.moveaxis(pixels.reshape(*shape, 3), -1, 0).astype(np.float32)
    np.savez_compressed(scene / "data.npz", rgb=planes(color), depth=depth.reshape(shape).astype(np.float32),
                        intrinsic=intrinsic, normals=planes(normal))
    np.savez_compressed(scene / "annotation" / "segm.npz", masks=np.stack([index.reshape(shape) == i for i in objects]),
                        masks_amodal=np.stack([masks[i] for i in objects]))
    np.savez_compressed(scene / "annotation" / "bbox3d.npz", dimensions=np.stack([boxes[i]["size"] for i in objects]),
                        centers=np.stack([boxes[i]["center"] for i in objects]), orientations=np.stack(quaternions))


def write_png(path, pixels):
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    chunk = lambda name, data: (struct.pack(">I", len(data)) + name + data +
                                struct.pack(">I", zlib.crc32(name + data)))
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) +
                     chunk(b"IEND", b""))


def make_room(folder, rng):
    """A room seen from its door: x right, y forward, z up; the sensor at the origin, 1.5 m above the floor."""
    shape, intrinsic = (480, 640), np.array([[420.0, 0, 319.5], [0, 420, 239.5], [0, 0, 1]])
    floor, parts, labels = -1.5, [], []

    def add(center, size, yaw, color):
        parts.append(dict(center=np.array(center, float), size=np.array(size, float),
                          matrix=quaternion_matrix(axis_quaternion([0, 0, 1], yaw)), color=color))

    def label(name, x, y, size, yaw, pieces):
        turn = quaternion_matrix(axis_quaternion([0, 0, 1], yaw))
        for offset, extent, color in pieces:
            add(np.array([x, y, floor]) + turn @ np.array(offset, float), extent, yaw, color)
        labels.append({"class": name, "box": {"center": [x, y, floor + size[2] / 2], "size": list(size), "yaw": yaw}})

    add((0, 3, floor - 0.05), (6, 8, 0.1), 0, (0.72, 0.66, 0.58))
    add((0, 5.6, 0), (6, 0.1, 3), 0, (0.86, 0.85, 0.80))
    add((-2.7, 3, 0), (0.1, 8, 3), 0, (0.80, 0.83, 0.85))
    add((2.85, 3, 0), (0.1, 8, 3), 0, (0.80, 0.83, 0.85))
    wood, dark, cloth, red = (0.62, 0.45, 0.28), (0.30, 0.26, 0.24), (0.48, 0.58, 0.74), (0.62, 0.26, 0.24)
    label("bed", -1.45, 4.3, (2.1, 1.6, 1.0), -np.pi / 2,
          [((0, 0, 0.2), (2.1, 1.6, 0.3), wood), ((0.05, 0, 0.45), (1.9, 1.5, 0.25), cloth),
           ((-1.02, 0, 0.5), (0.06, 1.6, 1.0), wood), ((-0.7, 0, 0.62), (0.4, 1.2, 0.12), (0.92, 0.92, 0.9))])
    legs = lambda l, w, h, color: [((sx * (l / 2 - 0.04), sy * (w / 2 - 0.04), h / 2), (0.06, 0.06, h), color)
                                   for sx in (-1, 1) for sy in (-1, 1)]
    label("table", 1.25, 3.2, (1.4, 0.8, 0.74), 0.25, [((0, 0, 0.72), (1.4, 0.8, 0.04), wood)] + legs(1.4, 0.8, 0.7, wood))
    for x, y, yaw in ((0.25, 2.75, 0.1), (2.15, 2.9, 2.7), (1.05, 4.05, -1.4)):
        label("chair", x, y, (0.5, 0.48, 0.92), yaw,
              [((0, 0, 0.45), (0.5, 0.48, 0.05), red), ((-0.23, 0, 0.7), (0.04, 0.48, 0.44), red)] + legs(0.5, 0.48, 0.43, dark))
    label("bookshelf", 2.3, 5.25, (0.4, 1.1, 1.9), -np.pi / 2,
          [((-0.18, 0, 0.95), (0.04, 1.1, 1.9), wood)] +
          [((0, 0, h), (0.4, 1.1, 0.03), wood) for h in (0.02, 0.48, 0.94, 1.4, 1.88)] +
          [((0, s * 0.535, 0.95), (0.4, 0.03, 1.9), wood) for s in (-1, 1)] +
          [((0.02, -0.2, 0.65), (0.2, 0.5, 0.3), red), ((0.02, 0.15, 1.1), (0.2, 0.6, 0.28), (0.3, 0.42, 0.55))])
    label("night_stand", -0.3, 5.2, (0.45, 0.5, 0.55), -np.pi / 2, [((0, 0, 0.275), (0.45, 0.5, 0.55), wood)])
    tilt = 0.32
    camera = np.array([[1, 0, 0], [0, -np.sin(tilt), -np.cos(tilt)], [0, np.cos(tilt), -np.sin(tilt)]])
    depth, color, _, _, _, rays = render(parts, intrinsic, shape, camera, np.zeros(3))
    seen = np.isfinite(depth)
    distance = depth[seen] + rng.normal(0, 0.004, seen.sum()) * depth[seen]
    points = np.concatenate([rays[seen] * distance[:, None], color[seen]], 1).astype(np.float32)
    root = folder / "room"
    for name in ("points", "labels", "images", "calib"):
        (root / name).mkdir(parents=True, exist_ok=True)
    text = "x,y,z,r,g,b\n" + "\n".join(",".join(f"{n:.4f}" for n in row) for row in points)
    (root / "points" / "room.csv").write_text(text + "\n")
    (root / "labels" / "room.json").write_text(json.dumps({"frame": "room", "objects": labels}))
    (root / "dataset.json").write_text(json.dumps({"format": "arbox dataset", "version": 1, "frame": "room"}))
    projection = np.concatenate([intrinsic @ camera, np.zeros((3, 1))], 1)
    (root / "calib" / "room.json").write_text(json.dumps(
        {"projection": projection.tolist(), "image_size": [shape[1], shape[0]]}))
    write_png(root / "images" / "room.png", (255 * color.reshape(*shape, 3)).astype(np.uint8))


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    make_bin(target, np.random.default_rng(7))
    make_room(target, np.random.default_rng(8))
