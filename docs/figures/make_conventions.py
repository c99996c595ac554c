#!/usr/bin/env python3
"""Draws docs/figures/conventions.svg: frames, yaw, sizes, corner order and KITTI's camera frame.

Use: docs/figures/make_conventions.py [FILE]. Needs Python alone. Boxes are projected here with the
same formulas that docs/conventions.md states, so the picture follows from the text.
"""

import math
import pathlib
import sys

X_COLOR, Y_COLOR, Z_COLOR = "#c0392b", "#1e8449", "#1f5fa8"
INK, FAINT, BOX = "#222222", "#9a9a9a", "#d35400"
PARTS = []


def add(text):
    PARTS.append(text)


def line(a, b, color=INK, width=1.6, dash="", arrow=False):
    style = f' stroke-dasharray="{dash}"' if dash else ""
    tip = ""
    if arrow:
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        points = " ".join(
            f"{b[0] + r * math.cos(angle + t):.1f},{b[1] + r * math.sin(angle + t):.1f}"
            for r, t in ((0, 0), (-11, 0.38), (-11, -0.38)))
        tip = f'<polygon points="{points}" fill="{color}"/>'
        b = (b[0] - 7 * math.cos(angle), b[1] - 7 * math.sin(angle))
    add(f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" '
        f'stroke="{color}" stroke-width="{width}" stroke-linecap="round"{style}/>{tip}')


def polygon(points, color, fill="none", width=2.0, opacity=1.0):
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    add(f'<polygon points="{text}" fill="{fill}" fill-opacity="{opacity}" stroke="{color}" '
        f'stroke-width="{width}" stroke-linejoin="round"/>')


def text(at, words, color=INK, size=15, anchor="middle", weight="normal", italic=False):
    style = ' font-style="italic"' if italic else ""
    add(f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{color}" font-size="{size}" '
        f'text-anchor="{anchor}" font-weight="{weight}"{style}>{words}</text>')


def dot(at, color=INK, radius=3.5):
    add(f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius}" fill="{color}"/>')


def arc(center, radius, start, end, color=INK):
    """An arrow along a circle; angles in radians, counter-clockwise on paper."""
    steps = 40
    points = [(center[0] + radius * math.cos(start + (end - start) * i / steps),
               center[1] - radius * math.sin(start + (end - start) * i / steps))
              for i in range(steps + 1)]
    path = "M " + " L ".join(f"{x:.1f} {y:.1f}" for x, y in points[:-1])
    add(f'<path d="{path}" fill="none" stroke="{color}" stroke-width="1.8"/>')
    line(points[-3], points[-1], color, 1.8, arrow=True)


def oblique(origin, scale):
    """A view from ahead, left and above: x comes towards the viewer, y goes right, z up."""
    def project(x, y, z):
        return (origin[0] + scale * (0.80 * y - 0.74 * x),
                origin[1] - scale * (0.94 * z - 0.20 * x - 0.22 * y))
    return project


def corners(center, size, yaw):
    c, s = math.cos(yaw), math.sin(yaw)
    result = []
    for i in range(8):
        x, y, z = (((i >> bit & 1) - 0.5) * size[bit] for bit in range(3))
        result.append((center[0] + c * x - s * y, center[1] + s * x + c * y, center[2] + z))
    return result


def corner_panel():
    text((250, 40), "A box: size, rotation, corner order", size=18, weight="bold")
    view = oblique((262, 280), 66)
    size, yaw = (4.0, 1.9, 1.6), 0.0
    points = [view(*p) for p in corners((0, 0, 0), size, yaw)]
    polygon([points[i] for i in (1, 3, 7, 5)], "none", BOX, 0, 0.16)
    hidden = {(0, 1), (0, 2), (0, 4)}
    for i in range(8):
        for bit in (1, 2, 4):
            j = i ^ bit
            if i < j:
                seen = (i, j) not in hidden
                line(points[i], points[j], BOX, 2.2 if seen else 1.3, "" if seen else "5 4")
    center = view(0, 0, 0)
    for axis, color, name in (((3.3, 0, 0), X_COLOR, "x"), ((0, 2.0, 0), Y_COLOR, "y"),
                              ((0, 0, 1.75), Z_COLOR, "z")):
        end = view(*axis)
        line(center, end, color, 2.4, arrow=True)
        away = (end[0] - center[0], end[1] - center[1])
        length = math.hypot(*away)
        text((end[0] + 14 * away[0] / length, end[1] + 14 * away[1] / length + 5), name, color, 17,
             weight="bold")
    dot(center)
    offsets = {0: (13, -6), 1: (-14, 10), 2: (15, 8), 3: (6, 22), 4: (-4, -10), 5: (-14, -4),
               6: (12, -6), 7: (13, 16)}
    for i, point in enumerate(points):
        dot(point, BOX, 3.2)
        text((point[0] + offsets[i][0], point[1] + offsets[i][1]), str(i), INK, 15, weight="bold")
    mid = lambda a, b: ((points[a][0] + points[b][0]) / 2, (points[a][1] + points[b][1]) / 2)
    for a, b, words, dx, dy, anchor in ((2, 3, "l (length)", 14, 16, "start"),
                                        (1, 3, "w (width)", -8, 26, "middle"),
                                        (1, 5, "h (height)", -10, 6, "end")):
        at = mid(a, b)
        text((at[0] + dx, at[1] + dy), words, FAINT, 14, anchor, italic=True)
    text((250, 528), "corner i: bit 0 of i is +x, bit 1 is +y, bit 2 is +z", size=14)
    text((250, 548), "shaded: the front face (+x); sizes are full extents", size=14)


