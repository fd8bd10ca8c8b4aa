"""Theatres as a calibration program would measure them, and the archives it would write."""

import io
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.layouts import layout
from subsea.stage.theatre.lenses import nodes_text
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.measures import chosen
from subsea.stage.theatre.theatre_writer import compose_layout, mesh_name
from subsea.stage.theatre.warp import mesh
from subsea.view.rig import sources_at

GAMMA = 2.2
RADIUS_CM, HALF_WIDTH, HALF_HEIGHT_CM = 275.0, np.radians(60.0), 125.0


def on_the_screen(yaw, x, y):
    """Shares of a cylinder's picture that a projector under the ceiling lights at (x, y)."""
    position = np.array([-40 * np.sin(yaw), 90.0, -40 * np.cos(yaw)])  # right, up, ahead
    ahead = np.array([np.sin(yaw) * 0.97, -0.24, np.cos(yaw) * 0.97])
    right = np.array([np.cos(yaw), 0.0, -np.sin(yaw)])
    up = np.cross(ahead, right)
    rays = ahead + (2 * x[..., None] - 1) * 0.47 * right + (2 * y[..., None] - 1) * 0.52 * up
    flat, start = rays[..., [0, 2]], position[[0, 2]]
    a, b, c = (flat**2).sum(-1), (flat * start).sum(-1), (start**2).sum() - RADIUS_CM**2
    hit = position + ((-b + np.sqrt(b * b - a * c)) / a)[..., None] * rays
    u = np.arctan2(hit[..., 0], hit[..., 2]) / (2 * HALF_WIDTH) + 0.5
    v = hit[..., 1] / (2 * HALF_HEIGHT_CM) + 0.5
    shares = np.stack([u, v], axis=-1)
    shares[((shares < 0) | (shares > 1)).any(axis=-1)] = np.nan
    return shares


def grid_of(size):
    """x and y (h, w) of the middles of pixels, upper row first."""
    x, y = (np.arange(size[0]) + 0.5) / size[0], 1 - (np.arange(size[1]) + 0.5) / size[1]
    return np.meshgrid(x, y)


def cylinder(size=(160, 120)):
    """Three projectors side by side: warp, alpha and beta of each, for one picture."""
    x, y = grid_of(size)
    yaws = np.radians([-38.0, 0.0, 38.0])
    projectors = []
    for name, yaw in zip(("left", "middle", "right"), yaws, strict=True):
        shares = on_the_screen(yaw, x, y)
        low = np.nanmin(shares.reshape(-1, 2), axis=0)
        high = np.nanmax(shares.reshape(-1, 2), axis=0)
        projectors.append(
            SimpleNamespace(
                name=name,
                yaw=yaw,
                size=size,
                place=(*low, *(high - low)),
                shares=shares,
                sources=(shares - low) / (high - low),
                frustum="",
            )
        )
    for one in projectors:  # of the light at a point each gives its part
        weights = [_rim_at(other.yaw, one.shares) for other in projectors]
        total = np.sum(weights, axis=0)
        part = np.where(total > 0, weights[projectors.index(one)] / np.maximum(total, 1e-9), 1.0)
        one.alpha = np.nan_to_num(part, nan=0.0) ** (1 / GAMMA)
        one.beta = np.where(np.sum(np.array(weights) > 0, axis=0) > 1, 0.0, 0.05)
    return projectors


def _rim_at(yaw, shares):
    """Depth of points of the screen within a projector's picture: 0 outside, to 1."""
    u, v = np.moveaxis(np.nan_to_num(shares, nan=0.5), -1, 0)
    longitude, height = (u - 0.5) * 2 * HALF_WIDTH, (v - 0.5) * 2 * HALF_HEIGHT_CM
    hit = np.stack([RADIUS_CM * np.sin(longitude), height, RADIUS_CM * np.cos(longitude)], axis=-1)
    ray = hit - [-40 * np.sin(yaw), 90.0, -40 * np.cos(yaw)]
    right = np.array([np.cos(yaw), 0.0, -np.sin(yaw)])
    depth = ray @ [np.sin(yaw) * 0.97, -0.24, np.cos(yaw) * 0.97]
    across = ray @ right / np.maximum(depth, 1e-9) / 0.47
    depth_scale = 0.97**2 + 0.24**2
    across = np.where(depth > 0, across * depth_scale, 9.0)
    return np.clip((1 - np.abs(across)) / 0.4, 0.0, 1.0)


