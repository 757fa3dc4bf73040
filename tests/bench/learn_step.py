#!/usr/bin/env python3
"""One training step of the learned map: PyTorch beside ours, on the same cores, taking turns.

    pip install torch
    cargo build --release -p seamwright-tests --bin learn_step
    python3 tests/bench/learn_step.py MESH.obj [--widths 512,128] [--threads 2] [--rounds 3]

A step is forward and backward of every published loss over all vertices, and AdamW. The PyTorch side is written to be
fast: no loop over points, LeakyReLU in place, tangents of both columns stacked in one product, one distance matrix for
the two directions of the nearest points, AdamW fused where it can be; the best of the thread counts 1..N counts. Processor time is that of all threads together: the fairer figure on a busy machine.
"""
import argparse
import math
import os
import subprocess
import time

import torch
import torch.nn.functional as F

OURS = os.path.join(os.path.dirname(__file__), "..", "..", "target", "release", "learn_step")


def load(path):
    positions, faces, known, joined = [], [], {}, []
    for line in open(path):
        words = line.split()
        if words[:1] == ["v"]:
            p = tuple(float(w) for w in words[1:4])
            joined.append(known.setdefault(p, len(known)))
            if len(known) > len(positions):
                positions.append(p)
        elif words[:1] == ["f"]:
            corners = [joined[int(w.split("/")[0]) - 1] for w in words[1:]]
            faces += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    p = torch.tensor(positions)
    p = (p - (p.amin(0) + p.amax(0)) / 2) / (p.amax(0) - p.amin(0)).max()
    return p, torch.tensor(faces)


class Layers(torch.nn.Module):
    def __init__(self, *sizes):
        super().__init__()
        self.layers = torch.nn.ModuleList(torch.nn.Linear(a, b) for a, b in zip(sizes, sizes[1:]))

    def forward(self, x, kept=None):
        for layer in self.layers[:-1]:
            x = F.leaky_relu_(layer(x), 0.01)
            if kept is not None:
                kept.append(x)
        return self.layers[-1](x)

    def tangents(self, t, kept):
        """t: (2, n, inputs), one slice a column; kept: the outputs of the hidden layers."""
        for layer, y in zip(self.layers[:-1], kept):
            slope = torch.where(y > 0, 1.0, 0.01)
            t = F.linear(t, layer.weight) * slope
        return F.linear(t, self.layers[-1].weight)


class Backbone(torch.nn.Module):
    def __init__(self, h, c):
        super().__init__()
        self.deform = torch.nn.ModuleList([Layers(2, h, h, h, c), Layers(c + 2, h, h, h, 2)])
        self.wrap = torch.nn.ModuleList([Layers(2, h, h, h, c), Layers(c + 2, h, h, h, 6)])
        self.cut = torch.nn.ModuleList([Layers(3, h, h, c), Layers(c + 3, h, h, 3)])
        self.unwrap = Layers(3, h, h, 2)


def coded(pair, x, kept=(None, None)):
    return pair[1](torch.cat([x, pair[0](x, kept[0])], 1), kept[1])


def norm(q):
    q = q - (q.amin(0) + q.amax(0)) / 2
    return q / q.norm(dim=1).max()


def repel(q, radius):
    q = norm(q)
    with torch.no_grad():
        near = torch.cdist(q, q).topk(9, 1, largest=False).indices[:, 1:]
    gap = q[:, None] - q[near]
    return (radius - ((gap * gap).sum(2) + 1e-8).sqrt()).clamp_min(0).mean()


def corner_cosines(x, faces):
    a, b, c = x[faces[:, 0]], x[faces[:, 1]], x[faces[:, 2]]
    return torch.stack([F.cosine_similarity(b - a, c - a), F.cosine_similarity(c - b, a - b), F.cosine_similarity(a - c, b - c)])