def yaw_panel():
    left = 500
    text((left + 230, 40), "LiDAR frame from above: yaw", size=18, weight="bold")
    origin = (left + 300, 430)
    paper = lambda x, y: (origin[0] - 34 * y, origin[1] - 34 * x)
    for r in (3, 6, 9):
        add(f'<circle cx="{origin[0]}" cy="{origin[1]}" r="{34 * r}" fill="none" '
            f'stroke="#e4e4e4" stroke-width="1" clip-path="url(#yaw)"/>')
    line(origin, paper(10.2, 0), X_COLOR, 2.4, arrow=True)
    line(origin, paper(0, 7), Y_COLOR, 2.4, arrow=True)
    add(f'<circle cx="{origin[0]}" cy="{origin[1]}" r="7" fill="white" stroke="{Z_COLOR}" '
        f'stroke-width="2"/>')
    dot(origin, Z_COLOR, 2.5)
    text((origin[0] + 10, paper(10.2, 0)[1] + 12), "x forward", X_COLOR, 15, "start", "bold")
    text((paper(0, 7)[0] + 4, origin[1] + 22), "y left", Y_COLOR, 15, "middle", "bold")
    text((origin[0] + 14, origin[1] + 20), "z up", Z_COLOR, 15, "start", "bold")
    center, size, yaw = (5.6, 3.4), (4.0, 1.9), math.radians(35)
    c, s = math.cos(yaw), math.sin(yaw)
    at = lambda x, y: paper(center[0] + c * x - s * y, center[1] + s * x + c * y)
    l, w = size[0] / 2, size[1] / 2
    polygon([at(l, w), at(l, -w), at(-l, -w), at(-l, w)], BOX, BOX, 2.4, 0.12)
    line(at(l, w), at(l, -w), BOX, 5)
    middle = paper(*center)
    line(middle, at(3.3, 0), BOX, 2.0, arrow=True)
    line(middle, paper(center[0] + 3.3, center[1]), X_COLOR, 1.4, "5 4")
    arc(middle, 78, math.pi / 2, math.pi / 2 + yaw)
    text((middle[0] - 24, middle[1] - 88), "yaw", INK, 16, weight="bold")
    dot(middle)
    tip = at(3.3, 0)
    text((tip[0] - 4, tip[1] - 8), "heading", BOX, 14)
    text((left + 230, 528), "counter-clockwise about +z from +x, in (-&#960;, &#960;]", size=14)
    text((left + 230, 548), "here +35&#176;: x of the box turned to the left", size=14)


def kitti_panel():
    left = 985
    text((left + 225, 40), "KITTI label files and how they turn", size=18, weight="bold")
    origin = (left + 200, 430)
    paper = lambda x, y: (origin[0] - 34 * y, origin[1] - 34 * x)
    camera = paper(0.9, 0)
    line(camera, paper(10.2, 0), Z_COLOR, 2.2, arrow=True)
    line(camera, paper(0.9, -5.2), X_COLOR, 2.2, arrow=True)
    add(f'<circle cx="{camera[0]}" cy="{camera[1]}" r="7" fill="white" stroke="{Y_COLOR}" '
        f'stroke-width="2"/>')
    for sign in (-1, 1):
        line((camera[0] - 5, camera[1] - 5 * sign), (camera[0] + 5, camera[1] + 5 * sign),
             Y_COLOR, 1.6)
    text((camera[0] + 10, paper(10.2, 0)[1] + 12), "z forward", Z_COLOR, 15, "start", "bold")
    text((paper(0.9, -5.2)[0], camera[1] + 20), "x right", X_COLOR, 15, "middle", "bold")
    text((camera[0] - 14, camera[1] + 20), "y down", Y_COLOR, 15, "end", "bold")
    text((camera[0] - 16, camera[1] - 8), "rectified camera 0", INK, 13, "end")
    center, yaw = (5.9, -1.4), math.radians(35)
    rotation_y = -yaw - math.pi / 2
    c, s = math.cos(yaw), math.sin(yaw)
    at = lambda x, y: paper(center[0] + c * x - s * y, center[1] + s * x + c * y)
    polygon([at(2, .95), at(2, -.95), at(-2, -.95), at(-2, .95)], BOX, BOX, 2.4, 0.12)
    line(at(2, .95), at(2, -.95), BOX, 5)
    middle = paper(*center)
    line(middle, at(3.2, 0), BOX, 2.0, arrow=True)
    line(middle, (middle[0] + 110, middle[1]), X_COLOR, 1.4, "5 4")
    # rotation_y turns clockwise seen from above, so a negative angle goes counter-clockwise here.
    arc(middle, 66, 0, -rotation_y)
    text((middle[0] + 82, middle[1] - 46), "rotation_y &lt; 0", INK, 15, "start", "bold")
    dot(middle)
    text((left + 225, 488), "yaw = -(rotation_y + &#960;/2)", size=16, weight="bold")
    text((left + 225, 508), "centre = T(x, y, z) + (0, 0, h/2)", size=16, weight="bold")
    text((left + 225, 530), "labels give the centre of the bottom face and h w l;", size=14)
    text((left + 225, 550), "T = inverse of R0_rect &#183; Tr_velo_to_cam", size=14)


def main():
    add('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1460 570" width="1460" height="570" '
        'font-family="DejaVu Sans, Helvetica, Arial, sans-serif">')
    add('<rect width="1460" height="570" fill="white"/>')
    add('<clipPath id="yaw"><rect x="500" y="60" width="470" height="440"/></clipPath>')
    for x in (492, 978):
        line((x, 24), (x, 550), "#d5d5d5", 1)
    corner_panel()
    yaw_panel()
    kitti_panel()
    add("</svg>")
    default = pathlib.Path(__file__).with_name("conventions.svg")
    path = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    path.write_text("\n".join(PARTS) + "\n")
    print(path)


if __name__ == "__main__":
    main()
