"""Train a small detector with a pose head on sets of `subsea dataset`, and test it on other sets.

    python docs/train_detector.py --train plain varied --test schools twilight --sheets sheets

Needs PyTorch and pycocotools (`pip install "subsea[train]"`). A model learns from the training part
of each set after --train, then finds the fishes of each set after --test. Prints their average
precision. docs/how-to/train.md describes the experiment.

Fishes are found as in CenterNet (Zhou, Wang, Krähenbühl, "Objects as Points", 2019): a map of the
middles of visible boxes at a quarter of the resolution, with size, offset and keypoints of each.
"""

import argparse
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch
from detector_pictures import MOST, STRIDE, Pictures, Targets, precision, sheet
from torch import Tensor, nn
from torch.nn import functional

WIDTHS = (16, 32, 64, 96, 128)  # channels at a half to a 32nd of the resolution
WIDE = 32  # channels of the way back up
RATE, WARM_UP, DECAY = 2e-3, 0.05, 1e-4  # of AdamW; a share of the training
POINTS_WEIGHT = 10.0  # lower ones learn poses later
LEAST_SCORE = 0.02


def block(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    """Make a normalised convolution."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class Detector(nn.Module):
    """Find fishes and k keypoints of each, with half a million weights."""

    def __init__(self, keypoints: int) -> None:
        super().__init__()
        inputs = (3, *WIDTHS[:-1])
        self.down = nn.ModuleList(
            nn.Sequential(block(a, b, 2), block(b, b)) if level > 1 else block(a, b, 2)
            for level, (a, b) in enumerate(zip(inputs, WIDTHS, strict=True))
        )
        self.across = nn.ModuleList(nn.Conv2d(width, WIDE, 1) for width in WIDTHS[1:])
        self.up = nn.ModuleList(block(WIDE, WIDE) for _ in WIDTHS[2:])
        self.heat = nn.Conv2d(WIDE, 1, 1)
        self.box = nn.Conv2d(WIDE, 4, 1)
        self.points = nn.Conv2d(WIDE, 2 * keypoints, 1)
        nn.init.constant_(self.heat.bias, -4.0)  # most cells have no fish

    def forward(self, pictures: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return the map (n, h, w), boxes (n, 4, h, w) and keypoints (n, 2 k, h, w)."""
        levels = []
        for step in self.down:
            pictures = step(pictures)
            levels.append(pictures)
        ways = [across(level) for across, level in zip(self.across, levels[1:], strict=True)]
        x = ways.pop()
        for smooth in self.up:
            x = smooth(functional.interpolate(x, scale_factor=2.0) + ways.pop())
        return self.heat(x)[:, 0], self.box(x), self.points(x)


def tensor_of(pixels: Any) -> Tensor:
    """Turn pictures (n, h, w, 3) of bytes into numbers (n, 3, h, w) about 0."""
    numbers = np.ascontiguousarray(pixels.transpose(0, 3, 1, 2)).astype(np.float32)
    return torch.from_numpy(numbers / 64.0 - 2.0).contiguous(memory_format=torch.channels_last)


def loss_of(model: nn.Module, targets: Targets) -> Tensor:
    """Sum the focal loss of the map (CenterNet eq. 1), and absolute errors at the fishes."""
    heat, cells, boxes, points, visible = map(torch.from_numpy, targets[1:])
    found, box, keypoints = model(tensor_of(targets.pixels))
    p = torch.sigmoid(found).clamp(1e-4, 1.0 - 1e-4)
    middle = heat == 1.0
    hits = -((1.0 - p) ** 2 * p.log())[middle].sum()
    misses = -((1.0 - heat) ** 4 * p**2 * (1.0 - p).log())[~middle].sum()
    fishes = max(len(cells), 1)
    k, row, column = cells.T
    off = (box[k, :, row, column] - boxes).abs().sum()
    guess = keypoints[k, :, row, column].reshape(len(cells), -1, 2)
    apart = ((guess - points).abs().sum(-1) * visible).sum()
    return (hits + misses + off) / fishes + POINTS_WEIGHT * apart / visible.sum().clamp(min=1)


def train(pictures: Pictures, seen: int, batch: int, seed: int) -> Detector:
    """Train with `seen` draws of a picture; half of the batches are mirrored."""
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    model = Detector(len(pictures.names)).to(memory_format=torch.channels_last)
    steps = max(seen // batch, 2)
    optimiser = torch.optim.AdamW(model.parameters(), RATE, weight_decay=DECAY)
    rate = torch.optim.lr_scheduler.LambdaLR(
        optimiser,
        lambda step: min((step + 1) / (WARM_UP * steps), 1.0)
        * 0.5 * (1.0 + math.cos(math.pi * step / steps)),
    )  # fmt: skip
    losses = []
    for step in range(1, steps + 1):
        who = random.integers(len(pictures), size=batch)
        loss = loss_of(model, pictures.targets(who.tolist(), bool(random.integers(2))))
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(model.parameters(), 5.0)
        optimiser.step()
        rate.step()
        losses.append(float(loss.detach()))
        if step % max(steps // 10, 1) == 0:
            print(
                f"  {step * batch} pictures, {time.process_time():.0f} s of processor time, loss "
                f"{np.mean(losses[-(steps // 10) or None :]):.2f}",
                flush=True,
            )
    return model.eval()


@torch.no_grad()
def find(model: nn.Module, pictures: Pictures, batch: int = 16) -> list[dict[str, Any]]:
    """Find the fishes of all pictures, as results in COCO's form."""
    results = []
    for start in range(0, len(pictures), batch):
        heat, box, points = model(tensor_of(pictures.pixels[start : start + batch]))
        p = torch.sigmoid(heat)
        peaks = torch.where(functional.max_pool2d(p, 3, 1, 1) == p, p, 0.0)
        scores, places = peaks.flatten(1).topk(min(MOST, p[0].numel()))
        for k, image in enumerate(pictures.images[start : start + batch]):
            row, column = places[k] // p.shape[2], places[k] % p.shape[2]
            log_w, log_h, dx, dy = box[k][:, row, column]
            middle = torch.stack([column + dx, row + dy], 1) * STRIDE
            size = torch.stack([log_w, log_h], 1).clamp(-2.0, 5.0).exp() * STRIDE
            named = points[k][:, row, column].T.reshape(len(row), -1, 2)
            named = middle[:, None] + named * size[:, None]
            seen = torch.ones(*named.shape[:2], 1)
            boxes = torch.cat([middle - size / 2, size], 1).tolist()
            keypoints = torch.cat([named, seen], 2).flatten(1).tolist()
            results += [
                {
                    "image_id": image["id"], "category_id": 1, "bbox": boxes[i],
                    "keypoints": keypoints[i], "score": score,
                }
                for i, score in enumerate(scores[k].tolist()) if score > LEAST_SCORE
            ]  # fmt: skip
    return results


def main() -> None:
    """Train and test as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--train", type=Path, nargs="+", required=True, metavar="SET")
    parser.add_argument("--test", type=Path, nargs="+", default=[], metavar="SET")
    parser.add_argument("--seen", type=int, default=60_000, help="pictures drawn in training")
    parser.add_argument("--batch", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sheets", type=Path, help="folder for pictures of hits and misses")
    options = parser.parse_args()
    tests = {folder: Pictures(folder, ("train", "val")) for folder in options.test}
    for folder in options.train:
        pictures = Pictures(folder, ("train",))
        print(f"{folder}: {len(pictures)} pictures", flush=True)
        model = train(pictures, options.seen, options.batch, options.seed)
        for other, test in tests.items():
            found = find(model, test)
            boxes, poses = (precision(test, found, kind) for kind in ("bbox", "keypoints"))
            print(
                f"{folder.name} on {other.name}: {len(test)} pictures, boxes AP {boxes[0]:.3f} "
                f"AP50 {boxes[1]:.3f}, keypoints AP {poses[0]:.3f} AP50 {poses[1]:.3f}",
                flush=True,
            )
            if options.sheets:
                options.sheets.mkdir(parents=True, exist_ok=True)
                sheet(test, found).save(options.sheets / f"{folder.name}-{other.name}.png")


if __name__ == "__main__":
    main()
