"""Solves a program that `modiolus export` wrote with another solver, and compares its answer with the one in the file.

DAQP, a dual active-set method, solves the arrays of PROGRAM.npz. HiGHS reads PROGRAM.qps and PROGRAM.qp beside it, where they are,
and must find the same arrays in them. (Its own active-set method ends with an error on these programs.)

Usage: solve_again.py PROGRAM.npz; exit code 1 when something differs.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import daqp
import highspy
import numpy as np

# DAQP stops at its own tolerance, above that of the certificate.
ACTIVATION = 1e-6
OBJECTIVE = 1e-7
# HiGHS leaves out coefficients below this.
SMALLEST = 1e-9


def by_daqp(program):
    """The minimiser; DAQP takes bounds first, then rows, and knows equalities by their kind."""
    P, A, G = program["P"], program["A"], program["G"]
    big = 1e30
    upper = np.concatenate([np.minimum(program["upper"], big), program["b"], program["h"]])
    lower = np.concatenate([np.maximum(program["lower"], -big), program["b"], np.full(len(G), -big)])
    kinds = np.zeros(len(upper), dtype=np.intc)
    kinds[len(P) : len(P) + len(A)] = 5
    rows = np.ascontiguousarray(np.vstack([A, G]))
    x, _, flag, _ = daqp.solve(P, program["q"].copy(), rows, upper, lower, kinds, primal_tol=1e-10)
    return x, flag == 1


def as_highs_reads(path):
    """The arrays of the text `path`."""
    # HiGHS knows a format by the name's ending.
    ending = {".qps": ".mps", ".qp": ".lp"}[path.suffix]
    highs = highspy.Highs()
    highs.setOptionValue("output_flag", False)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / f"program{ending}"
        shutil.copy(path, copy)
        if highs.readModel(str(copy)) == highspy.HighsStatus.kError:
            sys.exit(f"HiGHS does not read {path}")
    model = highs.getModel()
    lp, hessian = model.lp_, model.hessian_
    n, m = lp.num_col_, lp.num_row_

    def dense(matrix, rows):
        full = np.zeros((rows, n))
        for j in range(n):
            entries = slice(matrix.start_[j], matrix.start_[j + 1])
            full[np.array(matrix.index_[entries], dtype=int), j] = matrix.value_[entries]
        return full

    half = dense(hessian, n)
    rows = dense(lp.a_matrix_, m)
    lower, upper = np.array(lp.row_lower_), np.array(lp.row_upper_)
    is_equal = lower == upper
    return {
        "P": half + half.T - np.diag(np.diag(half)),
        "q": np.array(lp.col_cost_),
        "r": np.array(lp.offset_),
        "A": rows[is_equal],
        "b": upper[is_equal],
        "G": rows[~is_equal],
        "h": upper[~is_equal],
        "lower": np.array(lp.col_lower_),
        "upper": np.array(lp.col_upper_),
    }


def main(path):
    path = Path(path)
    with np.load(path, allow_pickle=False) as file:
        program = {name: file[name] for name in file.files}
    answer = program["x"]
    objective = lambda x: 0.5 * x @ program["P"] @ x + program["q"] @ x + float(program["r"])
    known = objective(answer)
    print(f"{path}: objective {known:.9g}")

    x, solved = by_daqp(program)
    # Forces of redundant contacts need not be unique; activations and the objective are.
    forces = np.char.startswith(program["variables"], "force of contact")
    activation = np.abs(x - answer)[~forces].max()
    excess = abs(objective(x) - known) / max(1.0, abs(known))
    good = bool(solved and activation <= ACTIVATION and excess <= OBJECTIVE)
    print(f"  DAQP: activations differ by {activation:.1e}, objective by {excess:.1e}")

    for text in [path.with_suffix(".qps"), path.with_suffix(".qp")]:
        if not text.exists():
            continue
        read = as_highs_reads(text)
        same_shape = all(read[name].shape == program[name].shape for name in read)
        same = same_shape and all(
            np.allclose(read[name], program[name], rtol=1e-15, atol=SMALLEST) for name in read
        )
        print(f"  {text.name} as HiGHS reads it: {'the same program' if same else 'ANOTHER PROGRAM'}")
        good = good and same
    print("the same answer" if good else "NOT THE SAME")
    return 0 if good else 1


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
