"""The fit again, from its formulas, with SciPy: python optimum.py FOLDER L2

FOLDER/N.bridges.csv: child, parent, allowed, features; FOLDER/N.roots.csv: features; FOLDER/weights.csv: a weight a case;
FOLDER/ours.csv: fitted weights. Prints the least objective found, the objective of ours.
FOLDER/links.csv: probability, right, weight; prints the calibration and its loss.
"""
import pathlib
import sys

import numpy as np
from scipy.optimize import minimize

folder, l2 = pathlib.Path(sys.argv[1]), float(sys.argv[2])
read = lambda name: np.loadtxt(folder / name, delimiter=",", ndmin=2)
omega = read("weights.csv").ravel()
cases = [(read(f"{k}.bridges.csv"), read(f"{k}.roots.csv")) for k in range(len(omega))]
nb = cases[0][0].shape[1] - 3
scale = np.r_[np.vstack([b[:, 3:] for b, _ in cases]).std(0) + 1e-6, np.maximum(np.vstack([z for _, z in cases]).std(0), .3)]


def objective(y):
    theta, value, slope = y / scale, 0., np.zeros_like(y)
    for (b, z), o in zip(cases, omega / omega.sum()):
        child, parent, allowed, x, n = b[:, 0].astype(int), b[:, 1].astype(int), b[:, 2] > 0, b[:, 3:], len(z)
        w, v = np.exp(np.clip(x @ theta[:nb], -25, 25)), np.exp(np.clip(z @ theta[nb:], -25, 25))
        lap = np.diag(v)
        np.add.at(lap, (child, child), w)
        np.add.at(lap, (child, parent), -w)
        inv = np.linalg.inv(lap)
        p, root = w * (inv[child, child] - inv[parent, child]), v * np.diag(inv)
        right = np.bincount(child[allowed], w[allowed], n)
        value += o * (np.log(np.where(right > 0, right, v)).sum() - np.linalg.slogdet(lap)[1])
        slope[:nb] += o * (np.where(allowed, w / np.maximum(right[child], 1e-300), 0) - p) @ x
        slope[nb:] += o * ((right == 0) - root) @ z
    return l2 * (y ** 2).sum() - value, 2 * l2 * y - slope / scale


best = minimize(objective, np.zeros(len(scale)), jac=True, method="L-BFGS-B", options=dict(maxiter=5000, ftol=1e-15, gtol=1e-9))
print(best.fun, objective(read("ours.csv").ravel() * scale)[0])

p, right, weight = read("links.csv").T
log_odds = np.log(p / (1 - p))
x = np.column_stack([np.ones_like(p), log_odds, np.minimum(log_odds, 0)])
s, weight = x.std(0), weight / weight.sum()
s[s == 0] = 1


def loss(b):
    z = x / s @ b
    return ((weight * (np.logaddexp(0, z) - right * z)).sum() + 1e-5 * (b[1:] ** 2).sum(),
            (x / s).T @ (weight * (1 / (1 + np.exp(-z)) - right)) + 2e-5 * np.r_[0, b[1:]])


fit = minimize(loss, np.zeros(3), jac=True, method="L-BFGS-B", options=dict(maxiter=1000, ftol=1e-15, gtol=1e-10))
print(*(fit.x / s))