def png(values, bits=8):
    """The bytes of a grey PNG of values (h, w) from 0 to 1, or of colours (h, w, 3)."""
    most = 2**bits - 1
    codes = np.round(np.clip(values, 0, 1) * most).astype(np.uint16 if bits == 16 else np.uint8)
    file = io.BytesIO()
    Image.fromarray(codes).save(file, "PNG")
    return file.getvalue()


def compose_pfm(numbers, little_endian=True):
    """The bytes of a PFM file of numbers (height, width, 3 or 1), the upper row first."""
    height, width, count = numbers.shape
    kind = {3: "PF", 1: "Pf"}[count]
    header = f"{kind}\n{width} {height}\n{-1.0 if little_endian else 1.0}\n".encode()
    return header + numbers[::-1].astype("<f4" if little_endian else ">f4").tobytes()


def places_of(warp, sources, eye=0):
    """Where sources (k, 2) are shown, (k, 2): the inverse of `sources_at`; NaN where nowhere."""
    shown = warp.vertices[:, 2 + 2 * eye : 4 + 2 * eye]
    return sources_at(mesh(shown, warp.vertices[:, :2], warp.triangles), sources)


def pfm(sources):
    """The bytes of a PFM grid of sources (h, w, 2)."""
    return compose_pfm(np.concatenate([sources, np.zeros((*sources.shape[:2], 1))], axis=2))


def parts(projectors, profile="2d", bits=8):
    """The files of an archive, by name."""
    regions, filesets, files = [], [], {}
    for one in projectors:
        x, y, width, height = one.place
        regions.append(
            f'<region id="{one.name}" Xresolution="{one.size[0]}" Yresolution="{one.size[1]}" '
            f'x="{x}" y="{y}" xsize="{width}" ysize="{height}">{one.frustum}</region>'
        )
        filesets.append(f"""
    <fileset region="{one.name}">
      <geometryWarpFile><path>{one.name}.pfm</path><interpolation>linear</interpolation>
      </geometryWarpFile>
      <alphaMap><path>maps/{one.name}-alpha.png</path><componentDepth>1</componentDepth>
        <bitDepth>{bits}</bitDepth><gammaEmbedded>{GAMMA}</gammaEmbedded></alphaMap>
      <betaMap><path>maps/{one.name}-beta.png</path><componentDepth>1</componentDepth>
        <bitDepth>8</bitDepth></betaMap>
    </fileset>""")
        files[f"{one.name}.pfm"] = pfm(one.sources)
        files[f"maps/{one.name}-alpha.png"] = png(one.alpha, bits)
        files[f"maps/{one.name}-beta.png"] = png(one.beta)
    xml = f"""<?xml version="1.0" encoding="utf-8"?>
<MPCDI profile="{profile}" geometry="1" color="1" date="2026-01-01 09:00:00" version="2.0">
  <display><buffer id="cylinder" Xresolution="400" Yresolution="100">
    {"".join(regions)}
  </buffer></display>
  <files>{"".join(filesets)}
  </files>
</MPCDI>
"""
    return {"mpcdi.xml": xml.encode(), **files}


def zipped(files):
    """The bytes of an archive of files."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            one = zipfile.ZipInfo(name)  # of no date: the same files give the same bytes
            archive.writestr(one, data, zipfile.ZIP_DEFLATED)
    return whole.getvalue()


@pytest.fixture
def projectors():
    return cylinder()


@pytest.fixture(scope="session")
def making():
    """The functions of this file, for tests that write archives of their own."""
    return SimpleNamespace(
        cylinder=cylinder,
        parts=parts,
        zipped=zipped,
        png=png,
        pfm=pfm,
        compose_pfm=compose_pfm,
        places_of=places_of,
        grid_of=grid_of,
        gamma=GAMMA,
    )


@pytest.fixture
def planned_channels(tmp_path):
    """The channels of a new theatre with projectors of a size, read from its files."""

    def channels(kind, size, **measures):
        plan = layout(kind, chosen(kind, {"across": size[0], "down": size[1], **measures}))
        path = tmp_path / "new.toml"
        path.write_text(compose_layout(plan, "new", size, False, ""))
        for one in plan.channels:
            if one.nodes is not None:
                (tmp_path / mesh_name("new", one.name)).write_text(nodes_text(one.nodes))
        usable, faults = usable_channels(*load_theatre(str(path)))
        assert not faults
        return usable

    return channels