class Problem:
    def __init__(self, path, width, code):
        torch.manual_seed(1)
        self.p, self.faces = load(path)
        p, f, n = self.p, self.faces, len(self.p)
        cross = torch.linalg.cross(p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]])
        normals = torch.zeros(n, 3)
        for c in range(3):
            normals.index_add_(0, f[:, c], cross)
        self.normals = F.normalize(normals)
        self.exposure = torch.arange(n) % 10 / 10
        self.side = math.isqrt(n - 1) + 1
        line = torch.linspace(-1, 1, self.side)
        self.grid = torch.stack(torch.meshgrid(line, line, indexing="ij"), 2).reshape(-1, 2)
        self.cosines = corner_cosines(p, f)
        self.units = torch.eye(2)[:, None, :].expand(2, n, 2).contiguous()
        ring = [set() for _ in range(n)]
        for t in f.tolist():
            for c in range(3):
                ring[t[c]] |= {t[(c + 1) % 3], t[(c + 2) % 3]}
        # Short rings are filled up with their last member; Spot has none.
        near = [sorted(r, key=lambda j: float((p[i] - p[j]).norm()))[:5] for i, r in enumerate(ring)]
        self.ring = torch.tensor([r + r[-1:] * (5 - len(r)) for r in near])
        self.net = Backbone(width, code)
        try:
            self.optimiser = torch.optim.AdamW(self.net.parameters(), 1e-3, eps=1e-5, weight_decay=1e-8, fused=True)
        except (RuntimeError, TypeError):
            self.optimiser = torch.optim.AdamW(self.net.parameters(), 1e-3, eps=1e-5, weight_decay=1e-8, foreach=True)

    def losses(self):
        net, p = self.net, self.p
        q = net.unwrap(p + coded(net.cut, p))
        kept = ([], [])
        cycle = coded(net.wrap, q, kept)
        q_hat = self.grid + coded(net.deform, self.grid)
        wrapped = coded(net.wrap, q_hat)
        p_hat = wrapped[:, :3]
        q_hat_cycle = net.unwrap(p_hat + coded(net.cut, p_hat))
        with torch.no_grad():
            distances = torch.cdist(p_hat, p)
            to_p, to_hat = distances.argmin(1), distances.argmin(0)
        wrap = torch.maximum((p_hat - p[to_p]).square().sum(1).mean(), (p_hat[to_hat] - p).square().sum(1).mean())
        radius = 0.25 * 2 / (self.side - 1)
        apart = repel(q, radius) + repel(q_hat, radius) + repel(q_hat_cycle, radius)
        points = (p - cycle[:, :3]).abs().mean() + (q_hat - q_hat_cycle).abs().mean()
        normals = (1 - F.cosine_similarity(self.normals, cycle[:, 3:])).mean()
        code = net.wrap[0].tangents(self.units, kept[0])
        j = net.wrap[1].tangents(torch.cat([self.units, code], 2), kept[1])[:, :, :3]
        a, b, c = (j[0] * j[0]).sum(1), (j[0] * j[1]).sum(1), (j[1] * j[1]).sum(1)
        differential = ((a - c).square() + 4 * b.square()).sqrt().mean()
        triangle = (corner_cosines(q, self.faces) - self.cosines).abs().mean()
        qn = norm(q)
        reach = torch.logsumexp(50 * (qn[:, None] - qn[self.ring]).norm(dim=2), 1) / 50
        tau = 0.1 * (qn.amax(0) - qn.amin(0)).max().detach()
        s = torch.sigmoid(50 * (reach - tau))
        visibility = (s * self.exposure).sum() / (s.sum() + 1e-6)
        return wrap + 0.01 * (apart + points + differential) + 0.005 * normals + 1e-5 * triangle + 0.004 * visibility

    def step(self):
        self.optimiser.zero_grad(set_to_none=True)
        self.losses().backward()
        self.optimiser.step()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("--widths", default="512,128")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    print(f"PyTorch {torch.__version__}; seconds a step: best (median)")
    for width in map(int, args.widths.split(",")):
        code = max(width // 8, 8)
        problem = Problem(args.mesh, width, code)
        theirs, ours = [], []
        for _ in range(args.rounds):
            for threads in range(1, args.threads + 1):
                torch.set_num_threads(threads)
                problem.step()
                times, cpu = [], time.process_time()
                for _ in range(args.steps):
                    start = time.perf_counter()
                    problem.step()
                    times.append(time.perf_counter() - start)
                theirs.append((min(times), sorted(times)[len(times) // 2], (time.process_time() - cpu) / args.steps, threads))
            command = [OURS, "--width", str(width), "--code", str(code), "--threads", str(args.threads)]
            out = subprocess.run(command + ["--steps", str(args.steps), args.mesh], capture_output=True, text=True, check=True)
            ours.append(tuple(map(float, out.stdout.split())))
        (a, am, _), (b, bm, _, threads) = min(ours), min(theirs)
        ca, cb = min(o[2] for o in ours), min(t[2] for t in theirs)
        print(f"width {width}: ours {a:.4f} ({am:.4f}), PyTorch {b:.4f} ({bm:.4f}) on {threads} threads, ratio {a / b:.2f};"
              f" processor time {ca:.3f}, {cb:.3f}, ratio {ca / cb:.2f}", flush=True)


if __name__ == "__main__":
    main()
