"""Checks the answer in a program that `modiolus export RESULT --to npz` wrote, with NumPy alone.

    minimise    1/2 x'Px + q'x + r
    subject to  A x  = b        multipliers y, any sign
                G x <= h        multipliers z >= 0
           lo <=  x <= hi       multipliers z_lo, z_hi >= 0

The program is convex, so that a feasible x is optimal where multipliers of the right signs balance the gradient and only push
at what is tight. Each residual is divided by the largest term that enters it, or by one when all are smaller.

Usage: check_certificate.py PROGRAM.npz [TOLERANCE]; exit code 1 when a residual is above the tolerance (1e-8).
"""

import sys

import numpy as np


def product(matrix, vector):
    """The product, and the largest term of each of its rows."""
    terms = np.abs(matrix * vector)
    return matrix @ vector, terms.max(axis=1, initial=0.0)


def relative(residual, *sizes):
    """The largest residual, each divided by its size or one."""
    size = np.ones(np.shape(residual))
    for other in sizes:
        size = np.maximum(size, np.abs(other))
    return float(np.max(np.abs(residual) / size, initial=0.0))


def residuals(program):
    P, q, A, b, G, h = (program[name] for name in "P q A b G h".split())
    lower, upper, x = program["lower"], program["upper"], program["x"]
    y, z, z_lower, z_upper = (program[name] for name in ["y", "z", "z_lower", "z_upper"])
    has_lower, has_upper = np.isfinite(lower), np.isfinite(upper)
    Ax, Ax_size = product(A, x)
    Gx, Gx_size = product(G, x)
    below = np.where(has_lower, np.maximum(lower - x, 0.0), 0.0)
    above = np.where(has_upper, np.maximum(x - upper, 0.0), 0.0)
    primal = max(
        relative(Ax - b, Ax_size, b),
        relative(np.maximum(Gx - h, 0.0), Gx_size, h),
        relative(below),
        relative(above),
    )

    multipliers = [z, z_lower, z_upper]
    sign = max(relative(np.minimum(m, 0.0)) for m in multipliers)
    # Nothing pushes back where there is no bound.
    sign = max(sign, relative(z_lower[~has_lower]), relative(z_upper[~has_upper]))

    curvature, size = product(P, x)
    by_rows, by_rows_size = product(A.T, y)
    by_limits, by_limits_size = product(G.T, z)
    gradient = curvature + q + by_rows + by_limits - z_lower + z_upper
    stationary = relative(gradient, size, q, by_rows_size, by_limits_size, z_lower, z_upper)

    slack = np.concatenate([h - Gx, (x - lower)[has_lower], (upper - x)[has_upper]])
    push = np.concatenate([z, z_lower[has_lower], z_upper[has_upper]])
    complementary = relative(slack * push, push, slack)

    objective = 0.5 * x @ P @ x + q @ x + program["r"]
    bound = lambda limit, m, has: limit[has] @ m[has]
    dual = -0.5 * x @ P @ x + program["r"] - b @ y - h @ z
    dual += bound(lower, z_lower, has_lower) - bound(upper, z_upper, has_upper)
    gap = relative(objective - dual, x @ P @ x, q @ x, b @ y)

    R, value, slopes = program["residual_matrix"], program["residual_value"], program["part_slope"]
    at = R @ x + value
    rows = program["part_rows"].astype(int)
    parts = np.array([0.5 * at[start:end] @ at[start:end] for start, end in rows]) + slopes @ x
    stated = program["part_objective"]
    terms = max(
        relative(parts - stated, stated),
        relative(parts.sum() - objective, x @ P @ x, q @ x, program["r"]),
        relative(R.T @ R - P, np.abs(P).max()),
        relative(R.T @ value + slopes.sum(axis=0) - q, np.abs(q).max()),
    )
    curvature = np.linalg.eigvalsh(0.5 * (P + P.T))
    convex = max(0.0, -curvature.min(initial=0.0)) / max(1.0, curvature.max(initial=0.0))
    return {
        "primal feasibility": primal,
        "signs of multipliers": sign,
        "stationarity": stationary,
        "complementarity": complementary,
        "duality gap": gap,
        "objective by term": terms,
        "convexity": convex,
    }


def main(path, tolerance=1e-8):
    with np.load(path, allow_pickle=False) as file:
        program = {name: file[name] for name in file.files}
    print(f"{path}: {len(program['x'])} variables, {len(program['b'])} equalities, {len(program['h'])} inequalities")
    found = residuals(program)
    for name, value in found.items():
        print(f"  {name:22} {value:.1e}")
    for name, objective in zip(program["part_names"], program["part_objective"]):
        print(f"  objective of {name}: {objective:.6g}")
    failed = [name for name, value in found.items() if not value <= tolerance]
    if failed:
        print(f"not optimal to {tolerance:g}: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], *map(float, sys.argv[2:])))
