#!/usr/bin/env python3
"""Plots the CSV of haptic_loop: forces, their change in a cycle over the largest force, and the energy taken from the hand.

Usage: plot.py FILE.csv FILE.png      needs numpy and matplotlib
Prints by how much forces on the way back differ from those on the way there, and from which distance on they agree.
"""
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

table = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
tools = [table[table["tool"] == t] for t in np.unique(table["tool"])]
time = tools[0]["time_s"]
forces = np.array([np.stack([tool[f"f{k}_N"] for k in "xyz"], 1) for tool in tools])
size = np.linalg.norm(forces, axis=2)
largest = max(size.max(), 1e-300)
change = np.linalg.norm(np.diff(forces, axis=1), axis=2).max(0) / largest
unsettled = (tools[0]["status"].astype(int) & 4) > 0
back = np.linalg.norm(forces - forces[:, ::-1], axis=2).max(0) / largest
differs = tools[0]["apart_m"][back > 0.02]
print(f"largest force {largest:.3g} N; back differs by {100 * back.max():.3g} % of it,",
      f"by more than 2 % to {1e3 * differs.max():.3g} mm" if differs.size else "nowhere by more than 2 %")

figure, axes = plt.subplots(3, sharex=True, figsize=(8, 8), constrained_layout=True)
for i, force in enumerate(size):
    axes[0].plot(time, force, label=f"tool {i}")
axes[0].set_ylabel("force [N]")
axes[0].legend()
axes[1].semilogy(time[1:], np.maximum(100 * change, 1e-4))
axes[1].axhline(5, color="gray", linestyle=":")
axes[1].set_ylabel("change in a cycle\n[% of the largest force]")
axes[2].plot(time, 1e3 * tools[-1]["taken_J"], label="taken from the hand")
axes[2].plot(time, 1e3 * tools[0]["energy_J"], label="stored")
axes[2].axhline(0, color="gray", linestyle=":")
axes[2].set_ylabel("energy [mJ]")
axes[2].set_xlabel("time [s]")
axes[2].legend()
for axis in axes:  # orange: cycles whose forces are not those of a balance
    axis.set_ylim(axis.get_ylim())
    axis.fill_between(time, 0, 1, where=unsettled, transform=axis.get_xaxis_transform(), color="orange", alpha=0.3)
figure.savefig(sys.argv[2], dpi=100)
