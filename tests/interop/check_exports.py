"""Opens what `modiolus export RESULT --to vtu|pvd|sto|csv|glb|obj` wrote with the programs that it is for: meshio and PyVista
read the field, OpenSim the activations where its wheel is installed.

Usage: check_exports.py FOLDER, which holds result.vtu, result.pvd, result.sto, result.csv, result.obj and program.npz, and the
answer's face.vtu and solution.json.
"""

import csv
import json
import sys
from pathlib import Path

import meshio
import numpy as np
import pyvista


def main():
    folder = Path(sys.argv[1])
    solution = json.loads((folder / "solution.json").read_text())
    stored = meshio.read(folder / "face.vtu")
    exported = meshio.read(folder / "result.vtu")
    assert np.array_equal(stored.points, exported.points)
    assert np.array_equal(stored.point_data["displacement"], exported.point_data["displacement"])
    assert "asymmetry_mm" in exported.point_data

    grid = pyvista.read(folder / "result.vtu")
    assert grid.n_points == len(stored.points)
    warped = grid.warp_by_vector("displacement")
    assert np.allclose(warped.points, stored.points + stored.point_data["displacement"], atol=1e-4)

    series = pyvista.get_reader(folder / "result.pvd")
    times = list(series.time_values)
    assert times[0] == 0 and times[-1] == 1 and len(times) > 2, times
    series.set_active_time_value(0)
    assert np.abs(series.read()[0]["displacement"]).max() == 0, "it begins at rest"
    series.set_active_time_value(1)
    assert np.allclose(series.read()[0]["displacement"], stored.point_data["displacement"]), "it ends at the answer"

    rows = list(csv.DictReader((folder / "result.csv").open()))
    last = {name: float(a) for name, a in rows[-1].items() if name != "time_s"}
    assert last == solution["activations"]

    surface = meshio.read(folder / "result.obj")
    assert len(surface.points) > 1000 and np.isfinite(surface.points).all()

    arrays = np.load(folder / "program.npz")
    assert np.array_equal(arrays["points"], stored.points)
    field = arrays["displacement"]
    assert np.array_equal(field, stored.point_data["displacement"])
    assert np.array_equal(arrays["contact_pressure_kpa"], stored.point_data["contact_pressure_kpa"].ravel())
    assert dict(zip(arrays["muscles"], arrays["activation"])) == solution["activations"]
    for marker, target, model in zip(solution["markers"], arrays["marker_target"], arrays["marker_model"]):
        asked = [np.nan if x is None else x for x in marker["target_mm"]]
        assert np.array_equal(target, asked, equal_nan=True) and np.array_equal(model, marker["model_mm"])
    assert list(arrays["markers"]) == [marker["name"] for marker in solution["markers"]]
    # A landmark that is a node has that node's row; all of them lie within what their surroundings do.
    rows = 0
    for place, moved in zip(arrays["landmark_points"], arrays["landmark_displacement"]):
        distance = np.linalg.norm(stored.points - place, axis=1)
        if distance.min() < 1e-9:
            assert np.allclose(moved, field[distance.argmin()], atol=1e-12)
            rows += 1
        near = field[distance < 6]
        assert (moved >= near.min(axis=0) - 1e-9).all() and (moved <= near.max(axis=0) + 1e-9).all()
    assert rows > 0 and len(arrays["landmarks"]) == len(arrays["landmark_points"])
    print("NumPy reads the field, the landmarks, the activations and the markers")

    try:
        import opensim
    except ImportError:
        print("OpenSim is not installed: the .sto file is not opened by it")
    else:
        table = opensim.TimeSeriesTable(str(folder / "result.sto"))
        labels = list(table.getColumnLabels())
        assert sorted(labels) == sorted(solution["activations"])
        row = table.getRowAtIndex(table.getNumRows() - 1)
        for k, name in enumerate(labels):
            assert row[k] == solution["activations"][name], name
        print("OpenSim reads the activations")
    print("meshio and PyVista read the field and the way from rest")


main()
